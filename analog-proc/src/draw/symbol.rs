//! Symbols of the blocks, as analog computers have drawn them since the 1950s.
//!
//! Each is drawn about its middle; inputs enter at the left edge, the output
//! leaves at the right. The integrator is the triangle with a bar at its back,
//! the summer the plain triangle, the pot a circle with its setting.

mod pen;

use super::label::number;
use crate::net::{Block, Kind, Level, Wave};
use pen::Pen;
pub(super) use pen::round;
use svg::node::element::{Circle, Group, Path, Title};

/// Distance between ports.
pub(super) const PORT_PITCH: f64 = 20.0;

/// Room that a symbol takes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Size {
    pub(super) width: f64,
    pub(super) height: f64,
    /// Room for text above (initial condition) and below (name).
    pub(super) above: f64,
    pub(super) below: f64,
    /// Heights of the outputs about the middle.
    pub(super) outputs: [f64; 2],
}

/// Room for a block with so many ports.
pub(super) fn size(block: &Block, ports: usize) -> Size {
    let least = match block.kind {
        Kind::Constant { .. } | Kind::Dac { .. } | Kind::Control { .. } => 26.0,
        Kind::Pot { .. } | Kind::Dcu { .. } | Kind::Time | Kind::Not => 34.0,
        Kind::Inverter => 36.0,
        _ => 48.0,
    };
    let width = match block.kind {
        Kind::Integrator { .. } => 66.0,
        Kind::Constant { .. } => 54.0,
        Kind::Pot { .. } | Kind::Dcu { .. } | Kind::Time | Kind::Not => 34.0,
        Kind::Inverter => 40.0,
        _ => 52.0,
    };
    let outputs = match block.kind {
        Kind::Resolver => [-12.0, 12.0],
        _ => [0.0, 0.0],
    };
    Size {
        width,
        height: f64::max(least, PORT_PITCH * ports as f64),
        above: if caption(&block.kind).is_some() { 16.0 } else { 2.0 },
        below: 16.0,
        outputs,
    }
}

/// Text above the symbol: initial condition, limits, setting.
fn caption(kind: &Kind) -> Option<String> {
    let level = |l: &Level| match l {
        Level::Fixed(value) => number(*value),
        Level::Net(_) => "·".to_owned(),
    };
    Some(match kind {
        Kind::Integrator { ic, limits: Some([low, high]), .. } => {
            format!("IC {}  [{}, {}]", number(*ic), number(*low), number(*high))
        }
        Kind::Integrator { ic, .. } => format!("IC {}", number(*ic)),
        Kind::Lag { tau, gain, ic } => {
            let gain = if *gain == 1.0 { String::new() } else { format!("K {}  ", number(*gain)) };
            let ic = if *ic == 0.0 { String::new() } else { format!("  IC {}", number(*ic)) };
            format!("{gain}τ {} s{ic}", number(*tau))
        }
        Kind::TransportDelay { delay, .. } => format!("T {} s", number(*delay)),
        Kind::DeadZone { width } => format!("± {}", level(width)),
        Kind::Limiter { low, high } => format!("[{}, {}]", level(low), level(high)),
        Kind::RateLimiter { rate, .. } => format!("± {} /s", number(*rate)),
        Kind::Backlash { width, .. } => number(*width),
        Kind::DryFriction { level, .. } => number(*level),
        Kind::Relay { points, outputs, .. } => format!(
            "at {}, {}: {} / {}",
            number(points[0]),
            number(points[1]),
            number(outputs[0]),
            number(outputs[1])
        ),
        Kind::Comparator { threshold, hysteresis } if *hysteresis > 0.0 => {
            format!("> {} ± {}", number(*threshold), number(hysteresis / 2.0))
        }
        Kind::Comparator { threshold, .. } => format!("> {}", number(*threshold)),
        Kind::Generator { wave, amplitude, frequency_hz, .. } => match wave {
            Wave::Step | Wave::Ramp => number(*amplitude),
            Wave::Sine | Wave::Square => {
                format!("{}, {} Hz", number(*amplitude), number(*frequency_hz))
            }
        },
        Kind::Noise { sigma, .. } => format!("σ {}", number(*sigma)),
        Kind::OneShot { width_s } => format!("{} s", number(*width_s)),
        Kind::DigitalFunction { x, first_channel, .. } => {
            format!("DCU {first_channel}–{}", *first_channel as usize + x.len() - 1)
        }
        _ => return None,
    })
}

/// Names of the inputs of kinds whose inputs differ.
pub(super) fn input_names(kind: &Kind) -> &'static [&'static str] {
    match kind {
        Kind::Resolver => &["x", "y", "∠"],
        Kind::Arctangent => &["y", "x"],
        Kind::Function2d { .. } => &["x", "y"],
        Kind::DryFriction { .. } => &["v", "F"],
        Kind::Switch { .. } => &["1", "0"],
        Kind::FlipFlop { .. } => &["S", "R"],
        Kind::Counter { .. } => &[">", "R"],
        Kind::Divider => &["÷·", "·÷"],
        _ => &[],
    }
}

