//! Random patches over all kinds of block: small, well scaled, some seconds long.
//!
//! First the kinds are drawn, then the wires: a block without memory reads blocks before it
//! or any block that stores, so that no algebraic loop arises. Levels are drawn close to the
//! peaks of what is compared with them wherever those are known, since that is where events
//! are missed. It is long, but one concept: how each kind is drawn.

use crate::patch::{Block, Field, Patch, Term};
use crate::random::Random;
use std::f64::consts::PI;

/// Kinds and how often each is drawn; `mass` and `oscillator` are pairs of blocks.
const KINDS: &str = "
    integrator 10, limited 5, gated 4, reset 4, oscillator 4, mass 4, chain 5, summer 6,
    inverter 1, gain 2, pot 1, multiplier 5, divider 3, square 3, square-root 3, abs 4, min 3,
    max 3, sine 4, cosine 3, arctangent 4, resolver 2, function 4, function-2d 3, dead-zone 4,
    limiter 5, rate-limiter 2, backlash 2, relay 4, lag 3, transport-delay 5, signal-generator 6,
    noise 1, switch 5, track-store 3, comparator 12, logic 5, flip-flop 4, one-shot 4, counter 6,
    dcu 1";

struct Draft {
    random: Random,
    blocks: Vec<Block>,
    /// Greatest magnitude of each block's net, where it is known.
    peaks: Vec<Option<f64>>,
}

/// The patch of a seed.
pub fn patch(seed: u64) -> Patch {
    let mut draft = Draft { random: Random::new(seed), blocks: Vec::new(), peaks: Vec::new() };
    let until_s = draft.random.between(1.2, 3.2);
    draft.draw_kinds();
    for i in 0..draft.blocks.len() {
        draft.wire(i);
    }
    draft.observe();
    Patch { blocks: draft.blocks, until_s }
}

impl Draft {
    fn push(&mut self, kind: &'static str) -> usize {
        let name = format!("n{:02}", self.blocks.len());
        self.blocks.push(Block { name, kind, inputs: Vec::new(), fields: Vec::new() });
        self.peaks.push(None);
        self.blocks.len() - 1
    }

    fn draw_kinds(&mut self) {
        let count = 3 + self.random.below(15);
        let one = self.push("constant");
        self.blocks[one].fields.push(("value", Field::Number(1.0)));
        self.peaks[one] = Some(1.0);
        let first = self.random.pick(&["signal-generator", "signal-generator", "time", "chain"]);
        self.push(first);
        let kinds = KINDS.split(',').map(|kind| kind.trim().split_once(' ').unwrap());
        let urn: Vec<&str> =
            kinds.flat_map(|(kind, often)| vec![kind; often.parse().unwrap()]).collect();
        while self.blocks.len() < count {
            let kind = self.random.pick(&urn);
            let compares = self.blocks.iter().any(|b| b.kind == "comparator");
            match kind {
                "logic" | "flip-flop" | "one-shot" | "counter" if !compares => {
                    self.push("comparator");
                }
                "oscillator" => {
                    self.push("oscillator");
                    self.push("oscillator-rate");
                }
                "mass" => {
                    self.push("dry-friction");
                    self.push("mass");
                }
                "logic" => {
                    let kind = self.random.pick(&["and", "or", "not"]);
                    self.push(kind);
                }
                kind => {
                    self.push(kind);
                }
            }
        }
        // Kinds that are integrators in the end are such for the wires of others, too.
        for block in &mut self.blocks {
            if block.is("limited gated reset oscillator oscillator-rate mass chain") {
                block.fields.push(("ic", Field::Word(block.kind)));
                block.kind = "integrator";
            }
        }
    }

    /// Nets that block `i` may read.
    fn nets(&self, i: usize, logic: bool) -> Vec<String> {
        let store = self.blocks[i].is_store();
        let mut nets = Vec::new();
        for (j, block) in self.blocks.iter().enumerate() {
            if block.is_logic() == logic && (j < i || block.is_store() || (store && j != i)) {
                nets.append(&mut block.nets());
            }
        }
        nets
    }

    fn analog(&mut self, i: usize) -> String {
        let nets = self.nets(i, false);
        // The constant is read less often than what moves.
        let net = self.random.pick(&nets);
        if net == "n00" { self.random.pick(&nets) } else { net }
    }

    /// Whether a net depends on a delay's output within the instant.
    fn is_delayed(&self, net: &str) -> bool {
        let Some(block) = self.blocks.iter().find(|b| b.drives(net)) else {
            return false;
        };
        match block.kind {
            "transport-delay" => true,
            _ if block.is_store() => false,
            _ => block.inputs.iter().any(|t| self.is_delayed(&t.net)),
        }
    }

