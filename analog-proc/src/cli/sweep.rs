//! `analog-proc sweep`: the same patch with other parameters, run after run, measured and overlaid.

use super::{
    PatchArgs, add_files, check::Compiled, expect_page, find_net, happenings, page_record,
    write_page,
};
use desk::{
    command_line::interrupt_flag,
    failure::Failure,
    outcome::Outcome,
    progress::Progress,
    report::{
        Cell, Heading, Table,
        plot::{Axis, LineChart, Series},
    },
};
use engine::{fault::RunFault, id::NetId};
use interface::{
    Tick,
    side_by_side::{Jobs, side_by_side},
};
use std::{
    ops::ControlFlow,
    path::PathBuf,
    sync::atomic::{AtomicBool, Ordering},
};

/// Most runs of one sweep.
const MOST_RUNS: usize = 100_000;
/// Most rows recorded of one run: what a picture shows, and measures need, is far less.
const MOST_ROWS: u64 = 1_000_000;
/// Two swings may differ by this part for the last to be told as a period.
const SWINGS_ALIKE: f64 = 1e-2;
/// Most values kept at once: half a gigabyte.
const MOST_VALUES: u64 = 1 << 26;
/// Most runs overlaid in one figure.
const MOST_DRAWN: usize = 12;

/// Run a patch once for each setting of its parameters
///
/// Run a patch once for each setting of its parameters (iterative operation).
///
///   analog-proc sweep patch-files/van-der-pol.toml --set mu=0.1:5:8 --until 30s --page mu.html
///   analog-proc sweep patch-files/damped-oscillator.toml --set zeta=0.1,0.3,1 --until 10s
///
/// LOW:HIGH:COUNT are so many values from LOW to HIGH, LOW:HIGH:COUNT:log in equal ratios; several
/// --set are combined, each with each. Runs go side by side on all processors, each as if alone. Of
/// each net: its last value, least and greatest, and the period of its last swing about its mean, where the
/// one before is as long to a hundredth.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Sweep {
    /// The patch file
    patch: PathBuf,
    /// Values of a parameter: a list, LOW:HIGH:COUNT, or LOW:HIGH:COUNT:log; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUES", value_parser = values, required = true)]
    sets: Vec<(String, Vec<f64>)>,
    /// Problem time to stop at, e.g. 20s
    #[arg(long, value_name = "TIME")]
    until: Tick,
    /// Interval between the rows that are measured and drawn [default: a thousandth of the run]
    #[arg(long, value_name = "TIME")]
    every: Option<Tick>,
    /// Nets to record, separated by commas [default: every integrator and lag]
    #[arg(long, value_delimiter = ',', value_name = "NETS")]
    record: Vec<String>,
    /// Page to write, with the runs overlaid
    #[arg(long, value_name = "FILE.html")]
    page: Option<PathBuf>,
    /// Machine profile: ideal, paper-class, ad4, or a file
    #[arg(long, default_value = "ideal")]
    profile: String,
    /// Print results and faults as JSON
    #[arg(long)]
    json: bool,
}

fn values(text: &str) -> Result<(String, Vec<f64>), String> {
    let (name, values) =
        text.split_once('=').ok_or("write NAME=VALUES, for example mu=0.1:10:20")?;
    let number = |text: &str| match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("`{text}` is not a finite number")),
    };
    let (range, is_log) = match values.strip_suffix(":log") {
        Some(range) => (range, true),
        None => (values, false),
    };
    let all = match range.split(':').collect::<Vec<_>>()[..] {
        [low, high, count] => {
            let (low, high) = (number(low)?, number(high)?);
            let count = count.trim().parse::<usize>().ok().filter(|n| (2..=MOST_RUNS).contains(n));
            let count = count.ok_or(format!("give 2 to {MOST_RUNS} values"))?;
            if is_log && (low <= 0.0 || high <= 0.0) {
                return Err("equal ratios need two positive ends".into());
            }
            let at = |i: usize| {
                let part = i as f64 / (count - 1) as f64;
                match i {
                    0 => low,
                    _ if i + 1 == count => high,
                    _ if is_log => low * libm::pow(high / low, part),
                    _ => low + (high - low) * part,
                }
            };
            (0..count).map(at).collect()
        }
        [list] if !is_log => list.split(',').map(number).collect::<Result<_, _>>()?,
        _ => return Err("write a list, or LOW:HIGH:COUNT, for example mu=0.1:10:20".into()),
    };
    Ok((name.trim().to_owned(), all))
}

/// What is told of a net in one run.
struct Measures {
    last: f64,
    least: f64,
    greatest: f64,
    period_s: Option<f64>,
}

/// One run.
struct Row {
    is_whole: bool,
    /// Why it ended early, and what else happened.
    remark: String,
    /// Of each net.
    measures: Vec<Measures>,
    times_s: Vec<f64>,
    /// The nets' values at those times.
    curves: Vec<Vec<f64>>,
}

