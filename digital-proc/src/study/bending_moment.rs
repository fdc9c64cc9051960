//! Bending moments of a run or a flight from what was sampled of it: eq. (23) of the paper.
//!
//! The moment is no part of a control loop, so it is found beside it: incidence and forces of
//! every sample load the beam ([`vehicle::structure`]), and its modes, eq. (24), answer to them
//! from rest. Between samples their forces are cubics, for which the answer is exact
//! ([`vehicle::modal_response`]); straight lines would take 0.6 % off the moment that a gust of
//! 46 ms edges makes in samples of 20 ms. The greatest moments are sought between samples too,
//! since the third mode turns round in two of them.

#[cfg(test)]
pub(crate) mod elements;
pub mod flight;
pub mod outcome;

use serde::{Deserialize, Serialize};
use std::{collections::VecDeque, rc::Rc};
use vehicle::{
    beam_shape::MODES,
    modal_response::{self, Cubic, ModalResponse},
    structure::{Beam, Loads, Structure},
};

/// A moment and where and when it was met.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Met {
    /// N·m; of both planes √(pitch² + yaw²), of one plane |BM|.
    pub moment_nm: f64,
    /// Station, m forward of the nozzle exit.
    pub station_m: f64,
    /// Time, s.
    pub time_s: f64,
}

/// The moments of one kind (quasi-static, or with the modes) in N planes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "[f64; N]: Serialize", deserialize = "[f64; N]: Deserialize<'de>"))]
pub struct Moments<const N: usize> {
    /// Greatest of all.
    pub greatest: Met,
    /// Moment in each plane along the vehicle when the greatest was met, N·m.
    pub profile_nm: Vec<[f64; N]>,
    /// Greatest along the vehicle at each sample, with the moment in each plane there, N·m.
    pub over_time: Vec<(Met, [f64; N])>,
    stations_m: Vec<f64>,
    /// Greatest at each station so far, squared, and when it was met. Arrays of numbers, which the
    /// processor takes two or four at a time: a case study has some 10⁹ of them.
    square: Vec<f64>,
    time_s: Vec<f64>,
}

/// The moments of one run or flight; N planes: pitch alone, yaw alone, or both.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "[f64; N]: Serialize", deserialize = "[f64; N]: Deserialize<'de>"))]
pub struct BendingMoments<const N: usize> {
    /// Without the modes.
    pub quasi_static: Moments<N>,
    /// With them.
    pub whole: Moments<N>,
}

impl<const N: usize> Moments<N> {
    fn new(structure: &Structure) -> Self {
        let stations_m = structure.stations_m().to_vec();
        let zero = vec![0.0; stations_m.len()];
        Moments {
            greatest: Met { moment_nm: 0.0, station_m: stations_m[0], time_s: 0.0 },
            profile_nm: vec![[0.0; N]; stations_m.len()],
            over_time: Vec::new(),
            stations_m,
            square: zero.clone(),
            time_s: zero,
        }
    }

    /// Takes the moments of one instant, N·m, shape `[plane][station]`; the greatest of them, with
    /// the moment in each plane there.
    fn meet(&mut self, time_s: f64, moment_nm: &[Vec<f64>; N]) -> (Met, [f64; N]) {
        let stations = self.square.len();
        let planes: [&[f64]; N] = std::array::from_fn(|plane| &moment_nm[plane][..stations]);
        let held = self.square.iter_mut().zip(&mut self.time_s).enumerate();
        let mut greatest = 0.0_f64;
        for (station, (square, met_s)) in held {
            let here: f64 = planes.iter().map(|plane| plane[station] * plane[station]).sum();
            *met_s = if here > *square { time_s } else { *met_s };
            *square = if here > *square { here } else { *square };
            greatest = if here > greatest { here } else { greatest };
        }
        let at = |station: usize| planes.map(|plane| plane[station]);
        let square = |station: usize| at(station).iter().map(|m| m * m).sum::<f64>();
        let worst = (0..stations).find(|&station| square(station) == greatest).unwrap_or(0);
        let met = Met { moment_nm: greatest.sqrt(), station_m: self.stations_m[worst], time_s };
        if met.moment_nm > self.greatest.moment_nm {
            self.greatest = met;
            self.profile_nm.iter_mut().enumerate().for_each(|(station, all)| *all = at(station));
        }
        (met, at(worst))
    }

    /// Takes the moments of a sample.
    fn observe(&mut self, time_s: f64, moment_nm: &[Vec<f64>; N]) {
        let met = self.meet(time_s, moment_nm);
        self.over_time.push(met);
    }

