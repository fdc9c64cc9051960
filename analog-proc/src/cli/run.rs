//! `analog-proc run`: a patch by itself, recorded to a file.

use super::{
    PatchArgs, add_file, check::Compiled, estimate, expect_output, find_net, progress::Progress,
};
use crate::{
    net::{Block, Kind},
    record::{RecordFault, Recorder},
};
use desk::{command_line::interrupt_flag, failure::Failure, note, outcome::Outcome};
use engine::{fault::RunFault, id::NetId, simulation::Pulse};
use interface::Tick;
use std::{ops::ControlFlow, path::PathBuf, sync::atomic::Ordering};

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
        expect_output(&self.out, &self.patch.patch, &["csv", "arrow"])?;
        let Compiled { ordered, .. } = self.patch.compile()?;
        let names = self.recorded(&ordered)?;
        estimate::check(&self.out, self.until, self.every, names.len() + 1)?;
        let nets: Vec<NetId> = names.iter().map(|(_, id)| *id).collect();
        let mut simulation = ordered.simulation().map_err(Failure::input)?;
        let write = |f: RecordFault| Failure::output(f);
        let interrupted = interrupt_flag().map_err(Failure::input)?;
        let mut recorder =
            Recorder::create(&self.out, names.iter().map(|(n, _)| n.as_str())).map_err(write)?;
        let mut progress = Progress::new(self.until, ordered.netlist.integration.method);
        let mut failed = None;
        let first: Vec<f64> = nets.iter().map(|n| simulation.net(*n)).collect();
        recorder.row(0.0, &first).map_err(write)?;
        let mut sink = |time_s: f64, values: &[f64]| {
            failed = recorder.row(time_s, values).err();
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
        let finished = recorder.finish();
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
        // Else standard output is taken by the record.
        let is_to_file = self.out.as_os_str() != "-";
        let advance = end.map_err(|f| {
            let text = format!("{f}\nrecorded up to there: {}", self.out.display());
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
        remarks.extend(simulation.remarks().iter().map(|remark| format!("remark: {remark}")));
        if advance.stopped_by.is_some() {
            let at = advance.reached;
            remarks.push(format!("the run ended at {at} by the patch's overload policy"));
        }
        let s = simulation.statistics();
        let mut outcome = Outcome::default();
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
            add_file(&mut outcome, &self.out);
        } else {
            // Where the record is not to be mixed with words.
            remarks.iter().for_each(|line| note!("{line}"));
            outcome.title = format!(
                "{}: {} steps ({} rejected), {} events; recorded to {}",
                self.until,
                s.steps,
                s.rejected,
                s.events,
                self.out.display()
            );
        }
        if is_to_file {
            outcome.tell("run", None, self.patch.json)
        } else {
            outcome.tell_beside("run", self.patch.json)
        }
    }

    /// Names and nets to record.
    fn recorded(&self, ordered: &crate::order::Ordered) -> Result<Vec<(String, NetId)>, Failure> {
        let netlist = &ordered.netlist;
        if self.record.is_empty() {
            let is_state = |b: &&Block| matches!(b.kind, Kind::Integrator(_) | Kind::Lag(_));
            let mut blocks: Vec<&Block> = netlist.blocks.iter().filter(is_state).collect();
            if blocks.is_empty() {
                blocks = netlist.blocks.iter().collect();
            }
            let nets = blocks.iter().flat_map(|b| &b.outputs);
            return Ok(nets.map(|id| (netlist.nets[id.index()].name.clone(), *id)).collect());
        }
        let twice = |(at, name): (usize, &String)| self.record[..at].contains(name);
        if let Some((_, name)) = self.record.iter().enumerate().find(|pair| twice(*pair)) {
            return Err(Failure::input(format!("--record names `{name}` twice; name it once")));
        }
        let find = |name: &String| Ok((name.clone(), find_net(ordered, name)?));
        self.record.iter().map(find).collect()
    }
}

fn go_on(wanted: bool) -> ControlFlow<()> {
    if wanted { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
}
