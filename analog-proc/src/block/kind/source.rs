//! `signal-generator`, `noise`, `constant`, `time`: what has no input.

use super::*;
use engine::element::source::{Timer, Waveform};
use std::f64::consts::{PI, TAU};

/// Wave form of a signal generator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wave {
    /// `offset` before `start_s`, `offset + amplitude` from then on.
    Step,
    /// `offset` until `start_s`, then rising by `amplitude` a second.
    Ramp,
    /// `offset + amplitude · sin(2πf(t − start_s) + phase)` from `start_s` on, `offset` before.
    Sine,
    /// `offset ± amplitude` from `start_s` on, high in the first half of each period of
    /// `2πf(t − start_s) + phase`, `offset` before.
    Square,
}

const WAVES: &[(&str, Wave)] =
    &[("step", Wave::Step), ("ramp", Wave::Ramp), ("sine", Wave::Sine), ("square", Wave::Square)];

kind! {
    Generator(f) {
        wave: Wave = f.word("wave", None, WAVES),
        amplitude: f64 = f.number("amplitude", Some(1.0)),
        offset: f64 = f.number("offset", Some(0.0)),
        frequency_hz: f64 = f.ranged("frequency", Some(1.0), "above 0, at most 5e8",
            |v| v > 0.0 && v <= 5e8),
        phase_rad: f64 = f.number("phase", Some(0.0)),
        start_s: f64 = f.number("start", Some(0.0)),
    }
    "signal-generator", "a wave of time",
    r#"`wave`: `"step"`, `"ramp"`, `"sine"`, `"square"`; `amplitude` (1; slope of a ramp); `offset` (0); `frequency` Hz (1); `phase` rad (0; sine and square); `start` s (0)"#,
    r#"wave = "sine", frequency = 0.5"#, inputs: Inputs::exactly(0),
    class: Some(BlockClass::FunctionGenerator),
}

impl Component for Generator {
    fn lower(&self, to: &mut Lowering, _: &Block, o: Slot) {
        let Generator { wave, amplitude, offset, frequency_hz, phase_rad, start_s } = *self;
        to.m.initial_nets[o as usize] = offset;
        let form = match wave {
            Wave::Step => {
                let high = offset + amplitude;
                to.m.timers.push((o, Timer::Step { high, start_s }));
                return;
            }
            Wave::Square => {
                let (low, high) = (offset - amplitude, offset + amplitude);
                let lead = 2.0 * (phase_rad / TAU).rem_euclid(1.0);
                to.m.timers.push((o, Timer::Square { low, high, frequency_hz, lead, start_s }));
                return;
            }
            Wave::Ramp => Waveform::Ramp { offset, slope: amplitude, start_s },
            Wave::Sine => Waveform::Sine { offset, amplitude, frequency_hz, phase_rad, start_s },
        };
        let wave = to.m.waves.len() as u32;
        to.m.waves.push(form);
        to.m.timers.push((o, Timer::Start { wave, start_s }));
        to.push(Op::Wave { o, wave }, &[o], true);
    }

    fn caption(&self) -> Option<String> {
        let amplitude = number(self.amplitude);
        Some(match self.wave {
            Wave::Step | Wave::Ramp => amplitude,
            Wave::Sine | Wave::Square => format!("{amplitude}, {} Hz", number(self.frequency_hz)),
        })
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.frame();
        match self.wave {
            Wave::Step => pen.curve("plot", &[(-1.0, -0.6), (-0.2, -0.6), (-0.2, 0.6), (1.0, 0.6)]),
            Wave::Ramp => pen.curve("plot", &[(-1.0, -0.6), (-0.4, -0.6), (1.0, 0.7)]),
            Wave::Square => pen.curve(
                "plot",
                &[(-1.0, -0.6), (-1.0, 0.6), (0.0, 0.6), (0.0, -0.6), (1.0, -0.6), (1.0, 0.6)],
            ),
            Wave::Sine => {
                let places = (-12..=12).map(|i| f64::from(i) / 12.0);
                let points: Vec<_> = places.map(|x| (x, 0.7 * libm::sin(x * PI))).collect();
                pen.curve("plot", &points);
            }
        }
    }
}

kind! {
    Noise(f) {
        sigma: f64 = f.ranged("sigma", Some(1.0), "0 or greater", |v| v >= 0.0),
        every_s: f64 = f.duration("every"),
        seed: u64 = f.whole("seed", Some(0)),
    }
    "noise", "normal deviates, renewed every `every`", "`every` s; `sigma` (1); `seed` (0)",
    "every = 0.01, seed = 7", inputs: Inputs::exactly(0), class: Some(BlockClass::FunctionGenerator),
}

impl Component for Noise {
    fn lower(&self, to: &mut Lowering, _: &Block, o: Slot) {
        let noise = to.m.noises.len() as u32;
        to.m.noises.push((self.sigma, self.seed));
        to.m.timers.push((o, Timer::Noise { noise, every_s: self.every_s }));
    }

    fn caption(&self) -> Option<String> {
        Some(format!("σ {}", number(self.sigma)))
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.frame();
        let heights = [0.1, -0.5, 0.7, -0.2, 0.3, -0.8, 0.9, -0.1, 0.4, -0.6, 0.2];
        let points: Vec<(f64, f64)> =
            heights.iter().enumerate().map(|(i, h)| (-1.0 + 0.2 * i as f64, *h)).collect();
        pen.curve("plot", &points);
    }
}

kind! {
    Constant(f) { value: f64 = f.number("value", None) }
    "constant", "`value`", "`value`", "value = 1.0", inputs: Inputs::exactly(0), size: (54.0, 26.0),
}

impl Component for Constant {
    fn lower(&self, to: &mut Lowering, _: &Block, o: Slot) {
        to.m.initial_nets[o as usize] = self.value;
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.frame();
        pen.text(0.0, 4.0, "tiny", &number(self.value));
    }
}

kind! {
    Time
    "time", "problem time, s", "", "", inputs: Inputs::exactly(0), size: (34.0, 34.0),
}

impl Component for Time {
    fn lower(&self, to: &mut Lowering, _: &Block, o: Slot) {
        to.push(Op::Time { o }, &[o], true);
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.circle(0.0, 1.0);
        pen.text(0.0, 5.0, "word", "t");
    }
}
