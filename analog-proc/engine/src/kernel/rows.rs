//! Derivatives as weighted sums: rows grouped by length, so that each group is one loop.
//!
//! The weights of all rows lie in one array in the order in which the groups are
//! evaluated. A band is a run of rows for neighbouring states whose nets are
//! neighbours too; it is a loop over slices, which the compiler vectorises.

use super::weights::{Part, Weights};
use crate::op::Slot;

/// Fewest rows that are worth a loop of their own.
const SHORTEST_BAND: usize = 4;

/// Rows of `N` terms: the state, and the nets read.
type Group<const N: usize> = Vec<(u32, [Slot; N])>;

/// Rows for states from `state` on; term k of row i reads net `first[k] + i`.
#[derive(Clone, Debug)]
struct Band {
    state: usize,
    rows: usize,
    terms: usize,
    first: [Slot; 3],
}

/// One derivative: its linear terms, and products of two nets.
pub struct Row {
    pub state: u32,
    pub linear: Vec<Part>,
    pub products: Vec<(Part, Slot)>,
}

/// All derivatives.
#[derive(Clone, Debug, Default)]
pub struct Rows {
    bands: Vec<Band>,
    one: Group<1>,
    two: Group<2>,
    three: Group<3>,
    four: Group<4>,
    /// State, and where its nets lie in `slots`.
    many: Vec<(u32, u32, u32)>,
    slots: Vec<Slot>,
    /// States that have products only.
    bare: Vec<u32>,
    /// State and the two nets whose product is added to it.
    products: Vec<(u32, [Slot; 2])>,
}

fn nets<const N: usize>(parts: &[Part]) -> [Slot; N] {
    std::array::from_fn(|i| parts[i].slot)
}

/// The longest run from the front that forms a band.
fn band(rows: &[Row]) -> Option<Band> {
    let first = rows.first()?;
    let terms = first.linear.len();
    if !(1..=3).contains(&terms) {
        return None;
    }
    let follows = |(i, row): &(usize, &Row)| {
        let i = *i as u32;
        row.state == first.state + i
            && row.linear.len() == terms
            && row.linear.iter().zip(&first.linear).all(|(part, start)| part.slot == start.slot + i)
    };
    let length = rows.iter().enumerate().take_while(follows).count();
    let mut slots = [0; 3];
    for (slot, part) in slots.iter_mut().zip(&first.linear) {
        *slot = part.slot;
    }
    (length >= SHORTEST_BAND).then_some(Band {
        state: first.state as usize,
        rows: length,
        terms,
        first: slots,
    })
}

#[inline(always)]
fn take<'a>(weights: &mut &'a [f64], n: usize) -> &'a [f64] {
    let (head, tail) = weights.split_at(n);
    *weights = tail;
    head
}

#[inline(always)]
fn group<const N: usize>(rows: &Group<N>, weights: &mut &[f64], nets: &[f64], d: &mut [f64]) {
    let (weights, _) = take(weights, N * rows.len()).as_chunks::<N>();
    for ((state, slots), w) in rows.iter().zip(weights) {
        let mut sum = w[0] * nets[slots[0] as usize];
        for i in 1..N {
            sum += w[i] * nets[slots[i] as usize];
        }
        d[*state as usize] = sum;
    }
}

impl Rows {
    pub fn build(mut rows: Vec<Row>, weights: &mut Weights) -> Rows {
        rows.sort_by_key(|row| row.state);
        let mut built = Rows::default();
        let mut single = Vec::new();
        let mut i = 0;
        while i < rows.len() {
            let Some(band) = band(&rows[i..]) else {
                single.push(&rows[i]);
                i += 1;
                continue;
            };
            for term in 0..band.terms {
                for row in &rows[i..i + band.rows] {
                    weights.push(&row.linear[term]);
                }
            }
            i += band.rows;
            built.bands.push(band);
        }
        for length in 0..=4 {
            for row in single.iter().filter(|row| row.linear.len() == length) {
                weights.push_all(&row.linear);
                match length {
                    0 => built.bare.push(row.state),
                    1 => built.one.push((row.state, nets(&row.linear))),
                    2 => built.two.push((row.state, nets(&row.linear))),
                    3 => built.three.push((row.state, nets(&row.linear))),
                    _ => built.four.push((row.state, nets(&row.linear))),
                }
            }
        }
        for row in single.iter().filter(|row| row.linear.len() > 4) {
            weights.push_all(&row.linear);
            let (start, len) = (built.slots.len() as u32, row.linear.len() as u32);
            built.slots.extend(row.linear.iter().map(|part| part.slot));
            built.many.push((row.state, start, len));
        }
        for row in &rows {
            for (part, other) in &row.products {
                weights.push(part);
                built.products.push((row.state, [part.slot, *other]));
            }
        }
        built
    }

    pub fn len(&self) -> usize {
        let bands: usize = self.bands.iter().map(|band| band.rows).sum();
        let groups = self.one.len() + self.two.len() + self.three.len() + self.four.len();
        bands + groups + self.many.len() + self.bare.len() + self.products.len()
    }

    #[inline(always)]
    pub fn evaluate(&self, mut weights: &[f64], nets: &[f64], d: &mut [f64]) {
        let w = &mut weights;
        for band in &self.bands {
            let n = band.rows;
            let d = &mut d[band.state..][..n];
            let term = |k: usize| &nets[band.first[k] as usize..][..n];
            match band.terms {
                1 => {
                    let (x, wx) = (term(0), take(w, n));
                    for i in 0..n {
                        d[i] = wx[i] * x[i];
                    }
                }
                2 => {
                    let (x, y) = (term(0), term(1));
                    let (wx, wy) = (take(w, n), take(w, n));
                    for i in 0..n {
                        d[i] = wx[i] * x[i] + wy[i] * y[i];
                    }
                }
                _ => {
                    let (x, y, z) = (term(0), term(1), term(2));
                    let (wx, wy, wz) = (take(w, n), take(w, n), take(w, n));
                    for i in 0..n {
                        d[i] = wx[i] * x[i] + wy[i] * y[i] + wz[i] * z[i];
                    }
                }
            }
        }
        for state in &self.bare {
            d[*state as usize] = 0.0;
        }
        group(&self.one, w, nets, d);
        group(&self.two, w, nets, d);
        group(&self.three, w, nets, d);
        group(&self.four, w, nets, d);
        for (state, start, len) in &self.many {
            let slots = &self.slots[*start as usize..(*start + *len) as usize];
            let weights = take(w, slots.len());
            let mut sum = 0.0;
            for (slot, w) in slots.iter().zip(weights) {
                sum += w * nets[*slot as usize];
            }
            d[*state as usize] = sum;
        }
        for ((state, [a, b]), w) in self.products.iter().zip(*w) {
            d[*state as usize] += w * nets[*a as usize] * nets[*b as usize];
        }
    }
}
