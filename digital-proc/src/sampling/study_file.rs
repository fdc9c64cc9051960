//! A user's own loop study: one TOML file that names a patch, a digital law and a sweep.
//!
//! ```toml
//! title = "My servo"
//! patch = "servo.toml"            # beside this file
//! stop = "20s"
//! measure = "x_adc"               # ADC whose record is identified
//!
//! [params]                        # values for the patch's [params]
//! wn = 3.0
//!
//! [sweep]
//! frame = ["20ms", "50ms"]
//! latency = [0.0, 1.0]            # frames
//! bits = [8, 12, 0]               # 0: ideal converters (the default)
//!
//! [[law]]                         # one or more, computed in order
//! kind = "gain-matrix"            # y = G x
//! inputs = ["x_adc"]
//! outputs = ["u"]
//! gain = [[9.0]]
//! ```
//! Other kinds: `difference-equation` (`numerator`, `denominator`: Σ a_i y_{n−i} = Σ b_i x_{n−i}),
//! `delay` (`frames`, `gain`), `table` (`x`, `y`), each with one input and one output. Every fault
//! names the file and the line; all that can be judged without the patch are reported at once.

use super::{
    identify,
    loop_law::{Element, LoopLaw},
    plan::LabError,
    table::Table1,
    theory::{C64, damping_ratio},
};
use interface::{
    Tick,
    control::{Channel, ChannelKind},
};
use serde::{Deserialize, Serialize};
use std::{fmt, ops::Range};
use toml::Spanned;

/// One fault of a study file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StudyFault {
    /// File as the user named it.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column, from 1.
    pub column: usize,
    /// What is wrong.
    pub message: String,
    /// What to do.
    pub help: String,
}

impl fmt::Display for StudyFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (file, line, column) = (&self.file, self.line, self.column);
        write!(f, "{file}:{line}:{column}: {}", self.message)?;
        if !self.help.is_empty() {
            write!(f, "\n  help: {}", self.help)?;
        }
        Ok(())
    }
}

/// All faults found.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
pub struct StudyFaults(pub Vec<StudyFault>);

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct Raw {
    title: Option<String>,
    patch: Spanned<String>,
    stop: Spanned<String>,
    measure: Spanned<String>,
    #[serde(default)]
    params: std::collections::BTreeMap<String, f64>,
    sweep: RawSweep,
    law: Vec<Spanned<RawLaw>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct RawSweep {
    frame: Spanned<Vec<Spanned<String>>>,
    latency: Option<Vec<Spanned<f64>>>,
    bits: Option<Vec<Spanned<u32>>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct RawLaw {
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

/// A channel by name, with its place for messages.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Named {
    name: String,
    span: Range<usize>,
}

#[derive(Clone, Debug)]
struct LawSpec {
    inputs: Vec<Named>,
    outputs: Vec<Named>,
    element: Element,
}

/// A study that can run once the patch's channels are known.
#[derive(Clone, Debug)]
pub struct LoopStudy {
    /// Title, or the file's name.
    pub title: String,
    /// Patch, relative to the study file.
    pub patch: String,
    /// Values for the patch's `[params]`.
    pub params: Vec<(String, f64)>,
    /// End of each run.
    pub stop: Tick,
    /// The cases, frame by frame, latency by latency, bits by bits.
    pub cases: Vec<LoopCase>,
    measure: Named,
    laws: Vec<LawSpec>,
    file: String,
    text: String,
}

/// One run of the sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoopCase {
    /// Frame.
    pub frame: Tick,
    /// Latency.
    pub latency: Tick,
    /// Bits of all converters; none for ideal ones.
    pub bits: Option<u32>,
}

/// One row of the answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LoopRow {
    /// Frame, s.
    pub frame_s: f64,
    /// Latency, s.
    pub latency_s: f64,
    /// Bits, none for ideal.
    pub bits: Option<u32>,
    /// ζ of the least damped oscillatory mode found, if any.
    pub zeta: Option<f64>,
    /// |s| of it, rad/s.
    pub omega_rad_s: Option<f64>,
    /// Its growth per cycle.
    pub growth_per_cycle: Option<f64>,
    /// Greatest magnitude in the last tenth of the record over that in the first tenth.
    pub last_over_first: f64,
}

