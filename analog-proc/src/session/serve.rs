//! The analog side of a session: answers requests, then runs the frame cycle.
//!
//! One loop for every link. In a run it is the only one who knows when samples
//! are taken and transfers take effect ([`crate::session::frame_cycle`]).

use crate::{
    net::Kind,
    order::Ordered,
    patch,
    session::{
        board::Board,
        channels::Channels,
        frame_cycle::{self, Stand},
        static_check::static_check,
        sweep,
    },
    tolerance,
};
use engine::{id::NetId, linear::Linear};
use interface::{
    Tick,
    control::{AnalogState, Checkpoints, Clock, LinearModel, PatchBundle, Reply, Request, RunSpec},
    link::{AnalogPort, FramePort, LinkFault, direct::AnalogSide},
    profile::Profile,
};
use nalgebra::DMatrix;

/// Serves one session until the digital side says goodbye or is gone.
pub fn serve(port: &mut dyn AnalogPort) -> Result<(), LinkFault> {
    let mut server = Server::default();
    loop {
        let request = port.await_request()?;
        let is_over = matches!(request, Request::Bye);
        let reply = server.answer(request, &mut || port.attend())?;
        port.reply(&reply)?;
        if is_over {
            return Ok(());
        }
        server.operate(port)?;
    }
}

/// What a `Load` left behind.
struct Loaded {
    bundle: PatchBundle,
    profile: Profile,
    params: Vec<(String, f64)>,
    ics: Vec<(String, f64)>,
    ordered: Ordered,
    board: Board,
}

/// An OPERATE period to be run.
struct Period {
    spec: RunSpec,
    checkpoints: Option<Checkpoints>,
    resumed: Option<Stand>,
}

/// The analog side of one session, whatever leads to it.
#[derive(Default)]
pub struct Server {
    loaded: Option<Loaded>,
    /// The period that was accepted and not yet run.
    accepted: Option<Period>,
    fault: Option<String>,
}

impl AnalogSide for Server {
    fn answer(
        &mut self,
        request: Request,
        attend: &mut dyn FnMut() -> Result<(), LinkFault>,
    ) -> Result<Reply, LinkFault> {
        let reply = match request {
            Request::Sweep(request) => match self.loaded() {
                Ok(loaded) => sweep::run(&request, &loaded.ordered, &loaded.board, attend)?,
                Err(refusal) => Reply::Refused(refusal),
            },
            request => self.reply(request).unwrap_or_else(Reply::Refused),
        };
        Ok(reply)
    }

    fn operate(&mut self, port: &mut dyn FramePort) -> Result<(), LinkFault> {
        let (Some(period), Some(loaded)) = (self.accepted.take(), &mut self.loaded) else {
            return Ok(());
        };
        let Period { spec, checkpoints, resumed } = period;
        let time_scale = loaded.ordered.netlist.integration.time_scale;
        let kept = (checkpoints.as_ref(), resumed);
        let fault = frame_cycle::run(&spec, time_scale, kept, &mut loaded.board, port)?;
        self.fault = fault.map(|f| f.to_string());
        Ok(())
    }
}

