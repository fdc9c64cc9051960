//! A user's own loop study: one TOML file that names a patch, a digital law and a sweep.
//!
//! ```toml
//! title = "My servo"
//! patch = "servo.toml"            # beside this file
//! stop = "20s"
//! measure = "x_adc"               # ADC whose record is identified
//! from = "0.5s"                   # the record's window, if it is not all of the run
//! until = "10s"
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

mod law_text;
mod remark;
mod row;
mod swing;
mod text;

pub use remark::Remark;
pub use row::{LoopRow, Saturated, WORST_FIT};
pub use swing::Swing;
pub use text::{load, parse};

use super::loop_law::{Element, LoopLaw};
use desk::faults::{FileFault, FileFaults, Source, suggestion};
use desk::reader::Named;
use interface::{
    Tick,
    control::{Channel, ChannelKind},
};

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
    patch: Named,
    /// Values for the patch's `[params]`.
    pub params: Vec<(String, f64)>,
    /// End of each run.
    pub stop: Tick,
    /// Start of the record that is judged.
    pub from: Tick,
    /// Its end.
    pub until: Tick,
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

impl LoopStudy {
    /// Patch, relative to the study file.
    pub fn patch(&self) -> &str {
        &self.patch.name
    }

    /// The whole text.
    pub fn text(&self) -> &str {
        &self.text
    }

    fn source(&self) -> Source<'_> {
        Source { file: &self.file, text: &self.text }
    }

    /// A fault of the patch, at the place where the study names it.
    pub fn patch_fault(&self, fault: String) -> FileFault {
        let remedy = "the path is relative to the study's own folder";
        self.source().fault(self.patch.span, fault, remedy)
    }

    /// What ended a run of `case` that is not the fault of the machine: a patch that refuses the
    /// study's parameters or converters, a record that says nothing.
    pub fn case_fault(&self, case: &LoopCase, cause: &dyn std::fmt::Display) -> FileFault {
        let fault = format!("frame {}, latency {}: {cause}", case.frame, case.latency);
        let remedy = "look at this study's patch, params, stop and sweep";
        self.source().fault(self.measure.span, fault, remedy)
    }

    /// The law for one run, its channel names looked up in the loaded patch.
    ///
    /// # Errors
    /// For every name that is no ADC or DAC of the patch.
    pub fn law(&self, channels: &[Channel]) -> Result<LoopLaw, FileFaults> {
        let mut faults: Vec<FileFault> = Vec::new();
        let mut find = |n: &Named, kind: ChannelKind, what: &str| {
            let of_kind = || channels.iter().filter(|c| c.kind == kind);
            let found = of_kind().find(|c| c.name == n.name);
            if found.is_none() {
                let fault = format!("the patch has no {what} `{}`", n.name);
                let remedy = suggestion(&n.name, of_kind().map(|c| c.name.as_str()));
                faults.push(self.source().fault(n.span, fault, remedy));
            }
            found.map_or(0, |c| c.number as usize)
        };
        let measure = find(&self.measure, ChannelKind::Adc, "ADC");
        let parts = self
            .laws
            .iter()
            .map(|l| {
                let inputs = l.inputs.iter().map(|n| find(n, ChannelKind::Adc, "ADC")).collect();
                let outputs = l.outputs.iter().map(|n| find(n, ChannelKind::Dac, "DAC")).collect();
                (inputs, outputs, l.element.clone())
            })
            .collect();
        FileFaults::unless(faults, LoopLaw::new(measure, parts))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{
        feedback::{Compensation, RootSetting},
        plain_machine::PlainMachine,
        theory::damping_ratio,
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
        let channel =
            |kind, name: &str| Channel { kind, name: name.to_owned(), number: 0, full_scale: None };
        vec![channel(ChannelKind::Adc, "x_adc"), channel(ChannelKind::Dac, "u")]
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
            let row = study.row(case, &law, &Saturated::default()).unwrap();
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
            let found = faults.0.iter().find(|f| f.fault.contains(part));
            let (line, _) = found.unwrap_or_else(|| panic!("{faults}")).place.unwrap();
            line
        };
        assert_eq!(line_of(&GOOD.replace("\"50ms\"", "\"50\""), "duration"), 9);
        assert_eq!(line_of(&GOOD.replace("[0.0, 1.0]", "[0.0, 1.5]"), "1.5"), 10);
        assert_eq!(line_of(&GOOD.replace("bits = [0]", "bits = [99]"), "99"), 11);
        assert_eq!(
            line_of(
                &GOOD.replace("difference-equation", "diference-equation"),
                "`law.kind` cannot be"
            ),
            13
        );
        assert_eq!(line_of(&GOOD.replace("[1.0]\n", "[0.0]\n"), "denominator"), 17);
        assert_eq!(line_of(&GOOD.replace("output = \"u\"\n", ""), "`output`"), 12);
        assert_eq!(line_of(&GOOD.replace("stop =", "stopp ="), "stopp"), 4);
        assert_eq!(line_of("patch = ", "string"), 1);
        let many = GOOD.replace("\"50ms\"", "\"50\"").replace("[0.0, 1.0]", "[2.0]");
        assert_eq!(parse("servo.toml", &many).unwrap_err().0.len(), 2);
        let text =
            parse("servo.toml", &GOOD.replace("\"50ms\"", "\"50\"")).unwrap_err().to_string();
        assert!(text.starts_with("servo.toml:9:10: "), "{text}");
    }

    #[test]
    fn unknown_channels_are_told_with_the_nearest_name() {
        let study =
            parse("servo.toml", &GOOD.replace("input = \"x_adc\"", "input = \"x_adk\"")).unwrap();
        let faults = study.law(&channels()).unwrap_err();
        assert_eq!((faults.0.len(), faults.0[0].place.unwrap().0), (1, 14));
        assert!(faults.0[0].remedy.contains("x_adc"));
    }
}