/// Line and column (from 1) of a byte in `text`.
fn place(text: &str, byte: usize) -> (usize, usize) {
    let before = text.get(..byte.min(text.len())).unwrap_or(text);
    let start = before.rfind('\n').map_or(0, |i| i + 1);
    (
        before.matches('\n').count() + 1,
        before[start..].chars().count() + 1,
    )
}

struct Faults<'a> {
    file: &'a str,
    text: &'a str,
    list: Vec<StudyFault>,
}

impl Faults<'_> {
    fn add(&mut self, span: &Range<usize>, message: impl Into<String>, help: impl Into<String>) {
        let (line, column) = place(self.text, span.start);
        self.list.push(StudyFault {
            file: self.file.to_owned(),
            line,
            column,
            message: message.into(),
            help: help.into(),
        });
    }

    fn duration(&mut self, value: &Spanned<String>, least: i64) -> Option<Tick> {
        match value.get_ref().parse::<Tick>() {
            Ok(t) if t.0 >= least => Some(t),
            Ok(t) => {
                self.add(&value.span(), format!("a duration of {t} is too short"), "");
                None
            }
            Err(e) => {
                self.add(&value.span(), e.to_string(), "");
                None
            }
        }
    }
}

const KINDS: [&str; 4] = ["gain-matrix", "difference-equation", "delay", "table"];

fn nearest<'a>(word: &str, among: impl IntoIterator<Item = &'a str>) -> String {
    among
        .into_iter()
        .map(|c| (strsim::damerau_levenshtein(word, c), c))
        .filter(|(d, c)| *d <= c.len() / 2)
        .min()
        .map_or_else(String::new, |(_, c)| format!("did you mean `{c}`?"))
}

/// Reads a study; `file` is only for messages.
///
/// # Errors
/// With every fault that can be seen without the patch.
pub fn parse(file: &str, text: &str) -> Result<LoopStudy, StudyFaults> {
    let mut faults = Faults {
        file,
        text,
        list: Vec::new(),
    };
    let raw: Raw = match toml::from_str(text) {
        Ok(raw) => raw,
        Err(e) => {
            faults.add(&e.span().unwrap_or(0..0), e.message().trim().to_owned(), "");
            return Err(StudyFaults(faults.list));
        }
    };
    let stop = faults.duration(&raw.stop, 1).unwrap_or(Tick::ZERO);
    let cases = cases(&raw.sweep, &mut faults);
    if raw.law.is_empty() {
        faults.add(&raw.measure.span(), "the study has no [[law]]", "");
    }
    let mut laws = Vec::new();
    for law in &raw.law {
        if let Some(spec) = law_spec(law, &mut faults) {
            laws.push(spec);
        }
    }
    for (name, value) in &raw.params {
        if !value.is_finite() {
            faults.add(&raw.patch.span(), format!("param `{name}` is {value}"), "");
        }
    }
    if !faults.list.is_empty() {
        return Err(StudyFaults(faults.list));
    }
    Ok(LoopStudy {
        title: raw.title.unwrap_or_else(|| file.to_owned()),
        patch: raw.patch.into_inner(),
        params: raw.params.into_iter().collect(),
        stop,
        cases,
        measure: named(&raw.measure),
        laws,
        file: file.to_owned(),
        text: text.to_owned(),
    })
}

fn cases(sweep: &RawSweep, faults: &mut Faults<'_>) -> Vec<LoopCase> {
    let mut all = Vec::new();
    if sweep.frame.get_ref().is_empty() {
        faults.add(
            &sweep.frame.span(),
            "the sweep has no frame",
            "list at least one, as \"20ms\"",
        );
    }
    let latencies: Vec<f64> = sweep.latency.as_ref().map_or(vec![0.0], |list| {
        list.iter()
            .filter_map(|l| {
                let ok = (0.0..=1.0).contains(l.get_ref());
                if !ok {
                    let message = format!("a latency of {} frames", l.get_ref());
                    faults.add(&l.span(), message, "latencies are 0 to 1, in frames");
                }
                ok.then_some(*l.get_ref())
            })
            .collect()
    });
    let bits: Vec<Option<u32>> = sweep.bits.as_ref().map_or(vec![None], |list| {
        list.iter()
            .filter_map(|b| {
                let n = *b.get_ref();
                if n == 0 {
                    return Some(None);
                }
                if !(2..=32).contains(&n) {
                    faults.add(
                        &b.span(),
                        format!("a converter of {n} bits"),
                        "2 to 32, or 0 for ideal",
                    );
                    return None;
                }
                Some(Some(n))
            })
            .collect()
    });
    for text in sweep.frame.get_ref() {
        let Some(frame) = faults.duration(text, 1) else {
            continue;
        };
        for l in &latencies {
            for b in &bits {
                all.push(LoopCase {
                    frame,
                    // At most one frame, so that the product fits wherever the frame does.
                    latency: Tick((frame.0 as f64 * l).round() as i64),
                    bits: *b,
                });
            }
        }
    }
    all
}