    /// The greatest at each station over time.
    pub fn at_stations(&self) -> impl Iterator<Item = Met> {
        let held = self.square.iter().zip(&self.time_s).zip(&self.stations_m);
        held.map(|((square, &time_s), &station_m)| Met {
            moment_nm: square.sqrt(),
            station_m,
            time_s,
        })
    }
}

/// Longest step between instants at which moments are sought, s: of the fastest mode (180 rad/s)
/// a peak is missed by 1 − cos(0.225) = 2.5 % at most, and that mode has a tenth of the moment.
const SOUGHT_EVERY_S: f64 = 2.5e-3;

/// A sample: its time, the beam then, f_i of every mode and the quasi-static moments.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound(
    serialize = "[[f64; MODES]; N]: Serialize, [Vec<f64>; N]: Serialize",
    deserialize = "[[f64; MODES]; N]: Deserialize<'de>, [Vec<f64>; N]: Deserialize<'de>"
))]
struct Sample<const N: usize> {
    time_s: f64,
    #[serde(with = "shared")]
    beam: Rc<Beam>,
    drive: [[f64; MODES]; N],
    quasi_static_nm: [Vec<f64>; N],
}

/// Finds the moments sample by sample, one behind: the forces between two samples are the cubic
/// through them and one on each side.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound(
    serialize = "[[ModalResponse; MODES]; N]: Serialize, Sample<N>: Serialize, [Vec<f64>; N]: Serialize, BendingMoments<N>: Serialize",
    deserialize = "[[ModalResponse; MODES]; N]: Deserialize<'de>, Sample<N>: Deserialize<'de>, [Vec<f64>; N]: Deserialize<'de>, BendingMoments<N>: Deserialize<'de>"
))]
pub struct Recorder<const N: usize> {
    modes: [[ModalResponse; MODES]; N],
    /// The latest, at most four; the modes are at the last but one.
    samples: VecDeque<Sample<N>>,
    moment_nm: [Vec<f64>; N],
    found: BendingMoments<N>,
}

/// A beam that several samples may have, kept with each.
mod shared {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use std::rc::Rc;
    use vehicle::structure::Beam;

    pub fn serialize<S: Serializer>(beam: &Rc<Beam>, to: S) -> Result<S::Ok, S::Error> {
        beam.as_ref().serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Rc<Beam>, D::Error> {
        Beam::deserialize(from).map(Rc::new)
    }
}

impl<const N: usize> Recorder<N> {
    /// Of a vehicle at rest.
    pub fn new(structure: &Structure) -> Self {
        Recorder {
            modes: [[ModalResponse::default(); MODES]; N],
            samples: VecDeque::with_capacity(4),
            moment_nm: std::array::from_fn(|_| vec![0.0; structure.stations_m().len()]),
            found: BendingMoments {
                quasi_static: Moments::new(structure),
                whole: Moments::new(structure),
            },
        }
    }

    /// Takes the next sample, with the beam of its time; samples come in order of time, and one
    /// that comes with no time since that before (on the wall clock) is left out.
    pub fn observe(&mut self, time_s: f64, beam: &Rc<Beam>, loads: [Loads; N]) {
        if self.samples.back().is_some_and(|last| last.time_s >= time_s) {
            return;
        }
        let quasi_static_nm = loads.map(|loads| {
            let mut moment_nm = vec![0.0; self.moment_nm[0].len()];
            beam.add_quasi_static(&loads, &mut moment_nm);
            moment_nm
        });
        self.found.quasi_static.observe(time_s, &quasi_static_nm);
        let drive = loads.map(|loads| beam.drive(&loads));
        let beam = Rc::clone(beam);
        self.samples.push_back(Sample { time_s, beam, drive, quasi_static_nm });
        match self.samples.len() {
            1 => self.load(0, None),
            2 => {}
            3 => self.advance(0),
            _ => {
                self.advance(1);
                self.samples.pop_front();
            }
        }
    }

    /// Lets the modes go on from a sample of those held to the next.
    fn advance(&mut self, from: usize) {
        let (before, now) = (&self.samples[from], &self.samples[from + 1]);
        let interval_s = now.time_s - before.time_s;
        let forces: [[Cubic; MODES]; N] =
            std::array::from_fn(|plane| std::array::from_fn(|mode| self.force(from, plane, mode)));
        let start = self.modes;
        let beam = Rc::clone(&now.beam);
        let begun_s = before.time_s;
        let steps = match self.may_exceed(from, &forces) {
            true => (interval_s / SOUGHT_EVERY_S).ceil().max(1.0),
            false => 1.0,
        };
        let mut step = 1.0;
        loop {
            let part = step / steps;
            for plane in 0..N {
                for (i, mode) in beam.modes.iter().enumerate() {
                    self.modes[plane][i] = start[plane][i].after(
                        mode.frequency_radps,
                        mode.damping,
                        part * interval_s,
                        forces[plane][i],
                    );
                }
            }
            if step >= steps {
                break;
            }
            self.load(from + 1, Some((part, &forces)));
            self.found.whole.meet(begun_s + part * interval_s, &self.moment_nm);
            step += 1.0;
        }
        self.load(from + 1, None);
    }