    fn logic(&mut self, i: usize) -> Option<String> {
        let nets = self.nets(i, true);
        (!nets.is_empty()).then(|| self.random.pick(&nets))
    }

    fn peak(&self, net: &str) -> Option<f64> {
        let block = self.blocks.iter().position(|b| b.name == net)?;
        self.peaks[block]
    }

    fn term(&mut self, i: usize) -> Term {
        let c = if self.random.chance(0.25) { 1.0 } else { self.random.signed(0.3, 1.6) };
        Term { c, net: self.analog(i) }
    }

    fn terms(&mut self, i: usize, most: usize) -> Vec<Term> {
        let count = 1 + self.random.below(most);
        (0..count).map(|_| self.term(i)).collect()
    }

    /// What the weighted sum of the inputs reaches at most, where it is known.
    fn reach(&self, terms: &[Term]) -> Option<f64> {
        terms.iter().map(|t| Some(t.c.abs() * self.peak(&t.net)?)).sum()
    }

    /// A level for what reaches `reach` at most: often close below it.
    fn level(&mut self, reach: Option<f64>) -> f64 {
        match reach {
            Some(reach) if self.random.chance(0.6) => {
                let depth = self.random.decade(3e-5, 0.3);
                let level = reach * (1.0 - depth);
                if self.random.chance(0.5) { level } else { -level }
            }
            _ => self.random.signed(0.0, 1.2),
        }
    }

    fn number(&mut self, i: usize, key: &'static str, low: f64, high: f64) {
        let value = self.random.between(low, high);
        self.set(i, key, Field::Number(value));
    }

    fn set(&mut self, i: usize, key: &'static str, value: Field) {
        self.blocks[i].fields.push((key, value));
    }

    /// A net that is never negative, if there is one.
    fn positive(&mut self, i: usize) -> Option<String> {
        let nets: Vec<String> = self.blocks[..i]
            .iter()
            .filter(|b| b.is("abs square"))
            .map(|b| b.name.clone())
            .collect();
        (!nets.is_empty()).then(|| self.random.pick(&nets))
    }