fn named(s: &Spanned<String>) -> Named {
    Named {
        name: s.get_ref().clone(),
        span: s.span(),
    }
}

fn law_spec(law: &Spanned<RawLaw>, faults: &mut Faults<'_>) -> Option<LawSpec> {
    let raw = law.get_ref();
    let kind = raw.kind.get_ref().as_str();
    let allowed: &[&str] = match kind {
        "gain-matrix" => &["inputs", "outputs", "gain"],
        "difference-equation" => &["input", "output", "numerator", "denominator"],
        "delay" => &["input", "output", "frames", "gain"],
        "table" => &["input", "output", "x", "y"],
        other => {
            let help = format!("{} kinds: {}", nearest(other, KINDS), KINDS.join(", "));
            faults.add(
                &raw.kind.span(),
                format!("unknown law `{other}`"),
                help.trim().to_owned(),
            );
            return None;
        }
    };
    let given = [
        (
            "inputs",
            raw.inputs
                .as_ref()
                .map(|v| v.first().map_or(law.span(), Spanned::span)),
        ),
        (
            "outputs",
            raw.outputs
                .as_ref()
                .map(|v| v.first().map_or(law.span(), Spanned::span)),
        ),
        ("input", raw.input.as_ref().map(Spanned::span)),
        ("output", raw.output.as_ref().map(Spanned::span)),
        ("gain", raw.gain.as_ref().map(Spanned::span)),
        ("numerator", raw.numerator.as_ref().map(Spanned::span)),
        ("denominator", raw.denominator.as_ref().map(Spanned::span)),
        ("frames", raw.frames.as_ref().map(Spanned::span)),
        ("x", raw.x.as_ref().map(Spanned::span)),
        ("y", raw.y.as_ref().map(Spanned::span)),
    ];
    let before = faults.list.len();
    for (key, span) in &given {
        match span {
            Some(span) if !allowed.contains(key) => {
                faults.add(
                    span,
                    format!("`{key}` has no meaning in a `{kind}` law"),
                    "",
                );
            }
            // A delay's gain is 1 unless stated.
            None if allowed.contains(key) && !(kind == "delay" && *key == "gain") => {
                faults.add(
                    &raw.kind.span(),
                    format!("a `{kind}` law needs `{key}`"),
                    "",
                );
            }
            _ => {}
        }
    }
    if faults.list.len() > before {
        return None;
    }
    let list = |many: &Option<Vec<Spanned<String>>>, one: &Option<Spanned<String>>| {
        many.iter()
            .flatten()
            .chain(one)
            .map(named)
            .collect::<Vec<_>>()
    };
    let inputs = list(&raw.inputs, &raw.input);
    let outputs = list(&raw.outputs, &raw.output);
    let element = match kind {
        "gain-matrix" => gain_matrix(raw.gain.as_ref()?, inputs.len(), outputs.len(), faults)?,
        "delay" => {
            let gain = match &raw.gain {
                None => 1.0,
                Some(g) => number(g.get_ref()).or_else(|| {
                    faults.add(&g.span(), "the gain of a delay must be a number", "");
                    None
                })?,
            };
            let frames = raw.frames.as_ref()?;
            Element::delay(*frames.get_ref(), gain)
                .map_err(|e| faults.add(&frames.span(), e.to_string(), ""))
                .ok()?
        }
        "difference-equation" => {
            let (b, a) = (raw.numerator.as_ref()?, raw.denominator.as_ref()?);
            Element::difference(b.get_ref().clone(), a.get_ref().clone())
                .map_err(|e| faults.add(&a.span(), e.to_string(), ""))
                .ok()?
        }
        _ => {
            let (x, y) = (raw.x.as_ref()?, raw.y.as_ref()?);
            Table1::new(x.get_ref().clone(), y.get_ref().clone())
                .map_err(|e| faults.add(&x.span(), e.to_string(), ""))
                .ok()
                .map(Element::Table)?
        }
    };
    Some(LawSpec {
        inputs,
        outputs,
        element,
    })
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
    let rows: Option<Vec<Vec<f64>>> = value.get_ref().as_array().and_then(|rows| {
        rows.iter()
            .map(|r| r.as_array()?.iter().map(number).collect())
            .collect()
    });
    match rows {
        Some(rows) if rows.len() == outputs && rows.iter().all(|r| r.len() == inputs) => {
            Some(Element::Gain(rows))
        }
        _ => {
            faults.add(
                &value.span(),
                format!("`gain` must be {outputs} rows of {inputs} numbers"),
                "one row an output, one column an input",
            );
            None
        }
    }
}

