//! The fields of each kind of block, read into its typed form.
//!
//! What a kind is called and how many inputs it takes is in [`super::catalogue`].

use super::catalogue::{
    ADC_CHANNELS, CONTROL_LINES, DAC_CHANNELS, DCU_CHANNELS, INTERRUPT_LINES, SENSE_LINES,
};
use super::diagnostic::PatchFault;
use super::fields::Fields;
use crate::net::{Kind, Level, Wave};

/// Reads the fields of a block. `None` after faults, which have been told.
pub(crate) fn build(kind: &str, f: &mut Fields<'_, '_>) -> Option<Kind> {
    Some(match kind {
        "integrator" => integrator(f)?,
        "summer" => Kind::Summer,
        "inverter" => Kind::Inverter,
        "square" => Kind::Square,
        "square-root" => Kind::SquareRoot,
        "abs" => Kind::Abs,
        "sine" => Kind::Sine,
        "cosine" => Kind::Cosine,
        "multiplier" => Kind::Multiplier,
        "min" => Kind::Min,
        "max" => Kind::Max,
        "divider" => Kind::Divider,
        "arctangent" => Kind::Arctangent,
        "resolver" => Kind::Resolver,
        "and" => Kind::And,
        "or" => Kind::Or,
        "not" => Kind::Not,
        "time" => Kind::Time,
        "gain" => Kind::Gain { k: f.number("k", None)? },
        "constant" => Kind::Constant { value: f.number("value", None)? },
        "pot" => pot(f)?,
        "dcu" | "mdac" | "dac" | "adc" => converter(kind, f)?,
        "function" => function(f)?,
        "function-2d" => function_2d(f)?,
        "digital-function" => digital_function(f)?,
        "dead-zone" | "limiter" => levels(kind, f)?,
        "rate-limiter" => {
            let rate = f.positive("rate", None);
            let tau = f.positive("tau", Some(1e-3));
            let ic = f.number("ic", Some(0.0));
            Kind::RateLimiter { rate: rate?, tau: tau?, ic: ic? }
        }
        "backlash" => {
            let width = f.positive("width", None);
            let tau = f.positive("tau", Some(1e-3));
            let ic = f.number("ic", Some(0.0));
            Kind::Backlash { width: width?, tau: tau?, ic: ic? }
        }
        "dry-friction" => dry_friction(f)?,
        "relay" => relay(f)?,
        "comparator" => {
            let threshold = f.number("threshold", Some(0.0));
            let hysteresis = f.ranged("hysteresis", Some(0.0), "0 or greater", |v| v >= 0.0);
            Kind::Comparator { threshold: threshold?, hysteresis: hysteresis? }
        }
        "switch" => Kind::Switch { control: f.net("control")? },
        "track-store" => {
            let track = f.net("track");
            let ic = f.number("ic", Some(0.0));
            Kind::TrackStore { track: track?, ic: ic? }
        }
        "transport-delay" => {
            let delay = f.positive("delay", None);
            let initial = f.number("initial", Some(0.0));
            Kind::TransportDelay { delay: delay?, initial: initial? }
        }
        "lag" => {
            let tau = f.positive("tau", None);
            let gain = f.number("gain", Some(1.0));
            let ic = f.number("ic", Some(0.0));
            Kind::Lag { tau: tau?, gain: gain?, ic: ic? }
        }
        "signal-generator" => generator(f)?,
        "noise" => {
            let sigma = f.ranged("sigma", Some(1.0), "0 or greater", |v| v >= 0.0);
            let every_s = f.positive("every", None);
            let seed = f.whole("seed", Some(0));
            Kind::Noise { sigma: sigma?, every_s: every_s?, seed: seed? }
        }
        "flip-flop" => Kind::FlipFlop { initial: f.flag("initial", false)? },
        "one-shot" => Kind::OneShot { width_s: f.positive("width", None)? },
        "counter" => {
            let modulo = f.whole("modulo", Some(0))?;
            let Ok(modulo) = u32::try_from(modulo) else {
                f.out_of_range("modulo", modulo as f64, "at most 4294967295");
                return None;
            };
            Kind::Counter { modulo }
        }
        "sense" => Kind::Sense { line: f.channel("line", "sense line", SENSE_LINES, 1)? },
        "interrupt" => {
            Kind::Interrupt { line: f.channel("line", "interrupt line", INTERRUPT_LINES, 1)? }
        }
        "control" => {
            let line = f.channel("line", "control line", CONTROL_LINES, 1);
            let initial = f.flag("initial", false);
            Kind::Control { line: line?, initial: initial? }
        }
        _ => return None,
    })
}