    fn wire(&mut self, i: usize) {
        let name = self.blocks[i].name.clone();
        match self.blocks[i].kind {
            "constant" | "time" => {}
            "integrator" => self.integrator(i),
            "signal-generator" => self.generator(i),
            "noise" => {
                self.number(i, "every", 0.03, 0.4);
                self.number(i, "sigma", 0.2, 1.0);
                let seed = self.random.below(1000) as u32;
                self.set(i, "seed", Field::Whole(seed));
            }
            "summer" | "inverter" | "gain" | "pot" | "square" | "abs" | "dcu" => {
                let most = if self.blocks[i].kind == "pot" { 1 } else { 3 };
                let inputs = self.terms(i, most);
                let mut reach = self.reach(&inputs);
                match self.blocks[i].kind {
                    "gain" => self.number(i, "k", 0.3, 1.6),
                    "pot" => self.number(i, "k", 0.2, 0.9),
                    "dcu" => {
                        self.number(i, "initial", 0.3, 1.6);
                        self.set(i, "channel", Field::Whole(i as u32));
                    }
                    "square" => reach = reach.map(|r| r * r),
                    _ => {}
                }
                for (key, field) in &self.blocks[i].fields {
                    if let (&("k" | "initial"), Field::Number(k)) = (key, field) {
                        reach = reach.map(|r| r * k);
                    }
                }
                self.blocks[i].inputs = inputs;
                self.peaks[i] = reach;
            }
            "multiplier" | "min" | "max" => {
                self.blocks[i].inputs = vec![self.term(i), self.term(i)];
            }
            "sine" | "cosine" => {
                let mut inputs = self.terms(i, 2);
                for term in &mut inputs {
                    // Of time or an angle up to some turns a second; round a delay it would
                    // fold the past ever finer.
                    let turns = self.random.decade(1.0, 15.0);
                    term.c *= if self.is_delayed(&term.net) { 0.7 } else { turns };
                }
                self.blocks[i].inputs = inputs;
                self.peaks[i] = Some(1.0);
            }
            "arctangent" => {
                let mut inputs = vec![self.term(i), self.term(i)];
                if inputs[0].net == inputs[1].net {
                    // A vector along one line has no angle where it turns back.
                    inputs[1].net = "n00".into();
                }
                self.blocks[i].inputs = inputs;
            }
            "resolver" => {
                let mut inputs = vec![self.term(i), self.term(i), self.term(i)];
                let turns = self.random.decade(1.0, 6.0);
                if !self.is_delayed(&inputs[2].net) {
                    inputs[2].c *= turns;
                }
                self.blocks[i].inputs = inputs;
            }
            "divider" => {
                self.blocks[i].inputs = vec![self.term(i), self.offset(i, 0.15)];
            }
            "square-root" => {
                self.blocks[i].inputs = vec![self.offset(i, 0.15)];
            }
            "function" => {
                let inputs = self.terms(i, 2);
                let reach = self.reach(&inputs);
                let mut x = vec![self.level(reach), self.random.signed(0.0, 1.0)];
                for _ in 0..self.random.below(3) {
                    x.push(self.random.signed(0.0, 2.0));
                }
                x.sort_by(f64::total_cmp);
                let y = x.iter().map(|_| self.random.signed(0.0, 1.5)).collect();
                self.blocks[i].inputs = inputs;
                self.set(i, "x", Field::List(x));
                self.set(i, "y", Field::List(y));
            }
            "function-2d" => {
                let inputs = vec![self.term(i), self.term(i)];
                for (key, input) in [("x", 0), ("y", 1)] {
                    let reach = self.reach(&inputs[input..=input]);
                    let mut points = vec![
                        self.level(reach),
                        self.random.signed(0.0, 1.0),
                        self.random.signed(0.5, 2.0),
                    ];
                    points.sort_by(f64::total_cmp);
                    self.set(i, key, Field::List(points));
                }
                let z = (0..3)
                    .map(|_| (0..3).map(|_| self.random.signed(0.0, 1.5)).collect())
                    .collect();
                self.set(i, "z", Field::Table(z));
                self.blocks[i].inputs = inputs;
            }
            "dead-zone" | "limiter" => {
                let inputs = self.terms(i, 2);
                let reach = self.reach(&inputs);
                self.blocks[i].inputs = inputs;
                let limiter = self.blocks[i].kind == "limiter";
                let key = if limiter { "limit" } else { "width" };
                let net = self.positive(i).filter(|_| self.random.chance(0.3));
                if let Some(net) = net {
                    self.set(i, key, Field::Net(net));
                } else if limiter && self.random.chance(0.5) {
                    let low = self.random.between(-1.0, 0.3);
                    let high = self.level(reach).abs().max(low + 0.1);
                    self.set(i, "limits", Field::List(vec![low, high]));
                } else {
                    let level = self.level(reach).abs().max(0.01);
                    self.set(i, key, Field::Number(level));
                }
            }
            "rate-limiter" | "backlash" => {
                self.blocks[i].inputs = self.terms(i, 2);
                if self.blocks[i].kind == "backlash" {
                    self.number(i, "width", 0.05, 0.6);
                } else {
                    self.number(i, "rate", 0.3, 3.0);
                }
                self.number(i, "tau", 0.02, 0.1);
                self.number(i, "ic", -0.5, 0.5);
            }
            "dry-friction" => {
                // The mass stands next and reads this block and the same force.
                let force = self.term(i);
                let reach = self.reach(std::slice::from_ref(&force));
                let level = self.level(reach).abs().max(0.02);
                self.set(i, "level", Field::Number(level));
                if self.random.chance(0.3) {
                    let breakaway = level * self.random.between(1.0, 1.4);
                    self.set(i, "breakaway", Field::Number(breakaway));
                }
                let velocity = Term { c: 1.0, net: self.blocks[i + 1].name.clone() };
                self.blocks[i].inputs = vec![velocity, force];
            }
            "relay" => {
                let inputs = self.terms(i, 2);
                let reach = self.reach(&inputs);
                let high = self.level(reach);
                let low = high - self.random.decade(0.02, 0.8);
                let outputs = vec![self.random.signed(0.0, 1.5), self.random.signed(0.0, 1.5)];
                let on = self.random.chance(0.5);
                self.blocks[i].inputs = inputs;
                self.set(i, "points", Field::List(vec![low, high]));
                self.set(i, "outputs", Field::List(outputs));
                self.set(i, "initially-on", Field::Flag(on));
            }
            "lag" => {
                self.blocks[i].inputs = self.terms(i, 2);
                self.number(i, "tau", 0.05, 1.0);
                self.number(i, "ic", -1.0, 1.0);
            }
            "transport-delay" => {
                let mut inputs = self.terms(i, 2);
                for term in &mut inputs {
                    // A closed path of delays alone must not grow.
                    term.c *= 0.4;
                }
                self.blocks[i].inputs = inputs;
                let delay = self.random.decade(0.1, 1.2);
                self.set(i, "delay", Field::Number(delay));
                self.number(i, "initial", -0.5, 0.5);
            }
            "switch" | "track-store" => {
                let Some(control) = self.logic(i) else {
                    self.blocks[i].kind = "summer";
                    self.blocks[i].inputs = self.terms(i, 2);
                    return;
                };
                if self.blocks[i].kind == "switch" {
                    self.blocks[i].inputs = vec![self.term(i), self.term(i)];
                    self.set(i, "control", Field::Net(control));
                } else {
                    self.blocks[i].inputs = self.terms(i, 2);
                    self.set(i, "track", Field::Net(control));
                    self.number(i, "ic", -1.0, 1.0);
                }
            }
            "comparator" => {
                let inputs = self.terms(i, 2);
                let reach = self.reach(&inputs);
                let level = self.level(reach);
                self.blocks[i].inputs = inputs;
                self.set(i, "threshold", Field::Number(level));
                if self.random.chance(0.4) {
                    let hysteresis = self.random.decade(0.01, 0.4);
                    self.set(i, "hysteresis", Field::Number(hysteresis));
                }
            }
            "and" | "or" | "not" | "flip-flop" | "one-shot" | "counter" => self.logical(i),
            other => unreachable!("{name}: {other}"),
        }
    }

