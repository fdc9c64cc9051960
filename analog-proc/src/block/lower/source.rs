//! Sources, and the delay, whose output is a source as far as the pass is concerned.

use crate::block::Lowering;
use crate::block::delay::DelayLine;
use crate::block::source::{Timer, Waveform};
use crate::net::{Block, Kind, Wave};
use crate::op::{Op, Slot, Term};

impl Lowering {
    /// Wires the outputs of a block of this file.
    pub(super) fn source(&mut self, o: Slot, block: &Block) {
        match &block.kind {
            Kind::TransportDelay { delay, initial } => {
                let line = self.m.lines.len() as u32;
                let input = Term { slot: 0, c: 0.0 };
                self.m.lines.push(DelayLine::new(input, *delay, *initial));
                self.m.step_cap_s = self.m.step_cap_s.min(*delay);
                self.push(Op::Delay { o, line }, &[o], true);
            }
            Kind::Generator { wave, amplitude, offset, frequency_hz, phase_rad, start_s } => {
                let (offset, amplitude, start_s) = (*offset, *amplitude, *start_s);
                self.m.initial_nets[o as usize] = offset;
                let form = match wave {
                    Wave::Step => {
                        let high = offset + amplitude;
                        self.m.timers.push((o, Timer::Step { high, start_s }));
                        None
                    }
                    Wave::Square => {
                        let (low, high) = (offset - amplitude, offset + amplitude);
                        let frequency_hz = *frequency_hz;
                        let square = Timer::Square {
                            low,
                            high,
                            frequency_hz,
                            lead: 2.0 * (phase_rad / std::f64::consts::TAU).rem_euclid(1.0),
                            start_s,
                        };
                        self.m.timers.push((o, square));
                        None
                    }
                    Wave::Ramp => Some(Waveform::Ramp { offset, slope: amplitude, start_s }),
                    Wave::Sine => {
                        let (frequency_hz, phase_rad) = (*frequency_hz, *phase_rad);
                        Some(Waveform::Sine { offset, amplitude, frequency_hz, phase_rad, start_s })
                    }
                };
                if let Some(form) = form {
                    let wave = self.m.waves.len() as u32;
                    self.m.waves.push(form);
                    self.m.timers.push((o, Timer::Start { wave, start_s }));
                    self.push(Op::Wave { o, wave }, &[o], true);
                }
            }
            Kind::Noise { sigma, every_s, seed } => {
                let noise = self.m.noises.len() as u32;
                self.m.noises.push((*sigma, *seed));
                self.m.timers.push((o, Timer::Noise { noise, every_s: *every_s }));
            }
            Kind::Constant { value } => self.m.initial_nets[o as usize] = *value,
            Kind::Time => self.push(Op::Time { o }, &[o], true),
            _ => {}
        }
    }
}