fn integrator(f: &mut Fields<'_, '_>) -> Option<Kind> {
    let ic = f.number("ic", Some(0.0));
    let limits = f.pair_or_none("limits");
    let operate = f.net_or_none("operate");
    let reset = f.net_or_none("reset");
    let reset_to = f.input_or_none("reset-to");
    if f.place("reset-to").is_some() && f.place("reset").is_none() {
        f.missing("reset", "\"NET\", the logic net that triggers `reset-to`");
        return None;
    }
    let (ic, limits) = (ic?, limits?);
    if let Some([low, high]) = limits {
        if !ordered("limits", low, high, f) {
            return None;
        }
        if ic < low || ic > high {
            f.fault_at("ic", |src, at| PatchFault::IcOutsideLimits {
                src,
                at,
                ic,
                low,
                high,
                help: "the feedback diodes would conduct at once: move the IC or the limits".into(),
            });
            return None;
        }
    }
    Some(Kind::Integrator { ic, limits, operate: operate?, reset: reset?, reset_to: reset_to? })
}

/// Whether a pair of limits is the right way round; told if not.
fn ordered(field: &'static str, low: f64, high: f64, f: &mut Fields<'_, '_>) -> bool {
    if low < high {
        return true;
    }
    f.fault_at(field, |src, at| PatchFault::InvertedLimits {
        src,
        at,
        field: field.to_owned(),
        low,
        high,
        help: format!("write the lower one first: {field} = [{high}, {low}]"),
    });
    false
}

fn pot(f: &mut Fields<'_, '_>) -> Option<Kind> {
    let value = f.number("k", None)?;
    if (0.0..=1.0).contains(&value) {
        return Some(Kind::Pot { k: value });
    }
    f.fault_at("k", |src, at| PatchFault::PotFraction {
        src,
        at,
        value,
        help:
            "a pot attenuates; use a `gain` block, or a coefficient on the input, for anything else"
                .into(),
    });
    None
}

fn converter(kind: &str, f: &mut Fields<'_, '_>) -> Option<Kind> {
    let (what, count) = match kind {
        "dcu" => ("DCU", DCU_CHANNELS),
        "adc" => ("ADC channel", ADC_CHANNELS),
        _ => ("DAC channel", DAC_CHANNELS),
    };
    let channel = f.channel("channel", what, count, 1);
    if kind == "adc" {
        return Some(Kind::Adc { channel: channel? });
    }
    let initial = f.number("initial", Some(0.0));
    // Left out, a DCU has its profile's range.
    let range = if kind == "dcu" { f.positive("range", Some(f64::INFINITY)) } else { None };
    let (channel, initial) = (channel?, initial?);
    Some(match kind {
        "dcu" => Kind::Dcu { channel, initial, range: Some(range?).filter(|r| r.is_finite()) },
        "mdac" => Kind::Mdac { channel, initial },
        _ => Kind::Dac { channel, initial },
    })
}

fn function(f: &mut Fields<'_, '_>) -> Option<Kind> {
    let x = f.breakpoints("x");
    let y = f.numbers("y");
    let (x, y) = (x?, y?);
    if x.len() != y.len() {
        f.table_size("y", y.len(), format!("{} (one for each x)", x.len()));
        return None;
    }
    Some(Kind::Function { x, y })
}

fn function_2d(f: &mut Fields<'_, '_>) -> Option<Kind> {
    let x = f.breakpoints("x");
    let y = f.breakpoints("y");
    let size = x.as_ref().zip(y.as_ref()).map(|(x, y)| (x.len(), y.len()));
    let z = f.grid("z", size);
    Some(Kind::Function2d { x: x?, y: y?, z: z? })
}

