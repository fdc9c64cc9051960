//! Wiring patches in code and comparing numbers, for tests and benchmarks of the engine alone.

#![allow(dead_code, clippy::unwrap_used, reason = "each user takes what it needs")]

use analog_proc::block::kind::{
    Constant, Control, Counter, Dac, DeadZone, Divider, DryFriction, Integrator, Interrupt,
    Limiter, Max, Multiplier, Not, OneShot, Relay, Sense, Square, SquareRoot, Summer, Switch, Time,
    TransportDelay,
};
use analog_proc::net::{Integration, Kind, Level, Method, NetId};
use analog_proc::order::Ordered;
use analog_proc::patch::compile;
use analog_proc::simulation::Simulation;
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

    /// The line of a block in the patch language. Numbers that the language refuses are
    /// stood in for; [`Patch::ordered`] then puts the true ones in their place.
    fn line(&self, name: &str, kind: &Kind, inputs: &[String]) -> String {
        let number = |x: f64| format!("{:?}", if x.is_finite() { x } else { 1.0 });
        let pair = |p: [f64; 2]| format!("[{}, {}]", number(p[0]), number(p[1]));
        let level = |l: &Level| match l {
            Level::Fixed(x) => number(*x),
            Level::Net(net) => format!("\"{}\"", self.name(*net)),
        };
        let fields = match kind {
            Kind::Integrator(Integrator { ic, limits, operate, reset, reset_to }) => {
                let mut text = format!("kind = \"integrator\", ic = {}", number(*ic));
                if let Some(limits) = limits {
                    text += &format!(", limits = {}", pair(*limits));
                }
                if let Some(net) = operate {
                    text += &format!(", operate = \"{}\"", self.name(*net));
                }
                if let Some(net) = reset {
                    text += &format!(", reset = \"{}\"", self.name(*net));
                }
                if let Some(to) = reset_to {
                    text += &format!(", reset-to = \"{} * {}\"", to.coefficient, self.name(to.net));
                }
                text
            }
            Kind::Summer(Summer) => "kind = \"summer\"".into(),
            Kind::Multiplier(Multiplier) => "kind = \"multiplier\"".into(),
            Kind::Square(Square) => "kind = \"square\"".into(),
            Kind::SquareRoot(SquareRoot) => "kind = \"square-root\"".into(),
            Kind::Max(Max) => "kind = \"max\"".into(),
            Kind::Divider(Divider) => "kind = \"divider\"".into(),
            Kind::Not(Not) => "kind = \"not\"".into(),
            Kind::Time(Time) => "kind = \"time\"".into(),
            Kind::Constant(Constant { value }) => {
                format!("kind = \"constant\", value = {}", number(*value))
            }
            Kind::Dac(Dac { channel, .. }) => format!("kind = \"dac\", channel = {channel}"),
            Kind::Control(Control { line, .. }) => format!("kind = \"control\", line = {line}"),
            Kind::Interrupt(Interrupt { line }) => format!("kind = \"interrupt\", line = {line}"),
            Kind::Sense(Sense { line }) => format!("kind = \"sense\", line = {line}"),
            Kind::Comparator(_) => "kind = \"comparator\"".into(),
            Kind::FlipFlop(_) => "kind = \"flip-flop\"".into(),
            Kind::Counter(Counter { modulo }) => format!("kind = \"counter\", modulo = {modulo}"),
            Kind::OneShot(OneShot { width_s }) => {
                format!("kind = \"one-shot\", width = {}", number(*width_s))
            }
            Kind::Relay(Relay { points, outputs, .. }) => {
                format!(
                    "kind = \"relay\", points = {}, outputs = {}",
                    pair(*points),
                    pair(*outputs)
                )
            }
            Kind::DeadZone(DeadZone { width }) => {
                format!("kind = \"dead-zone\", width = {}", level(width))
            }
            Kind::Limiter(Limiter { low, high }) => {
                format!("kind = \"limiter\", limits = [{}, {}]", level(low), level(high))
            }
            Kind::DryFriction(DryFriction { level, .. }) => {
                format!("kind = \"dry-friction\", level = {}", number(*level))
            }
            Kind::TransportDelay(TransportDelay { delay, .. }) => {
                format!("kind = \"transport-delay\", delay = {}", number(*delay))
            }
            Kind::Generator(_) => "kind = \"signal-generator\", wave = \"sine\"".into(),
            Kind::Switch(Switch { control }) => {
                format!("kind = \"switch\", control = \"{}\"", self.name(*control))
            }
            other => panic!("no text for {other:?}"),
        };
        let inputs: Vec<String> = inputs.iter().map(|i| format!("\"{i}\"")).collect();
        let wired = if inputs.is_empty() {
            String::new()
        } else {
            format!(", in = [{}]", inputs.join(", "))
        };
        format!("{name} = {{ {fields}{wired} }}\n")
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
        Simulation::new(&self.ordered()).unwrap()
    }
}
