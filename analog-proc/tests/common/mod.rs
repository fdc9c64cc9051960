//! Wiring patches in code and comparing numbers, for tests and benchmarks of the engine alone.

#![allow(dead_code, clippy::unwrap_used, reason = "each user takes what it needs")]

use analog_proc::block::kind::{Integrator, Interrupt, Switch};
use analog_proc::net::Kind;
use analog_proc::order::Ordered;
use analog_proc::patch::compile;
use engine::simulation::Simulation;
use engine::{
    id::NetId,
    integration::{Integration, Method},
};
use interface::Tick;
use interface::control::PatchBundle;

/// The tick nearest to `s` seconds.
pub fn tick(s: f64) -> Tick {
    Tick::from_secs(s).unwrap()
}

/// Asserts that `found` lies within a relative error of `expected`.
pub fn close(found: f64, expected: f64, relative: f64, what: &str) {
    let error = (found - expected).abs() / expected.abs();
    assert!(error <= relative, "{what}: {found} instead of {expected}, relative error {error:e}");
}

/// A patch under construction; inputs are `net` or `c * net`.
#[derive(Clone, Default)]
pub struct Patch {
    blocks: Vec<(String, Kind, Vec<String>, Option<f64>)>,
    pub integration: Integration,
}

pub fn integrator(ic: f64) -> Kind {
    Kind::Integrator(Integrator { ic, limits: None, operate: None, reset: None, reset_to: None })
}

impl Patch {
    pub fn new() -> Patch {
        Patch::default()
    }

    pub fn with(method: Method) -> Patch {
        let mut patch = Patch::default();
        patch.integration.method = method;
        patch
    }

    /// The net that the `n`-th block added will drive (patches of tests hold no resolvers).
    pub fn id(&self, name: &str) -> NetId {
        NetId(self.blocks.iter().position(|b| b.0 == name).unwrap() as u32)
    }

    pub fn add(&mut self, name: &str, kind: Kind, inputs: &[&str]) -> NetId {
        let inputs = inputs.iter().map(|s| (*s).to_string()).collect();
        self.blocks.push((name.to_string(), kind, inputs, None));
        NetId(self.blocks.len() as u32 - 1)
    }

    pub fn max(&mut self, name: &str, max: f64) {
        self.blocks.iter_mut().find(|b| b.0 == name).unwrap().3 = Some(max);
    }

    fn name(&self, net: NetId) -> &str {
        &self.blocks[net.index()].0
    }

    /// A line of the patch language for a block, with stand-ins for what does not change the
    /// wiring; [`Patch::ordered`] then puts the true kind in its place.
    fn line(&self, name: &str, kind: &Kind, inputs: &[String]) -> String {
        let fields = match kind {
            Kind::Switch(Switch { control }) => format!("control = \"{}\"", self.name(*control)),
            Kind::DeadZone(_) => "width = 1".into(),
            Kind::Limiter(_) => "limit = 1".into(),
            Kind::Constant(_) => "value = 1".into(),
            Kind::Dac(_) => "channel = 0".into(),
            Kind::Control(_) | Kind::Sense(_) => "line = 0".into(),
            Kind::Interrupt(Interrupt { line }) => format!("line = {line}"),
            Kind::DryFriction(_) => "level = 1".into(),
            Kind::Relay(_) => "points = [0, 1], outputs = [0, 1]".into(),
            Kind::OneShot(_) => "width = 1".into(),
            Kind::TransportDelay(_) => "delay = 1".into(),
            Kind::Generator(_) => "wave = \"sine\"".into(),
            _ => "note = \"\"".into(),
        };
        format!("{name} = {{ kind = \"{}\", {fields}, in = {inputs:?} }}\n", kind.name())
    }

    /// Compiles the patch.
    pub fn ordered(&self) -> Ordered {
        let mut text = String::from("[blocks]\n");
        for (name, kind, inputs, _) in &self.blocks {
            text += &self.line(name, kind, inputs);
        }
        let files = vec![("test.toml".to_string(), text)];
        let bundle = PatchBundle { root: "test.toml".to_string(), files };
        let mut ordered = match compile(&bundle, &[]) {
            Ok(ordered) => ordered,
            Err(faults) => panic!("{}", faults.render()),
        };
        ordered.netlist.integration = self.integration;
        for (i, (name, kind, _, max)) in self.blocks.iter().enumerate() {
            assert_eq!(ordered.netlist.nets[i].name, *name);
            ordered.netlist.blocks[i].kind = kind.clone();
            ordered.netlist.blocks[i].max = *max;
        }
        ordered
    }

    pub fn simulation(&self) -> Simulation {
        self.ordered().simulation().unwrap()
    }
}
