//! Weights of the folded program, and those that coefficient units take part in.

use crate::op::Slot;

/// Where a weight stands.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Place {
    /// In the flat array of the rows and long sums.
    Row(usize),
    /// The `k`-th of a folded operation.
    Step { index: usize, k: usize },
}

/// A weight that coefficient units take part in: `base · Π dcus`.
#[derive(Clone, Debug)]
pub(crate) struct Scaled {
    pub(crate) place: Place,
    pub(crate) base: f64,
    pub(crate) dcus: Vec<u32>,
}

/// A net read with a weight `c · Π dcus`.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub slot: Slot,
    pub c: f64,
    pub dcus: Vec<u32>,
}

impl Part {
    pub fn plain(slot: Slot, c: f64) -> Part {
        let dcus = Vec::new();
        Part { slot, c, dcus }
    }

    /// What this part becomes where the net it reads is itself `inner`.
    pub fn times(&self, inner: &Part) -> Part {
        let mut dcus = self.dcus.clone();
        dcus.extend_from_slice(&inner.dcus);
        Part { slot: inner.slot, c: self.c * inner.c, dcus }
    }
}

/// The flat array of weights under construction.
#[derive(Default)]
pub(crate) struct Weights {
    pub base: Vec<f64>,
    pub scaled: Vec<Scaled>,
}

impl Weights {
    /// The place of one more weight of the rows.
    pub fn push(&mut self, part: &Part) -> u32 {
        let place = self.base.len();
        self.base.push(part.c);
        self.scale(Place::Row(place), part);
        place as u32
    }

    pub fn push_all(&mut self, parts: &[Part]) -> u32 {
        let start = self.base.len() as u32;
        for part in parts {
            self.push(part);
        }
        start
    }

    /// Weights that stand in operation `index` itself.
    pub fn within<const N: usize>(&mut self, index: usize, parts: &[Part]) -> [f64; N] {
        std::array::from_fn(|k| {
            let part = &parts[k];
            self.scale(Place::Step { index, k }, part);
            part.c
        })
    }

    pub fn scale(&mut self, place: Place, part: &Part) {
        if !part.dcus.is_empty() {
            self.scaled.push(Scaled { place, base: part.c, dcus: part.dcus.clone() });
        }
    }
}
