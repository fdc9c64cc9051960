//! The partition drawn: the analog processor, the linkage, and the digital processor.

use maud::{Markup, html};

/// What stands in the three columns. Names come from the patch and the executive.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Partition {
    /// Groups of analog blocks, each a line (`Pitch, yaw, roll rotation`).
    pub analog: Vec<String>,
    /// Signals sampled by ADC, analog to digital.
    pub adc: Vec<String>,
    /// Signals and coefficients set by DAC and DCU, digital to analog.
    pub dac: Vec<String>,
    /// Logic: sense and control lines; may be empty.
    pub logic: Vec<String>,
    /// Tasks of the digital executive, each with its period (`Trajectory, RK4 (0.1 s)`).
    pub digital: Vec<String>,
}

impl Partition {
    /// The partition of the long-period flight.
    pub fn long_period() -> Partition {
        let list = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
        Partition {
            analog: list(&[
                "Rotation: pitch, yaw, roll",
                "Fin-tip (FTC) actuators: rate, travel",
                "TVC actuators: rate, limit",
                "TVC dead zone",
                "Fin sharing: yaw ± roll",
                "Rate gyros",
                "Bending filter",
                "Error resolution through roll",
                "Redundant α integrator",
            ]),
            adc: list(&["θ, ψ, φ", "body rates", "α", "fin deflections", "TVC forces"]),
            dac: list(&[
                "pitch command θ",
                "air-path angle γ, range angle Γ",
                "moment and force slopes",
                "control effectiveness",
                "loop gains",
                "dead-zone width",
            ]),
            logic: Vec::new(),
            digital: list(&[
                "Trajectory: V, γ, h, Γ by RK4",
                "Atmosphere, gravity",
                "Mass properties, thrust",
                "Aerodynamic functions of α, Mach",
                "Wind",
                "Pitch programme",
                "Gain sequencer",
                "Failures",
            ]),
        }
    }
}

const PITCH: f64 = 30.0;
const TOP: f64 = 58.0;

/// The diagram as SVG.
pub fn block_diagram(partition: &Partition) -> Markup {
    let middle = partition.adc.len() + partition.dac.len() + partition.logic.len();
    let groups = [&partition.adc, &partition.dac, &partition.logic];
    let headed = groups.iter().filter(|group| !group.is_empty()).count();
    let tallest = (partition.analog.len().max(partition.digital.len()) as f64 * PITCH)
        .max(middle as f64 * 19.0 + headed as f64 * 46.0);
    let height = TOP + tallest + 30.0;
    let mut y = TOP + 4.0;
    // Each group of the linkage: heading, names, where its arrow runs, and its direction.
    let mut lanes = Vec::new();
    for (heading, names, digital_bound) in [
        ("ADC: sampled", &partition.adc, true),
        ("DAC and DCU: set", &partition.dac, false),
        ("sense and control lines", &partition.logic, false),
    ] {
        if names.is_empty() {
            continue;
        }
        lanes.push((y, heading, names, digital_bound));
        y += 46.0 + names.len() as f64 * 19.0;
    }
    html! {
        svg.chart viewBox=(format!("0 0 900 {:.0}", height + 6.0)) role="img" style="max-width:900px" {
            title { "Partition between the analog and the digital processor" }
            (column(8.0, "analog-proc", "continuous, in parallel", &partition.analog, height))
            (column(612.0, "digital-proc", "sampled, in sequence", &partition.digital, height))
            rect.hull x="316" y="6" width="268" height=(format!("{:.0}", height - 8.0)) rx="8" stroke-dasharray="5 4" {}
            text.ti x="450" y="27" text-anchor="middle" { "interface" }
            text.tt x="450" y="44" text-anchor="middle" { "frames of period T" }
            @for (y, heading, names, digital_bound) in &lanes {
                @let (line, head) = if *digital_bound { ("fl", "fla") } else { ("fr", "fra") };
                @let arrow = y + 24.0;
                text.at x="450" y=(format!("{:.0}", y + 15.0)) text-anchor="middle" { (heading) }
                path.(line) d=(format!("M290 {arrow:.0}H610")) {}
                @if *digital_bound {
                    path.(head) d=(format!("M611 {arrow:.0}l-11-5v10z")) {}
                } @else {
                    path.(head) d=(format!("M289 {arrow:.0}l11-5v10z")) {}
                }
                @for (n, name) in names.iter().enumerate() {
                    text.tt x="450" y=(format!("{:.0}", y + 42.0 + n as f64 * 19.0)) text-anchor="middle" { (name) }
                }
            }
        }
    }
}

/// One processor with its blocks.
fn column(x: f64, name: &str, kind: &str, blocks: &[String], height: f64) -> Markup {
    html! {
        rect.hull x=(x) y="6" width="280" height=(format!("{:.0}", height - 8.0)) rx="8" {}
        text.ti x=(x + 140.0) y="27" text-anchor="middle" { (name) }
        text.tt x=(x + 140.0) y="44" text-anchor="middle" { (kind) }
        @for (row, block) in blocks.iter().enumerate() {
            @let y = TOP + row as f64 * PITCH;
            rect.box x=(x + 12.0) y=(y) width="256" height="24" rx="3" {}
            text.lg x=(x + 140.0) y=(y + 16.5) text-anchor="middle" { (block) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_drawn() {
        let partition = Partition::long_period();
        let svg = block_diagram(&partition).into_string();
        for name in [&partition.analog, &partition.adc, &partition.dac, &partition.digital]
            .into_iter()
            .flatten()
        {
            assert!(svg.contains(&format!(">{name}</text>")), "{name}");
        }
    }
}
