//! Recording at multiples of a period: reads what is there, and never alters a step.
//!
//! It ends where its sink has had enough, and at a value that is not finite: the dense
//! output of a step may overflow though both ends of the step are finite.

use interface::Tick;
use std::ops::ControlFlow;

/// Takes a row: time in s and values.
pub type Sink<'a> = dyn FnMut(f64, &[f64]) -> ControlFlow<()> + 'a;

/// Why no further rows are recorded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Cut {
    /// The sink takes no more.
    Sink,
    /// The value of this slot at this time, s, is not finite.
    NonFinite(u32, f64),
}

/// Hands nets to a sink at multiples of a period.
pub(crate) struct Recorder<'a> {
    every: Tick,
    next: i64,
    slots: Vec<u32>,
    values: Vec<f64>,
    sink: &'a mut Sink<'a>,
    cut: Option<Cut>,
}

impl<'a> Recorder<'a> {
    pub fn new(now_s: f64, every: Tick, slots: Vec<u32>, sink: &'a mut Sink<'a>) -> Recorder<'a> {
        let every = Tick(every.0.max(1));
        let mut next = (now_s * 1e9) as i64 / every.0;
        while Tick(every.0.saturating_mul(next)).secs() <= now_s {
            next += 1;
        }
        let values = vec![0.0; slots.len()];
        Recorder { every, next, slots, values, sink, cut: None }
    }

    /// Instant of the next row, s; never, once it is cut.
    pub fn next_s(&self) -> f64 {
        if self.cut.is_some() {
            return f64::INFINITY;
        }
        Tick(self.every.0.saturating_mul(self.next)).secs()
    }

    /// Why it ended, if it did.
    pub fn cut(&self) -> Option<Cut> {
        self.cut
    }

    pub fn record(&mut self, nets: &[f64]) {
        let t_s = self.next_s();
        for (value, slot) in self.values.iter_mut().zip(&self.slots) {
            *value = nets[*slot as usize];
        }
        if let Some(i) = self.values.iter().position(|v| !v.is_finite()) {
            self.cut = Some(Cut::NonFinite(self.slots[i], t_s));
            return;
        }
        self.next += 1;
        if (self.sink)(t_s, &self.values).is_break() {
            self.cut = Some(Cut::Sink);
        }
    }
}
