//! One step: its length by the error controller, its end by the stop or an event.

use super::crossing::Ending;
use super::instants::resolution_s;
use super::{Engine, Heed, Recorder};
use crate::fault::RunFault;
use crate::integrate::{Scheme, System};

/// Factor below the step at which the error estimate would just be met.
const SAFETY: f64 = 0.9;

/// Least and greatest change of the step at once.
const SHRINK: f64 = 0.2;

const GROW: f64 = 10.0;

/// Weight of the former error in the controller (Hairer's choice for this method).
const BETA: f64 = 0.04;

/// Resolutions of time from one side of a vector's origin to the other.
const ORIGIN_STEP: f64 = 8.0;

/// First step of a patch without integrators, s.
const FIRST_STEP_S: f64 = 1e-3;

impl Engine {
    pub(super) fn first_step_s(&mut self) -> f64 {
        let n = self.step.y0.len();
        let cap_s = self.cap_s();
        if n == 0 {
            return FIRST_STEP_S.min(cap_s);
        }
        let rtol = self.integration.rtol;
        let size = |v: &[f64], y: &[f64], atol: &[f64]| {
            let mut norm = 0.0_f64;
            for i in 0..n {
                norm = norm.max(v[i].abs() / (atol[i] + rtol * y[i].abs()));
            }
            norm
        };
        let (y0, f0) = (&self.step.y0, &self.step.f0);
        let (d0, d1) = (size(y0, y0, &self.atol), size(f0, y0, &self.atol));
        let mut h0 = if d0 < 1e-5 || d1 < 1e-5 { 1e-6 } else { 0.01 * d0 / d1 };
        h0 = h0.min(cap_s);
        for i in 0..n {
            self.probe[i] = y0[i] + h0 * f0[i];
        }
        let t_s = self.t_s + h0;
        self.machine.derivatives(&self.frozen, t_s, &mut self.probe, &mut self.step.f1);
        self.step.evaluations += 1;
        for i in 0..n {
            self.step.f1[i] = (self.step.f1[i] - self.step.f0[i]) / h0;
        }
        let d2 = size(&self.step.f1, &self.step.y0, &self.atol);
        let greatest = d1.max(d2);
        let h1 = if greatest <= 1e-15 {
            (h0 * 1e-3).max(1e-6)
        } else {
            libm::pow(0.01 / greatest, 1.0 / self.scheme.exponent())
        };
        let h = (100.0 * h0).min(h1).min(cap_s);
        if h.is_finite() && h > 0.0 { h } else { 1e-6_f64.min(cap_s) }
    }

    fn cap_s(&self) -> f64 {
        let longest_s = self.machine.step_cap_s.min(self.paces.limit_s);
        if self.scheme.adaptive() { longest_s.min(self.integration.max_step_s) } else { longest_s }
    }

    pub(super) fn attempt(&mut self, h_s: f64) -> f64 {
        for line in &mut self.frozen.lines {
            line.aim(self.t_s, h_s);
        }
        let Engine { machine, frozen, atol, integration, step, nets, scheme, .. } = self;
        step.t0_s = self.t_s;
        let system = System { machine, frozen, atol, rtol: integration.rtol };
        scheme.attempt(system, step, h_s, nets)
    }

    /// Brings up to date, at the end of a step, what no derivative depends on.
    pub(super) fn complete(&mut self, end_s: f64) {
        self.machine.complete(&self.frozen, end_s, &mut self.nets);
    }

    /// One accepted step towards `target_s`, ended early by an event.
    pub(super) fn advance_once(
        &mut self,
        target_s: f64,
        recorder: Option<&mut Recorder<'_>>,
        heed: &mut Heed<'_>,
    ) -> Result<(), RunFault> {
        let (origin, (end_s, ending)) = match self.find_step(target_s, heed) {
            Err(fault @ (RunFault::TooQuick { .. } | RunFault::StepUnderflow { .. })) => {
                self.pass_origin(target_s, fault)?
            }
            found => (None, found?),
        };
        self.count_cuts(matches!(ending, Ending::Cut(_)))?;
        let (end_s, cut, element) = match ending {
            Ending::Crossed(end_s, element) => (end_s, true, Some(element)),
            Ending::Cut(end_s) | Ending::Rest(end_s) => (end_s, true, None),
            Ending::Whole | Ending::Failed => (end_s, false, None),
        };
        self.complete(end_s);
        self.finish(end_s, cut, recorder)?;
        if let Some(element) = element.or(origin) {
            self.statistics.events += 1;
            self.count_chatter(element)?;
            self.settle(false, Some(0))?;
        }
        if origin.is_some() {
            self.next_step_s = self.first_step_s();
        }
        Ok(())
    }

    /// Where time resolves no step because a vector is at its origin, a straight step to the other
    /// side: its angle jumps there, by an event of the element that is returned. Else it is the
    /// `fault` that it was.
    fn pass_origin(
        &mut self,
        target_s: f64,
        fault: RunFault,
    ) -> Result<(Option<u32>, (f64, Ending)), RunFault> {
        let resolution_s = resolution_s(self.t_s);
        let (paces, bounded) = (&self.paces, matches!(fault, RunFault::TooQuick { .. }));
        let origin = paces.at_origin(&self.machine, resolution_s, &self.rated_start, bounded);
        if origin.is_none() {
            return Err(fault);
        }
        let end_s = target_s.min(self.t_s + ORIGIN_STEP * resolution_s);
        // What the angle is beyond is known there only: no stage may look at it before.
        let scheme = std::mem::replace(&mut self.scheme, Scheme::Euler);
        self.step.quartic.fill(0.0);
        self.attempt(end_s - self.t_s);
        self.rate_end();
        let ending = self.find_crossing(end_s);
        self.scheme = scheme;
        Ok((origin, (end_s, ending?)))
    }

