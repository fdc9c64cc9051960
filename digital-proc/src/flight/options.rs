//! How the work of a flight is shared out between the sides, beside the shipped way: what the
//! laboratory finds of Figure 1, of axes and of function generation, put to the flight.
//!
//! An option that needs other blocks exchanges them in the stage patch, so that the shipped patch
//! stays what is flown without options.

use super::{AlphaPath, FlightFault, stage_patch};
use crate::linkage::console::Console;
use interface::control::{ChannelKind, PatchBundle};
use vehicle::trajectory::TranslationAxes;

/// Where the aerodynamic moments are formed.
#[derive(
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Eq,
    serde::Serialize,
    serde::Deserialize,
    clap::ValueEnum,
)]
#[serde(rename_all = "kebab-case")]
pub enum FunctionGeneration {
    /// Rubin's: slopes from the digital side, times the angle on the analog side
    #[default]
    Hybrid,
    /// At the sampled angle on the digital side, held
    Digital,
}

/// Axes of the translational equations, as a user chooses them.
#[derive(
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Eq,
    serde::Serialize,
    serde::Deserialize,
    clap::ValueEnum,
)]
#[serde(rename_all = "kebab-case")]
pub enum AxesName {
    /// Speed and path angle
    #[default]
    FlightPath,
    /// Howe's H frame: horizontal and vertical velocity
    HFrame,
}

impl From<AxesName> for TranslationAxes {
    fn from(name: AxesName) -> TranslationAxes {
        match name {
            AxesName::FlightPath => TranslationAxes::FlightPath,
            AxesName::HFrame => TranslationAxes::H,
        }
    }
}

/// The options of a flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// How the yaw incidence reaches the rotational equations.
    pub beta: AlphaPath,
    /// Axes of the translation.
    pub axes: AxesName,
    /// Where the aerodynamic moments are formed.
    pub functions: FunctionGeneration,
}

impl Options {
    /// As shipped.
    pub const NONE: Options = Options {
        beta: AlphaPath::Held,
        axes: AxesName::FlightPath,
        functions: FunctionGeneration::Hybrid,
    };

    /// The stage patch with the blocks that they need.
    pub fn patch(self) -> PatchBundle {
        let mut bundle = stage_patch();
        let Some((_, text)) = bundle.files.first_mut() else {
            return bundle;
        };
        if self.beta == AlphaPath::Redundant {
            *text = replace_block(text, "alpha_y", REDUNDANT_BETA);
        }
        if self.functions == FunctionGeneration::Digital {
            for (name, signal) in [("mu_alpha_p", "aero_p"), ("mu_alpha_y", "aero_y")] {
                *text =
                    text.replace(&format!("in = [\"{name}\","), &format!("in = [\"{signal}\","));
            }
            *text = text.replace("[integration]", DIGITAL_MOMENTS);
        }
        bundle
    }

    /// The channels that they add.
    pub(super) fn channels(self, console: &Console<'_>) -> Result<OptionChannels, FlightFault> {
        let dac = |name| console.channel(ChannelKind::Dac, name);
        let beta = match self.beta {
            AlphaPath::Redundant => Some([dac("alpha_y_drift")?, dac("alpha_y_mend")?]),
            AlphaPath::Held => None,
        };
        let moments = match self.functions {
            FunctionGeneration::Digital => Some([dac("aero_p")?, dac("aero_y")?]),
            FunctionGeneration::Hybrid => None,
        };
        Ok(OptionChannels { beta, moments })
    }
}

/// Channels beyond those of the shipped patch, where an option is on.
#[derive(Clone, Copy, Debug)]
pub(super) struct OptionChannels {
    /// Drift and correction of the redundant yaw incidence, rad/s.
    pub beta: Option<[usize; 2]>,
    /// Aerodynamic moments over inertia in pitch and yaw, rad/s².
    pub moments: Option<[usize; 2]>,
}

/// Figure 1's scheme for β, in the sign of the yaw incidence: it turns with ψ.
const REDUNDANT_BETA: &str = r#"{ kind = "integrator", in = ["psi_dot", "alpha_y_drift", "alpha_y_mend"], max = 1.0, note = "redundant integrator, corrected slowly" }
alpha_y_drift = { kind = "dac", channel = 30, max = 0.5, note = "rate of the crosswind angle, rad/s" }
alpha_y_mend  = { kind = "dac", channel = 31, max = 2.0, note = "correction of the redundant integrator, rad/s" }"#;

/// The moments as signals of the digital side.
const DIGITAL_MOMENTS: &str = r#"aero_p = { kind = "dac", channel = 28, max = 5.0, note = "aerodynamic moment over inertia, pitch, rad/s2" }
aero_y = { kind = "dac", channel = 29, max = 5.0, note = "and yaw" }

[integration]"#;

/// The text with the definition of one block exchanged.
pub(crate) fn replace_block(text: &str, name: &str, block: &str) -> String {
    let lines: Vec<String> = text
        .lines()
        .map(|line| match line.split_once('=') {
            Some((key, _)) if key.trim() == name => format!("{name} = {block}"),
            _ => line.to_owned(),
        })
        .collect();
    lines.join("\n") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every block that an option exchanges is in the shipped patch.
    #[test]
    fn options_find_what_they_exchange() {
        let text = |options: Options| options.patch().files.swap_remove(0).1;
        let shipped = text(Options::NONE);
        assert_eq!(shipped, stage_patch().files[0].1);
        let beta = text(Options { beta: AlphaPath::Redundant, ..Options::NONE });
        assert_eq!(beta.lines().count(), shipped.lines().count() + 2);
        let digital = text(Options { functions: FunctionGeneration::Digital, ..Options::NONE });
        for signal in ["in = [\"aero_p\",", "in = [\"aero_y\","] {
            assert_eq!(digital.matches(signal).count(), 1, "{signal}");
        }
    }
}
