//! `analog-proc run`: a patch by itself, recorded to a file; `analog-proc resume`: one that was
//! killed, from its last checkpoint.

use super::{
    PatchArgs, add_files, check::Compiled, estimate, expect_output, expect_page, find_net,
    page_record, picture::Picture, progress::Progress, write_page,
};
use crate::{
    net::{Block, Kind},
    order::Ordered,
    record::{RecordFault, RecordState, Recorder},
};
use desk::{
    checkpoint, command_line::interrupt_flag, failure::Failure, note, outcome::Outcome,
    run_dir::RunRecord,
};
use engine::{fault::RunFault, simulation::Pulse, simulation::Simulation};
use interface::Tick;
use serde::{Deserialize, Serialize};
use std::{
    ops::ControlFlow,
    path::{Path, PathBuf},
    sync::atomic::Ordering,
};

/// Run a patch by itself: record nets as CSV or Arrow, or look at them on a page
///
/// Run a patch by itself: record nets to a file, or look at them on a page.
///
///   analog-proc run patch-files/lorenz.toml --until 40s --xy x:z
///   analog-proc run patch-files/van-der-pol.toml --until 20s --plot x,v --page vdp.html
///   analog-proc run patch-files/van-der-pol.toml --until 20s --out vdp.csv
///
/// A long run keeps its state in FILE.checkpoint, beside its output, and goes on after a kill with
/// the numbers that it would have had:
///
///   analog-proc run patch-files/lorenz.toml --until 100000s --every 1s --checkpoint 1000s --out l.csv
///   analog-proc resume l.csv.checkpoint
#[derive(Clone, clap::Args, Serialize, Deserialize)]
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
    /// Problem time between two checkpoints [default: none are kept]
    #[arg(long, value_name = "TIME")]
    checkpoint: Option<Tick>,
}

/// Go on with a run from its last checkpoint
///
/// Go on with a run that was killed or interrupted, from its last checkpoint. Its output and its
/// numbers are those of a run that was never stopped.
///
///   analog-proc resume vdp.csv.checkpoint
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Resume {
    /// The checkpoint, which stands beside the run's output
    checkpoint: PathBuf,
    /// Print results and faults as JSON
    #[arg(long)]
    json: bool,
}

/// All that a run goes on from, apart from its patch.
#[derive(Serialize, Deserialize)]
struct Checkpoint {
    run: Run,
    /// Where its relative paths begin.
    folder: PathBuf,
    /// When it was begun, and by what command line.
    started: String,
    command_line: Vec<String>,
    /// SHA-256 of the patch, hexadecimal.
    patch: String,
    simulation: Vec<u8>,
    record: Option<RecordState>,
    picture: Option<Picture>,
}

impl Resume {
    pub fn execute(self) -> Result<(), Failure> {
        let mut kept: Checkpoint = checkpoint::read(&self.checkpoint)?;
        std::env::set_current_dir(&kept.folder).map_err(|e| {
            let folder = kept.folder.display();
            Failure::input(format!("cannot go to {folder}, where the run was begun: {e}"))
        })?;
        kept.run.patch.json |= self.json;
        kept.run.clone().carry_out(Some(kept))
    }
}

/// Where the rows of a run go.
struct Output {
    picture: Option<Picture>,
    recorder: Option<Recorder>,
}

impl Output {
    fn row(&mut self, time_s: f64, values: &[f64]) -> Result<(), RecordFault> {
        if let Some(picture) = &mut self.picture {
            picture.row(time_s, values);
        }
        self.recorder.as_mut().map_or(Ok(()), |recorder| recorder.row(time_s, values))
    }

    fn finish(&mut self) -> Result<(), RecordFault> {
        self.recorder.take().map_or(Ok(()), Recorder::finish)
    }
}

impl Run {
    pub fn execute(self) -> Result<(), Failure> {
        self.carry_out(None)
    }

