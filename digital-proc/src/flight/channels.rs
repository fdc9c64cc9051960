//! The channels of the stage patch by their part in the flight.
//!
//! Resolved once a session, so that a frame touches only numbers. A user's own
//! stage patch must have every channel named here; it may have more.

use crate::linkage::console::{Console, ConsoleFault};
use interface::{control::ChannelKind, frame::Samples};

/// Declares a set of channels of one kind: a field each, resolved by its own name.
macro_rules! channel_set {
    ($(#[$doc:meta])* $set:ident, $kind:expr, [$($field:ident),* $(,)?]) => {
        $(#[$doc])*
        #[derive(Clone, Debug)]
        pub struct $set { $(#[doc = concat!("Channel `", stringify!($field), "`.")] pub $field: usize),* }

        impl $set {
            fn resolve(console: &Console<'_>) -> Result<$set, ConsoleFault> {
                Ok($set { $($field: console.channel($kind, stringify!($field))?),* })
            }
        }
    };
}

channel_set!(
    /// Sampled by the digital side.
    Sampled, ChannelKind::Adc,
    [
        adc_theta, adc_psi, adc_phi, adc_alpha, adc_alpha_y, adc_q, adc_r, adc_p, adc_tip_p,
        adc_tip_2, adc_tip_4, adc_force_p, adc_force_y, adc_control, adc_control_y,
    ]
);
channel_set!(
    /// Signals set by the digital side.
    Signals, ChannelKind::Dac,
    [
        theta_c, gamma_air, range_angle, wind_angle, alpha_drift, alpha_mend, dead_zone,
        a_misalign_p, a_misalign_y, a_cant, roll_reference,
    ]
);
channel_set!(
    /// Coefficients set by the digital side.
    Coefficients, ChannelKind::Dcu,
    [
        mu_alpha_p, mu_alpha_y, mu_rate_p, mu_rate_y, roll_damping, lead_f_p, lead_f_y, u_pitch,
        u_yaw, lead_phi, u_roll, dead_zone_yield, lead_t_p, lead_t_y, demand_p, demand_y, accel_tip_p, accel_tip_2,
        accel_tip_4, accel_tvc_p, accel_tvc_y, roll_tip_2, roll_tip_4, side_tip_p, side_tip_2,
        side_tip_4,
    ]
);
channel_set!(
    /// Logic set by the digital side.
    Lines, ChannelKind::Control, [redundant, resolved]
);

/// Every channel of the stage patch.
#[derive(Clone, Debug)]
pub struct StageChannels {
    pub adc: Sampled,
    pub dac: Signals,
    pub dcu: Coefficients,
    pub line: Lines,
}

impl StageChannels {
    /// Finds the channels of the loaded patch.
    pub fn resolve(console: &Console<'_>) -> Result<StageChannels, ConsoleFault> {
        Ok(StageChannels {
            adc: Sampled::resolve(console)?,
            dac: Signals::resolve(console)?,
            dcu: Coefficients::resolve(console)?,
            line: Lines::resolve(console)?,
        })
    }
}

/// What the analog side told in one frame, SI units and radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AttitudeSample {
    /// θ, ψ, φ, rad.
    pub angle_rad: [f64; 3],
    /// q, r, p, rad/s, body axes.
    pub rate_radps: [f64; 3],
    /// α, rad.
    pub incidence_rad: f64,
    /// α_y, rad.
    pub yaw_incidence_rad: f64,
    /// Pitch pair, tip 2, tip 4, rad.
    pub tip_rad: [f64; 3],
    /// Secondary injection in pitch and yaw, N.
    pub tvc_n: [f64; 2],
    /// Control forces in the pitch and the yaw plane, N.
    pub control_force_n: [f64; 2],
}

impl Sampled {
    /// How many there are: each is one number.
    pub const COUNT: u32 = (size_of::<Sampled>() / size_of::<usize>()) as u32;

    pub fn read(&self, samples: &Samples) -> AttitudeSample {
        let at = |channel: usize| samples.adc[channel];
        AttitudeSample {
            angle_rad: [at(self.adc_theta), at(self.adc_psi), at(self.adc_phi)],
            rate_radps: [at(self.adc_q), at(self.adc_r), at(self.adc_p)],
            incidence_rad: at(self.adc_alpha),
            yaw_incidence_rad: at(self.adc_alpha_y),
            tip_rad: [at(self.adc_tip_p), at(self.adc_tip_2), at(self.adc_tip_4)],
            tvc_n: [at(self.adc_force_p), at(self.adc_force_y)],
            control_force_n: [at(self.adc_control), at(self.adc_control_y)],
        }
    }
}
