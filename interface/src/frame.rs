//! The two frames that cross the linkage in each period.
//!
//! *Samples n* go from the analog to the digital side: what the ADCs held at
//! `t_n` (channel i at `t_n + i·δ`), sense lines, interrupts with their located
//! times, overloads. *Updates n* go back: DAC transfers, DCU settings, control
//! lines and a mode command, all taking effect together at `t_n + τ`.
//! Both are plain `repr(C)` data without padding, so that a frame is the same
//! bytes on every link. Values are in problem units, already quantised.

use crate::Tick;
use serde::{Deserialize, Serialize};

/// ADC channels a frame can carry.
pub const ADC_CHANNELS: usize = 64;
/// DAC (and MDAC) channels a frame can carry.
pub const DAC_CHANNELS: usize = 64;
/// DCU channels a frame can carry.
pub const DCU_CHANNELS: usize = 128;
/// Sense lines (logic, analog to digital).
pub const SENSE_LINES: usize = 64;
/// Control lines (logic, digital to analog).
pub const CONTROL_LINES: usize = 64;
/// Interrupt lines (comparator edges with located times).
pub const INTERRUPT_LINES: usize = 32;
/// Edges recorded per frame; further ones are counted in [`Samples::edges_lost`].
pub const EDGES_PER_FRAME: usize = 32;

/// Frames that a free-running analog side may be ahead of the last updates; then it
/// waits, so that no frame is lost and updates are late by a frame at most in problem
/// time: two frames of latency is what the correction of a redundant integrator bears.
pub const FRAMES_AHEAD: u64 = 2;
/// Transfers told per frame: those that waited for its samples, and as many that came since.
pub const TRANSFERS_PER_FRAME: usize = 2 * FRAMES_AHEAD as usize;

/// State of the analog side as told in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum RunState {
    /// Integrating; an update is expected for this frame.
    Operate = 0,
    /// Held by a mode command or by the overload policy.
    Hold = 1,
    /// The stop time was reached; no update is expected.
    Ended = 2,
    /// The run stopped by a fault; ask for it over the control plane.
    Faulted = 3,
}

/// Mode command carried by an update.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum ModeCommand {
    /// Go on as before.
    Continue = 0,
    /// Integrators hold from the effective instant on; frames go on.
    Hold = 1,
    /// Integrators operate again.
    Operate = 2,
    /// The run ends at the effective instant.
    End = 3,
}

/// One located comparator edge on an interrupt line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(C)]
pub struct Edge {
    /// Located instant.
    pub tick: Tick,
    /// Interrupt line, `0..INTERRUPT_LINES`.
    pub line: u32,
    /// 1 for a rising, 0 for a falling edge.
    pub rising: u32,
}

/// One transfer as it took effect.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(C)]
pub struct Transfer {
    /// Frame of the updates.
    pub frame: u64,
    /// Run time at which they took effect.
    pub tick: Tick,
}

/// Samples n: analog to digital.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[repr(C)]
pub struct Samples {
    /// Frame number n.
    pub frame: u64,
    /// `t_n`.
    pub tick: Tick,
    /// ADC values (problem units, after conversion), by channel.
    #[serde(with = "values")]
    pub adc: [f64; ADC_CHANNELS],
    /// One bit per ADC channel that saturated in this frame.
    pub adc_saturated: u64,
    /// One bit per DAC channel that saturated in a transfer since the last frame, or, in
    /// the first frame, where the run started.
    pub dac_saturated: u64,
    /// One bit per DCU channel likewise (low 64, high 64).
    pub dcu_saturated: [u64; 2],
    /// Sense lines, one bit each.
    pub sense: u64,
    /// Overloads latched so far (count of blocks).
    pub overloads: u32,
    /// [`RunState`] as a number.
    pub state: u32,
    /// Number of valid entries in `edges`.
    pub edge_count: u32,
    /// Edges that found no room in `edges`.
    pub edges_lost: u32,
    /// Interrupt edges since the last frame, in order of time.
    pub edges: [Edge; EDGES_PER_FRAME],
    /// Number of valid entries in `transfers`.
    pub transfer_count: u64,
    /// Transfers since the last frame, in order of time.
    pub transfers: [Transfer; TRANSFERS_PER_FRAME],
    /// Wall time by which a free-running analog side was late in publishing this frame,
    /// ns; zero when nothing is paced.
    pub late: Tick,
}

/// Updates n: digital to analog. As a preset they are part of a request.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[repr(C)]
pub struct Updates {
    /// Frame number n.
    pub frame: u64,
    /// The instant at which they take effect, `t_n + τ` in lock-step.
    pub effective: Tick,
    /// One bit per DAC channel that is set by this update.
    pub dac_mask: u64,
    /// One bit per DCU channel that is set (low 64, high 64).
    pub dcu_mask: [u64; 2],
    /// One bit per control line that is set.
    pub control_mask: u64,
    /// Control line values, one bit each.
    pub control: u64,
    /// [`ModeCommand`] as a number.
    pub mode: u32,
    /// Reserved, zero.
    pub reserved: u32,
    /// DAC values in problem units, by channel.
    #[serde(with = "values")]
    pub dac: [f64; DAC_CHANNELS],
    /// DCU coefficients, by channel.
    #[serde(with = "values")]
    pub dcu: [f64; DCU_CHANNELS],
}