fn digital_function(f: &mut Fields<'_, '_>) -> Option<Kind> {
    let x = f.breakpoints("x");
    let needed = x.as_ref().map_or(1, Vec::len);
    let first_channel = f.channel("first-channel", "DCU", DCU_CHANNELS, needed);
    let has_initial = f.place("initial").is_some();
    let initial = f.numbers_or_none("initial");
    if has_initial && initial.is_none() {
        return None;
    }
    let x = x?;
    let initial = initial.unwrap_or_else(|| vec![0.0; x.len()]);
    if initial.len() != x.len() {
        f.table_size("initial", initial.len(), format!("{} (one for each x)", x.len()));
        return None;
    }
    Some(Kind::DigitalFunction { x, first_channel: first_channel?, initial })
}

fn levels(kind: &str, f: &mut Fields<'_, '_>) -> Option<Kind> {
    if kind == "dead-zone" {
        let Some(entry) = f.entry("width") else {
            f.missing("width", "NUMBER or \"NET\" (half the width)");
            return None;
        };
        let width = f.level("width", &entry.value, "width")?;
        if let Level::Fixed(value) = width
            && value < 0.0
        {
            f.out_of_range("width", value, "0 or greater");
            return None;
        }
        return Some(Kind::DeadZone { width });
    }
    if let Some(entry) = f.entry("limits") {
        let super::value::Data::List(items) = &entry.value.data else {
            super::number::wrong_type(
                "limits",
                "a list [low, high]",
                &entry.value,
                f.resolver.faults,
            );
            return None;
        };
        let [low, high] = &items[..] else {
            f.table_size("limits", items.len(), "2 (low and high)".into());
            return None;
        };
        let low = f.level("limits", low, "low");
        let high = f.level("limits", high, "high");
        let (low, high) = (low?, high?);
        if let (Level::Fixed(low), Level::Fixed(high)) = (low, high)
            && !ordered("limits", low, high, f)
        {
            return None;
        }
        return Some(Kind::Limiter { low, high });
    }
    let Some(entry) = f.entry("limit") else {
        f.missing("limits", "[LOW, HIGH], or limit = LEVEL for both sides");
        return None;
    };
    Some(match f.level("limit", &entry.value, "high")? {
        Level::Fixed(value) if value > 0.0 => {
            Kind::Limiter { low: Level::Fixed(-value), high: Level::Fixed(value) }
        }
        Level::Fixed(value) => {
            f.out_of_range("limit", value, "greater than 0");
            return None;
        }
        Level::Net(net) => Kind::Limiter {
            low: Level::Net(f.inverted(net, "low", entry.value.span)),
            high: Level::Net(net),
        },
    })
}

fn dry_friction(f: &mut Fields<'_, '_>) -> Option<Kind> {
    let level = f.ranged("level", None, "0 or greater", |v| v >= 0.0);
    let breakaway = f.number("breakaway", level.or(Some(0.0)));
    let (level, breakaway) = (level?, breakaway?);
    if breakaway < level {
        f.out_of_range("breakaway", breakaway, "at least `level`");
        return None;
    }
    Some(Kind::DryFriction { level, breakaway })
}

fn relay(f: &mut Fields<'_, '_>) -> Option<Kind> {
    let points = f.pair("points");
    let outputs = f.pair("outputs");
    let initially_on = f.flag("initially-on", false);
    let points = points?;
    if points[0] > points[1] && !ordered("points", points[0], points[1], f) {
        return None;
    }
    Some(Kind::Relay { points, outputs: outputs?, initially_on: initially_on? })
}

fn generator(f: &mut Fields<'_, '_>) -> Option<Kind> {
    let wave = f.word(
        "wave",
        None,
        &[
            ("step", Wave::Step),
            ("ramp", Wave::Ramp),
            ("sine", Wave::Sine),
            ("square", Wave::Square),
        ],
    );
    let amplitude = f.number("amplitude", Some(1.0));
    let offset = f.number("offset", Some(0.0));
    let frequency_hz = f.positive("frequency", Some(1.0));
    let phase_rad = f.number("phase", Some(0.0));
    let start_s = f.number("start", Some(0.0));
    Some(Kind::Generator {
        wave: wave?,
        amplitude: amplitude?,
        offset: offset?,
        frequency_hz: frequency_hz?,
        phase_rad: phase_rad?,
        start_s: start_s?,
    })
}
