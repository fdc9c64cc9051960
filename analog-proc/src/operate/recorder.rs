//! Recording at multiples of a period: reads what is there, and never alters a step.

use interface::Tick;

/// Hands nets to a sink at multiples of a period.
pub(crate) struct Recorder<'a> {
    every: Tick,
    next: i64,
    slots: Vec<u32>,
    values: Vec<f64>,
    sink: &'a mut dyn FnMut(f64, &[f64]),
}

impl<'a> Recorder<'a> {
    pub fn new(
        now_s: f64,
        every: Tick,
        slots: Vec<u32>,
        sink: &'a mut dyn FnMut(f64, &[f64]),
    ) -> Recorder<'a> {
        let every = Tick(every.0.max(1));
        let mut next = (now_s * 1e9) as i64 / every.0;
        while Tick(every.0.saturating_mul(next)).secs() <= now_s {
            next += 1;
        }
        let values = vec![0.0; slots.len()];
        Recorder {
            every,
            next,
            slots,
            values,
            sink,
        }
    }

    pub fn next_s(&self) -> f64 {
        Tick(self.every.0.saturating_mul(self.next)).secs()
    }

    pub fn record(&mut self, nets: &[f64]) {
        for (value, slot) in self.values.iter_mut().zip(&self.slots) {
            *value = nets[*slot as usize];
        }
        let t_s = self.next_s();
        (self.sink)(t_s, &self.values);
        self.next += 1;
    }
}
