//! Bending moments of a run or a flight from what was sampled of it: eq. (23) of the paper.
//!
//! The moment is no part of a control loop, so it is found beside it: incidence and forces of
//! every sample load the beam ([`vehicle::structure`]), and its modes, eq. (24), answer to them
//! from rest. Between samples the loads are taken as straight lines, for which the modes' answer
//! is exact ([`vehicle::modal_response`]); the greatest moments are sought between them too, since
//! the third mode turns round in two samples of 20 ms.

pub mod flight;
pub mod outcome;

use vehicle::{
    beam_shape::MODES,
    modal_response::ModalResponse,
    structure::{Beam, Loads, Structure},
};

/// A moment and where and when it was met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Met {
    /// N·m; of both planes √(pitch² + yaw²), of one plane |BM|.
    pub moment_nm: f64,
    /// Station, m forward of the nozzle exit.
    pub station_m: f64,
    /// Time, s.
    pub time_s: f64,
}

/// The moments of one kind (quasi-static, or with the modes) in N planes.
#[derive(Clone, Debug, PartialEq)]
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
#[derive(Clone, Debug, PartialEq)]
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

/// A sample: its time, f_i of every mode and the quasi-static moments.
#[derive(Clone)]
struct Sample<const N: usize> {
    time_s: f64,
    drive: [[f64; MODES]; N],
    quasi_static_nm: [Vec<f64>; N],
}

/// Finds the moments sample by sample.
pub struct Recorder<const N: usize> {
    modes: [[ModalResponse; MODES]; N],
    before: Option<Sample<N>>,
    now: Sample<N>,
    moment_nm: [Vec<f64>; N],
    found: BendingMoments<N>,
}

impl<const N: usize> Recorder<N> {
    /// Of a vehicle at rest.
    pub fn new(structure: &Structure) -> Self {
        let zero: [Vec<f64>; N] = std::array::from_fn(|_| vec![0.0; structure.stations_m().len()]);
        Recorder {
            modes: [[ModalResponse::default(); MODES]; N],
            before: None,
            now: Sample { time_s: 0.0, drive: [[0.0; MODES]; N], quasi_static_nm: zero.clone() },
            moment_nm: zero,
            found: BendingMoments {
                quasi_static: Moments::new(structure),
                whole: Moments::new(structure),
            },
        }
    }

    /// Takes the next sample, with the beam of its time; samples come in order of time.
    pub fn observe(&mut self, time_s: f64, beam: &Beam, loads: [Loads; N]) {
        self.now.time_s = time_s;
        for (plane, loads) in loads.iter().enumerate() {
            self.now.drive[plane] = beam.drive(loads);
            let moment_nm = &mut self.now.quasi_static_nm[plane];
            moment_nm.fill(0.0);
            beam.add_quasi_static(loads, moment_nm);
        }
        self.found.quasi_static.observe(time_s, &self.now.quasi_static_nm);
        // On the wall clock a sample may come with no time since that before.
        if let Some(before) = self.before.take().filter(|before| time_s > before.time_s) {
            self.advance(&before, beam);
            self.before = Some(before);
        }
        self.load(None, beam);
        self.found.whole.observe(time_s, &self.moment_nm);
        match &mut self.before {
            Some(before) => std::mem::swap(before, &mut self.now),
            None => self.before = Some(self.now.clone()),
        }
    }

    /// Lets the modes go on from the sample before to the present one.
    fn advance(&mut self, before: &Sample<N>, beam: &Beam) {
        let interval_s = self.now.time_s - before.time_s;
        let steps = match self.may_exceed(before, beam) {
            true => (interval_s / SOUGHT_EVERY_S).ceil().max(1.0),
            false => 1.0,
        };
        let mut step = 0.0;
        while step < steps {
            let part = [step / steps, (step + 1.0) / steps];
            for plane in 0..N {
                for (i, mode) in beam.modes.iter().enumerate() {
                    let [from, to] = [before.drive[plane][i], self.now.drive[plane][i]];
                    let force = part.map(|part| from + part * (to - from));
                    self.modes[plane][i].advance(
                        mode.frequency_radps,
                        mode.damping,
                        interval_s / steps,
                        force,
                    );
                }
            }
            step += 1.0;
            if step < steps {
                self.load(Some((before, step / steps)), beam);
                let time_s = before.time_s + step / steps * interval_s;
                self.found.whole.meet(time_s, &self.moment_nm);
            }
        }
    }

    /// Whether the moment of any station may come to exceed its greatest before the present sample.
    fn may_exceed(&self, before: &Sample<N>, beam: &Beam) -> bool {
        let bounds: [[f64; MODES]; N] = std::array::from_fn(|plane| {
            std::array::from_fn(|i| {
                let mode = &beam.modes[i];
                self.modes[plane][i].acceleration_bound_mps2(
                    mode.frequency_radps,
                    mode.damping,
                    self.now.time_s - before.time_s,
                    [before.drive[plane][i], self.now.drive[plane][i]],
                )
            })
        });
        let held = &self.found.whole.square;
        let stations = held.len();
        let columns = beam.mode_columns().map(|column| &column[..stations]);
        let planes: [_; N] = std::array::from_fn(|plane| {
            let rows = [before, &self.now].map(|s| &s.quasi_static_nm[plane][..stations]);
            (rows, bounds[plane])
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

    /// The moments with the modes as they are, the loads being those of the present sample or so
    /// far on the way to it from that before.
    fn load(&mut self, on_the_way: Option<(&Sample<N>, f64)>, beam: &Beam) {
        for plane in 0..N {
            let (now, sum) = (&self.now.quasi_static_nm[plane], &mut self.moment_nm[plane]);
            let mut drive = self.now.drive[plane];
            match on_the_way {
                None => sum.copy_from_slice(now),
                Some((before, part)) => {
                    let between = |from: f64, to: f64| from + part * (to - from);
                    let quasi_static = before.quasi_static_nm[plane].iter().zip(now);
                    for (sum, (from, to)) in sum.iter_mut().zip(quasi_static) {
                        *sum = between(*from, *to);
                    }
                    for (to, from) in drive.iter_mut().zip(before.drive[plane]) {
                        *to = between(from, *to);
                    }
                }
            }
            let accelerations = std::array::from_fn(|i| {
                let (mode, response) = (&beam.modes[i], &self.modes[plane][i]);
                response.acceleration_mps2(mode.frequency_radps, mode.damping, drive[i])
            });
            beam.add_modes(accelerations, sum);
        }
    }

    /// What was found.
    pub fn finish(self) -> BendingMoments<N> {
        self.found
    }
}
