//! From the blocks of a patch to its channels, and how they are told to the digital side.
//!
//! A profile that cannot convert a block is refused here, with every such block at
//! once. Whether the profile has enough converters is checked before.

use super::{AdcChannel, Channels, DacChannel, DcuChannel, Line, Saturations};
use crate::{
    net::{Kind, Netlist},
    simulation::Simulation,
};
use interface::{
    control::{Channel, ChannelKind},
    hold::Hold,
    profile::Profile,
};

impl Channels {
    /// Collects the channels of a patch and sets the machine to their initial values.
    ///
    /// # Errors
    /// A text naming the converters that have bits but no full scale.
    pub fn new(
        netlist: &Netlist,
        profile: &Profile,
        simulation: &mut Simulation,
    ) -> Result<Channels, String> {
        let mut channels = Channels {
            profile: profile.clone(),
            adc: Vec::new(),
            dac: Vec::new(),
            dcu: Vec::new(),
            sense: Vec::new(),
            control: Vec::new(),
            edges: Vec::new(),
            saturations: Saturations::default(),
            transfers: Vec::new(),
        };
        let mut faults = Vec::new();
        for block in &netlist.blocks {
            let mut fault =
                |e: &dyn std::fmt::Display| faults.push(format!("`{}`: {e}", block.name));
            let net = block.outputs[0];
            match block.kind {
                Kind::Adc { channel } => match profile.adc_converter(block.max) {
                    Ok(converter) => {
                        channels.adc.push(AdcChannel { channel: channel as usize, net, converter })
                    }
                    Err(e) => fault(&e),
                },
                Kind::Dac { channel, initial } | Kind::Mdac { channel, initial } => {
                    match profile.dac_converter(block.max) {
                        Ok(converter) => channels.dac.push(DacChannel {
                            channel: channel as usize,
                            converter,
                            hold: Hold::new(profile.hold(), initial),
                            value: initial,
                        }),
                        Err(e) => fault(&e),
                    }
                }
                Kind::Dcu { channel, initial, range } => match profile.coefficient_unit(range) {
                    Ok(unit) => channels.dcu.push(DcuChannel {
                        channel: channel as usize,
                        unit,
                        value: initial,
                    }),
                    Err(e) => fault(&e),
                },
                Kind::DigitalFunction { first_channel, ref initial, .. } => {
                    match profile.coefficient_unit(None) {
                        Ok(unit) => channels.dcu.extend(
                            (first_channel as usize..)
                                .zip(initial)
                                .map(|(channel, &value)| DcuChannel { channel, unit, value }),
                        ),
                        Err(e) => fault(&e),
                    }
                }
                Kind::Sense { line } => channels.sense.push(Line { line: line as usize, net }),
                Kind::Control { line, initial } => channels.control.push((line as usize, initial)),
                _ => {}
            }
        }
        if !faults.is_empty() {
            return Err(format!(
                "the profile `{}` cannot convert these blocks:\n  {}",
                profile.name,
                faults.join("\n  ")
            ));
        }
        channels.adc.sort_by_key(|c| c.channel);
        channels.dac.sort_by_key(|c| c.channel);
        channels.dcu.sort_by_key(|c| c.channel);
        channels.set_all(simulation);
        Ok(channels)
    }

    /// Takes over the settings of the same channels before a pot-set.
    pub fn carry_over(&mut self, old: &Channels, simulation: &mut Simulation) {
        for dac in &mut self.dac {
            if let Some(was) = old.dac.iter().find(|d| d.channel == dac.channel) {
                dac.value = was.value;
            }
        }
        for dcu in &mut self.dcu {
            if let Some(was) = old.dcu.iter().find(|d| d.channel == dcu.channel) {
                dcu.value = was.value;
            }
        }
        for (line, value) in &mut self.control {
            if let Some((_, was)) = old.control.iter().find(|(l, _)| l == line) {
                *value = *was;
            }
        }
        self.set_all(simulation);
    }

    /// The channels as the digital side is told of them.
    pub fn describe(&self, netlist: &Netlist) -> Vec<Channel> {
        let mut described = Vec::new();
        for block in &netlist.blocks {
            let (kind, number, count) = match block.kind {
                Kind::Adc { channel } => (ChannelKind::Adc, channel, 1),
                Kind::Dac { channel, .. } | Kind::Mdac { channel, .. } => {
                    (ChannelKind::Dac, channel, 1)
                }
                Kind::Dcu { channel, .. } => (ChannelKind::Dcu, channel, 1),
                Kind::DigitalFunction { first_channel, ref x, .. } => {
                    (ChannelKind::Dcu, first_channel, x.len())
                }
                Kind::Sense { line } => (ChannelKind::Sense, line, 1),
                Kind::Control { line, .. } => (ChannelKind::Control, line, 1),
                Kind::Interrupt { line } => (ChannelKind::Interrupt, line, 1),
                _ => continue,
            };
            for i in 0..count {
                // The ordinates of a function generator are NAME[0], NAME[1], …
                let name = if matches!(block.kind, Kind::DigitalFunction { .. }) {
                    format!("{}[{i}]", block.name)
                } else {
                    block.name.clone()
                };
                described.push(Channel {
                    kind,
                    name,
                    number: number + i as u32,
                    full_scale: block.max,
                });
            }
        }
        described
    }
}
