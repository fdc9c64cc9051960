//! The patch's converters, coefficients and lines, and the stages between them
//! and the frames.
//!
//! Each ADC converts (bits, full scale, saturation flag); each DAC converts,
//! holds (zero order, extrapolating, interpolating) and settles; each DCU is
//! set to its nearest coefficient. With an ideal profile every stage passes f64.
//! What lies beyond a stage is held at its end and flagged in the next frame,
//! whether it came in a transfer or stood there when the run started.

mod build;

use engine::{
    element::{dac::DacPiece, logic},
    id::NetId,
    simulation::Simulation,
};
use interface::{
    Tick,
    converter::Converter,
    frame::{Edge, Samples, TRANSFERS_PER_FRAME, Transfer, Updates},
    hold::Hold,
    profile::Profile,
};
use serde::{Deserialize, Serialize};

#[derive(Clone)]
struct AdcChannel {
    channel: usize,
    net: NetId,
    converter: Converter,
}

#[derive(Clone)]
struct DacChannel {
    channel: usize,
    converter: Converter,
    hold: Hold,
    value: f64,
}

#[derive(Clone)]
struct DcuChannel {
    channel: usize,
    unit: Converter,
    value: f64,
}

/// DAC and DCU channels set beyond what their stage can represent, a bit each.
#[derive(Clone, Default, Serialize, Deserialize)]
struct Saturations {
    dac: u64,
    dcu: [u64; 2],
}

impl Saturations {
    /// Converts a DAC channel's present value.
    fn convert(&mut self, dac: &DacChannel) -> f64 {
        let conversion = dac.converter.convert(dac.value);
        self.dac |= u64::from(conversion.saturated || conversion.non_finite) << dac.channel;
        conversion.value
    }

    /// The coefficient to which a DCU channel's present value sets it.
    fn set(&mut self, dcu: &DcuChannel) -> f64 {
        let setting = dcu.unit.convert(dcu.value);
        self.dcu[dcu.channel / 64] |=
            u64::from(setting.saturated || setting.non_finite) << (dcu.channel % 64);
        setting.value
    }
}

#[derive(Clone)]
struct Line {
    line: usize,
    net: NetId,
}

/// What the channels hold between two frames, and what is still to be told of them.
#[derive(Serialize, Deserialize)]
pub struct ChannelState {
    dac: Vec<(Hold, f64)>,
    dcu: Vec<f64>,
    control: Vec<bool>,
    saturations: Saturations,
    transfers: Vec<Transfer>,
}

/// Every channel of one loaded patch, in order of number.
#[derive(Clone)]
pub struct Channels {
    profile: Profile,
    adc: Vec<AdcChannel>,
    dac: Vec<DacChannel>,
    dcu: Vec<DcuChannel>,
    sense: Vec<Line>,
    /// Control line and its present value.
    control: Vec<(usize, bool)>,
    edges: Vec<logic::Edge>,
    /// What saturated, and which transfers took effect, since the last frame.
    saturations: Saturations,
    transfers: Vec<Transfer>,
}

impl Channels {
    /// What they hold between two frames.
    pub fn state(&self) -> ChannelState {
        ChannelState {
            dac: self.dac.iter().map(|dac| (dac.hold, dac.value)).collect(),
            dcu: self.dcu.iter().map(|dcu| dcu.value).collect(),
            control: self.control.iter().map(|(_, on)| *on).collect(),
            saturations: self.saturations.clone(),
            transfers: self.transfers.clone(),
        }
    }

    /// Takes over what the channels of the same patch held; the machine has it already.
    pub fn restore(&mut self, state: ChannelState) {
        for (dac, (hold, value)) in self.dac.iter_mut().zip(state.dac) {
            (dac.hold, dac.value) = (hold, value);
        }
        for (dcu, value) in self.dcu.iter_mut().zip(state.dcu) {
            dcu.value = value;
        }
        for ((_, on), was) in self.control.iter_mut().zip(state.control) {
            *on = was;
        }
        (self.saturations, self.transfers) = (state.saturations, state.transfers);
    }

    /// ADC channels in a scan.
    pub fn adc_count(&self) -> usize {
        self.adc.len()
    }

    /// From the first to the last hold of a scan; `None` where no tick can hold it.
    pub fn scan_time(&self, skew: Tick) -> Option<Tick> {
        skew.checked_mul(self.adc.len().saturating_sub(1) as u64)
    }

    /// Sets channels while the machine does not operate: all or none.
    pub fn preset(&mut self, preset: &Updates, simulation: &mut Simulation) -> Result<(), String> {
        let mut known = 0;
        let mut check = |kind: &str, channel: usize, value: Option<f64>| match value {
            Some(v) if !v.is_finite() => {
                Err(format!("the preset of {kind} {channel} is {v}, not a finite number"))
            }
            value => {
                known += u32::from(value.is_some());
                Ok(())
            }
        };
        for dac in &self.dac {
            check("DAC", dac.channel, preset.new_dac(dac.channel))?;
        }
        for dcu in &self.dcu {
            check("DCU", dcu.channel, preset.new_dcu(dcu.channel))?;
        }
        for (line, _) in &self.control {
            check("control line", *line, preset.new_control(*line).map(f64::from))?;
        }
        if known < preset.count() {
            return Err("the preset sets a channel that the patch does not have".to_owned());
        }
        for dac in &mut self.dac {
            dac.value = preset.new_dac(dac.channel).unwrap_or(dac.value);
        }
        for dcu in &mut self.dcu {
            dcu.value = preset.new_dcu(dcu.channel).unwrap_or(dcu.value);
        }
        for (line, on) in &mut self.control {
            *on = preset.new_control(*line).unwrap_or(*on);
        }
        self.set_all(simulation);
        Ok(())
    }

