//! The partition drawn: the analog processor, the linkage, and the digital processor.

use maud::{Markup, html};

/// Groups of analog blocks.
const ANALOG: &[&str] = &[
    "Rotation: pitch, yaw, roll",
    "Fin-tip (FTC) actuators: rate, travel",
    "TVC actuators: rate, limit",
    "TVC dead zone",
    "Fin sharing: yaw ± roll",
    "Rate gyros",
    "Bending filter",
    "Error resolution through roll",
    "Redundant α integrator",
];
/// Tasks of the digital executive.
const DIGITAL: &[&str] = &[
    "Trajectory: V, γ, h, Γ by RK4",
    "Atmosphere, gravity",
    "Mass properties, thrust",
    "Aerodynamic functions of α, Mach",
    "Wind",
    "Pitch programme",
    "Gain sequencer",
    "Failures",
];
/// Groups of the linkage: heading, names, and whether they go to the digital side.
const LANES: [(&str, &[&str], bool); 2] = [
    ("ADC: sampled", &["θ, ψ, φ", "body rates", "α", "fin deflections", "TVC forces"], true),
    (
        "DAC and DCU: set",
        &[
            "pitch command θ",
            "air-path angle γ, range angle Γ",
            "moment and force slopes",
            "control effectiveness",
            "loop gains",
            "dead-zone width",
        ],
        false,
    ),
];

const PITCH: f64 = 30.0;
const TOP: f64 = 58.0;

/// The partition of the long-period flight as SVG.
pub fn block_diagram() -> Markup {
    // A lane is its heading, its arrow and its names.
    let lane_height = |names: &[&str]| 46.0 + names.len() as f64 * 19.0;
    let middle: f64 = LANES.iter().map(|(_, names, _)| lane_height(names)).sum();
    let height = TOP + middle.max(ANALOG.len().max(DIGITAL.len()) as f64 * PITCH) + 30.0;
    let mut y = TOP + 4.0;
    let lanes = LANES.map(|(heading, names, digital_bound)| {
        let top = y;
        y += lane_height(names);
        (top, heading, names, digital_bound)
    });
    html! {
        svg.chart viewBox=(format!("0 0 900 {:.0}", height + 6.0)) role="img" style="max-width:900px" {
            title { "Partition between the analog and the digital processor" }
            (column(8.0, "analog-proc", "continuous, in parallel", ANALOG, height))
            (column(612.0, "digital-proc", "sampled, in sequence", DIGITAL, height))
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
fn column(x: f64, name: &str, kind: &str, blocks: &[&str], height: f64) -> Markup {
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
