//! A loaded patch on the machine: the array with the channels that lead out of it.

use crate::{order::Ordered, session::channels::Channels};
use engine::{id::BlockId, mode::Mode, simulation::Simulation};
use interface::{control::Overload, frame::Updates};

/// The array with the channels that lead out of it.
#[derive(Clone)]
pub(super) struct Board {
    pub simulation: Simulation,
    pub channels: Channels,
}

impl Board {
    /// Sets initial conditions and goes to IC; where that is impossible the former ones
    /// are put back.
    pub fn set_ics(&mut self, patch: &Ordered, values: &[(String, f64)]) -> Result<(), String> {
        let blocks = values
            .iter()
            .map(|(name, value)| store(patch, name, *value))
            .collect::<Result<Vec<BlockId>, _>>()?;
        let former: Vec<Option<f64>> = blocks.iter().map(|b| self.simulation.ic(*b)).collect();
        for (block, (_, value)) in blocks.iter().zip(values) {
            self.simulation.set_ic(*block, *value);
        }
        if let Err(fault) = self.simulation.reset() {
            for (block, former) in blocks.iter().zip(former) {
                if let Some(value) = former {
                    self.simulation.set_ic(*block, value);
                }
            }
            // A fault of the former ICs stood before; it stands on in the simulation.
            self.reset().ok();
            return Err(fault.to_string());
        }
        Ok(())
    }

    /// Presets channels; where the machine cannot settle with them the former settings
    /// are put back. At IC the fault goes with them; later it stands until the next reset.
    pub fn preset(&mut self, preset: &Updates) -> Result<(), String> {
        let former = self.channels.clone();
        self.channels.preset(preset, &mut self.simulation)?;
        let Err(fault) = self.settle() else {
            return Ok(());
        };
        self.channels = former;
        self.channels.set_all(&mut self.simulation);
        if self.simulation.mode() == Mode::InitialCondition {
            self.reset().ok();
        }
        Err(fault)
    }

    pub fn reset(&mut self) -> Result<(), String> {
        self.simulation.reset().map_err(|f| f.to_string())
    }

    pub fn settle(&mut self) -> Result<(), String> {
        self.simulation.apply().map_err(|f| f.to_string())
    }

    /// Latched overloads in order of time.
    pub fn overloads(&self, patch: &Ordered) -> Vec<Overload> {
        self.simulation
            .overloads()
            .iter()
            .map(|o| Overload {
                block: patch.netlist.blocks[o.block.index()].name.clone(),
                time_s: o.t_s,
                value: o.value,
            })
            .collect()
    }
}

/// The block whose initial condition is to be `value`.
fn store(patch: &Ordered, name: &str, value: f64) -> Result<BlockId, String> {
    if !value.is_finite() {
        return Err(format!("the IC of `{name}` is {value}, not a finite number"));
    }
    patch
        .netlist
        .blocks
        .iter()
        .position(|b| b.name == name && b.kind.is_store())
        .map(|index| BlockId(index as u32))
        .ok_or_else(|| format!("the patch has no integrator `{name}` to set an IC of"))
}
