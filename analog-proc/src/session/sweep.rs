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
    link::{FramePort, LinkFault},
    side_by_side::{Jobs, side_by_side},
};
use std::sync::atomic::{AtomicBool, Ordering};

/// Samples that one request may ask for: half a gigabyte.
const MOST_VALUES: u64 = 1 << 26;

/// Runs a sweep over the board as it stands, which stays as it is.
///
/// # Errors
/// The link's, where the digital side went or this process was interrupted meanwhile.
pub(super) fn run(
    sweep: &Sweep,
    patch: &Ordered,
    board: &Board,
    attend: &mut dyn FnMut() -> Result<(), LinkFault>,
) -> Result<Reply, LinkFault> {
    if let Err(refusal) = admit(sweep) {
        return Ok(Reply::Refused(refusal));
    }
    let mut runs: Vec<Option<SweptRun>> = vec![None; sweep.cases.len()];
    let mut refusal: Option<(usize, String)> = None;
    let worker = |jobs: Jobs<'_, _>| {
        while let Some(i) = jobs.next() {
            let case = &sweep.cases[i];
            jobs.done(i, run_case(sweep, case, patch, board.clone(), jobs.given_up()));
        }
    };
    side_by_side(sweep.cases.len(), worker, |result| {
        match result {
            Some((i, Ok(run))) => runs[i] = Some(run),
            // The first in order: which came first is chance.
            Some((i, Err(reason))) if refusal.as_ref().is_none_or(|(first, _)| i < *first) => {
                refusal = Some((i, reason));
            }
            _ => {}
        }
        attend()
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
    let ended = frame_cycle::run(&spec, time_scale, (None, None), &mut board, &mut tape);
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

    /// Nobody asks for it.
    fn give_state(&mut self, _: u64, _: Vec<u8>) -> Result<(), LinkFault> {
        Ok(())
    }

    fn attend(&mut self) -> Result<(), LinkFault> {
        match self.given_up.load(Ordering::Relaxed) {
            true => Err(LinkFault::Interrupted { frame: 0 }),
            false => Ok(()),
        }
    }
}
