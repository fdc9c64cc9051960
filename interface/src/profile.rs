//! Machine profile: the numbers of one hybrid machine, with their provenance.
//!
//! Every number says where it is from ([`Provenance`]); a number that is absent
//! is a stage switched off, or a supply without limit. [`Profile::ideal`] has
//! none. A profile is plain data: what a number does is told where it is used
//! (converter, hold).

use crate::{
    Tick,
    converter::{Converter, ConverterError},
    hold::HoldKind,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Overload level when a profile states none: |x| > 1.1 of a block's `max`.
pub const DEFAULT_OVERLOAD_LEVEL: f64 = 1.1;

/// How far a number can be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Provenance {
    /// Read in the source named.
    Verified,
    /// Read in an excerpt of the source.
    Excerpt,
    /// Remembered, not looked up.
    Memory,
    /// Chosen for want of a source.
    Assumed,
}

/// A number and where it is from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sourced<T> {
    pub value: T,
    /// How far it can be trusted.
    pub status: Provenance,
    pub source: String,
}

crate::named! {
    /// Classes of block of which a machine has a certain number, by their keys in a profile's
    /// `[counts]`, which are also their names in tables.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
    pub enum BlockClass, key {
        /// Integrators, track/stores included.
        Integrator "integrators"
        /// Summers, inverters and other amplifiers that are no integrators.
        Amplifier "amplifiers"
        /// Multipliers, dividers, squares and square roots.
        Multiplier "multipliers"
        Resolver "resolvers"
        FunctionGenerator "function-generators"
        /// Potentiometers set by hand or servo.
        Potentiometer "potentiometers"
        Dcu "dcus"
        /// Digital-to-analog converters, the multiplying ones included.
        Dac "dacs"
        /// Multiplying digital-to-analog converters, which count as DACs too.
        Mdac "mdacs"
        AdcChannel "adc-channels"
        /// Comparators and relays.
        Comparator "comparators"
        Switch "switches"
        /// Non-linear diode networks: dead zone, limiter, backlash, friction, abs.
        DiodeNetwork "diode-networks"
        /// Gates, flip-flops, one-shots, counters.
        Logic "logic"
        SenseLine "sense-lines"
        ControlLine "control-lines"
        InterruptLine "interrupt-lines"
    }
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AdcStage {
    /// Bits, sign included.
    pub bits: Option<Sourced<u32>>,
    /// Time of one conversion.
    pub conversion: Option<Sourced<Tick>>,
    /// Multiplexer skew δ between neighbouring channels.
    pub skew: Option<Sourced<Tick>>,
    /// Aperture of the track/hold: the sample is a mean over this time before the hold.
    pub aperture: Option<Sourced<Tick>>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DacStage {
    /// Bits, sign included.
    pub bits: Option<Sourced<u32>>,
    /// Settling time constant.
    pub settling: Option<Sourced<Tick>>,
    /// Reconstruction between transfers; zero order when absent.
    pub hold: Option<Sourced<HoldKind>>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DcuStage {
    /// Bits, sign included.
    pub bits: Option<Sourced<u32>>,
    /// Largest coefficient that can be set.
    pub range: Option<Sourced<f64>>,
}

/// The numbers of one machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    pub name: String,
    pub note: String,
    /// Volts of one machine unit.
    pub reference_v: Option<Sourced<f64>>,
    /// Overload beyond this many machine units.
    pub overload_level: Option<Sourced<f64>>,
    /// Relative error of components (one standard deviation).
    pub component_error: Option<Sourced<f64>>,
    /// Blocks available by class; a class that is absent has no limit.
    pub counts: BTreeMap<BlockClass, Sourced<u32>>,
    pub adc: AdcStage,
    pub dac: DacStage,
    pub dcu: DcuStage,
    /// Latency of the linkage itself, from the end of the scan to the digital side and back.
    pub latency: Option<Sourced<Tick>>,
    /// Time that the digital side computes for one frame.
    pub compute: Option<Sourced<Tick>>,
}

impl Default for Profile {
    fn default() -> Profile {
        Profile::ideal()
    }
}

/// A class of which a patch needs more than the machine has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shortfall {
    pub class: BlockClass,
    pub needed: u32,
    pub available: u32,
}

impl Profile {
    /// Every stage off and no limits.
    pub fn ideal() -> Profile {
        Profile {
            name: "ideal".to_owned(),
            note: "Every stage off: plain f64 through the linkage, blocks without limit."
                .to_owned(),
            reference_v: None,
            overload_level: None,
            component_error: None,
            counts: BTreeMap::new(),
            adc: AdcStage::default(),
            dac: DacStage::default(),
            dcu: DcuStage::default(),
            latency: None,
            compute: None,
        }
    }

    /// Blocks of a class that the machine has; `None` is without limit.
    pub fn available(&self, class: BlockClass) -> Option<u32> {
        self.counts.get(&class).map(|count| count.value)
    }

    /// Classes of which more is needed than there is. Multiplying DACs take DACs.
    pub fn shortfalls(&self, needed: &BTreeMap<BlockClass, u32>) -> Vec<Shortfall> {
        let need = |class: &BlockClass| needed.get(class).copied().unwrap_or(0);
        BlockClass::ALL
            .iter()
            .filter_map(|&class| {
                let needed = match class {
                    BlockClass::Dac => {
                        need(&BlockClass::Dac).saturating_add(need(&BlockClass::Mdac))
                    }
                    class => need(&class),
                };
                let available = self.available(class)?;
                (needed > available).then_some(Shortfall { class, needed, available })
            })
            .collect()
    }

    /// Overload level in machine units.
    pub fn overload_level(&self) -> f64 {
        self.overload_level.as_ref().map_or(DEFAULT_OVERLOAD_LEVEL, |level| level.value)
    }

    /// Component error as a fraction; zero when off.
    pub fn component_error(&self) -> f64 {
        self.component_error.as_ref().map_or(0.0, |error| error.value)
    }

    /// The ADC of a channel whose full scale is the block's `max`, problem units.
    pub fn adc_converter(&self, full_scale: Option<f64>) -> Result<Converter, ConverterError> {
        converter(self.adc.bits.as_ref(), full_scale)
    }

    /// The DAC of a channel, likewise.
    pub fn dac_converter(&self, full_scale: Option<f64>) -> Result<Converter, ConverterError> {
        converter(self.dac.bits.as_ref(), full_scale)
    }

    /// A digital coefficient unit scaled for `range`, or else for the profile's own
    /// range. A profile without bits sets every coefficient exactly.
    pub fn coefficient_unit(&self, range: Option<f64>) -> Result<Converter, ConverterError> {
        let own = self.dcu.range.as_ref().map(|range| range.value);
        match &self.dcu.bits {
            Some(bits) => Converter::coefficient(Some(bits.value), range.or(own)),
            None => Ok(Converter::ideal()),
        }
    }

    /// Multiplexer skew δ; zero is a simultaneous sample.
    pub fn skew(&self) -> Tick {
        duration(self.adc.skew.as_ref())
    }

    /// Aperture of the track/hold.
    pub fn aperture(&self) -> Tick {
        duration(self.adc.aperture.as_ref())
    }

    /// Total latency τ from sample to transfer with `channels` ADC channels: the scan
    /// (one skew between neighbours), the conversion of the last channel, the
    /// linkage, and the computation.
    pub fn total_latency(&self, channels: u32) -> Tick {
        self.skew() * i64::from(channels.saturating_sub(1))
            + duration(self.adc.conversion.as_ref())
            + duration(self.latency.as_ref())
            + duration(self.compute.as_ref())
    }

    /// The total latency, at most one frame of `frame`; and the whole of it where it was cut.
    pub fn latency_within(&self, channels: u32, frame: Tick) -> (Tick, Option<Tick>) {
        let whole = self.total_latency(channels);
        (whole.min(frame), (whole > frame).then_some(whole))
    }

    /// Reconstruction between transfers.
    pub fn hold(&self) -> HoldKind {
        self.dac.hold.as_ref().map_or(HoldKind::ZeroOrder, |h| h.value)
    }

    /// Time constant of the settling of the DACs; zero is off.
    pub fn settling(&self) -> Tick {
        duration(self.dac.settling.as_ref())
    }
}

/// The ideal converter when the bits are off: a profile without bits limits no range.
fn converter(
    bits: Option<&Sourced<u32>>,
    full_scale: Option<f64>,
) -> Result<Converter, ConverterError> {
    match bits {
        Some(bits) => Converter::new(Some(bits.value), full_scale),
        None => Ok(Converter::ideal()),
    }
}

fn duration(tick: Option<&Sourced<Tick>>) -> Tick {
    tick.map_or(Tick::ZERO, |tick| tick.value)
}
