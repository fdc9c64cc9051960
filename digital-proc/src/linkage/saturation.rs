//! Which converters and coefficients saturated in a run: flags of the frames, by name.

use interface::{
    control::{Channel, ChannelKind},
    frame::Samples,
};

/// Channels that saturated in at least one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Saturations {
    adc: u64,
    dac: u64,
    dcu: [u64; 2],
}

impl Saturations {
    /// Takes in the flags of one frame; whether there was any.
    pub fn note(&mut self, samples: &Samples) -> bool {
        self.adc |= samples.adc_saturated;
        self.dac |= samples.dac_saturated;
        for (all, new) in self.dcu.iter_mut().zip(samples.dcu_saturated) {
            *all |= new;
        }
        samples.saturated()
    }

    /// The saturated channels as `ADC alpha`, in the order of `channels`.
    pub fn names(&self, channels: &[Channel]) -> Vec<String> {
        let set = |mask: u64, bit: u32| mask >> (bit % 64) & 1 == 1;
        channels
            .iter()
            .filter_map(|channel| {
                let n = channel.number;
                let (kind, on) = match channel.kind {
                    ChannelKind::Adc => ("ADC", set(self.adc, n)),
                    ChannelKind::Dac => ("DAC", set(self.dac, n)),
                    ChannelKind::Dcu => ("DCU", set(self.dcu[(n / 64) as usize % 2], n)),
                    _ => return None,
                };
                on.then(|| format!("{kind} {}", channel.name))
            })
            .collect()
    }
}