    /// f_i from a sample of those held to the next: the cubic through these two and their
    /// neighbours, of lower degree where there are none, in the time from the first of the two.
    fn force(&self, from: usize, plane: usize, mode: usize) -> Cubic {
        let here = &self.samples[from];
        let f = |sample: &Sample<N>| sample.drive[plane][mode];
        // (f − f₀)/t of the other samples is c₁ + c₂t + c₃t².
        let mut others = [(0.0, 0.0); 3];
        let first = from.saturating_sub(1);
        let near = self.samples.iter().enumerate().skip(first).take(from + 3 - first);
        let mut count = 0;
        for (_, sample) in near.filter(|(i, _)| *i != from) {
            let t = sample.time_s - here.time_s;
            others[count] = (t, (f(sample) - f(here)) / t);
            count += 1;
        }
        let [(ta, ga), (tb, gb), (tc, gc)] = others;
        let (mut c1, mut c2, mut c3) = (ga, 0.0, 0.0);
        if count > 1 {
            c2 = (gb - ga) / (tb - ta);
        }
        if count > 2 {
            c3 = ((gc - gb) / (tc - tb) - c2) / (tc - ta);
            c2 -= c3 * (ta + tb);
        }
        c1 -= ta * (c2 + c3 * ta);
        [f(here), c1, c2, c3]
    }

    /// Whether the moment of any station may come to exceed its greatest so far on the way from a
    /// sample of those held to the next.
    fn may_exceed(&self, from: usize, forces: &[[Cubic; MODES]; N]) -> bool {
        let (before, now) = (&self.samples[from], &self.samples[from + 1]);
        let held = &self.found.whole.square;
        let stations = held.len();
        let columns = now.beam.mode_columns().map(|column| &column[..stations]);
        let planes: [_; N] = std::array::from_fn(|plane| {
            let rows = [before, now].map(|s| &s.quasi_static_nm[plane][..stations]);
            let bounds: [f64; MODES] = std::array::from_fn(|i| {
                let mode = &now.beam.modes[i];
                self.modes[plane][i].acceleration_bound_mps2(
                    mode.frequency_radps,
                    mode.damping,
                    now.time_s - before.time_s,
                    forces[plane][i],
                )
            });
            (rows, bounds)
        });
        let mut exceeds = false;
        for station in 0..stations {
            let mut square = 0.0;
            for ([from, to], bounds) in &planes {
                let (from, to) = (from[station].abs(), to[station].abs());
                let mut bound = if from > to { from } else { to };
                for (column, acceleration) in columns.iter().zip(bounds) {
                    bound += column[station].abs() * acceleration;
                }
                square += bound * bound;
            }
            exceeds |= square > held[station];
        }
        exceeds
    }

    /// The moments with the modes as they are, at a sample of those held, where they are recorded,
    /// or on the way to it from the one before: so far, under these forces.
    fn load(&mut self, at: usize, on_the_way: Option<(f64, &[[Cubic; MODES]; N])>) {
        let now = &self.samples[at];
        for plane in 0..N {
            let (row, sum) = (&now.quasi_static_nm[plane], &mut self.moment_nm[plane]);
            let mut drive = now.drive[plane];
            match on_the_way {
                None => sum.copy_from_slice(row),
                Some((part, forces)) => {
                    let before = &self.samples[at - 1];
                    let rows = before.quasi_static_nm[plane].iter().zip(row);
                    for (sum, (from, to)) in sum.iter_mut().zip(rows) {
                        *sum = from + part * (to - from);
                    }
                    let t_s = part * (now.time_s - before.time_s);
                    drive = forces[plane].map(|force| modal_response::at(force, t_s));
                }
            }
            let accelerations = std::array::from_fn(|i| {
                let (mode, response) = (&now.beam.modes[i], &self.modes[plane][i]);
                response.acceleration_mps2(mode.frequency_radps, mode.damping, drive[i])
            });
            now.beam.add_modes(accelerations, sum);
        }
        if on_the_way.is_none() {
            self.found.whole.observe(now.time_s, &self.moment_nm);
        }
    }

    /// What was found.
    pub fn finish(mut self) -> BendingMoments<N> {
        if let Some(from) = self.samples.len().checked_sub(2) {
            self.advance(from);
        }
        self.found
    }
}