    /// An input that stays clear of zero, but with probability `bare`.
    fn offset(&mut self, i: usize, bare: f64) -> Term {
        let term = self.term(i);
        if self.random.chance(bare) {
            return term;
        }
        // 1 + x² of any x, as blocks put in before this one cannot be: by an absolute value.
        match self.positive_sum(i) {
            Some(net) => Term { c: 1.0, net },
            None => Term { c: self.random.between(0.5, 2.0), net: "n00".into() },
        }
    }

    /// A sum of the constant and an absolute value or a sine that are already there.
    fn positive_sum(&mut self, i: usize) -> Option<String> {
        let name = format!("p{i:02}");
        let (net, low, high) = match self.positive(i) {
            Some(net) => (net, 0.3, 1.6),
            None => {
                let known: Vec<String> = (0..i)
                    .filter(|j| self.peaks[*j].is_some() && *j > 0)
                    .map(|j| self.blocks[j].name.clone())
                    .collect();
                if known.is_empty() {
                    return None;
                }
                (self.random.pick(&known), 0.0, 0.0)
            }
        };
        let c = if high > 0.0 {
            self.random.between(low, high)
        } else {
            0.95 / self.peak(&net)?.max(0.1)
        };
        let base = if high > 0.0 { self.random.decade(0.05, 1.0) } else { 1.0 };
        self.blocks.push(Block {
            name: name.clone(),
            kind: "summer",
            inputs: vec![Term { c: base, net: "n00".into() }, Term { c, net }],
            fields: Vec::new(),
        });
        self.peaks.push(None);
        Some(name)
    }

    fn generator(&mut self, i: usize) {
        let wave = self.random.pick(&["sine", "sine", "sine", "sine", "square", "ramp", "step"]);
        self.set(i, "wave", Field::Word(wave));
        let amplitude = self.random.signed(0.4, 1.5);
        self.set(i, "amplitude", Field::Number(amplitude));
        match wave {
            "sine" | "square" => {
                let frequency = self.random.decade(0.3, 8.0);
                self.set(i, "frequency", Field::Number(frequency));
                self.number(i, "phase", -PI, PI);
                self.peaks[i] = Some(amplitude.abs());
            }
            _ => self.number(i, "start", 0.0, 1.0),
        }
    }