impl Sweep {
    pub fn execute(self) -> Result<(), Failure> {
        let every = self.every.unwrap_or(Tick((self.until.0 / 1000).max(1)));
        if self.until <= Tick::ZERO || every <= Tick::ZERO || every > self.until {
            return Err(Failure::input(format!(
                "--until {} and --every {every} must be positive, and a run longer than its interval",
                self.until
            )));
        }
        if (self.until.0 / every.0) as u64 > MOST_ROWS {
            return Err(Failure::input(format!(
                "--every {every} makes more than {MOST_ROWS} rows a run; give a longer interval"
            )));
        }
        if let Some(page) = &self.page {
            expect_page(page, &self.patch)?;
        }
        let cases = self.cases()?;
        // The first is compiled here, so that a fault of the patch is told once and in full.
        let first = self.of(&cases[0]);
        let Compiled { ordered, hash } =
            first.compile().map_err(|f| self.labelled(&cases[0], f))?;
        let netlist = &ordered.netlist;
        let names: Vec<String> =
            if self.record.is_empty() { super::run::states(&ordered) } else { self.record.clone() };
        let nets = names.iter().map(|n| find_net(&ordered, n)).collect::<Result<Vec<_>, _>>()?;
        let drawn = drawn(cases.len());
        let rows = (self.until.0 / every.0) as u64 + 1;
        let kept = if self.page.is_some() { drawn.len() as u64 } else { 0 };
        let at_once = std::thread::available_parallelism().map_or(1, |n| n.get() as u64) + kept;
        if rows.saturating_mul(nets.len() as u64).saturating_mul(at_once) > MOST_VALUES {
            return Err(Failure::input(format!(
                "{rows} rows of {} nets are more than is kept of a sweep; give a longer --every, or fewer nets with --record",
                nets.len()
            )));
        }
        let interrupted = interrupt_flag().map_err(Failure::input)?;
        let worker = |jobs: Jobs<'_, Result<Row, Failure>>| {
            while let Some(i) = jobs.next() {
                let run = self.run(&cases[i], &nets, every, jobs.given_up());
                // Only what is drawn is kept whole.
                let keep = |row: Row| match self.page.is_some() && drawn.contains(&i) {
                    true => row,
                    false => Row { times_s: Vec::new(), curves: Vec::new(), ..row },
                };
                jobs.done(i, run.map(keep));
            }
        };
        let mut rows: Vec<Option<Row>> = (0..cases.len()).map(|_| None).collect();
        let mut progress = Progress::new(cases.len() as u64, "runs");
        let mut done = 0;
        let swept = side_by_side(cases.len(), worker, |result| {
            if let Some((i, row)) = result {
                rows[i] = Some(row?);
                done += 1;
                progress.at(done);
            }
            match interrupted.load(Ordering::Relaxed) {
                true => Err(Failure::interrupted(format!("interrupted after {done} runs"))),
                false => Ok(()),
            }
        });
        progress.done();
        swept?;
        let rows: Vec<Row> = rows.into_iter().flatten().collect();
        let mut outcome = Outcome::new(
            format!("{}: {} runs to {}", netlist.title, cases.len(), self.until),
            "Each run from its initial conditions, as if alone.",
        );
        outcome.section("Runs").table(
            "sweep",
            "Measures of each run",
            self.table(&names, &cases, &rows),
        );
        let faults = rows.iter().filter(|row| !row.is_whole).count();
        if faults == rows.len() {
            outcome.refused.push("every run ended early".to_owned());
        } else if faults > 0 {
            outcome.remarks.push(format!("{faults} of {} runs ended early", rows.len()));
        }
        if let Some(page) = &self.page {
            if drawn.len() < cases.len() {
                let text =
                    format!("{} of {} runs are drawn, evenly chosen.", drawn.len(), cases.len());
                outcome.section("Overlay").aside(text);
            }
            for (k, name) in names.iter().enumerate() {
                let series = drawn.iter().map(|i| {
                    Series::line(self.label(&cases[*i]), &rows[*i].times_s, &rows[*i].curves[k])
                });
                let axes = (Axis::new("Time", "s"), Axis::new(name.as_str(), ""));
                let chart = LineChart::new(name.as_str(), axes.0, axes.1, series.collect());
                outcome.section("Overlay").chart(
                    name.as_str(),
                    format!("`{name}` over the runs."),
                    &chart,
                );
            }
            write_page(&outcome, &page_record("sweep", &first, hash), page)?;
            add_files(&mut outcome, [page.as_path()]);
        }
        outcome.tell("sweep", None, self.json)
    }

    /// Every combination of the values, the last parameter fastest.
    fn cases(&self) -> Result<Vec<Vec<f64>>, Failure> {
        let names = || self.sets.iter().map(|set| &set.0);
        if let Some((_, name)) =
            names().enumerate().find(|(i, name)| names().take(*i).any(|n| n == *name))
        {
            return Err(Failure::input(format!("--set names `{name}` twice; give it once")));
        }
        let count = self.sets.iter().fold(1_usize, |n, set| n.saturating_mul(set.1.len()));
        if count > MOST_RUNS {
            return Err(Failure::input(format!(
                "{count} runs are more than {MOST_RUNS}; give fewer values"
            )));
        }
        let mut cases = vec![Vec::new()];
        for (_, values) in &self.sets {
            let each = |case: Vec<f64>| values.iter().map(move |v| [&case[..], &[*v]].concat());
            cases = cases.into_iter().flat_map(each).collect();
        }
        Ok(cases)
    }

    /// The patch with the parameters of a case.
    fn of(&self, case: &[f64]) -> PatchArgs {
        PatchArgs {
            patch: self.patch.clone(),
            params: self.sets.iter().map(|set| set.0.clone()).zip(case.iter().copied()).collect(),
            profile: self.profile.clone(),
            json: self.json,
        }
    }

    fn labelled(&self, case: &[f64], failure: Failure) -> Failure {
        Failure { text: format!("{}: {}", self.label(case), failure.text), ..failure }
    }

    fn label(&self, case: &[f64]) -> String {
        let one = |(set, value): (&(String, Vec<f64>), &f64)| {
            format!("{} = {}", set.0, desk::report::significant(*value, 4))
        };
        self.sets.iter().zip(case).map(one).collect::<Vec<_>>().join(", ")
    }

    fn run(
        &self,
        case: &[f64],
        nets: &[NetId],
        every: Tick,
        given_up: &AtomicBool,
    ) -> Result<Row, Failure> {
        let told = |f: Failure| self.labelled(case, f);
        let Compiled { ordered, .. } = self.of(case).compile().map_err(told)?;
        let mut simulation = ordered.simulation().map_err(|f| told(Failure::input(f)))?;
        let mut times_s = vec![0.0];
        let mut curves: Vec<Vec<f64>> = nets.iter().map(|net| vec![simulation.net(*net)]).collect();
        let go_on = || match given_up.load(Ordering::Relaxed) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let mut sink = |t_s: f64, values: &[f64]| {
            times_s.push(t_s);
            curves.iter_mut().zip(values).for_each(|(curve, value)| curve.push(*value));
            go_on()
        };
        let end =
            simulation
                .advance_recording_attended(self.until, every, nets, &mut sink, &mut |_| go_on());
        let has_ended = match end {
            Ok(advance) => advance.stopped_by.map(|_| format!("ended at {}", advance.reached)),
            Err(fault @ RunFault::Halted { .. }) => return Err(Failure::interrupted(fault)),
            Err(fault) => Some(fault.to_string()),
        };
        let is_whole = has_ended.is_none();
        let remark = has_ended
            .into_iter()
            .chain(happenings(&ordered, &simulation))
            .collect::<Vec<_>>()
            .join("; ");
        let mut measures: Vec<Measures> =
            curves.iter().map(|curve| Measures::of(&times_s, curve)).collect();
        if is_whole {
            // The end need not be a row.
            measures.iter_mut().zip(nets).for_each(|(of, net)| of.last = simulation.net(*net));
        }
        Ok(Row { is_whole, remark, measures, times_s, curves })
    }

    fn table(&self, names: &[String], cases: &[Vec<f64>], rows: &[Row]) -> Table {
        let mut headings: Vec<Heading> =
            self.sets.iter().map(|set| Heading::new(set.0.as_str(), "").digits(6)).collect();
        for name in names {
            for (what, unit) in [("last", ""), ("least", ""), ("greatest", ""), ("period", "s")] {
                headings.push(Heading::new(format!("{name} {what}"), unit).digits(6));
            }
        }
        headings.push(Heading::new("remark", ""));
        let mut table = Table::new(headings);
        for (case, row) in cases.iter().zip(rows) {
            let measures = row.measures.iter().flat_map(|m| {
                [m.last.into(), m.least.into(), m.greatest.into(), Cell::from(m.period_s)]
            });
            let parameters = case.iter().map(|value| Cell::from(*value));
            table.row(parameters.chain(measures).chain([Cell::from(row.remark.as_str())]));
        }
        table
    }
}

/// Which of so many runs are drawn.
fn drawn(runs: usize) -> Vec<usize> {
    let shown = runs.min(MOST_DRAWN);
    (0..shown).map(|k| if shown == 1 { 0 } else { k * (runs - 1) / (shown - 1) }).collect()
}

impl Measures {
    fn of(times_s: &[f64], values: &[f64]) -> Measures {
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let greatest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        // Upward through the mean, between rows by the straight line.
        let rises = |i: &usize| values[*i] < mean && values[i + 1] >= mean;
        let crossings: Vec<f64> = (0..values.len().saturating_sub(1))
            .filter(rises)
            .map(|i| {
                let part = (mean - values[i]) / (values[i + 1] - values[i]);
                times_s[i] + part * (times_s[i + 1] - times_s[i])
            })
            .collect();
        let period_s = match crossings[..] {
            // Two swings that differ are no period: a transient, or no oscillation.
            [.., a, b, c] if ((c - b) - (b - a)).abs() <= SWINGS_ALIKE * (c - b) => Some(c - b),
            _ => None,
        };
        Measures { last: values.last().copied().unwrap_or(f64::NAN), least, greatest, period_s }
    }
}
