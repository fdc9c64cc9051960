//! A digital law of a loop study as it stands in the text.

use super::{
    super::{loop_law::Element, plan::LabError, table::Table1},
    LawSpec, named,
    text::Faults,
};
use desk::faults::suggestion;
use serde::Deserialize;
use std::ops::Range;
use toml::Spanned;

const KINDS: [&str; 4] = ["gain-matrix", "difference-equation", "delay", "table"];

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(super) struct RawLaw {
    kind: Spanned<String>,
    inputs: Option<Vec<Spanned<String>>>,
    outputs: Option<Vec<Spanned<String>>>,
    input: Option<Spanned<String>>,
    output: Option<Spanned<String>>,
    gain: Option<Spanned<toml::Value>>,
    numerator: Option<Spanned<Vec<f64>>>,
    denominator: Option<Spanned<Vec<f64>>>,
    frames: Option<Spanned<u32>>,
    x: Option<Spanned<Vec<f64>>>,
    y: Option<Spanned<Vec<f64>>>,
}

/// The law, or faults.
pub(super) fn law(law: &Spanned<RawLaw>, faults: &mut Faults<'_>) -> Option<LawSpec> {
    let raw = law.get_ref();
    let kind = raw.kind.get_ref().as_str();
    let allowed: &[&str] = match kind {
        "gain-matrix" => &["inputs", "outputs", "gain"],
        "difference-equation" => &["input", "output", "numerator", "denominator"],
        "delay" => &["input", "output", "frames", "gain"],
        "table" => &["input", "output", "x", "y"],
        other => {
            faults.add(
                raw.kind.span(),
                format!("unknown law `{other}`"),
                suggestion(other, KINDS.into_iter()),
            );
            return None;
        }
    };
    let given = [
        ("inputs", raw.inputs.as_ref().map(|v| v.first().map_or(law.span(), Spanned::span))),
        ("outputs", raw.outputs.as_ref().map(|v| v.first().map_or(law.span(), Spanned::span))),
        ("input", raw.input.as_ref().map(Spanned::span)),
        ("output", raw.output.as_ref().map(Spanned::span)),
        ("gain", raw.gain.as_ref().map(Spanned::span)),
        ("numerator", raw.numerator.as_ref().map(Spanned::span)),
        ("denominator", raw.denominator.as_ref().map(Spanned::span)),
        ("frames", raw.frames.as_ref().map(Spanned::span)),
        ("x", raw.x.as_ref().map(Spanned::span)),
        ("y", raw.y.as_ref().map(Spanned::span)),
    ];
    let before = faults.count();
    for (key, span) in &given {
        match span {
            Some(span) if !allowed.contains(key) => {
                faults.add(
                    span.clone(),
                    format!("`{key}` has no meaning in a `{kind}` law"),
                    format!("remove it; the keys are {}", allowed.join(", ")),
                );
            }
            // A delay's gain is 1 unless stated.
            None if allowed.contains(key) && !(kind == "delay" && *key == "gain") => {
                faults.add(
                    raw.kind.span(),
                    format!("this `{kind}` law has no `{key}`"),
                    "add the key",
                );
            }
            _ => {}
        }
    }
    if faults.count() > before {
        return None;
    }
    let list = |many: &Option<Vec<Spanned<String>>>, one: &Option<Spanned<String>>| {
        many.iter().flatten().chain(one).map(named).collect::<Vec<_>>()
    };
    let inputs = list(&raw.inputs, &raw.input);
    let outputs = list(&raw.outputs, &raw.output);
    let element = match kind {
        "gain-matrix" => gain_matrix(raw.gain.as_ref()?, inputs.len(), outputs.len(), faults)?,
        "delay" => {
            let gain = match &raw.gain {
                None => 1.0,
                Some(g) => number(g.get_ref()).or_else(|| {
                    faults.add(
                        g.span(),
                        "the gain of this delay is no number",
                        "give one finite number",
                    );
                    None
                })?,
            };
            let frames = raw.frames.as_ref()?;
            let delay = Element::delay(*frames.get_ref(), gain);
            accepted(delay, frames.span(), faults)?
        }
        "difference-equation" => {
            let (b, a) = (raw.numerator.as_ref()?, raw.denominator.as_ref()?);
            let equation = Element::difference(b.get_ref().clone(), a.get_ref().clone());
            accepted(equation, a.span(), faults)?
        }
        _ => {
            let (x, y) = (raw.x.as_ref()?, raw.y.as_ref()?);
            let table = Table1::new(x.get_ref().clone(), y.get_ref().clone());
            Element::Table(accepted(table, x.span(), faults)?)
        }
    };
    Some(LawSpec { inputs, outputs, element })
}

/// What was made of the values at `span`, or a fault there.
fn accepted<T>(
    made: Result<T, LabError>,
    span: Range<usize>,
    faults: &mut Faults<'_>,
) -> Option<T> {
    match made {
        Ok(made) => return Some(made),
        Err(LabError::Setting { what, value, range }) => {
            faults.add(span, format!("{what} is {value}"), format!("it must be {range}"));
        }
        Err(other) => faults.add(span, other.to_string(), "correct it here"),
    }
    None
}

fn number(value: &toml::Value) -> Option<f64> {
    match value {
        toml::Value::Float(f) => Some(*f),
        // Coefficients beyond 2^53 are not met.
        toml::Value::Integer(i) => Some(*i as f64),
        _ => None,
    }
    .filter(|v| v.is_finite())
}

fn gain_matrix(
    value: &Spanned<toml::Value>,
    inputs: usize,
    outputs: usize,
    faults: &mut Faults<'_>,
) -> Option<Element> {
    let rows: Option<Vec<Vec<f64>>> = value
        .get_ref()
        .as_array()
        .and_then(|rows| rows.iter().map(|r| r.as_array()?.iter().map(number).collect()).collect());
    match rows {
        Some(rows) if rows.len() == outputs && rows.iter().all(|r| r.len() == inputs) => {
            Some(Element::Gain(rows))
        }
        _ => {
            faults.add(
                value.span(),
                format!("`gain` must be {outputs} rows of {inputs} numbers"),
                "one row an output, one column an input",
            );
            None
        }
    }
}
