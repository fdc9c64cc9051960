//! The analog side of a session: answers requests, then runs the frame cycle.
//!
//! One loop for every link. In a run it is the only one who knows when samples
//! are taken and transfers take effect ([`crate::session::frame_cycle`]).

use crate::{
    order::Ordered,
    patch,
    session::{channels::Channels, frame_cycle, static_check::static_check},
    tolerance,
};
use engine::{
    id::{BlockId, NetId},
    mode::Mode,
    simulation::Simulation,
};
use interface::{
    Tick,
    control::{Overload, PatchBundle, Reply, Request, RunSpec},
    frame::Updates,
    link::{AnalogPort, LinkFault},
    profile::Profile,
};

/// Serves one session until the digital side says goodbye or is gone.
pub fn serve(port: &mut dyn AnalogPort) -> Result<(), LinkFault> {
    let mut server = Server::default();
    loop {
        let reply = match port.await_request()? {
            Request::Bye => {
                port.reply(&Reply::Done)?;
                return Ok(());
            }
            Request::Operate(spec) => match server.admit(&spec) {
                Ok(()) => {
                    port.reply(&Reply::Done)?;
                    server.run(&spec, port)?;
                    continue;
                }
                Err(refusal) => Reply::Refused(refusal),
            },
            request => server.answer(request).unwrap_or_else(Reply::Refused),
        };
        port.reply(&reply)?;
    }
}

/// What a `Load` left behind.
struct Loaded {
    bundle: PatchBundle,
    profile: Profile,
    params: Vec<(String, f64)>,
    ics: Vec<(String, f64)>,
    ordered: Ordered,
    simulation: Simulation,
    channels: Channels,
}

#[derive(Default)]
struct Server {
    loaded: Option<Loaded>,
    fault: Option<String>,
}

impl Server {
    fn answer(&mut self, request: Request) -> Result<Reply, String> {
        match request {
            Request::Hello { .. } => Err("the two sides have greeted each other already".into()),
            Request::Load { bundle, params, profile } => {
                self.loaded = None;
                let loaded = Loaded::new(bundle, params, Vec::new(), profile)?;
                let reply = Reply::Loaded {
                    patch_hash: loaded.bundle.hash(),
                    channels: loaded.channels.describe(&loaded.ordered.netlist),
                };
                self.loaded = Some(loaded);
                Ok(reply)
            }
            Request::SetParams(values) => {
                let old = self.loaded()?;
                let mut params = old.params.clone();
                for (name, value) in values {
                    match params.iter_mut().find(|(n, _)| *n == name) {
                        Some(entry) => entry.1 = value,
                        None => params.push((name, value)),
                    }
                }
                let mut new =
                    Loaded::new(old.bundle.clone(), params, old.ics.clone(), old.profile.clone())?;
                new.channels.carry_over(&old.channels, &mut new.simulation);
                new.settle()?;
                self.loaded = Some(new);
                Ok(Reply::Done)
            }
            Request::SetIcs(values) => {
                self.loaded()?.set_ics(values)?;
                Ok(Reply::Done)
            }
            Request::Preset(preset) => {
                self.loaded()?.preset(&preset)?;
                Ok(Reply::Done)
            }
            Request::Read(names) => {
                let loaded = self.loaded()?;
                let netlist = &loaded.ordered.netlist;
                let read = |name: &String| {
                    netlist
                        .nets
                        .iter()
                        .position(|n| n.name == *name)
                        .map(|i| loaded.simulation.net(NetId(i as u32)))
                        .ok_or_else(|| format!("the patch has no net `{name}` to read"))
                };
                names.iter().map(read).collect::<Result<_, _>>().map(Reply::Values)
            }
            Request::StaticCheck => {
                let loaded = self.loaded()?;
                static_check(&loaded.ordered, &mut loaded.simulation)
                    .map(Reply::StaticCheck)
                    .map_err(|f| f.to_string())
            }
            Request::Diagnose => Ok(Reply::Diagnosis {
                fault: self.fault.clone(),
                overloads: self.loaded.as_ref().map(Loaded::overloads).unwrap_or_default(),
            }),
            Request::Operate(_) | Request::Bye => Err("not a request to be answered here".into()),
        }
    }

