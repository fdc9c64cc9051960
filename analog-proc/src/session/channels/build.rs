//! From the blocks of a patch to its channels, and how they are told to the digital side.
//!
//! A profile that cannot convert a block is refused here, with every such block at
//! once. Whether the profile has enough converters is checked before.

use super::{AdcChannel, Channels, DacChannel, DcuChannel, Line, Saturations};
use crate::net::Netlist;
use engine::simulation::Simulation;
use interface::{
    control::{Channel, ChannelKind},
    hold::Hold,
    profile::Profile,
};

impl Channels {
    /// Collects the channels of a patch and sets the machine to their initial values.
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
            let Some(claim) = block.kind.component().claim() else {
                continue;
            };
            let net = block.outputs[0];
            for (channel, value) in (claim.first as usize..).zip(claim.initial) {
                let made = match claim.kind {
                    ChannelKind::Adc => profile.adc_converter(block.max).map(|converter| {
                        channels.adc.push(AdcChannel { channel, net, converter });
                    }),
                    ChannelKind::Dac => profile.dac_converter(block.max).map(|converter| {
                        let hold = Hold::new(profile.hold(), value);
                        channels.dac.push(DacChannel { channel, converter, hold, value });
                    }),
                    ChannelKind::Dcu => profile.coefficient_unit(claim.range).map(|unit| {
                        channels.dcu.push(DcuChannel { channel, unit, value });
                    }),
                    ChannelKind::Sense => {
                        channels.sense.push(Line { line: channel, net });
                        Ok(())
                    }
                    ChannelKind::Control => {
                        channels.control.push((channel, value != 0.0));
                        Ok(())
                    }
                    ChannelKind::Interrupt => Ok(()),
                };
                if let Err(e) = made {
                    faults.push(format!("`{}`: {e}", block.name));
                    break;
                }
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
            let Some(claim) = block.kind.component().claim() else {
                continue;
            };
            let count = claim.initial.len();
            for (i, number) in (0..count).zip(claim.first..) {
                // The ordinates of a function generator are NAME[0], NAME[1], …
                let name =
                    if count > 1 { format!("{}[{i}]", block.name) } else { block.name.clone() };
                let full_scale = block.max;
                described.push(Channel { kind: claim.kind, name, number, full_scale });
            }
        }
        described
    }
}