    /// From the start, or from where it was.
    fn carry_out(self, kept: Option<Checkpoint>) -> Result<(), Failure> {
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
        if self.checkpoint.is_some_and(|every| every <= Tick::ZERO) {
            return Err(Failure::input("--checkpoint must be positive"));
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
        let checkpoint = self.place_of_checkpoints(out.as_deref(), page.as_deref())?;
        let Compiled { ordered, hash } = self.patch.compile()?;
        if kept.as_ref().is_some_and(|kept| kept.patch != hash) {
            return Err(Failure::input(format!(
                "{} is not as it was when the run began; put it back, or start the run anew",
                self.patch.patch.display()
            )));
        }
        let mut begun = page_record("run", &self.patch, hash.clone());
        let mut names = self.recorded(&ordered)?;
        let picture = match page {
            Some(_) => Some(Picture::new(&ordered, &mut names, &self.plot, &self.xy)?),
            None => None,
        };
        if let (Some(out), None) = (&out, &kept) {
            estimate::check(out, self.until, self.every, names.len() + 1)?;
        }
        let nets =
            names.iter().map(|name| find_net(&ordered, name)).collect::<Result<Vec<_>, _>>()?;
        let mut simulation = ordered.simulation().map_err(Failure::input)?;
        let write = |f: RecordFault| Failure::output(f);
        let interrupted = interrupt_flag().map_err(Failure::input)?;
        let header = || names.iter().map(String::as_str);
        let mut output = match kept {
            None => {
                let recorder = out.as_ref().map(|out| Recorder::create(out, header()));
                let recorder = recorder.transpose().map_err(write)?;
                let mut output = Output { picture, recorder };
                let first: Vec<f64> = nets.iter().map(|n| simulation.net(*n)).collect();
                output.row(0.0, &first).map_err(write)?;
                output
            }
            Some(kept) => {
                let Checkpoint { simulation: state, record, picture, .. } = kept;
                (begun.started, begun.command_line) = (kept.started, kept.command_line);
                simulation.restore(&state).map_err(Failure::input)?;
                let resume = |(out, record): (&PathBuf, _)| Recorder::resume(out, header(), record);
                Output { picture, recorder: out.as_ref().zip(record).map(resume).transpose()? }
            }
        };
        let method = ordered.netlist.integration.method;
        let mut progress = Progress::new(simulation.now(), self.until, method);
        let mut failed = None;
        let end = loop {
            let mut sink = |time_s: f64, values: &[f64]| {
                failed = output.row(time_s, values).err();
                go_on(failed.is_none() && !interrupted.load(Ordering::Relaxed))
            };
            let mut attend = |pulse: &Pulse| {
                progress.at(pulse);
                go_on(!interrupted.load(Ordering::Relaxed))
            };
            let leg = (self.until, self.next_checkpoint(simulation.now()));
            let end = simulation.advance_by_legs(leg, self.every, &nets, &mut sink, &mut attend);
            let is_under_way = end.as_ref().is_ok_and(|end| end.stopped_by.is_none())
                && simulation.now_s() < self.until.secs();
            let Some(place) = checkpoint.as_deref().filter(|_| is_under_way) else {
                break end;
            };
            if let Err(unkept) = self.keep(place, &begun, &simulation, &mut output) {
                output.finish().map_err(write)?;
                return Err(unkept);
            }
        };
        let finished = output.finish();
        let picture = &output.picture;
        progress.done();
        let is_interrupted = matches!(end, Err(RunFault::Halted { .. }));
        if let Some(place) = checkpoint.as_deref().filter(|place| place.exists()) {
            if is_interrupted {
                note!("go on with: analog-proc resume {}", place.display());
            } else {
                // The run is over; what is left of it otherwise is told by its name.
                let _ = std::fs::remove_file(place);
            }
        }
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
        if let (Some(picture), Some(page)) = (picture, &page) {
            outcome.title = format!("{}: to {}", ordered.netlist.title, simulation.now());
            outcome.remarks.clone_from(&remarks);
            outcome.remarks.extend(end.as_ref().err().map(ToString::to_string));
            picture.fill(&mut outcome);
            write_page(&outcome, &begun, page)?;
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

    /// Where the checkpoints go, if any are asked for: beside the output.
    fn place_of_checkpoints(
        &self,
        out: Option<&Path>,
        page: Option<&Path>,
    ) -> Result<Option<PathBuf>, Failure> {
        if self.checkpoint.is_none() {
            return Ok(None);
        }
        match out.or(page) {
            Some(output) if output.as_os_str() != "-" => Ok(Some(checkpoint::beside(output))),
            _ => {
                Err(Failure::input("--checkpoint needs a file to go on with: name one with --out"))
            }
        }
    }

    /// The first multiple of the checkpoints' interval after `now`.
    fn next_checkpoint(&self, now: Tick) -> Tick {
        let next = |every: Tick| Tick(every.0.saturating_mul(now.0 / every.0 + 1));
        self.checkpoint.map_or(Tick(i64::MAX), next)
    }

    /// Keeps the state of the run.
    fn keep(
        &self,
        place: &Path,
        begun: &RunRecord,
        simulation: &Simulation,
        output: &mut Output,
    ) -> Result<(), Failure> {
        let state = Checkpoint {
            run: self.clone(),
            folder: std::env::current_dir().map_err(Failure::input)?,
            started: begun.started.clone(),
            command_line: begun.command_line.clone(),
            patch: begun.patch.as_ref().map(|patch| patch.sha256.clone()).unwrap_or_default(),
            simulation: simulation.snapshot().map_err(Failure::input)?,
            record: output.recorder.as_mut().map(Recorder::state).transpose()?,
            picture: output.picture.clone(),
        };
        Ok(checkpoint::write(place, &state)?)
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