impl Server {
    fn reply(&mut self, request: Request) -> Result<Reply, String> {
        match request {
            Request::Hello { .. } => Err("the two sides have greeted each other already".into()),
            Request::Load { bundle, params, profile } => {
                self.loaded = None;
                let loaded = Loaded::new(bundle, params, Vec::new(), profile)?;
                let reply = Reply::Loaded {
                    patch_hash: loaded.bundle.hash(),
                    channels: loaded.board.channels.describe(&loaded.ordered.netlist),
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
                new.board.channels.carry_over(&old.board.channels, &mut new.board.simulation);
                new.board.settle()?;
                self.loaded = Some(new);
                Ok(Reply::Done)
            }
            Request::SetIcs(values) => {
                self.loaded()?.set_ics(values)?;
                Ok(Reply::Done)
            }
            Request::Preset(preset) => {
                self.loaded()?.board.preset(&preset)?;
                Ok(Reply::Done)
            }
            Request::Read(names) => {
                let loaded = self.loaded()?;
                let nets = loaded.nets(&names)?;
                let values = nets.into_iter().map(|net| loaded.board.simulation.net(net));
                Ok(Reply::Values(values.collect()))
            }
            Request::Linearise { inputs, outputs } => {
                self.loaded()?.linearise(&inputs, &outputs).map(Reply::Linear)
            }
            Request::StaticCheck => {
                let loaded = self.loaded()?;
                static_check(&loaded.ordered, &mut loaded.board.simulation)
                    .map(Reply::StaticCheck)
                    .map_err(|f| f.to_string())
            }
            Request::Diagnose => Ok(Reply::Diagnosis {
                fault: self.fault.clone(),
                overloads: self
                    .loaded
                    .as_ref()
                    .map(|l| l.board.overloads(&l.ordered))
                    .unwrap_or_default(),
            }),
            Request::Operate(spec) => {
                self.admit(&spec)?;
                self.accepted = Some(Period { spec, checkpoints: None, resumed: None });
                Ok(Reply::Done)
            }
            Request::OperateKept(spec, checkpoints) => {
                if checkpoints.every == 0 || spec.clock != Clock::LockStep {
                    return Err("checkpoints are kept in lock-step, some frames apart".into());
                }
                self.admit(&spec)?;
                let board = &mut self.loaded()?.board;
                let resume = |from: &AnalogState| Stand::read(from, board);
                let resumed = checkpoints.from.as_ref().map(resume).transpose()?;
                self.accepted = Some(Period { spec, checkpoints: Some(checkpoints), resumed });
                Ok(Reply::Done)
            }
            Request::Bye => Ok(Reply::Done),
            Request::Sweep(_) | Request::Checkpoint => {
                Err("not a request to be answered here".into())
            }
        }
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
        let scan = loaded.board.channels.scan_time(skew);
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
            loaded.board.reset()?;
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
        let board = Board { simulation, channels };
        let mut loaded = Loaded { bundle, profile, params, ics: Vec::new(), ordered, board };
        loaded.set_ics(ics)?;
        Ok(loaded)
    }

    fn nets(&self, names: &[String]) -> Result<Vec<NetId>, String> {
        names.iter().map(|name| self.ordered.netlist.net(name)).collect()
    }

    fn linearise(&self, inputs: &[String], outputs: &[String]) -> Result<LinearModel, String> {
        let (inputs, outputs) = (self.nets(inputs)?, self.nets(outputs)?);
        let netlist = &self.ordered.netlist;
        for net in &inputs {
            let block = &netlist.blocks[netlist.nets[net.index()].driver.index()];
            // What the digital side sets of it is a factor, not its output.
            if matches!(block.kind, Kind::Mdac(_)) {
                return Err(format!(
                    "`{}` multiplies: the loop through it is not linear",
                    block.name
                ));
            }
        }
        let linear = self.board.simulation.linearise(&inputs, &outputs);
        let Linear { a, b, c, d } = linear.map_err(|fault| fault.to_string())?;
        let machine = self.board.simulation.machine();
        let states = machine.block_of_state.iter();
        let rows = |m: DMatrix<f64>| m.transpose().as_slice().to_vec();
        Ok(LinearModel {
            states: states.map(|block| machine.block_names[block.index()].clone()).collect(),
            a: rows(a),
            b: rows(b),
            c: rows(c),
            d: rows(d),
        })
    }

    /// Sets initial conditions and goes to IC, and remembers them.
    fn set_ics(&mut self, values: Vec<(String, f64)>) -> Result<(), String> {
        self.board.set_ics(&self.ordered, &values)?;
        for (name, value) in values {
            self.ics.retain(|(n, _)| *n != name);
            self.ics.push((name, value));
        }
        Ok(())
    }
}
