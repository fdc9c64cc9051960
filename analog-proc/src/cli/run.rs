//! `analog-proc run`: a patch by itself, recorded to a file.

use super::{Failure, PatchArgs, check::Compiled, expect_output};
use crate::{
    net::{Block, Kind, NetId},
    patch::suggestion,
    record::{RecordFault, Recorder},
    simulation::Simulation,
};
use indicatif::{ProgressBar, ProgressStyle};
use interface::{Tick, note, say};
use std::{
    path::PathBuf,
    time::{Duration, Instant},
};

/// Run a patch by itself.
#[derive(clap::Args)]
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
    /// File to write: .csv (17 significant digits) or .arrow (IPC stream); `-` for CSV on standard output
    #[arg(long, short, default_value = "-", value_name = "FILE")]
    out: PathBuf,
}

impl Run {
    pub fn execute(self) -> Result<(), Failure> {
        if self.until < Tick::ZERO || self.every <= Tick::ZERO {
            return Err(Failure::input(
                "--until must not be negative and --every must be positive",
            ));
        }
        if self.until > Tick::ZERO && self.every > self.until {
            return Err(Failure::input(format!(
                "--every {} is longer than --until {}: nothing but the start would be recorded",
                self.every, self.until
            )));
        }
        expect_output(&self.out, &self.patch.patch, &["csv", "arrow"])?;
        let Compiled { ordered, .. } = self.patch.compile()?;
        let names = self.recorded(&ordered)?;
        let nets: Vec<NetId> = names.iter().map(|(_, id)| *id).collect();
        let mut simulation = Simulation::new(&ordered).map_err(Failure::input)?;
        let write = |f: RecordFault| Failure::output(f);
        let mut recorder =
            Recorder::create(&self.out, names.iter().map(|(n, _)| n.as_str())).map_err(write)?;
        let progress = Progress::new(self.until);
        let mut failed = None;
        let first: Vec<f64> = nets.iter().map(|n| simulation.net(*n)).collect();
        recorder.row(0.0, &first).map_err(write)?;
        let end = simulation.advance_recording(self.until, self.every, &nets, |time_s, values| {
            if failed.is_none() {
                failed = recorder.row(time_s, values).err();
            }
            progress.at(time_s);
        });
        let finished = recorder.finish();
        progress.done();
        let written = failed.map_or(finished, Err);
        if written.as_ref().is_err_and(RecordFault::reader_left) {
            // `| head` and the like: nobody wants the rest.
            return Ok(());
        }
        written.map_err(write)?;
        let overloads: Vec<String> = simulation
            .overloads()
            .iter()
            .map(|o| {
                let name = &ordered.netlist.blocks[o.block.index()].name;
                format!("overload: {name} at {} s ({})", o.t_s, o.value)
            })
            .collect();
        for line in &overloads {
            note!("{line}");
        }
        let advance = end.map_err(|f| {
            Failure::input(format!("{f}\nrecorded up to there: {}", self.out.display()))
        })?;
        if advance.stopped_by.is_some() {
            note!(
                "the run ended at {} by the patch's overload policy",
                advance.reached
            );
        }
        let s = simulation.statistics();
        let to_file = self.out.as_os_str() != "-";
        if self.patch.json {
            let report = serde_json::json!({ "steps": s.steps, "rejected": s.rejected, "evaluations": s.evaluations, "events": s.events, "overloads": overloads });
            // Standard output may be taken by the record.
            if to_file {
                say!("{report}");
            } else {
                note!("{report}");
            }
        } else if to_file {
            say!(
                "{}: {} steps ({} rejected), {} events; recorded to {}",
                self.until,
                s.steps,
                s.rejected,
                s.events,
                self.out.display()
            );
        }
        Ok(())
    }

    /// Names and nets to record.
    fn recorded(&self, ordered: &crate::order::Ordered) -> Result<Vec<(String, NetId)>, Failure> {
        let netlist = &ordered.netlist;
        if self.record.is_empty() {
            let is_state =
                |b: &&Block| matches!(b.kind, Kind::Integrator { .. } | Kind::Lag { .. });
            let mut blocks: Vec<&Block> = netlist.blocks.iter().filter(is_state).collect();
            if blocks.is_empty() {
                blocks = netlist.blocks.iter().collect();
            }
            let nets = blocks.iter().flat_map(|b| &b.outputs);
            return Ok(nets
                .map(|id| (netlist.nets[id.index()].name.clone(), *id))
                .collect());
        }
        let find = |name: &String| {
            netlist
                .nets
                .iter()
                .position(|n| n.name == *name)
                .map(|i| (name.clone(), NetId(i as u32)))
                .ok_or_else(|| {
                    let names = netlist.nets.iter().map(|n| n.name.as_str());
                    let help = suggestion(name, "nets", names);
                    Failure::input(format!("--record: the patch has no net `{name}`; {help}"))
                })
        };
        self.record.iter().map(find).collect()
    }
}

/// A progress bar that appears only when a run takes more than a second.
struct Progress {
    bar: std::cell::OnceCell<ProgressBar>,
    started: Instant,
    until_s: f64,
}

impl Progress {
    fn new(until: Tick) -> Progress {
        Progress {
            bar: std::cell::OnceCell::new(),
            started: Instant::now(),
            until_s: until.secs(),
        }
    }

    fn at(&self, time_s: f64) {
        if self.bar.get().is_none() && self.started.elapsed() < Duration::from_secs(1) {
            return;
        }
        let bar = self.bar.get_or_init(|| {
            let bar = ProgressBar::new(1000);
            if let Ok(style) =
                ProgressStyle::with_template("{bar:40} {percent}% of problem time, {eta} left")
            {
                bar.set_style(style);
            }
            bar
        });
        bar.set_position((1000.0 * time_s / self.until_s) as u64);
    }

    fn done(&self) {
        if let Some(bar) = self.bar.get() {
            bar.finish_and_clear();
        }
    }
}