    /// Runs one OPERATE period that was admitted.
    fn run(&mut self, spec: &RunSpec, port: &mut dyn AnalogPort) -> Result<(), LinkFault> {
        let Some(loaded) = &mut self.loaded else {
            return Ok(()); // never: `admit` asked for it
        };
        let fault = frame_cycle::run(
            spec,
            loaded.ordered.netlist.integration.time_scale,
            &mut loaded.simulation,
            &mut loaded.channels,
            port,
        )?;
        self.fault = fault.map(|f| f.to_string());
        Ok(())
    }

    fn loaded(&mut self) -> Result<&mut Loaded, String> {
        self.loaded.as_mut().ok_or_else(|| "no patch is loaded; load one first".into())
    }

    /// Whether a run may start as asked.
    fn admit(&mut self, spec: &RunSpec) -> Result<(), String> {
        let loaded = self.loaded()?;
        let RunSpec { frame, latency, skew, stop, .. } = *spec;
        if frame <= Tick::ZERO {
            return Err(format!("frame period {frame} is not positive"));
        }
        if latency < Tick::ZERO || latency > frame {
            return Err(format!("latency {latency} lies outside 0 … {frame} (one frame)"));
        }
        let scan = loaded.channels.scan_time(skew);
        if skew < Tick::ZERO || scan.is_none_or(|scan| scan > latency) {
            let scan = scan.map_or("more than 292 years".into(), |scan| scan.to_string());
            return Err(format!(
                "the scan of the ADC channels takes {scan} (skew {skew} a channel), longer than the latency {latency}; raise the latency or lower the skew"
            ));
        }
        if stop < Tick::ZERO {
            return Err(format!("stop time {stop} is negative"));
        }
        if spec.from_ic {
            loaded.reset()?;
        }
        self.fault = None;
        Ok(())
    }
}

impl Loaded {
    fn new(
        bundle: PatchBundle,
        params: Vec<(String, f64)>,
        ics: Vec<(String, f64)>,
        profile: Profile,
    ) -> Result<Loaded, String> {
        let mut ordered = patch::compile(&bundle, &params).map_err(|f| f.render())?;
        crate::check::against_profile(&ordered, &profile).map_err(|f| f.render())?;
        tolerance::apply(&mut ordered, profile.component_error());
        let mut simulation = ordered.simulation().map_err(|f| f.to_string())?;
        let channels = Channels::new(&ordered.netlist, &profile, &mut simulation)?;
        let mut loaded =
            Loaded { bundle, profile, params, ics: Vec::new(), ordered, simulation, channels };
        loaded.set_ics(ics)?;
        Ok(loaded)
    }

    /// Sets initial conditions and goes to IC; where that is impossible the former ones
    /// are put back.
    fn set_ics(&mut self, values: Vec<(String, f64)>) -> Result<(), String> {
        let blocks = values
            .iter()
            .map(|(name, value)| self.store(name, *value))
            .collect::<Result<Vec<BlockId>, _>>()?;
        let former: Vec<Option<f64>> = blocks.iter().map(|b| self.simulation.ic(*b)).collect();
        for (block, (_, value)) in blocks.iter().zip(&values) {
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
        for (name, value) in values {
            self.ics.retain(|(n, _)| *n != name);
            self.ics.push((name, value));
        }
        Ok(())
    }

    /// The block whose initial condition is to be `value`.
    fn store(&self, name: &str, value: f64) -> Result<BlockId, String> {
        if !value.is_finite() {
            return Err(format!("the IC of `{name}` is {value}, not a finite number"));
        }
        self.ordered
            .netlist
            .blocks
            .iter()
            .position(|b| b.name == name && b.kind.is_store())
            .map(|index| BlockId(index as u32))
            .ok_or_else(|| format!("the patch has no integrator `{name}` to set an IC of"))
    }

    /// Presets channels; where the machine cannot settle with them the former settings
    /// are put back. At IC the fault goes with them; later it stands until the next reset.
    fn preset(&mut self, preset: &Updates) -> Result<(), String> {
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

    fn reset(&mut self) -> Result<(), String> {
        self.simulation.reset().map_err(|f| f.to_string())
    }

    fn settle(&mut self) -> Result<(), String> {
        self.simulation.apply().map_err(|f| f.to_string())
    }

    fn overloads(&self) -> Vec<Overload> {
        self.simulation
            .overloads()
            .iter()
            .map(|o| Overload {
                block: self.ordered.netlist.blocks[o.block.index()].name.clone(),
                time_s: o.t_s,
                value: o.value,
            })
            .collect()
    }
}
