//! What each kind of block is made of.

use super::Lowering;
use super::curve::{
    DigitalFunction, Piece, band, pieces_of_abs, pieces_of_dead_zone, pieces_of_limiter,
    pieces_of_table,
};
use super::delay::DelayLine;
use super::friction::Friction;
use super::integrator::{Control, Stops};
use super::logic::Store;
use super::piecewise::Piecewise;
use super::source::{Timer, Waveform};
use super::surface::{Cell, Table};
use crate::fault::RunFault;
use crate::machine::{Op, Slot, Term};
use crate::net::{Block, Kind, Level, Wave};
use crate::order::Ordered;

/// Shortest delay, pulse or period: one tick, s.
const LEAST_TIME_S: f64 = 1e-9;

fn scaled(terms: Vec<Term>, factor: f64) -> Vec<Term> {
    terms
        .into_iter()
        .map(|t| Term {
            slot: t.slot,
            c: factor * t.c,
        })
        .collect()
}

impl Lowering {
    /// Wires the block's outputs; for a store, its initial output.
    #[allow(clippy::too_many_lines, reason = "one arm a kind of block")]
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
            Kind::Summer | Kind::Adc { .. } => self.weighted(o, block, 1.0)?,
            Kind::Interrupt { .. } => self.weighted(o, block, 1.0)?,
            Kind::Sense { line } => {
                self.weighted(o, block, 1.0)?;
                self.m.senses.push((*line, o));
            }
            Kind::Inverter => self.weighted(o, block, -1.0)?,
            Kind::Gain { k } | Kind::Pot { k } => self.weighted(o, block, *k)?,
            Kind::Dcu {
                channel, initial, ..
            } => {
                let u = self.sum(&block.inputs)?;
                let dcu = self.dcu(*channel, *initial);
                let varying = self.vary(&[u.slot]);
                self.push(
                    Op::Dcu {
                        o,
                        dcu,
                        a: u.slot,
                        c: u.c,
                    },
                    &[o],
                    varying,
                );
            }
            Kind::Mdac { channel, initial } => {
                let u = self.sum(&block.inputs)?;
                let hold = self.dac(*channel, *initial);
                self.push(
                    Op::Mdac {
                        o,
                        hold,
                        a: u.slot,
                        c: u.c,
                    },
                    &[o],
                    true,
                );
            }
            Kind::Dac { channel, initial } => {
                let hold = self.dac(*channel, *initial);
                self.push(Op::Dac { o, hold }, &[o], true);
            }
            Kind::Multiplier => self.product(o, block)?,
            Kind::Divider => {
                let [a, b] = self.exactly(&block.inputs)?;
                self.element(Piecewise::Divisor { u: b }, &[b.slot]);
                let varying = self.vary(&[a.slot, b.slot]);
                let op = Op::Quotient {
                    o,
                    a: a.slot,
                    b: b.slot,
                    c: a.c / b.c,
                };
                self.push(op, &[o], varying);
            }
            Kind::Square => {
                let u = self.sum(&block.inputs)?;
                let varying = self.vary(&[u.slot]);
                self.push(
                    Op::Product {
                        o,
                        a: u.slot,
                        b: u.slot,
                        c: u.c * u.c,
                    },
                    &[o],
                    varying,
                );
            }
            Kind::SquareRoot => {
                let u = self.sum(&block.inputs)?;
                self.element(Piecewise::Radicand { u }, &[u.slot]);
                let varying = self.vary(&[u.slot]);
                self.push(
                    Op::Root {
                        o,
                        a: u.slot,
                        c: u.c,
                    },
                    &[o],
                    varying,
                );
            }
            Kind::Sine | Kind::Cosine => {
                let u = self.sum(&block.inputs)?;
                let varying = self.vary(&[u.slot]);
                let (a, c) = (u.slot, u.c);
                let sine = matches!(block.kind, Kind::Sine);
                let op = if sine {
                    Op::Sine { o, a, c }
                } else {
                    Op::Cosine { o, a, c }
                };
                self.push(op, &[o], varying);
            }
            Kind::Resolver => {
                let terms: [Term; 3] = self.exactly(&block.inputs)?;
                let Some(&second) = block.outputs.get(1) else {
                    return Err(self.malformed("a resolver drives two nets"));
                };
                let y = self.slot(second);
                let varying = self.vary(&terms.map(|t| t.slot));
                let (start, _) = self.store_terms(&terms);
                self.push(Op::Rotate { x: o, y, start }, &[o, y], varying);
                self.overload(y, block.max);
            }
            Kind::Arctangent => {
                let [y, x] = self.exactly(&block.inputs)?;
                let e = self.element(Piecewise::Sheet { y }, &[y.slot]);
                let varying = self.vary(&[y.slot, x.slot]);
                self.push(Op::Arctangent { o, e, y, x }, &[o], varying);
            }
            Kind::Abs => {
                let u = self.sum(&block.inputs)?;
                self.curve_into(o, u, &[0.0], &pieces_of_abs());
            }
            Kind::Min => self.extremum(o, block, -1.0)?,
            Kind::Max => self.extremum(o, block, 1.0)?,
            Kind::Function { x, y } => {
                if x.is_empty() || x.len() != y.len() {
                    return Err(self.malformed("its table needs as many values as breakpoints"));
                }
                let u = self.sum(&block.inputs)?;
                self.curve_into(o, u, x, &pieces_of_table(x, y));
            }
            Kind::DigitalFunction {
                x,
                first_channel,
                initial,
            } => {
                if x.is_empty() || x.len() != initial.len() {
                    return Err(self.malformed("its table needs as many values as breakpoints"));
                }
                let u = self.sum(&block.inputs)?;
                let curve = self.curve_into(o, u, x, &pieces_of_table(x, initial));
                // The ordinates lie side by side, so they have coefficients of their own.
                let first = self.m.dcu_channels.len() as u32;
                for (i, value) in initial.iter().enumerate() {
                    let channel = first_channel.saturating_add(i as u32);
                    self.m.dcu_channels.push((channel, *value));
                }
                self.m
                    .digital_functions
                    .push(DigitalFunction { curve, first });
            }
            Kind::Function2d { x, y, z } => {
                if x.is_empty() || y.is_empty() || z.len() != x.len() * y.len() {
                    return Err(
                        self.malformed("its table needs one value for each pair of breakpoints")
                    );
                }
                let [u, v] = self.exactly(&block.inputs)?;
                let table = self.m.tables.len() as u32;
                let bands = [band(x), band(y)];
                self.m.tables.push(Table {
                    x: x.clone(),
                    y: y.clone(),
                    z: z.clone(),
                    bands,
                });
                let slots = [u.slot, v.slot];
                let e = self.element(Piecewise::Cell(Cell { table, x: u, y: v }), &slots);
                let varying = self.vary(&slots);
                self.push(
                    Op::Surface {
                        o,
                        e,
                        table,
                        x: u,
                        y: v,
                    },
                    &[o],
                    varying,
                );
            }
            Kind::DeadZone { width } => {
                let u = self.sum(&block.inputs)?;
                match *width {
                    Level::Fixed(w) => {
                        self.curve_into(o, u, &[-w, w], &pieces_of_dead_zone(w));
                    }
                    Level::Net(net) => {
                        let w = self.slot(net);
                        let e = self.element(Piecewise::DeadZone { u, width: w }, &[u.slot, w]);
                        let varying = self.vary(&[u.slot, w]);
                        self.push(
                            Op::DeadZone {
                                o,
                                e,
                                a: u.slot,
                                c: u.c,
                                w,
                            },
                            &[o],
                            varying,
                        );
                    }
                }
            }
            Kind::Limiter { low, high } => {
                let u = self.sum(&block.inputs)?;
                if let (Level::Fixed(low), Level::Fixed(high)) = (low, high) {
                    let pieces = pieces_of_limiter(*low, *high);
                    self.curve_into(o, u, &[*low, *high], &pieces);
                } else {
                    let (low, high) = (self.level(*low), self.level(*high));
                    let slots = [u.slot, low, high];
                    let e = self.element(Piecewise::Limiter { u, low, high }, &slots);
                    let varying = self.vary(&slots);
                    self.push(
                        Op::Limit {
                            o,
                            e,
                            a: u.slot,
                            c: u.c,
                            low,
                            high,
                        },
                        &[o],
                        varying,
                    );
                }
            }
            Kind::DryFriction { level, breakaway } => {
                let [velocity, applied] = self.exactly(&block.inputs)?;
                let state = ((velocity.slot as usize) < self.m.states).then_some(velocity.slot);
                let friction = Friction {
                    velocity,
                    applied,
                    level: *level,
                    breakaway: *breakaway,
                    state,
                };
                let slots = [velocity.slot, applied.slot];
                let e = self.element(Piecewise::Friction(friction), &slots);
                self.push(
                    Op::Friction {
                        o,
                        e,
                        a: applied.slot,
                        c: applied.c,
                    },
                    &[o],
                    true,
                );
            }
            Kind::Relay {
                points,
                outputs,
                initially_on,
            } => {
                let u = self.sum(&block.inputs)?;
                let relay = Piecewise::Relay {
                    u,
                    points: *points,
                    outputs: *outputs,
                    initially_on: *initially_on,
                };
                let e = self.element(relay, &[u.slot]);
                self.push(Op::Constant { o, e }, &[o], false);
            }
            Kind::Comparator {
                threshold,
                hysteresis,
            } => {
                let u = self.sum(&block.inputs)?;
                let comparator = Piecewise::Comparator {
                    u,
                    on_above: threshold + 0.5 * hysteresis,
                    off_at: threshold - 0.5 * hysteresis,
                };
                let e = self.element(comparator, &[u.slot]);
                self.push(Op::Constant { o, e }, &[o], false);
            }
            Kind::Switch { control } => {
                let [a, b] = self.exactly(&block.inputs)?;
                let control = self.slot(*control);
                let varying = self.vary(&[a.slot, b.slot]);
                self.push(Op::Switch { o, control, a, b }, &[o], varying);
            }
            Kind::TrackStore { track, ic } => {
                let u = self.sum(&block.inputs)?;
                let control = self.slot(*track);
                let store = self.m.track_ics.len() as u32;
                self.m.track_ics.push(*ic);
                let varying = self.vary(&[u.slot]);
                self.push(
                    Op::Track {
                        o,
                        control,
                        a: u.slot,
                        c: u.c,
                        store,
                    },
                    &[o],
                    varying,
                );
            }
            Kind::TransportDelay { delay, initial } => {
                let line = self.m.lines.len() as u32;
                let input = Term { slot: 0, c: 0.0 };
                self.m.lines.push(DelayLine::new(input, *delay, *initial));
                self.m.step_cap_s = self.m.step_cap_s.min(*delay);
                self.push(Op::Delay { o, line }, &[o], true);
            }
            Kind::Generator {
                wave,
                amplitude,
                offset,
                frequency_hz,
                phase_rad,
                start_s,
            } => {
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
                            start_s,
                        };
                        self.m.timers.push((o, square));
                        None
                    }
                    Wave::Ramp => Some(Waveform::Ramp {
                        offset,
                        slope: amplitude,
                        start_s,
                    }),
                    Wave::Sine => {
                        if *frequency_hz > 0.0 {
                            // No step passes over more than a quarter of a period unseen.
                            self.m.step_cap_s = self.m.step_cap_s.min(0.25 / frequency_hz);
                        }
                        let (frequency_hz, phase_rad) = (*frequency_hz, *phase_rad);
                        Some(Waveform::Sine {
                            offset,
                            amplitude,
                            frequency_hz,
                            phase_rad,
                            start_s,
                        })
                    }
                };
                if let Some(form) = form {
                    let wave = self.m.waves.len() as u32;
                    self.m.waves.push(form);
                    self.m.timers.push((o, Timer::Start { wave, start_s }));
                    self.push(Op::Wave { o, wave }, &[o], true);
                }
            }
            Kind::Noise {
                sigma,
                every_s,
                seed,
            } => {
                let noise = self.m.noises.len() as u32;
                self.m.noises.push((*sigma, *seed));
                self.m.timers.push((
                    o,
                    Timer::Noise {
                        noise,
                        every_s: *every_s,
                    },
                ));
            }
            Kind::And | Kind::Or => {
                let terms = self.terms(&block.inputs);
                let (start, len) = self.store_terms(&terms);
                let and = matches!(block.kind, Kind::And);
                let op = if and {
                    Op::And { o, start, len }
                } else {
                    Op::Or { o, start, len }
                };
                self.push(op, &[o], false);
            }
            Kind::Not => {
                let [a] = self.exactly(&block.inputs)?;
                self.push(Op::Not { o, a: a.slot }, &[o], false);
            }
            Kind::FlipFlop { initial } => self.m.initial_nets[o as usize] = f64::from(*initial),
            Kind::OneShot { .. } | Kind::Counter { .. } => {}
            Kind::Control { line, initial } => {
                self.m.initial_nets[o as usize] = f64::from(*initial);
                self.m.control_lines.push((*line, o));
            }
            Kind::Constant { value } => self.m.initial_nets[o as usize] = *value,
            Kind::Time => self.push(Op::Time { o }, &[o], true),
        }
        self.overload(o, block.max);
        Ok(())
    }

    /// Wires what a store reads, once every net is in place.
    pub(super) fn inputs_of_stores(&mut self, ordered: &Ordered) -> Result<(), RunFault> {
        let Some(block) = ordered.netlist.blocks.get(self.block.index()) else {
            return Ok(());
        };
        let Some(&net) = block.outputs.first() else {
            return Ok(());
        };
        let o = self.slot(net);
        match &block.kind {
            Kind::Integrator {
                limits,
                operate,
                reset,
                reset_to,
                ..
            } => {
                let mut terms = self.terms(&block.inputs);
                if terms.is_empty() {
                    return Err(self.malformed("it needs at least one input"));
                }
                let mut stops = None;
                if let Some([low, high]) = *limits {
                    let rate = self.sum(&block.inputs)?;
                    let element = Piecewise::Stops(Stops {
                        state: o,
                        rate,
                        low,
                        high,
                    });
                    stops = Some(self.element(element, &[o]));
                    terms = vec![rate];
                }
                self.rate(o, &terms);
                if stops.is_some() || operate.is_some() || reset.is_some() {
                    let control = Control {
                        state: o,
                        operate: operate.map(|n| self.slot(n)),
                        reset: reset.map(|n| self.slot(n)),
                        reset_to: reset_to.as_ref().map(|i| self.term(i)),
                        stops,
                    };
                    self.m.controls.push(control);
                }
            }
            Kind::Lag { tau, gain, .. } => {
                let mut terms = scaled(self.terms(&block.inputs), gain / tau);
                terms.push(Term {
                    slot: o,
                    c: -1.0 / tau,
                });
                self.rate(o, &terms);
            }
            Kind::RateLimiter { rate, tau, .. } => {
                let mut terms = scaled(self.terms(&block.inputs), 1.0 / tau);
                terms.push(Term {
                    slot: o,
                    c: -1.0 / tau,
                });
                let pieces = pieces_of_limiter(-rate, *rate);
                self.follower(o, &terms, &[-rate, *rate], &pieces, 1.0);
            }
            Kind::Backlash { width, tau, .. } => {
                let mut terms = self.terms(&block.inputs);
                terms.push(Term { slot: o, c: -1.0 });
                let half = 0.5 * width;
                let pieces = pieces_of_dead_zone(half);
                self.follower(o, &terms, &[-half, half], &pieces, 1.0 / tau);
            }
            Kind::TransportDelay { .. } => {
                let input = self.sum(&block.inputs)?;
                let line = self.m.fast.iter().find_map(|op| match op {
                    Op::Delay { o: out, line } if *out == o => Some(*line as usize),
                    _ => None,
                });
                if let Some(line) = line {
                    self.m.lines[line].input = input;
                }
            }
            Kind::FlipFlop { .. } => {
                let [set, reset] = self.exactly(&block.inputs)?;
                self.m.stores.push(Store::FlipFlop {
                    o,
                    set: set.slot,
                    reset: reset.slot,
                });
            }
            Kind::OneShot { width_s } => {
                let [input] = self.exactly(&block.inputs)?;
                let timer = self.m.timers.len() as u32;
                self.m.timers.push((o, Timer::OneShotEnd));
                let (input, width_s) = (input.slot, *width_s);
                self.m.stores.push(Store::OneShot {
                    o,
                    input,
                    width_s,
                    timer,
                });
            }
            Kind::Counter { modulo } => {
                let Some(clock) = block.inputs.first() else {
                    return Err(self.malformed("it needs a clock"));
                };
                let clock = self.slot(clock.net);
                let reset = block.inputs.get(1).map(|i| self.slot(i.net));
                self.m.stores.push(Store::Counter {
                    o,
                    clock,
                    reset,
                    modulo: *modulo,
                });
            }
            Kind::Interrupt { line } => {
                self.m.stores.push(Store::Interrupt {
                    input: o,
                    line: *line,
                });
            }
            _ => {}
        }
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
            Kind::Generator {
                frequency_hz,
                start_s,
                ..
            } => start_s.is_finite() && (0.0..=0.5 / LEAST_TIME_S).contains(&frequency_hz),
            _ => true,
        };
        if fine {
            Ok(())
        } else {
            Err(self.malformed("one of its times is not positive, or below a nanosecond"))
        }
    }

    fn weighted(&mut self, o: Slot, block: &Block, factor: f64) -> Result<(), RunFault> {
        if block.inputs.is_empty() {
            return Err(self.malformed("it needs at least one input"));
        }
        let terms = scaled(self.terms(&block.inputs), factor);
        self.sum_into(o, &terms);
        Ok(())
    }

    fn product(&mut self, o: Slot, block: &Block) -> Result<(), RunFault> {
        let terms = self.terms(&block.inputs);
        let [first, .., last] = *terms else {
            return Err(self.malformed("a product needs two inputs"));
        };
        let mut left = first;
        for right in &terms[1..terms.len() - 1] {
            let slot = self.hidden();
            let varying = self.vary(&[left.slot, right.slot]);
            let op = Op::Product {
                o: slot,
                a: left.slot,
                b: right.slot,
                c: left.c * right.c,
            };
            self.push(op, &[slot], varying);
            left = Term { slot, c: 1.0 };
        }
        let varying = self.vary(&[left.slot, last.slot]);
        let op = Op::Product {
            o,
            a: left.slot,
            b: last.slot,
            c: left.c * last.c,
        };
        self.push(op, &[o], varying);
        Ok(())
    }

    fn extremum(&mut self, o: Slot, block: &Block, sign: f64) -> Result<(), RunFault> {
        if block.inputs.is_empty() {
            return Err(self.malformed("it needs at least one input"));
        }
        let terms = self.terms(&block.inputs);
        let slots: Vec<Slot> = terms.iter().map(|t| t.slot).collect();
        let (start, len) = self.store_terms(&terms);
        let e = self.element(Piecewise::Extremum { start, len, sign }, &slots);
        let varying = self.vary(&slots);
        self.push(Op::Extreme { o, e, start }, &[o], varying);
        Ok(())
    }

    /// `dy/dt = factor · curve(Σ terms)`.
    fn follower(
        &mut self,
        o: Slot,
        terms: &[Term],
        corners: &[f64],
        pieces: &[Piece],
        factor: f64,
    ) {
        let slot = self.hidden();
        self.sum_into(slot, terms);
        let driven = self.hidden();
        self.curve_into(driven, Term { slot, c: 1.0 }, corners, pieces);
        self.rate(
            o,
            &[Term {
                slot: driven,
                c: factor,
            }],
        );
    }
}