/// Draws a block with its middle at `(x, y)`.
pub(super) fn draw(block: &Block, note: Option<&str>, size: Size, x: f64, y: f64) -> Group {
    let mut pen = Pen {
        group: Group::new(),
        x,
        y,
        half_width: size.width / 2.0,
        half_height: size.height / 2.0,
    };
    body(&mut pen, &block.kind);
    if let Some(caption) = caption(&block.kind) {
        pen.text(0.0, -pen.half_height - 5.0, "value", &caption);
    }
    pen.text(0.0, pen.half_height + 13.0, "name", &block.name);
    let mut hint = block.name.clone();
    if let Some(max) = block.max {
        hint.push_str(&format!(", max {}", number(max)));
    }
    if let Some(note) = note {
        hint.push_str(&format!(": {note}"));
    }
    pen.group.add(Title::new(hint))
}

fn body(pen: &mut Pen, kind: &Kind) {
    match kind {
        Kind::Integrator { .. } => {
            let back = -1.0 + 11.0 / pen.half_width;
            pen.outline("body", &[(back, -1.0), (1.0, 0.0), (back, 1.0)], true);
            pen.outline("body", &[(-1.0, -1.0), (back, -1.0), (back, 1.0), (-1.0, 1.0)], true);
        }
        Kind::Summer => pen.triangle(),
        Kind::Inverter => {
            pen.triangle();
            pen.text(-6.0, 4.0, "tiny", "−1");
        }
        Kind::Gain { k } => {
            pen.triangle();
            pen.text(-8.0, 4.0, "tiny", &number(*k));
        }
        Kind::Pot { k } => {
            pen.circle();
            pen.text(0.0, 4.0, "tiny", &number(*k));
        }
        Kind::Dcu { channel, .. } => {
            pen.circle();
            pen.text(0.0, -1.0, "tiny", "DCU");
            pen.text(0.0, 10.0, "tiny", &channel.to_string());
        }
        Kind::Mdac { channel, .. } => {
            pen.frame();
            pen.text(0.0, -2.0, "tiny", "MDAC");
            pen.text(0.0, 12.0, "tiny", &channel.to_string());
        }
        Kind::Dac { channel, .. } => pen.flag(&format!("DAC {channel}")),
        Kind::Adc { channel } => pen.flag(&format!("ADC {channel}")),
        Kind::Sense { line } => pen.flag(&format!("SL {line}")),
        Kind::Control { line, .. } => pen.flag(&format!("CL {line}")),
        Kind::Interrupt { line } => pen.flag(&format!("INT {line}")),
        Kind::Multiplier => pen.boxed("×"),
        Kind::Divider => pen.boxed("÷"),
        Kind::Square => pen.boxed("x²"),
        Kind::SquareRoot => pen.boxed("√"),
        Kind::Abs => pen.boxed("|x|"),
        Kind::Min => pen.boxed("min"),
        Kind::Max => pen.boxed("max"),
        Kind::Sine => pen.boxed("sin"),
        Kind::Cosine => pen.boxed("cos"),
        Kind::Resolver => pen.boxed("R"),
        Kind::Arctangent => pen.boxed("atan"),
        Kind::Function { x, y } => {
            pen.frame();
            pen.curve("plot", &scaled(x, y));
        }
        Kind::Function2d { .. } => pen.boxed("f(x,y)"),
        Kind::DigitalFunction { x, initial, .. } => {
            pen.frame();
            pen.curve("plot", &scaled(x, initial));
            pen.outline("axis", &[(-1.0, 0.8), (1.0, 0.8)], false);
        }
        Kind::DeadZone { .. } => {
            pen.characteristic(&[(-1.0, -0.8), (-0.4, 0.0), (0.4, 0.0), (1.0, 0.8)]);
        }
        Kind::Limiter { .. } => {
            pen.characteristic(&[(-1.0, -0.7), (-0.5, -0.7), (0.5, 0.7), (1.0, 0.7)]);
        }
        Kind::RateLimiter { .. } => {
            pen.frame();
            pen.curve("axis", &[(-1.0, -0.7), (-0.7, -0.7), (-0.7, 0.7), (1.0, 0.7)]);
            pen.curve("plot", &[(-1.0, -0.7), (-0.7, -0.7), (0.6, 0.7), (1.0, 0.7)]);
        }
        Kind::Backlash { .. } => {
            pen.characteristic(&[(-1.0, -0.7), (-0.4, -0.7), (1.0, 0.7)]);
            pen.curve("plot", &[(1.0, 0.7), (0.4, 0.7), (-1.0, -0.7)]);
        }
        Kind::DryFriction { .. } => {
            pen.characteristic(&[(-1.0, -0.6), (0.0, -0.6), (0.0, 0.6), (1.0, 0.6)]);
        }
        Kind::Relay { .. } => {
            pen.characteristic(&[(-1.0, -0.6), (0.35, -0.6), (0.35, 0.6), (1.0, 0.6)]);
            pen.curve("plot", &[(0.35, 0.6), (-0.35, 0.6), (-0.35, -0.6)]);
        }
        Kind::Comparator { .. } => {
            pen.triangle();
            pen.text(-9.0, 5.0, "word", ">");
        }
        Kind::Switch { .. } => {
            pen.frame();
            pen.curve("plot", &[(-1.2, 0.6), (-0.6, 0.6)]);
            pen.curve("plot", &[(-1.2, -0.4), (-0.6, -0.4)]);
            pen.curve("plot", &[(-0.55, 0.5), (0.6, 0.0), (1.3, 0.0)]);
        }
        Kind::TrackStore { .. } => pen.boxed("T/S"),
        Kind::TransportDelay { .. } => {
            pen.frame();
            pen.text(0.0, 5.0, "word", "e⁻ˢᵀ");
        }
        Kind::Lag { .. } => {
            pen.frame();
            pen.text(0.0, -4.0, "tiny", "1");
            pen.outline("plot", &[(-0.6, 0.0), (0.6, 0.0)], false);
            pen.text(0.0, 13.0, "tiny", "1+τs");
        }
        Kind::Generator { wave, .. } => {
            pen.frame();
            match wave {
                Wave::Step => {
                    pen.curve("plot", &[(-1.0, -0.6), (-0.2, -0.6), (-0.2, 0.6), (1.0, 0.6)]);
                }
                Wave::Ramp => pen.curve("plot", &[(-1.0, -0.6), (-0.4, -0.6), (1.0, 0.7)]),
                Wave::Square => pen.curve(
                    "plot",
                    &[(-1.0, -0.6), (-1.0, 0.6), (0.0, 0.6), (0.0, -0.6), (1.0, -0.6), (1.0, 0.6)],
                ),
                Wave::Sine => {
                    let point = |i: i32| {
                        let x = f64::from(i) / 12.0;
                        (x, 0.7 * libm::sin(x * std::f64::consts::PI))
                    };
                    let points: Vec<(f64, f64)> = (-12..=12).map(point).collect();
                    pen.curve("plot", &points);
                }
            }
        }
        Kind::Noise { .. } => {
            pen.frame();
            let heights = [0.1, -0.5, 0.7, -0.2, 0.3, -0.8, 0.9, -0.1, 0.4, -0.6, 0.2];
            let points: Vec<(f64, f64)> =
                heights.iter().enumerate().map(|(i, h)| (-1.0 + 0.2 * i as f64, *h)).collect();
            pen.curve("plot", &points);
        }
        Kind::And => gate(pen, false),
        Kind::Or => gate(pen, true),
        Kind::Not => {
            pen.outline("body", &[(-1.0, -1.0), (0.6, 0.0), (-1.0, 1.0)], true);
            let bubble = Circle::new()
                .set("class", "body")
                .set("cx", round(pen.x + 0.8 * pen.half_width))
                .set("cy", round(pen.y))
                .set("r", round(0.2 * pen.half_width));
            pen.add(bubble);
        }
        Kind::FlipFlop { .. } => pen.boxed("FF"),
        Kind::OneShot { .. } => {
            pen.frame();
            pen.curve(
                "plot",
                &[(-1.0, -0.5), (-0.4, -0.5), (-0.4, 0.5), (0.4, 0.5), (0.4, -0.5), (1.0, -0.5)],
            );
        }
        Kind::Counter { modulo: 0 } => pen.boxed("CTR"),
        Kind::Counter { modulo } => {
            pen.frame();
            pen.text(0.0, -2.0, "tiny", "CTR");
            pen.text(0.0, 12.0, "tiny", &format!("÷{modulo}"));
        }
        Kind::Constant { value } => {
            pen.frame();
            pen.text(0.0, 4.0, "tiny", &number(*value));
        }
        Kind::Time => {
            pen.circle();
            pen.text(0.0, 5.0, "word", "t");
        }
    }
}