impl Samples {
    pub fn new(frame: u64, tick: Tick, state: RunState) -> Samples {
        Samples {
            frame,
            tick,
            adc: [0.0; ADC_CHANNELS],
            adc_saturated: 0,
            dac_saturated: 0,
            dcu_saturated: [0; 2],
            sense: 0,
            overloads: 0,
            state: state as u32,
            edge_count: 0,
            edges_lost: 0,
            edges: [Edge::default(); EDGES_PER_FRAME],
            transfer_count: 0,
            transfers: [Transfer::default(); TRANSFERS_PER_FRAME],
            late: Tick::ZERO,
        }
    }

    /// State of the analog side; a number that is none counts as a fault.
    pub fn run_state(&self) -> RunState {
        match self.state {
            0 => RunState::Operate,
            1 => RunState::Hold,
            2 => RunState::Ended,
            _ => RunState::Faulted,
        }
    }

    /// Whether a converter or coefficient unit was driven beyond its range.
    pub fn saturated(&self) -> bool {
        self.adc_saturated | self.dac_saturated != 0 || self.dcu_saturated != [0; 2]
    }

    /// The told transfers in order of time.
    pub fn transfers(&self) -> &[Transfer] {
        let count = usize::try_from(self.transfer_count).unwrap_or(usize::MAX);
        &self.transfers[..count.min(TRANSFERS_PER_FRAME)]
    }

    /// The recorded edges in order of time.
    pub fn edges(&self) -> &[Edge] {
        &self.edges[..(self.edge_count as usize).min(EDGES_PER_FRAME)]
    }
}

impl Updates {
    pub fn new(frame: u64, effective: Tick) -> Updates {
        Updates {
            frame,
            effective,
            dac_mask: 0,
            dcu_mask: [0; 2],
            control_mask: 0,
            control: 0,
            mode: ModeCommand::Continue as u32,
            reserved: 0,
            dac: [0.0; DAC_CHANNELS],
            dcu: [0.0; DCU_CHANNELS],
        }
    }

    /// Loads DAC `channel`; channels beyond the last are the caller's bug and ignored in release.
    pub fn set_dac(&mut self, channel: usize, value: f64) {
        debug_assert!(channel < DAC_CHANNELS);
        if let Some(slot) = self.dac.get_mut(channel) {
            *slot = value;
            self.dac_mask |= 1 << channel;
        }
    }

    /// Loads DCU `channel`.
    pub fn set_dcu(&mut self, channel: usize, coefficient: f64) {
        debug_assert!(channel < DCU_CHANNELS);
        if let Some(slot) = self.dcu.get_mut(channel) {
            *slot = coefficient;
            self.dcu_mask[channel / 64] |= 1 << (channel % 64);
        }
    }

    /// What DAC `channel` is set to, if it is.
    pub fn new_dac(&self, channel: usize) -> Option<f64> {
        (self.dac_mask >> channel & 1 == 1).then(|| self.dac[channel])
    }

    /// What DCU `channel` is set to, if it is.
    pub fn new_dcu(&self, channel: usize) -> Option<f64> {
        (self.dcu_mask[channel / 64] >> (channel % 64) & 1 == 1).then(|| self.dcu[channel])
    }

    /// What control `line` is set to, if it is.
    pub fn new_control(&self, line: usize) -> Option<bool> {
        (self.control_mask >> line & 1 == 1).then(|| self.control >> line & 1 == 1)
    }

    /// How many channels and lines are set.
    pub fn count(&self) -> u32 {
        let [low, high] = self.dcu_mask;
        [self.dac_mask, low, high, self.control_mask].map(u64::count_ones).iter().sum()
    }

    /// Sets control `line`.
    pub fn set_control(&mut self, line: usize, value: bool) {
        debug_assert!(line < CONTROL_LINES);
        if line < CONTROL_LINES {
            self.control_mask |= 1 << line;
            self.control = (self.control & !(1 << line)) | (u64::from(value) << line);
        }
    }

    /// The mode command; a number that is none counts as `End`.
    pub fn mode_command(&self) -> ModeCommand {
        match self.mode {
            0 => ModeCommand::Continue,
            1 => ModeCommand::Hold,
            2 => ModeCommand::Operate,
            _ => ModeCommand::End,
        }
    }
}

/// Arrays of more than 32, which serde does not know.
mod values {
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

    pub fn serialize<S: Serializer>(values: &[f64], to: S) -> Result<S::Ok, S::Error> {
        values.serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>, const N: usize>(
        from: D,
    ) -> Result<[f64; N], D::Error> {
        let values: Vec<f64> = Deserialize::deserialize(from)?;
        values.try_into().map_err(|_| D::Error::custom("a wrong number of channels"))
    }
}