impl LoopStudy {
    /// The law for one run, its channel names looked up in the loaded patch.
    ///
    /// # Errors
    /// For every name that is no ADC or DAC of the patch.
    pub fn law(&self, channels: &[Channel]) -> Result<LoopLaw, StudyFaults> {
        let mut faults = Faults {
            file: &self.file,
            text: &self.text,
            list: Vec::new(),
        };
        let mut find = |n: &Named, kind: ChannelKind, what: &str| {
            let of_kind = || channels.iter().filter(|c| c.kind == kind);
            let found = of_kind().find(|c| c.name == n.name);
            if found.is_none() {
                let mut help = nearest(&n.name, of_kind().map(|c| c.name.as_str()));
                if help.is_empty() {
                    let names: Vec<&str> = of_kind().map(|c| c.name.as_str()).collect();
                    help = format!("the patch has: {}", names.join(", "));
                }
                let message = format!("the patch has no {what} `{}`", n.name);
                faults.add(&n.span, message, help);
            }
            found.map_or(0, |c| c.number as usize)
        };
        let measure = find(&self.measure, ChannelKind::Adc, "ADC");
        let parts = self
            .laws
            .iter()
            .map(|l| {
                let inputs = l
                    .inputs
                    .iter()
                    .map(|n| find(n, ChannelKind::Adc, "ADC"))
                    .collect();
                let outputs = l
                    .outputs
                    .iter()
                    .map(|n| find(n, ChannelKind::Dac, "DAC"))
                    .collect();
                (inputs, outputs, l.element.clone())
            })
            .collect();
        if faults.list.is_empty() {
            Ok(LoopLaw::new(measure, parts))
        } else {
            Err(StudyFaults(faults.list))
        }
    }
}

