//! Sources: signal generators and seeded noise.
//!
//! What is constant between edges (step, square, noise) is written to its net
//! by a timer; ramp and sine are evaluated in the pass, after their start.

use interface::deviate::Normal;
use serde::{Deserialize, Serialize};

use crate::signal::Signal;

/// A ramp or a sine.
#[derive(Clone, Copy, Debug)]
pub enum Waveform {
    Ramp { offset: f64, slope: f64, start_s: f64 },
    Sine { offset: f64, amplitude: f64, frequency_hz: f64, phase_rad: f64, start_s: f64 },
}

impl Waveform {
    /// How long it takes to turn by so much, s; a ramp never does.
    pub fn time_to_turn_s(&self, turn_rad: f64) -> f64 {
        match *self {
            Waveform::Sine { frequency_hz, .. } if frequency_hz > 0.0 => {
                turn_rad / (std::f64::consts::TAU * frequency_hz)
            }
            _ => f64::INFINITY,
        }
    }

    #[inline]
    pub fn signal<N: Signal>(&self, t_s: f64, started: bool) -> N {
        match *self {
            Waveform::Ramp { offset, slope, start_s } => {
                if started {
                    N::of_time(t_s, offset + slope * (t_s - start_s), || slope)
                } else {
                    N::constant(offset)
                }
            }
            Waveform::Sine { offset, amplitude, frequency_hz, phase_rad, start_s } => {
                if !started {
                    return N::constant(offset);
                }
                let turns = frequency_hz * (t_s - start_s);
                let angle = std::f64::consts::TAU * turns + phase_rad;
                N::of_time(t_s, offset + amplitude * libm::sin(angle), || {
                    std::f64::consts::TAU * frequency_hz * amplitude * libm::cos(angle)
                })
            }
        }
    }
}

/// Something that happens at instants known beforehand.
#[derive(Clone, Copy, Debug)]
pub enum Timer {
    Step {
        high: f64,
        start_s: f64,
    },
    Square {
        low: f64,
        high: f64,
        frequency_hz: f64,
        /// Half periods that lie behind at the start, 0 to 2.
        lead: f64,
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
pub enum Firing {
    Value(f64),
    Started(u32),
    Renew(u32),
}

impl Timer {
    /// The last firing due by t = 0, for what starts before it; else the first.
    pub fn first(&self) -> u64 {
        match *self {
            Timer::Square { frequency_hz, lead, start_s, .. }
                if start_s < 0.0 && frequency_hz > 0.0 =>
            {
                (-start_s * 2.0 * frequency_hz + lead.fract()).floor() as u64
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
            Timer::Square { frequency_hz, lead, start_s, .. } => {
                if n > 0 && frequency_hz <= 0.0 {
                    f64::INFINITY
                } else if n == 0 {
                    start_s
                } else {
                    start_s + (n as f64 - lead.fract()) / (2.0 * frequency_hz)
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
            Timer::Square { low, high, lead, .. } => {
                let half = n + lead as u64;
                Firing::Value(if half.is_multiple_of(2) { high } else { low })
            }
            Timer::Start { wave, .. } => Firing::Started(wave),
            Timer::Noise { noise, .. } => Firing::Renew(noise),
            Timer::OneShotEnd => Firing::Value(0.0),
        }
    }
}

/// A seeded source of normal deviates.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Noise {
    sigma: f64,
    deviates: Normal,
}

impl Noise {
    pub fn new(sigma: f64, seed: u64) -> Noise {
        Noise { sigma, deviates: Normal::seeded(seed) }
    }

    pub fn renew(&mut self) -> f64 {
        self.sigma * self.deviates.draw()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_phase_of_a_square_wave_shifts_its_edges() {
        // Half a second a half period; `lead` of phase π/2, π, −π/2.
        for (lead, high_first, first_edge_s) in
            [(0.5, true, 0.25), (1.0, false, 0.5), (1.5, false, 0.25)]
        {
            let wave =
                Timer::Square { low: -1.0, high: 1.0, frequency_hz: 1.0, lead, start_s: 0.0 };
            let is_high = |n| matches!(wave.fire(n), Firing::Value(v) if v > 0.0);
            assert_eq!(wave.instant_s(0).to_bits(), 0.0_f64.to_bits());
            for n in 1..5 {
                let edge_s = first_edge_s + 0.5 * (n - 1) as f64;
                assert!((wave.instant_s(n) - edge_s).abs() < 1e-15);
                assert_eq!(is_high(n), high_first == n.is_multiple_of(2));
            }
            assert_eq!(is_high(0), high_first);
        }
    }
}
