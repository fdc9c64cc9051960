//! Numbers of a patch: written out, or as arithmetic with numbers and parameters in quotes.
//!
//! Every part that cannot be had is told at its own place in the string. A value
//! that is not finite is refused: neither infinity nor NaN has a meaning on a machine.

use super::diagnostic::Flaw;
use super::expression::{Expression, Node, parse};
use super::faults::Faults;
use crate::net::Span;
use desk::faults::suggestion;
use desk::reader::{Board, Data, Fault, Value};
use std::collections::HashMap;

/// Before names are resolved no parameter is known.
impl Board for Faults {
    fn tell(&mut self, at: Span, fault: Fault, help: String) {
        self.push(at, fault, help);
    }

    fn number(&mut self, field: &str, value: &Value) -> Option<f64> {
        number(field, value, &HashMap::new(), self)
    }
}

/// Value of arithmetic with numbers and parameters. `place` gives the place of a part of the string.
pub(crate) fn evaluate(
    expression: &Expression<'_>,
    params: &HashMap<String, Option<f64>>,
    place: &dyn Fn(std::ops::Range<usize>) -> Span,
    field: &str,
    faults: &mut Faults,
) -> Option<f64> {
    let mut of = |inner: &Expression<'_>| evaluate(inner, params, place, field, faults);
    let at = || place(expression.range.clone());
    let value = match &expression.node {
        Node::Number(number) => *number,
        Node::Negative(inner) => -of(inner)?,
        Node::Chain(first, rest) => {
            let first = of(first);
            rest.iter().fold(first, |a, (operator, b)| {
                let b = of(b);
                Some(operator.of(a?, b?))
            })?
        }
        Node::Call(function, arguments) => {
            let arguments: Vec<Option<f64>> = arguments.iter().map(of).collect();
            function.of(&arguments.into_iter().collect::<Option<Vec<_>>>()?)
        }
        Node::Name(name) => match params.get(*name) {
            Some(value) => (*value)?,
            None if *name == "pi" => std::f64::consts::PI,
            None if matches!(name.to_ascii_lowercase().as_str(), "nan" | "inf") => f64::NAN,
            None => {
                unknown_param(name, at(), params, faults);
                return None;
            }
        },
    };
    if !value.is_finite() {
        not_finite(field, at(), faults);
        return None;
    }
    Some(value)
}

/// Place of a part of a quoted string, or the whole string if it has escapes.
pub(crate) fn part_of(
    faults: &Faults,
    whole: Span,
    content: &str,
) -> impl Fn(std::ops::Range<usize>) -> Span + use<> {
    let is_plain =
        faults.sources.text(whole).get(1..).is_some_and(|text| text.starts_with(content));
    let length = content.len();
    move |range| {
        if !is_plain || range.end > length {
            return whole;
        }
        let offset = |i: usize| whole.start + 1 + u32::try_from(i).unwrap_or(0);
        Span { file: whole.file, start: offset(range.start), end: offset(range.end) }
    }
}

pub(crate) fn not_finite(field: &str, at: Span, faults: &mut Faults) {
    let help = "use a finite number; infinity and NaN have no place on the patch board";
    faults.push(at, Fault::NotFinite { field: field.to_owned() }, help);
}

/// A number, or arithmetic with numbers and parameters in quotes.
pub(crate) fn number(
    field: &str,
    value: &Value,
    params: &HashMap<String, Option<f64>>,
    faults: &mut Faults,
) -> Option<f64> {
    match &value.data {
        Data::Number { value: number, .. } => {
            if number.is_finite() {
                return Some(*number);
            }
            not_finite(field, value.span, faults);
            None
        }
        Data::Text(text) => {
            let place = part_of(faults, value.span, text);
            match parse(text) {
                Ok(expression) => evaluate(&expression, params, &place, field, faults),
                Err(error) => {
                    bad_coefficient(text, place(error.range), error.why, error.help, faults);
                    None
                }
            }
        }
        _ => {
            faults.wrong_type(field, "a number or a parameter", value);
            None
        }
    }
}

pub(crate) fn bad_coefficient(
    text: &str,
    at: Span,
    why: &'static str,
    help: &str,
    faults: &mut Faults,
) {
    faults.push(at, Flaw::BadCoefficient { text: text.to_owned(), why }, help.to_owned());
}

fn unknown_param(name: &str, at: Span, params: &HashMap<String, Option<f64>>, faults: &mut Faults) {
    let help = suggestion(name, sorted(params));
    faults.push(
        at,
        Flaw::UnknownParam { param: name.to_owned() },
        format!("{help}; nets cannot be coefficients (a `multiplier` takes two nets)"),
    );
}

fn sorted(params: &HashMap<String, Option<f64>>) -> Vec<&str> {
    let mut names: Vec<&str> = params.keys().map(String::as_str).collect();
    names.sort_unstable();
    names
}