/// The D of an and gate, or the shield of an or gate.
fn gate(pen: &mut Pen, is_or: bool) {
    let (x, y) = (pen.x, pen.y);
    let (w, h) = (pen.half_width, pen.half_height);
    let (left, right, top, bottom) = (round(x - w), round(x + w), round(y - h), round(y + h));
    let d = if is_or {
        format!(
            "M{left} {top}Q{x} {top} {right} {y}Q{x} {bottom} {left} {bottom}Q{} {y} {left} {top}Z",
            round(x - 0.6 * w)
        )
    } else {
        format!("M{left} {top}H{x}Q{right} {top} {right} {y}Q{right} {bottom} {x} {bottom}H{left}Z")
    };
    pen.add(Path::new().set("class", "body").set("d", d));
    pen.text(-4.0, 5.0, "word", if is_or { "≥1" } else { "&" });
}

/// A table as a curve within the symbol.
fn scaled(x: &[f64], y: &[f64]) -> Vec<(f64, f64)> {
    let bounds = |v: &[f64]| {
        let low = v.iter().copied().fold(f64::INFINITY, f64::min);
        let high = v.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        (low, (high - low).max(f64::MIN_POSITIVE))
    };
    let ((x0, width), (y0, height)) = (bounds(x), bounds(y));
    x.iter()
        .zip(y)
        .map(|(x, y)| (2.0 * (x - x0) / width - 1.0, 1.6 * (y - y0) / height - 0.8))
        .collect()
}