impl LoopCase {
    /// What a run did.
    ///
    /// A record without oscillation leaves the modal columns empty; only a record that cannot be
    /// judged at all is an error.
    ///
    /// # Errors
    /// On an empty or non-finite record.
    pub fn row(&self, law: &LoopLaw) -> Result<LoopRow, LabError> {
        let record = law.record();
        let floor = match self.bits {
            // Quantisation of relative size 2^−bits stands above the noise-free floor.
            Some(bits) => 4.0 * 2f64.powi(-i32::try_from(bits).unwrap_or(32)),
            None => 1e-9,
        };
        let poles = match identify::poles(record, self.frame.secs(), floor) {
            Ok(p) => p,
            Err(identify::IdentifyError::NoOscillation) => Vec::new(),
            Err(e) => return Err(e.into()),
        };
        let half_rate = std::f64::consts::PI / self.frame.secs();
        let least: Option<C64> = poles
            .into_iter()
            .filter(|s| s.im > 0.0 && s.im < 0.999 * half_rate)
            .max_by(|a, b| a.re.total_cmp(&b.re));
        let tenth = (record.len() / 10).max(1);
        let peak = |part: &[f64]| part.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        Ok(LoopRow {
            frame_s: self.frame.secs(),
            latency_s: self.latency.secs(),
            bits: self.bits,
            zeta: least.map(damping_ratio),
            omega_rad_s: least.map(|s| s.norm()),
            growth_per_cycle: least.map(super::theory::growth_per_cycle),
            last_over_first: peak(&record[record.len() - tenth..]) / peak(&record[..tenth]),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{
        feedback::{Compensation, RootSetting},
        plain_machine::PlainMachine,
    };

    const GOOD: &str = r#"
title = "Servo"
patch = "root.toml"
stop = "10s"
measure = "x_adc"
[params]
wn = 3.0
[sweep]
frame = ["50ms", "100ms"]
latency = [0.0, 1.0]
bits = [0]
[[law]]
kind = "difference-equation"
input = "x_adc"
output = "u"
numerator = [13.5, -4.5]
denominator = [1.0]
"#;

    fn channels() -> Vec<Channel> {
        let channel = |kind, name: &str| Channel {
            kind,
            name: name.to_owned(),
            number: 0,
            full_scale: None,
        };
        vec![
            channel(ChannelKind::Adc, "x_adc"),
            channel(ChannelKind::Dac, "u"),
        ]
    }

    /// A study that writes half-frame prediction as a difference equation finds the roots of theory.
    #[test]
    fn a_study_finds_the_roots_of_its_loop() {
        let study = parse("servo.toml", GOOD).unwrap();
        assert_eq!(study.cases.len(), 4);
        for case in &study.cases {
            let setting = RootSetting {
                omega0_rad_s: 3.0,
                zeta: 0.3,
                frame_s: case.frame.secs(),
                latency_frames: case.latency.secs() / case.frame.secs(),
                compensation: Compensation::HalfFrame,
            };
            let mut law = study.law(&channels()).unwrap();
            let mut machine = PlainMachine::new(
                &[&[0.0, 1.0], &[0.0, -1.8]],
                &[&[0.0], &[-1.0]],
                &[&[1.0, 0.0]],
                &[1.0, 0.0],
            );
            machine.run(&setting.plan().unwrap(), |n, adc, up| law.step(n, adc, up));
            let row = case.row(&law).unwrap();
            let exact = damping_ratio(setting.theory().exact_root().unwrap());
            // As in the root experiment; the first frames, in which the equation's memory fills from
            // zero, add modes that the pencil tells apart.
            assert!((row.zeta.unwrap() - exact).abs() < 1e-4, "{row:?} {exact}");
        }
    }

    #[test]
    fn faults_name_file_and_line() {
        let line_of = |text: &str, part: &str| {
            let faults = parse("servo.toml", text).unwrap_err();
            let found = faults.0.iter().find(|f| f.message.contains(part));
            found.unwrap_or_else(|| panic!("{faults}")).line
        };
        assert_eq!(line_of(&GOOD.replace("\"50ms\"", "\"50\""), "duration"), 9);
        assert_eq!(
            line_of(&GOOD.replace("[0.0, 1.0]", "[0.0, 1.5]"), "1.5"),
            10
        );
        assert_eq!(
            line_of(&GOOD.replace("bits = [0]", "bits = [99]"), "99"),
            11
        );
        assert_eq!(
            line_of(
                &GOOD.replace("difference-equation", "diference-equation"),
                "unknown law"
            ),
            13
        );
        assert_eq!(
            line_of(&GOOD.replace("[1.0]\n", "[0.0]\n"), "denominator"),
            17
        );
        assert_eq!(
            line_of(&GOOD.replace("output = \"u\"\n", ""), "`output`"),
            13
        );
        assert_eq!(line_of(&GOOD.replace("stop =", "stopp ="), "stopp"), 4);
        assert_eq!(line_of("patch = ", "string"), 1);
        let many = GOOD
            .replace("\"50ms\"", "\"50\"")
            .replace("[0.0, 1.0]", "[2.0]");
        assert_eq!(parse("servo.toml", &many).unwrap_err().0.len(), 2);
        let text = parse("servo.toml", &GOOD.replace("\"50ms\"", "\"50\""))
            .unwrap_err()
            .to_string();
        assert!(text.starts_with("servo.toml:9:10: "), "{text}");
    }

    #[test]
    fn unknown_channels_are_told_with_the_nearest_name() {
        let study = parse(
            "servo.toml",
            &GOOD.replace("input = \"x_adc\"", "input = \"x_adk\""),
        )
        .unwrap();
        let faults = study.law(&channels()).unwrap_err();
        assert_eq!((faults.0.len(), faults.0[0].line), (1, 14));
        assert!(faults.0[0].help.contains("x_adc"));
    }
}