    /// Puts every channel to its present value, held: where a run starts. What saturates
    /// here is told in the run's first frame; what saturated before is forgotten.
    pub fn set_all(&mut self, simulation: &mut Simulation) {
        let now_s = simulation.now_s();
        self.saturations = Saturations::default();
        for dac in &mut self.dac {
            dac.hold = Hold::new(self.profile.hold(), dac.value);
            let value = self.saturations.convert(dac);
            simulation.set_dac(dac.channel as u32, DacPiece::held(value, now_s));
        }
        for dcu in &self.dcu {
            simulation.set_dcu(dcu.channel as u32, self.saturations.set(dcu));
        }
        for (line, on) in &self.control {
            simulation.set_control(*line as u32, *on);
        }
    }

    /// Aperture of the track-and-hold; zero is off.
    pub fn aperture(&self) -> Tick {
        self.profile.aperture()
    }

    /// What the `index`-th ADC channel sees now.
    pub fn seen(&self, index: usize, simulation: &Simulation) -> f64 {
        simulation.net(self.adc[index].net)
    }

    /// Converts what the `index`-th ADC channel has held.
    pub fn sample(&self, index: usize, held: f64, samples: &mut Samples) {
        let adc = &self.adc[index];
        let conversion = adc.converter.convert(held);
        samples.adc[adc.channel] = conversion.value;
        if conversion.saturated || conversion.non_finite {
            samples.adc_saturated |= 1 << adc.channel;
        }
    }

    /// Lets updates take effect at run time `at`, problem time `now_s`.
    pub fn transfer(&mut self, updates: &Updates, at: Tick, simulation: &mut Simulation) {
        let now_s = simulation.now_s();
        let settling_s = self.profile.settling().secs();
        for dac in &mut self.dac {
            let Some(value) = updates.new_dac(dac.channel) else { continue };
            dac.value = value;
            let value = self.saturations.convert(dac);
            let piece = dac.hold.transfer(at, value);
            simulation.set_dac(
                dac.channel as u32,
                DacPiece {
                    // A lag behind a ramp: the asymptote runs `slope · tau` behind it.
                    value: piece.value - piece.slope * settling_s,
                    slope_per_s: piece.slope,
                    from_s: now_s,
                    settling_s,
                },
            );
        }
        for dcu in &mut self.dcu {
            if let Some(value) = updates.new_dcu(dcu.channel) {
                dcu.value = value;
                simulation.set_dcu(dcu.channel as u32, self.saturations.set(dcu));
            }
        }
        for (line, on) in &mut self.control {
            if let Some(new) = updates.new_control(*line) {
                *on = new;
                simulation.set_control(*line as u32, *on);
            }
        }
        self.transfers.push(Transfer { frame: updates.frame, tick: at });
    }

    /// The next instant after `from` at which an interpolating hold has reached its value.
    pub fn next_arrival(&self, from: Tick) -> Option<Tick> {
        self.dac.iter().filter_map(|d| d.hold.piece().end).filter(|end| *end > from).min()
    }

    /// Holds the DACs whose interpolation ends at `at`.
    pub fn arrive(&mut self, at: Tick, simulation: &mut Simulation) {
        let now_s = simulation.now_s();
        let settling_s = self.profile.settling().secs();
        for dac in self.dac.iter().filter(|d| d.hold.piece().end == Some(at)) {
            let value = dac.hold.piece().at(at);
            simulation.set_dac(
                dac.channel as u32,
                DacPiece { value, slope_per_s: 0.0, from_s: now_s, settling_s },
            );
        }
    }

    /// Adds what happened since the last stamp: logic, edges, transfers, saturations,
    /// overloads; `shift` leads from problem to run time.
    pub fn stamp(&mut self, simulation: &mut Simulation, shift: Tick, samples: &mut Samples) {
        samples.sense = self
            .sense
            .iter()
            .filter(|sense| simulation.net(sense.net) != 0.0)
            .fold(0, |lines, sense| lines | 1 << sense.line);
        self.edges.clear();
        simulation.take_edges(&mut self.edges);
        for edge in &self.edges {
            // Problem time is within 292 years: it always fits a tick.
            let tick = Tick::from_secs(edge.t_s).unwrap_or_default() + shift;
            match samples.edges.get_mut(samples.edge_count as usize) {
                Some(slot) => {
                    *slot = Edge { tick, line: edge.line, rising: u32::from(edge.rising) };
                    samples.edge_count += 1;
                }
                None => samples.edges_lost = samples.edges_lost.saturating_add(1),
            }
        }
        // What finds no room is told in the next frame.
        let room = self.transfers.len().min(TRANSFERS_PER_FRAME);
        for (slot, transfer) in samples.transfers.iter_mut().zip(self.transfers.drain(..room)) {
            *slot = transfer;
            samples.transfer_count += 1;
        }
        let new = std::mem::take(&mut self.saturations);
        samples.dac_saturated |= new.dac;
        for (told, new) in samples.dcu_saturated.iter_mut().zip(new.dcu) {
            *told |= new;
        }
        samples.overloads = simulation.overloads().len() as u32;
    }
}
