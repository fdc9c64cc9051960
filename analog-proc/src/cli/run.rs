//! `analog-proc run`: a patch by itself, recorded to a file.

use super::{
    PatchArgs, add_files, check::Compiled, estimate, expect_output, expect_page, find_net,
    picture::Picture, progress::Progress, write_page,
};
use crate::{
    net::{Block, Kind},
    order::Ordered,
    record::{RecordFault, Recorder},
};
use desk::{command_line::interrupt_flag, failure::Failure, note, outcome::Outcome};
use engine::{fault::RunFault, simulation::Pulse};
use interface::Tick;
use std::{ops::ControlFlow, path::PathBuf, sync::atomic::Ordering};

/// Run a patch by itself: record nets as CSV or Arrow, or look at them on a page
///
/// Run a patch by itself: record nets to a file, or look at them on a page.
///
///   analog-proc run patch-files/lorenz.toml --until 40s --xy x:z
///   analog-proc run patch-files/van-der-pol.toml --until 20s --plot x,v --page vdp.html
///   analog-proc run patch-files/van-der-pol.toml --until 20s --out vdp.csv
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Run {
    #[command(flatten)]
    patch: PatchArgs,
    /// Problem time to stop at, e.g. 20s
    #[arg(long, value_name = "TIME")]
    until: Tick,
    /// Interval between recorded rows; recording never alters the integration
    #[arg(long, value_name = "TIME", default_value = "10ms")]
    every: Tick,
    /// Nets to record, separated by commas [default: every integrator and lag, or every block if there are none]
    #[arg(long, value_delimiter = ',', value_name = "NETS")]
    record: Vec<String>,
    /// Nets to draw over time, separated by commas
    #[arg(long, value_delimiter = ',', value_name = "NETS")]
    plot: Vec<String>,
    /// Two nets to draw one over the other, e.g. x:z; may be repeated
    #[arg(long, value_name = "X:Y")]
    xy: Vec<String>,
    /// Page to draw on [default with --plot or --xy: the patch's name with .html, here; without them every recorded net is drawn]
    #[arg(long, value_name = "FILE.html")]
    page: Option<PathBuf>,
    /// File to write: .csv (17 significant digits) or .arrow (IPC stream); `-` for CSV on standard output [default: `-`, or none with a page]
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
}

