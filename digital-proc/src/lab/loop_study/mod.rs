//! A user's own loop study: one TOML file that names a patch, a digital law and a sweep.
//!
//! What it may hold is told in the help of its command, [`Loop`]. Every fault names the file and
//! the line; all that can be judged without the patch are reported at once.

mod law_text;
mod poles;
mod remark;
mod row;
mod swing;
mod text;

use self::{poles::Poles, remark::Remark, row::LoopRow};
use super::{
    bench::chosen,
    loop_law::{Element, LoopLaw},
    theory::growth_per_cycle,
    *,
};
use crate::linkage::console::ConsoleFault;
use desk::{
    bundle::bundle_from_path,
    faults::{FileFault, FileFaults, Source, suggestion},
    reader::Named,
};
use interface::control::{Channel, ChannelKind, PatchBundle};
use std::path::{Path, PathBuf};

/// Your own loop: a patch and a digital law from a TOML file, over frames, latencies and bits
///
/// A loop of your own: a patch with ADC and DAC lines, and a digital law, from one TOML file.
///
///     title = "My servo"
///     patch = "servo.toml"            # beside this file
///     stop = "20s"
///     measure = "x_adc"               # the ADC whose record is judged
///     from = "0.5s"                   # what of it, if not all of the run
///     until = "10s"
///
///     [params]                        # values for the patch's [params]
///     wn = 3.0
///
///     [sweep]
///     frame = ["20ms", "50ms"]
///     latency = [0.0, 1.0]            # in frames
///     bits = [8, 12, 0]               # 0: ideal converters; bits need `max` at ADC and DAC
///
///     [[law]]                         # one or more
///     kind = "gain-matrix"            # y = G x
///     inputs = ["x_adc"]
///     outputs = ["u"]
///     gain = [[9.0]]
///
/// Other kinds, each with one `input` and one `output`: `difference-equation` (`numerator`,
/// `denominator`), `delay` (`frames`, `gain`), `table` (`x`, `y`). A fault names file and line.
///
/// The record must be a free decay, or a step response after the last change of the reference:
/// state `from`. The column `fit` is what the modes found leave of it (rms over rms); where that
/// is more than a linear loop and its converters leave, no damping is told, and a remark says why.
/// A case that saturates is judged from there on.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
#[allow(rustdoc::invalid_rust_codeblocks, reason = "the help shows a TOML file")]
pub struct Loop {
    /// The study
    #[arg(value_name = "STUDY.toml")]
    study: PathBuf,
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
    /// Its own, or the file's name.
    pub title: String,
    patch: Named,
    /// Values for the patch's `[params]`.
    pub params: Vec<(String, f64)>,
    pub stop: Tick,
    /// Start of the record that is judged.
    pub from: Tick,
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
    pub frame: Tick,
    pub latency: Tick,
    /// Bits of all converters; none for ideal ones.
    pub bits: Option<u32>,
}

