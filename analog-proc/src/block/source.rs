//! Sources: signal generators and seeded noise.
//!
//! What is constant between edges (step, square, noise) is written to its net
//! by a timer; ramp and sine are evaluated in the pass, after their start.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// A ramp or a sine.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Waveform {
    Ramp {
        offset: f64,
        slope: f64,
        start_s: f64,
    },
    Sine {
        offset: f64,
        amplitude: f64,
        frequency_hz: f64,
        phase_rad: f64,
        start_s: f64,
    },
}

impl Waveform {
    #[inline]
    pub fn at(&self, t_s: f64, started: bool) -> f64 {
        match *self {
            Waveform::Ramp {
                offset,
                slope,
                start_s,
            } => {
                if started {
                    offset + slope * (t_s - start_s)
                } else {
                    offset
                }
            }
            Waveform::Sine {
                offset,
                amplitude,
                frequency_hz,
                phase_rad,
                start_s,
            } => {
                if started {
                    let turns = frequency_hz * (t_s - start_s);
                    offset + amplitude * (std::f64::consts::TAU * turns + phase_rad).sin()
                } else {
                    offset
                }
            }
        }
    }
}

/// Something that happens at instants known beforehand.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Timer {
    Step {
        high: f64,
        start_s: f64,
    },
    Square {
        low: f64,
        high: f64,
        frequency_hz: f64,
        start_s: f64,
    },
    Start {
        wave: u32,
        start_s: f64,
    },
    Noise {
        noise: u32,
        every_s: f64,
    },
    /// Set by its one-shot.
    OneShotEnd,
}

/// What a timer does when it is due.
pub(crate) enum Firing {
    Value(f64),
    Started(u32),
    Renew(u32),
}

impl Timer {
    /// The last firing due by t = 0, for what starts before it; else the first.
    pub fn first(&self) -> u64 {
        match *self {
            Timer::Square {
                frequency_hz,
                start_s,
                ..
            } if start_s < 0.0 && frequency_hz > 0.0 => {
                (-start_s * 2.0 * frequency_hz).floor() as u64
            }
            _ => 0,
        }
    }

    /// The instant of the `n`-th firing, s.
    pub fn instant_s(&self, n: u64) -> f64 {
        match *self {
            Timer::Step { start_s, .. } | Timer::Start { start_s, .. } => {
                if n == 0 {
                    start_s
                } else {
                    f64::INFINITY
                }
            }
            Timer::Square {
                frequency_hz,
                start_s,
                ..
            } => {
                if n > 0 && frequency_hz <= 0.0 {
                    f64::INFINITY
                } else if n == 0 {
                    start_s
                } else {
                    start_s + n as f64 / (2.0 * frequency_hz)
                }
            }
            Timer::Noise { every_s, .. } => {
                if n == 0 {
                    0.0
                } else {
                    n as f64 * every_s
                }
            }
            Timer::OneShotEnd => f64::INFINITY,
        }
    }

    pub fn fire(&self, n: u64) -> Firing {
        match *self {
            Timer::Step { high, .. } => Firing::Value(high),
            Timer::Square { low, high, .. } => {
                Firing::Value(if n.is_multiple_of(2) { high } else { low })
            }
            Timer::Start { wave, .. } => Firing::Started(wave),
            Timer::Noise { noise, .. } => Firing::Renew(noise),
            Timer::OneShotEnd => Firing::Value(0.0),
        }
    }
}

/// A seeded source of normal deviates.
#[derive(Clone, Debug)]
pub(crate) struct Noise {
    sigma: f64,
    generator: Xoshiro256PlusPlus,
}

impl Noise {
    pub fn new(sigma: f64, seed: u64) -> Noise {
        Noise {
            sigma,
            generator: Xoshiro256PlusPlus::seed_from_u64(seed),
        }
    }

    pub fn next(&mut self) -> f64 {
        let deviate: f64 = StandardNormal.sample(&mut self.generator);
        self.sigma * deviate
    }
}