    fn integrator(&mut self, i: usize) {
        let name = self.blocks[i].name.clone();
        let form = match self.blocks[i].fields.pop() {
            Some((_, Field::Word(form))) => form,
            _ => "integrator",
        };
        let ic = self.random.signed(0.0, 1.0);
        let this = |c: f64| Term { c, net: name.clone() };
        let neighbour =
            |draft: &Draft, j: usize, c: f64| Term { c, net: draft.blocks[j].name.clone() };
        match form {
            "oscillator" => {
                // Its partner's rate is drawn here and read there.
                let w = self.random.decade(2.0, 40.0);
                let rate = neighbour(self, i + 1, w);
                self.blocks[i].inputs = vec![rate];
            }
            "oscillator-rate" => {
                let w = self.blocks[i - 1].inputs[0].c;
                let back = neighbour(self, i - 1, -w);
                let mut inputs = vec![back];
                if self.random.chance(0.6) {
                    inputs.push(this(-w * self.random.between(0.0, 0.4)));
                }
                if self.random.chance(0.5) {
                    inputs.push(self.term(i));
                }
                self.blocks[i].inputs = inputs;
            }
            "mass" => {
                let drag = neighbour(self, i - 1, 1.0);
                let force = self.blocks[i - 1].inputs[1].clone();
                self.blocks[i].inputs = vec![force, drag];
                if self.random.chance(0.4) {
                    self.set(i, "ic", Field::Number(0.0));
                    return;
                }
            }
            "chain" => {
                // Of a constant, or of an earlier one: polynomials of time.
                let earlier: Vec<String> = self.blocks[..i]
                    .iter()
                    .filter(|b| b.kind == "integrator" && b.inputs.len() == 1)
                    .map(|b| b.name.clone())
                    .collect();
                let net = if earlier.is_empty() || self.random.chance(0.3) {
                    "n00".to_string()
                } else {
                    self.random.pick(&earlier)
                };
                let c = self.random.signed(0.3, 1.6);
                self.blocks[i].inputs = vec![Term { c, net }];
            }
            _ => {
                let mut inputs = self.terms(i, 2);
                if self.random.chance(0.75) {
                    inputs.push(this(-self.random.decade(0.3, 6.0)));
                }
                self.blocks[i].inputs = inputs;
            }
        }
        self.set(i, "ic", Field::Number(ic));
        if form == "limited" {
            let (low, high) = (self.random.between(0.05, 0.8), self.random.between(0.05, 0.8));
            let ic = ic.clamp(-low, high);
            self.blocks[i].fields[0].1 = Field::Number(ic);
            self.set(i, "limits", Field::List(vec![-low, high]));
        }
        let both = form == "limited" && self.random.chance(0.2);
        if (form == "gated" || both)
            && let Some(net) = self.logic(i)
        {
            self.set(i, "operate", Field::Net(net));
        }
        if (form == "reset" || both)
            && let Some(net) = self.logic(i)
        {
            self.set(i, "reset", Field::Net(net));
            if self.random.chance(0.5) {
                let to = Term { c: self.random.signed(0.2, 0.9), net: self.analog(i) };
                self.set(i, "reset-to", Field::Term(to));
            }
        }
    }

    fn logical(&mut self, i: usize) {
        let wire = |net: String| Term { c: 1.0, net };
        // A comparator stands before the first of these.
        let first = self.logic(i).expect("a comparator");
        let second = self.logic(i).expect("a comparator");
        let reset = self.random.chance(0.3);
        self.blocks[i].inputs = match self.blocks[i].kind {
            "not" | "one-shot" => vec![wire(first)],
            "counter" if !reset => vec![wire(first)],
            _ => vec![wire(first), wire(second)],
        };
        match self.blocks[i].kind {
            "flip-flop" => {
                let initial = self.random.chance(0.5);
                self.set(i, "initial", Field::Flag(initial));
            }
            "one-shot" => {
                let width = self.random.decade(0.01, 0.6);
                self.set(i, "width", Field::Number(width));
            }
            "counter" if self.random.chance(0.3) => {
                let modulo = 2 + self.random.below(4) as u32;
                self.set(i, "modulo", Field::Whole(modulo));
            }
            _ => {}
        }
    }

    /// Integrals of what would otherwise leave no trace in the final values.
    fn observe(&mut self) {
        let blocks = self.blocks.clone();
        let mut add = |name: String, kind, inputs, fields| {
            self.blocks.push(Block { name, kind, inputs, fields });
        };
        let wire = |net: &str| Term { c: 1.0, net: net.into() };
        for block in blocks.iter().filter(|b| b.is_logic()).take(4) {
            let (name, gate) = (&block.name, format!("g_{}", block.name));
            let control = vec![("control", Field::Net(name.clone()))];
            let both = vec![wire("n00"), Term { c: -1.0, net: "n00".into() }];
            add(gate.clone(), "switch", both, control);
            add(format!("d_{name}"), "integrator", vec![wire(&gate)], Vec::new());
            add(format!("c_{name}"), "counter", vec![wire(name)], Vec::new());
        }
        let moving = "limiter dead-zone function function-2d relay min max abs transport-delay \
                      arctangent track-store";
        for block in blocks.iter().filter(|b| b.is(moving)).take(3) {
            add(format!("i_{}", block.name), "integrator", vec![wire(&block.name)], Vec::new());
        }
    }
}
