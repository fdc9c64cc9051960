//! What each kind of block is made of: operations, elements, stores.

mod arithmetic;
mod corner;
mod inputs;
mod logic;
mod source;

use super::Lowering;
use crate::fault::RunFault;
use crate::net::Kind;
use crate::op::Term;
use crate::order::Ordered;

/// Shortest delay, pulse or period: one tick, s.
const LEAST_TIME_S: f64 = 1e-9;

fn scaled(terms: Vec<Term>, factor: f64) -> Vec<Term> {
    terms.into_iter().map(|t| Term { slot: t.slot, c: factor * t.c }).collect()
}

impl Lowering {
    /// Wires the block's outputs; for a store, its initial output.
    pub(super) fn outputs(&mut self, ordered: &Ordered) -> Result<(), RunFault> {
        let Some(block) = ordered.netlist.blocks.get(self.block.index()) else {
            return Ok(());
        };
        let Some(&net) = block.outputs.first() else {
            return Err(self.malformed("it drives no net"));
        };
        let o = self.slot(net);
        self.check_times(&block.kind)?;
        match &block.kind {
            Kind::Integrator { ic, .. }
            | Kind::RateLimiter { ic, .. }
            | Kind::Backlash { ic, .. }
            | Kind::Lag { ic, .. } => self.m.ics[o as usize] = *ic,
            Kind::Summer
            | Kind::Adc { .. }
            | Kind::Interrupt { .. }
            | Kind::Sense { .. }
            | Kind::Inverter
            | Kind::Gain { .. }
            | Kind::Pot { .. }
            | Kind::Dcu { .. }
            | Kind::Mdac { .. }
            | Kind::Dac { .. }
            | Kind::Multiplier
            | Kind::Divider
            | Kind::Square
            | Kind::SquareRoot
            | Kind::Sine
            | Kind::Cosine
            | Kind::Resolver
            | Kind::Arctangent => self.arithmetic(o, block)?,
            Kind::Abs
            | Kind::Min
            | Kind::Max
            | Kind::Function { .. }
            | Kind::DigitalFunction { .. }
            | Kind::Function2d { .. }
            | Kind::DeadZone { .. }
            | Kind::Limiter { .. }
            | Kind::DryFriction { .. }
            | Kind::Relay { .. }
            | Kind::Comparator { .. } => self.corner(o, block)?,
            Kind::TransportDelay { .. }
            | Kind::Generator { .. }
            | Kind::Noise { .. }
            | Kind::Constant { .. }
            | Kind::Time => self.source(o, block),
            Kind::Switch { .. }
            | Kind::TrackStore { .. }
            | Kind::And
            | Kind::Or
            | Kind::Not
            | Kind::FlipFlop { .. }
            | Kind::OneShot { .. }
            | Kind::Counter { .. }
            | Kind::Control { .. } => self.logic(o, block)?,
        }
        self.overload(o, block.max);
        Ok(())
    }

    /// Refuses times that problem time cannot resolve.
    fn check_times(&self, kind: &Kind) -> Result<(), RunFault> {
        let resolved = |s: f64| s >= LEAST_TIME_S;
        let fine = match *kind {
            Kind::RateLimiter { tau, .. } | Kind::Backlash { tau, .. } | Kind::Lag { tau, .. } => {
                tau > 0.0
            }
            Kind::TransportDelay { delay, .. } => resolved(delay),
            Kind::OneShot { width_s } => resolved(width_s),
            Kind::Noise { every_s, .. } => resolved(every_s),
            Kind::Generator { frequency_hz, start_s, .. } => {
                start_s.is_finite() && (0.0..=0.5 / LEAST_TIME_S).contains(&frequency_hz)
            }
            _ => true,
        };
        if fine {
            Ok(())
        } else {
            Err(self.malformed("one of its times is not positive, or below a nanosecond"))
        }
    }
}