    /// The longest step towards `target_s` that shows all that happens in it.
    fn find_step(&mut self, target_s: f64, heed: &mut Heed<'_>) -> Result<(f64, Ending), RunFault> {
        let room_s = target_s - self.t_s;
        let adaptive = self.scheme.adaptive();
        let cap_s = self.cap_s();
        if cap_s <= resolution_s(self.t_s) {
            return Err(self.too_quick());
        }
        let proposal_s = self.next_step_s.min(cap_s);
        let mut h_s = if adaptive { proposal_s.min(room_s) } else { room_s.min(cap_s) };
        if adaptive && proposal_s <= resolution_s(self.t_s) {
            return Err(self.underflow(1.0, proposal_s));
        }
        let mut end_s = self.end_of(h_s, target_s, room_s);
        let mut rejected = false;
        let mut former = None;
        loop {
            // The step as time resolves it; the wish goes on shrinking below that.
            let step_s = end_s - self.t_s;
            let error = self.attempt(step_s);
            let inaccurate = adaptive && (error > 1.0 || error.is_nan());
            let shrink = if inaccurate {
                if error.is_finite() {
                    self.find_grain(error, &mut former);
                    let power = -1.0 / self.scheme.exponent();
                    (SAFETY * libm::pow(error, power)).clamp(SHRINK, SAFETY)
                } else {
                    0.1
                }
            } else {
                if self.keeps_pace(step_s) {
                    let ending = self.find_crossing(end_s)?;
                    if !matches!(ending, Ending::Failed) {
                        self.propose(error, step_s, proposal_s, rejected);
                        return Ok((end_s, ending));
                    }
                }
                0.5
            };
            self.heed(heed)?;
            rejected = true;
            self.statistics.rejected += 1;
            h_s = shrink * h_s.min(step_s);
            self.next_step_s = h_s;
            if h_s <= resolution_s(self.t_s) {
                return Err(if inaccurate { self.underflow(error, h_s) } else { self.too_quick() });
            }
            end_s = self.end_of(h_s, target_s, room_s);
        }
    }

    /// Whether nothing hides in the step; without one before it that tells, its middle is
    /// looked at too.
    fn keeps_pace(&mut self, step_s: f64) -> bool {
        if !self.followed && !self.machine.paces.is_empty() {
            self.rate_at(0.5);
            let (start, middle) = (&self.rated_start, &self.rated);
            if !self.paces.kept(&self.machine, 0.5 * step_s, start, middle) {
                return false;
            }
        }
        self.rate_end();
        let (start, end) = (&self.rated_start, &self.rated);
        self.paces.kept(&self.machine, step_s, start, end)
    }

    /// End of a step of about `h_s`, without leaving a sliver before the target.
    fn end_of(&self, h_s: f64, target_s: f64, room_s: f64) -> f64 {
        if h_s >= room_s * (1.0 - 1e-9) {
            target_s
        } else if h_s > 0.55 * room_s {
            self.t_s + 0.5 * room_s
        } else {
            self.t_s + h_s
        }
    }

    fn propose(&mut self, error: f64, h_s: f64, proposal_s: f64, rejected: bool) {
        let order = self.scheme.exponent();
        let error = error.max(1e-10);
        let former = self.former_error;
        // errorᵃ · formerᵇ by one exponential: half the time of two powers.
        let power = BETA * libm::log(former) - (1.0 / order - 0.75 * BETA) * libm::log(error);
        let factor = SAFETY * libm::exp(power);
        let mut next_s = h_s * factor.clamp(SHRINK, GROW);
        if rejected {
            next_s = next_s.min(h_s);
        } else if h_s < proposal_s * (1.0 - 1e-9) {
            // Truncated at a stop: the proposal stands, unless the step shows it too long.
            next_s = next_s.max(proposal_s);
        }
        if h_s >= proposal_s * (1.0 - 1e-9) || rejected {
            self.former_error = error.max(1e-4);
        }
        self.next_step_s = next_s.min(self.cap_s());
    }

    /// Accepts the step that ends at `end_s` with what `nets` now hold.
    fn finish(
        &mut self,
        end_s: f64,
        cut: bool,
        recorder: Option<&mut Recorder<'_>>,
    ) -> Result<(), RunFault> {
        self.statistics.steps += 1;
        let (t0_s, h_s) = (self.t_s, self.step.h_s);
        if let Some(recorder) = recorder {
            while recorder.next_s() < end_s {
                self.look((recorder.next_s() - t0_s) / h_s);
                recorder.record(&self.probe);
            }
        }
        if !self.scheme.adaptive() {
            self.fixed_steps.take(&self.scheme, &self.step);
        }
        self.follow(cut);
        self.size_up(false);
        std::mem::swap(&mut self.rated_start, &mut self.rated);
        if !self.frozen.lines.is_empty() {
            self.store_delays();
        }
        self.step.advance();
        self.t_s = end_s;
        self.look_at_paces();
        self.check_finite()
    }

    /// Brings `probe` to the instant `theta` of the step.
    fn look(&mut self, theta: f64) {
        self.step.dense(theta, &mut self.probe);
        let t_s = self.step.t0_s + theta * self.step.h_s;
        self.machine.outputs(&self.frozen, t_s, &mut self.probe);
        self.step.evaluations += 1;
    }
}
