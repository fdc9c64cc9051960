//! Iterative operation: many runs of one patch, on all processors, without a frame crossing.
//!
//! Each case begins with the board as it stands and is run by the very frame cycle of a single
//! run, at whose other end a tape keeps the samples: its bits are those of that run alone,
//! whatever thread took it and whatever ran before. The thread that serves the session
//! only waits meanwhile, and ends them all when nobody waits for it any more.

use crate::{
    order::Ordered,
    session::{board::Board, frame_cycle},
};
use interface::{
    Tick,
    control::{Clock, Reply, RunSpec, Sweep, SweepCase, SweptRun},
    frame::{ADC_CHANNELS, RunState, Samples, Updates},
    link::{AnalogPort, FramePort, LinkFault},
};
use std::{
    sync::{
        atomic::{AtomicBool, AtomicUsize, Ordering},
        mpsc::{RecvTimeoutError, sync_channel},
    },
    thread,
    time::Duration,
};

/// Samples that one request may ask for: half a gigabyte.
const MOST_VALUES: u64 = 1 << 26;
/// Between two looks whether somebody still waits.
const LOOK: Duration = Duration::from_millis(2);

/// Runs a sweep over the board as it stands, which stays as it is.
///
/// # Errors
/// The link's, where the digital side went or this process was interrupted meanwhile.
pub(super) fn run(
    sweep: &Sweep,
    patch: &Ordered,
    board: &Board,
    port: &mut dyn AnalogPort,
) -> Result<Reply, LinkFault> {
    if let Err(refusal) = admit(sweep) {
        return Ok(Reply::Refused(refusal));
    }
    let processors = thread::available_parallelism().map_or(1, usize::from);
    let (next, given_up) = (AtomicUsize::new(0), AtomicBool::new(false));
    let mut runs: Vec<Option<SweptRun>> = vec![None; sweep.cases.len()];
    let mut refusal = None;
    thread::scope(|scope| {
        let (sender, receiver) = sync_channel(processors);
        for _ in 0..processors.min(sweep.cases.len()) {
            let (sender, next, given_up) = (sender.clone(), &next, &given_up);
            scope.spawn(move || {
                while let i = next.fetch_add(1, Ordering::Relaxed)
                    && let Some(case) = sweep.cases.get(i)
                    && !given_up.load(Ordering::Relaxed)
                {
                    let run = run_case(sweep, case, patch, board.clone(), given_up);
                    if sender.send((i, run)).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        let give_up = |fault| {
            given_up.store(true, Ordering::Relaxed);
            Err(fault)
        };
        loop {
            match receiver.recv_timeout(LOOK) {
                Ok((i, Ok(run))) => runs[i] = Some(run),
                // The first in order: which came first is chance.
                Ok((i, Err(reason))) => match &refusal {
                    Some((first, _)) if *first < i => {}
                    _ => refusal = Some((i, reason)),
                },
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
            port.attend().or_else(give_up)?;
        }
    })?;
    Ok(match (refusal, runs.into_iter().collect()) {
        (None, Some(runs)) => Reply::Swept(runs),
        (Some((case, reason)), _) => Reply::Refused(format!("case {case} of the sweep: {reason}")),
        (None, None) => Reply::Refused("a run of the sweep was lost".into()),
    })
}

fn admit(sweep: &Sweep) -> Result<(), String> {
    if sweep.every <= Tick::ZERO {
        return Err(format!("the sampling interval {} is not positive", sweep.every));
    }
    if let Some(channel) = sweep.adc.iter().find(|c| **c as usize >= ADC_CHANNELS) {
        return Err(format!("there is no ADC channel {channel} to be recorded"));
    }
    let mut values = 0_u64;
    for case in &sweep.cases {
        if case.stop < Tick::ZERO {
            return Err(format!("stop time {} is negative", case.stop));
        }
        let rows = (case.stop.0 / sweep.every.0) as u64 + 2;
        values = values.saturating_add(rows.saturating_mul(sweep.adc.len() as u64));
    }
    if values > MOST_VALUES {
        return Err(format!(
            "the sweep asks for {values} samples, more than {MOST_VALUES}; sample less often, or ask for fewer runs at a time"
        ));
    }
    Ok(())
}

/// One case on a board of its own; or why it cannot begin.
fn run_case(
    sweep: &Sweep,
    case: &SweepCase,
    patch: &Ordered,
    mut board: Board,
    given_up: &AtomicBool,
) -> Result<SweptRun, String> {
    board.set_ics(patch, &case.ics)?;
    board.preset(&case.preset)?;
    board.reset()?;
    let spec = RunSpec {
        frame: sweep.every,
        latency: sweep.every,
        skew: Tick::ZERO,
        stop: case.stop,
        from_ic: true,
        clock: Clock::LockStep,
    };
    let mut tape =
        Tape { adc: &sweep.adc, given_up, rows: Vec::new(), saturated: false, last: Tick::ZERO };
    let time_scale = patch.netlist.integration.time_scale;
    // A tape fails only where the whole sweep is given up.
    let ended = frame_cycle::run(&spec, time_scale, &mut board, &mut tape);
    let fault = ended.map_err(|fault| fault.to_string())?;
    Ok(SweptRun {
        samples: tape.rows,
        saturated: tape.saturated,
        overloads: board.overloads(patch),
        fault: fault.map(|fault| (tape.last, fault.to_string())),
    })
}

/// The other side of a run that is only read.
struct Tape<'a> {
    adc: &'a [u32],
    given_up: &'a AtomicBool,
    rows: Vec<f64>,
    saturated: bool,
    /// Run time of the last frame.
    last: Tick,
}

impl FramePort for Tape<'_> {
    fn send_samples(&mut self, samples: &Samples) -> Result<(), LinkFault> {
        self.last = samples.tick;
        if samples.run_state() != RunState::Faulted {
            self.rows.extend(self.adc.iter().map(|channel| samples.adc[*channel as usize]));
            self.saturated |= samples.saturated();
        }
        Ok(())
    }

    fn await_updates(&mut self, frame: u64) -> Result<Updates, LinkFault> {
        Ok(Updates::new(frame, Tick::ZERO))
    }

    fn poll_updates(&mut self, _: u64) -> Result<Option<Updates>, LinkFault> {
        Ok(None)
    }

    fn attend(&mut self) -> Result<(), LinkFault> {
        match self.given_up.load(Ordering::Relaxed) {
            true => Err(LinkFault::Interrupted { frame: 0 }),
            false => Ok(()),
        }
    }
}
