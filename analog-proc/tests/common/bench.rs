//! Patches as users write them, compiled and run, for tests that judge the engine from outside.

#![allow(dead_code, clippy::unwrap_used, reason = "each user takes what it needs")]

use analog_proc::order::Ordered;
use analog_proc::patch::compile;
use engine::element::logic::Edge;
use engine::fault::RunFault;
use engine::id::NetId;
use engine::simulation::{Advance, Simulation};
use interface::Tick;
use interface::control::PatchBundle;

/// A patch in operation.
pub struct Bench {
    pub ordered: Ordered,
    pub simulation: Simulation,
}

/// Compiles a whole patch file; its faults in words where it has some.
pub fn ordered(text: &str) -> Result<Ordered, String> {
    let bundle =
        PatchBundle { root: "test.toml".into(), files: vec![("test.toml".into(), text.into())] };
    compile(&bundle, &[]).map_err(|faults| faults.render())
}

impl Bench {
    pub fn of(ordered: Ordered) -> Bench {
        let simulation = ordered.simulation().unwrap();
        Bench { ordered, simulation }
    }

    /// The lines of `[blocks]`, with default settings.
    pub fn new(blocks: &str) -> Bench {
        Bench::with("", blocks)
    }

    /// The lines of `[integration]` and of `[blocks]`.
    pub fn with(integration: &str, blocks: &str) -> Bench {
        let text = format!("[integration]\n{integration}\n[blocks]\n{blocks}");
        Bench::of(ordered(&text).unwrap_or_else(|faults| panic!("{faults}")))
    }

    /// A patch that is shipped.
    pub fn shipped(name: &str) -> Bench {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../patch-files/");
        let text = std::fs::read_to_string(format!("{folder}{name}")).unwrap();
        Bench::of(ordered(&text).unwrap_or_else(|faults| panic!("{faults}")))
    }

    pub fn id(&self, name: &str) -> NetId {
        let nets = &self.ordered.netlist.nets;
        NetId(nets.iter().position(|net| net.name == name).unwrap() as u32)
    }

    pub fn try_run(&mut self, until_s: f64) -> Result<Advance, RunFault> {
        self.simulation.advance_to(Tick::from_secs(until_s).unwrap())
    }

    /// Runs; a fault is a failure.
    pub fn run(&mut self, until_s: f64) -> &mut Bench {
        self.try_run(until_s).unwrap();
        self
    }

    pub fn net(&self, name: &str) -> f64 {
        self.simulation.net(self.id(name))
    }

    /// Greatest distance of a net from `truth(t)` at every multiple of `every_s` after now, and where.
    pub fn worst(
        &mut self,
        name: &str,
        until_s: f64,
        every_s: f64,
        truth: impl Fn(f64) -> f64,
    ) -> (f64, f64) {
        let mut worst = (0.0, 0.0);
        let mut rows = 0;
        let net = self.id(name);
        let tick = |s| Tick::from_secs(s).unwrap();
        self.simulation
            .advance_recording(tick(until_s), tick(every_s), &[net], |t_s, values| {
                rows += 1;
                let error = (values[0] - truth(t_s)).abs();
                if error > worst.0 || error.is_nan() {
                    worst = (error, t_s);
                }
            })
            .unwrap();
        assert!(rows > 0);
        worst
    }

    /// Instants at which interrupt line `line` rose (or fell).
    pub fn edges(&mut self, line: u32, rising: bool) -> Vec<f64> {
        let mut edges: Vec<Edge> = Vec::new();
        self.simulation.take_edges(&mut edges);
        edges.iter().filter(|e| e.line == line && e.rising == rising).map(|e| e.t_s).collect()
    }
}