impl LoopStudy {
    fn source(&self) -> Source<'_> {
        Source { file: &self.file, text: &self.text }
    }

    /// The patch, named relative to the study file.
    fn bundle(&self, study: &Path) -> Result<PatchBundle, FileFault> {
        let folder = study.parent().unwrap_or(Path::new(""));
        bundle_from_path(&folder.join(&self.patch.name)).map_err(|fault| {
            let remedy = "the path is relative to the study's own folder";
            self.source().fault(self.patch.span, fault.to_string(), remedy)
        })
    }

    /// What ended a run of `case` that is not the fault of the machine: a patch that refuses the
    /// study's parameters or converters, a record that says nothing.
    fn case_fault(&self, case: &LoopCase, cause: &LabError) -> FileFault {
        let fault = format!("frame {}, latency {}: {cause}", case.frame, case.latency);
        let remedy = "look at this study's patch, params, stop and sweep";
        self.source().fault(self.measure.span, fault, remedy)
    }

    /// The law for one run, its channel names looked up in the loaded patch; faults for every
    /// name that is no ADC or DAC of it.
    fn law(&self, channels: &[Channel]) -> Result<LoopLaw, FileFaults> {
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

impl LoopStudy {
    fn run(
        &self,
        bench: &mut Bench<'_, '_>,
        bundle: &PatchBundle,
        case: &LoopCase,
    ) -> Result<LoopRow, LabError> {
        let mut profile = bench.base().clone();
        if let Some(bits) = case.bits {
            profile.adc.bits = chosen(bits);
            profile.dac.bits = chosen(bits);
        }
        let bits = profile.adc.bits.as_ref().map(|b| b.value);
        let channels = bench.load(bundle.clone(), self.params.clone(), profile.clone())?;
        let mut law = self.law(channels)?;
        let poles = Poles::of(self, bench, &profile, case)?;
        let spec = lock_step(case.frame, case.latency, Tick::ZERO, self.stop);
        let saturated = bench.operate(&spec, &mut |samples, updates| law.step(samples, updates))?;
        let mut row = self.row(&LoopCase { bits, ..*case }, law.record(), &saturated)?;
        match poles {
            Ok(poles) => row.poles = Some(poles),
            Err(reason) => row.remarks.push(Remark::NoPoles(reason)),
        }
        Ok(row)
    }
}

impl Experiment for Loop {
    const NAME: &'static str = "loop";
    const TITLE: &'static str = "A loop of the user's own";
    const LEAD: &'static str =
        "The least damped mode of the measured record over frame period, latency and bits.";

    fn measure(&self, bench: &mut Bench<'_, '_>, outcome: &mut Outcome) -> Result<(), Failure> {
        let study = text::load(&self.study)?;
        let bundle = study.bundle(&self.study).map_err(|fault| FileFaults(vec![fault]))?;
        outcome.title.clone_from(&study.title);
        outcome.set("study", study.text.as_str());
        let rows = bench.each(&study.cases, |bench, case| {
            study.run(bench, &bundle, case).map_err(|fault| match fault {
                LabError::Study(_) => fault,
                LabError::Console(ref cause)
                    if !matches!(
                        cause,
                        ConsoleFault::Refused(_) | ConsoleFault::RunFault { .. }
                    ) =>
                {
                    fault
                }
                told => FileFaults(vec![study.case_fault(case, &told)]).into(),
            })
        })?;
        for explanation in rows.iter().flat_map(|r| &r.remarks).filter_map(Remark::explanation) {
            if !outcome.remarks.contains(&explanation) {
                outcome.remarks.push(explanation);
            }
        }
        let columns = [
            Column::new("frame", "s", |r: &LoopRow| r.case.frame.secs().into()),
            Column::new("latency", "s", |r| r.case.latency.secs().into()),
            Column::new("bits", "", |r| {
                r.case.bits.map_or_else(|| "ideal".into(), |b| f64::from(b).into())
            }),
            Column::new("zeta", "", |r| r.root.map(damping_ratio).into()),
            Column::new("omega", "rad/s", |r| r.root.map(|s| s.modulus()).into()),
            Column::new("zeta exact", "", |r| r.exact().map(damping_ratio).into()),
            Column::new("omega exact", "rad/s", |r| r.exact().map(|s| s.modulus()).into()),
            Column::of("spectral radius", "", 6, |r| {
                r.poles.as_ref().map(Poles::spectral_radius).into()
            }),
            Column::of("growth per cycle", "", 5, |r| r.root.map(growth_per_cycle).into()),
            Column::of("last tenth / first tenth", "", 3, |r| r.last_over_first.into()),
            Column::of("fit", "", 2, |r| r.fit.into()),
            Column::new("remark", "", |r| {
                let all: Vec<String> = r.remarks.iter().map(ToString::to_string).collect();
                Cell::from(all.join("; "))
            }),
        ];
        let caption = "Least damped oscillatory mode of each case; fit is what the modes leave of the record. Exact: the poles of the loop made linear at its initial condition, sampled, held and late as it is; beyond a spectral radius of 1 it is unstable.";
        outcome.section("Numbers").table("loop", caption, Table::of(&columns, &rows));

        // Latency in frames, to a thousandth, and bits: what makes a curve.
        let kind = |r: &LoopRow| {
            let share = r.case.latency.secs() / r.case.frame.secs();
            ((1e3 * share).round() / 1e3, r.case.bits)
        };
        let mut kinds: Vec<(f64, Option<u32>)> = Vec::new();
        for row in &rows {
            if !kinds.contains(&kind(row)) {
                kinds.push(kind(row));
            }
        }
        let chart = |title: &str, y: Axis, value: fn(&LoopRow) -> Option<f64>| {
            let series = kinds.iter().map(|of| {
                let bits = of.1.map_or("ideal".to_owned(), |b| format!("{b} bits"));
                let points = rows.iter().filter(|r| kind(r) == *of);
                let points =
                    points.map(|r| (r.case.frame.secs() * 1e3, value(r).unwrap_or(f64::NAN)));
                Series::of(format!("latency {} frames, {bits}", of.0), points)
                    .draw(Draw::LineAndMarkers)
            });
            LineChart::new(title, Axis::new("frame", "ms"), y, series.collect())
        };
        let damping = chart("Damping", damping_axis(), |r| r.root.map(damping_ratio));
        let frequency =
            chart("Frequency", Axis::new("frequency", "rad/s"), |r| r.root.map(|s| s.modulus()));
        let caption = "Damping ratio of the least damped oscillatory mode; below zero the loop is unstable. Cases without a value are left out.";
        let figures = outcome.section("Figures");
        let figures = figures.chart("damping", caption, &damping.limit(0.0, "stability"));
        figures.chart("frequency", "Its frequency.", &frequency);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::text::parse;

    const SHIPPED: &str = include_str!("../../../../patch-files/studies/servo-loop.toml");

    #[test]
    fn faults_name_file_and_line() {
        let measure = "measure = \"x_adc\"";
        let window = |keys: &str| format!("{measure}\n{keys}");
        for (good, bad, place, word) in [
            ("\"50ms\"", "\"50\"", "15:18", "duration"),
            ("[0.0, 1.0]", "[0.0, 1.5]", "16:", "1.5"),
            ("latency =", "bits = [99]\nlatency =", "16:", "99"),
            ("difference-equation", "diference-equation", "19:", "`law.kind` cannot be"),
            ("denominator = [1.0]", "denominator = [0.0]", "23:", "denominator"),
            ("output = \"u\"\n", "", "18:", "`output`"),
            ("stop =", "stopp =", "7:", "stopp"),
            ("title = ", "title = \n", "5:", "string"),
            (measure, &window("from = \"11s\""), "9:8", "from 11s until 10s"),
            (measure, &window("from = \"2s\"\nuntil = \"1s\""), "9:8", "from 2s until 1s"),
            (measure, &window("until = \"12s\""), "9:9", "until 12s"),
            (measure, &window("from = 0.5"), "9:8", "a time in quotes"),
        ] {
            let told = parse("servo.toml", &SHIPPED.replace(good, bad)).unwrap_err().to_string();
            let mut lines = told.lines();
            let at = format!("servo.toml:{place}");
            assert!(lines.any(|l| l.starts_with(&at) && l.contains(word)), "{bad}: {told}");
        }
        let many = SHIPPED.replace("\"50ms\"", "\"50\"").replace("[0.0, 1.0]", "[2.0]");
        assert_eq!(parse("servo.toml", &many).unwrap_err().0.len(), 2);
    }
}
