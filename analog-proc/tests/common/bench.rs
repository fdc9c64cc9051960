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

/// The tick nearest to `s` seconds.
pub fn tick(s: f64) -> Tick {
    Tick::from_secs(s).unwrap()
}

/// Asserts a relative error.
pub fn close(found: f64, expected: f64, relative: f64, what: &str) {
    let error = (found - expected).abs() / expected.abs();
    assert!(error <= relative, "{what}: {found} instead of {expected}, relative error {error:e}");
}

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
        self.simulation.advance_to(tick(until_s))
    }

    /// Runs; a fault is a failure.
    pub fn run(&mut self, until_s: f64) -> &mut Bench {
        self.try_run(until_s).unwrap();
        self
    }

    pub fn net(&self, name: &str) -> f64 {
        self.simulation.net(self.id(name))
    }

    /// Nets at every multiple of `every_s` after now.
    pub fn record(&mut self, names: &[&str], until_s: f64, every_s: f64) -> Vec<(f64, Vec<f64>)> {
        let nets: Vec<NetId> = names.iter().map(|name| self.id(name)).collect();
        let mut rows = Vec::new();
        self.simulation
            .advance_recording(tick(until_s), tick(every_s), &nets, |t_s, values| {
                rows.push((t_s, values.to_vec()));
            })
            .unwrap();
        assert!(!rows.is_empty());
        rows
    }

    /// Greatest distance of a net from `truth(t)` at every multiple of `every_s` after now, and where.
    pub fn worst(
        &mut self,
        name: &str,
        until_s: f64,
        every_s: f64,
        truth: impl Fn(f64) -> f64,
    ) -> (f64, f64) {
        let rows = self.record(&[name], until_s, every_s).into_iter();
        let errors = rows.map(|(t_s, values)| ((values[0] - truth(t_s)).abs(), t_s));
        errors.fold((0.0, 0.0), |w, d| if d.0 > w.0 || d.0.is_nan() { d } else { w })
    }

    /// Asserts that a net is within `limit` of `truth(t)` at every hundredth of a second.
    pub fn follows(&mut self, name: &str, until_s: f64, limit: f64, truth: impl Fn(f64) -> f64) {
        let (worst, t_s) = self.worst(name, until_s, 0.01, truth);
        assert!(worst <= limit, "{name}: {worst:e} at {t_s} s");
    }

    /// The interrupt edges so far.
    pub fn all_edges(&mut self) -> Vec<Edge> {
        let mut edges = Vec::new();
        self.simulation.take_edges(&mut edges);
        edges
    }

    /// Instants at which interrupt line `line` rose (or fell).
    pub fn edges(&mut self, line: u32, rising: bool) -> Vec<f64> {
        let edges = self.all_edges();
        edges.iter().filter(|e| e.line == line && e.rising == rising).map(|e| e.t_s).collect()
    }
}