impl Run {
    pub fn execute(self) -> Result<(), Failure> {
        if self.until < Tick::ZERO {
            return Err(Failure::input(format!("--until {} must not be negative", self.until)));
        }
        if self.every <= Tick::ZERO {
            return Err(Failure::input(format!("--every {} must be positive", self.every)));
        }
        if self.until > Tick::ZERO && self.every > self.until {
            return Err(Failure::input(format!(
                "--every {} is longer than --until {}: nothing but the start would be recorded",
                self.every, self.until
            )));
        }
        let page = self.page();
        if let Some(page) = &page {
            expect_page(page, &self.patch.patch)?;
        }
        // A page alone needs no record.
        let out = self.out.clone().or(page.is_none().then(|| PathBuf::from("-")));
        if let Some(out) = &out {
            expect_output(out, &self.patch.patch, &["csv", "arrow"])?;
        }
        let Compiled { ordered, hash } = self.patch.compile()?;
        let mut names = self.recorded(&ordered)?;
        let mut picture = match page {
            Some(_) => Some(Picture::new(&ordered, &mut names, &self.plot, &self.xy)?),
            None => None,
        };
        if let Some(out) = &out {
            estimate::check(out, self.until, self.every, names.len() + 1)?;
        }
        let nets =
            names.iter().map(|name| find_net(&ordered, name)).collect::<Result<Vec<_>, _>>()?;
        let mut simulation = ordered.simulation().map_err(Failure::input)?;
        let write = |f: RecordFault| Failure::output(f);
        let interrupted = interrupt_flag().map_err(Failure::input)?;
        let create = |out: &PathBuf| Recorder::create(out, names.iter().map(String::as_str));
        let mut recorder = out.as_ref().map(create).transpose().map_err(write)?;
        let mut progress = Progress::new(self.until, ordered.netlist.integration.method);
        let mut failed = None;
        let first: Vec<f64> = nets.iter().map(|n| simulation.net(*n)).collect();
        let mut take = |time_s: f64, values: &[f64]| {
            if let Some(picture) = &mut picture {
                picture.row(time_s, values);
            }
            recorder.as_mut().map_or(Ok(()), |recorder| recorder.row(time_s, values))
        };
        take(0.0, &first).map_err(write)?;
        let mut sink = |time_s: f64, values: &[f64]| {
            failed = take(time_s, values).err();
            go_on(failed.is_none() && !interrupted.load(Ordering::Relaxed))
        };
        let mut attend = |pulse: &Pulse| {
            progress.at(pulse);
            go_on(!interrupted.load(Ordering::Relaxed))
        };
        let end = simulation.advance_recording_attended(
            self.until,
            self.every,
            &nets,
            &mut sink,
            &mut attend,
        );
        let finished = recorder.map_or(Ok(()), Recorder::finish);
        progress.done();
        let written = failed.map_or(finished, Err);
        if written.as_ref().is_err_and(RecordFault::reader_left) {
            // `| head` and the like: nobody wants the rest.
            return Ok(());
        }
        written.map_err(write)?;
        let overloads = simulation.overloads().iter().map(|o| {
            let name = &ordered.netlist.blocks[o.block.index()].name;
            format!("overload: {name} at {} s ({})", o.t_s, o.value)
        });
        let mut remarks: Vec<String> = overloads.collect();
        remarks.extend(simulation.remarks().iter().map(|remark| format!("remark: {remark}")));
        let mut outcome = Outcome::default();
        if let (Some(picture), Some(page)) = (&picture, &page) {
            outcome.title = format!("{}: to {}", ordered.netlist.title, simulation.now());
            outcome.remarks.clone_from(&remarks);
            outcome.remarks.extend(end.as_ref().err().map(ToString::to_string));
            picture.fill(&mut outcome);
            write_page(&outcome, "run", page, &self.patch, hash)?;
        }
        // Else standard output is taken by the record.
        let is_to_file = out.as_ref().is_none_or(|out| out.as_os_str() != "-");
        let places = [&out, &page].into_iter().flatten().map(|file| file.display().to_string());
        let places = places.collect::<Vec<_>>().join(" and ");
        let advance = end.map_err(|f| {
            let text = format!("{f}\nrecorded up to there: {places}");
            remarks.iter().for_each(|line| note!("{line}"));
            let failure = match f {
                // Nothing else halts it: a record that failed was told above.
                RunFault::Halted { .. } => Failure::interrupted(format!("interrupted: {text}")),
                _ => Failure::input(text),
            };
            if self.patch.json && !is_to_file {
                note!("{:#}", Outcome::default().json("run", None, Some(&failure)));
            }
            Failure { is_told: !is_to_file, ..failure }
        })?;
        if advance.stopped_by.is_some() {
            let at = advance.reached;
            remarks.push(format!("the run ended at {at} by the patch's overload policy"));
        }
        let s = simulation.statistics();
        if self.patch.json {
            outcome.title = ordered.netlist.title.clone();
            outcome.remarks = remarks;
            for (key, count) in [
                ("steps", s.steps),
                ("rejected", s.rejected),
                ("evaluations", s.evaluations),
                ("events", s.events),
            ] {
                outcome.results.add(key, "", count as f64, 17, "", "");
            }
            add_files(&mut outcome, [&out, &page].into_iter().flatten().map(PathBuf::as_path));
        } else {
            outcome.remarks.clear();
            // Where the record is not to be mixed with words.
            remarks.iter().for_each(|line| note!("{line}"));
            outcome.title = format!(
                "{}: {} steps ({} rejected), {} events; recorded to {}",
                self.until, s.steps, s.rejected, s.events, places
            );
        }
        if is_to_file {
            outcome.tell("run", None, self.patch.json)
        } else {
            outcome.tell_beside("run", self.patch.json)
        }
    }

    /// The page to draw on, if one is asked for.
    fn page(&self) -> Option<PathBuf> {
        let own = || PathBuf::from(self.patch.patch.file_stem().unwrap_or_default());
        let is_drawn = !self.plot.is_empty() || !self.xy.is_empty();
        self.page.clone().or_else(|| is_drawn.then(|| own().with_extension("html")))
    }

    /// Names of the nets to record.
    fn recorded(&self, ordered: &Ordered) -> Result<Vec<String>, Failure> {
        let twice = |(at, name): (usize, &String)| self.record[..at].contains(name);
        if let Some((_, name)) = self.record.iter().enumerate().find(|pair| twice(*pair)) {
            return Err(Failure::input(format!("--record names `{name}` twice; name it once")));
        }
        Ok(if self.record.is_empty() { states(ordered) } else { self.record.clone() })
    }
}

/// Nets of the integrators and lags, or of every block where there are none.
pub fn states(ordered: &Ordered) -> Vec<String> {
    let netlist = &ordered.netlist;
    let is_state = |b: &&Block| matches!(b.kind, Kind::Integrator(_) | Kind::Lag(_));
    let mut blocks: Vec<&Block> = netlist.blocks.iter().filter(is_state).collect();
    if blocks.is_empty() {
        blocks = netlist.blocks.iter().collect();
    }
    let nets = blocks.iter().flat_map(|b| &b.outputs);
    nets.map(|id| netlist.nets[id.index()].name.clone()).collect()
}

fn go_on(wanted: bool) -> ControlFlow<()> {
    if wanted { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
}
