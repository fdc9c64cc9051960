//! Wiring patches in code, for tests and benchmarks of the engine alone.

#![allow(dead_code, clippy::unwrap_used)]

use analog_proc::net::{
    Block, BlockId, Input, Integration, Kind, Method, Net, NetId, Netlist, Span,
};
use analog_proc::order::Ordered;
use analog_proc::simulation::Simulation;

/// A patch under construction; inputs are `net` or `c * net`.
#[derive(Clone, Default)]
pub struct Patch {
    blocks: Vec<(String, Kind, Vec<String>, Option<f64>)>,
    pub integration: Integration,
}

pub fn integrator(ic: f64) -> Kind {
    Kind::Integrator { ic, limits: None, operate: None, reset: None, reset_to: None }
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

    pub fn ordered(&self) -> Ordered {
        let input = |text: &str| {
            let mut parts: Vec<&str> = text.split('*').map(str::trim).collect();
            let name = parts.pop().unwrap();
            let (sign, name) = name.strip_prefix('-').map_or((1.0, name), |n| (-1.0, n));
            let product: f64 = parts.iter().map(|p| p.parse::<f64>().unwrap()).product();
            Input { net: self.id(name), coefficient: sign * product, span: Span::default() }
        };
        let blocks: Vec<Block> = self
            .blocks
            .iter()
            .enumerate()
            .map(|(i, (name, kind, inputs, max))| Block {
                name: name.clone(),
                span: Span::default(),
                kind: kind.clone(),
                inputs: inputs.iter().map(|t| input(t)).collect(),
                outputs: vec![NetId(i as u32)],
                max: *max,
            })
            .collect();
        let nets = self
            .blocks
            .iter()
            .enumerate()
            .map(|(i, b)| Net { name: b.0.clone(), driver: BlockId(i as u32) })
            .collect();
        let mut order: Vec<BlockId> = Vec::new();
        let mut placed = vec![false; blocks.len()];
        for (i, block) in blocks.iter().enumerate() {
            if block.kind.is_store() {
                placed[i] = true;
                order.push(BlockId(i as u32));
            }
        }
        while order.len() < blocks.len() {
            let before = order.len();
            for (i, block) in blocks.iter().enumerate() {
                let reads = block.inputs.iter().map(|x| x.net).chain(block.kind.side_nets());
                if !placed[i] && reads.into_iter().all(|n| placed[n.index()]) {
                    placed[i] = true;
                    order.push(BlockId(i as u32));
                }
            }
            assert!(order.len() > before, "algebraic loop in a test patch");
        }
        let netlist = Netlist {
            title: String::new(),
            blocks,
            nets,
            integration: self.integration,
            expected: Vec::new(),
            params: Vec::new(),
        };
        Ordered { netlist, order }
    }

    pub fn simulation(&self) -> Simulation {
        Simulation::new(&self.ordered()).unwrap()
    }
}
