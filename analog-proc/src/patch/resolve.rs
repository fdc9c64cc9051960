//! Second stage: from texts to the typed net, names resolved and numbers put in.
//!
//! A block with a fault stays in the draft as broken, with whatever of it could
//! be understood, so that the later stages can look at the rest of the patch
//! without repeating the fault. A draft with faults is never ordered.

mod inputs;

use super::diagnostic::Flaw;
use super::faults::Faults;
use super::fields::Fields;
use super::scope::{self, Instances, Stub};
use super::settings;
use super::text::{BlockText, PatchText};
use crate::block::kind::{self, Constant, Storage};
use crate::net::{Block, Expected, Input, Kind, Net, Netlist, Span};
use desk::faults::suggestion;
use desk::reader::{Board, Data, Entry};
use engine::{
    id::{BlockId, NetId},
    integration::Integration,
};
use inputs::inputs_of;
use std::collections::HashMap;

/// A net that has not been checked.
#[derive(Debug)]
pub(crate) struct Draft {
    pub(crate) netlist: Netlist,
    /// Blocks with a fault of their own; their kind is a stand-in.
    pub(crate) broken: Vec<bool>,
    /// Comments on blocks.
    pub(crate) notes: Vec<(BlockId, String)>,
}

/// Resolves all names of a patch.
pub(crate) fn resolve(
    names: &HashMap<&str, u32>,
    texts: &[PatchText],
    root: u32,
    overrides: &[(String, f64)],
    faults: &mut Faults,
) -> Option<Draft> {
    let instances = scope::expand(names, texts, root, overrides, faults);
    if instances.is_too_large {
        return None;
    }
    let mut resolver = Resolver::new(instances, texts, faults);
    resolver.bind_ports();
    let mut blocks = Vec::with_capacity(resolver.instances.stubs.len());
    let mut broken = Vec::with_capacity(blocks.capacity());
    let mut notes = Vec::new();
    for index in 0..resolver.instances.stubs.len() {
        let made = resolver.block(index);
        let id = BlockId(u32::try_from(index).unwrap_or(u32::MAX));
        notes.extend(made.note.map(|note| (id, note)));
        blocks.push(made.block);
        broken.push(made.is_broken);
    }
    broken.resize(blocks.len() + resolver.hidden.len(), false);
    let integration = resolver.integration(&texts[root as usize].integration);
    let expected = resolver.expected(&texts[root as usize].expect);
    let params = texts[root as usize]
        .params
        .iter()
        .filter_map(|p| {
            let value = *resolver.instances.scopes[0].params.get(&p.key)?;
            Some((p.key.clone(), value?))
        })
        .collect();
    blocks.append(&mut resolver.hidden);
    let title = texts[root as usize].title.clone().unwrap_or_else(|| {
        let name = resolver.faults.sources.name(root);
        name.trim_end_matches(".toml").to_owned()
    });
    Some(Draft {
        netlist: Netlist { title, blocks, nets: resolver.nets, integration, expected, params },
        broken,
        notes,
    })
}

struct Made {
    block: Block,
    is_broken: bool,
    note: Option<String>,
}

/// A net with the coefficient under which a name stands for it.
type Weighted = (NetId, f64);

pub(crate) struct Resolver<'a> {
    texts: &'a [PatchText],
    pub(crate) faults: &'a mut Faults,
    pub(crate) instances: Instances,
    /// The scope whose fields are being read.
    pub(crate) scope: usize,
    nets: Vec<Net>,
    by_name: HashMap<String, NetId>,
    /// First net of each stub.
    first_net: Vec<NetId>,
    /// Resolved bindings of each scope's ports.
    bound: Vec<HashMap<String, Option<Weighted>>>,
    /// Blocks that a field makes, such as the inverter of a symmetric limiter.
    hidden: Vec<Block>,
}

impl<'a> Resolver<'a> {
    fn new(instances: Instances, texts: &'a [PatchText], faults: &'a mut Faults) -> Self {
        let mut resolver = Resolver {
            texts,
            faults,
            nets: Vec::with_capacity(instances.stubs.len()),
            by_name: HashMap::with_capacity(instances.stubs.len()),
            first_net: Vec::with_capacity(instances.stubs.len()),
            bound: Vec::with_capacity(instances.scopes.len()),
            hidden: Vec::new(),
            scope: 0,
            instances,
        };
        for index in 0..resolver.instances.stubs.len() {
            let (text, name) = resolver.stub(index);
            let driver = BlockId(u32::try_from(index).unwrap_or(u32::MAX));
            resolver.first_net.push(NetId(u32::try_from(resolver.nets.len()).unwrap_or(u32::MAX)));
            let ends = outputs(text);
            for end in ends {
                resolver.add_net(format!("{name}.{end}"), driver);
            }
            if ends.is_empty() {
                resolver.add_net(name, driver);
            }
        }
        resolver
    }

    fn add_net(&mut self, name: String, driver: BlockId) -> NetId {
        let id = NetId(u32::try_from(self.nets.len()).unwrap_or(u32::MAX));
        self.by_name.insert(name.clone(), id);
        self.nets.push(Net { name, driver });
        id
    }

    /// Text and full name of a stub.
    fn stub(&self, index: usize) -> (&'a BlockText, String) {
        let Stub { scope, index } = self.instances.stubs[index];
        let scope = &self.instances.scopes[scope];
        let text = &self.texts[scope.file as usize].blocks[index];
        (text, format!("{}{}", scope.prefix, text.name))
    }

    /// Binds ports from the root downwards, so that a binding may name a port of its own scope.
    fn bind_ports(&mut self) {
        for index in 0..self.instances.scopes.len() {
            let parent = self.instances.scopes[index].parent;
            let mut ports: Vec<(String, Option<Entry>)> =
                self.instances.scopes[index].ports.drain().collect();
            ports.sort_by(|a, b| a.0.cmp(&b.0));
            let bound = ports
                .into_iter()
                .map(|(port, entry)| {
                    let input = entry.and_then(|e| self.input(parent, &e.key, &e.value));
                    (port, input.map(|i| (i.net, i.coefficient)))
                })
                .collect();
            self.bound.push(bound);
        }
    }

    /// Parameters of the scope being read.
    pub(crate) fn params(&self) -> &HashMap<String, Option<f64>> {
        &self.instances.scopes[self.scope].params
    }

    /// Makes a block that a field needs, and gives its net.
    pub(crate) fn hide(&mut self, name: String, span: Span, kind: Kind, input: Input) -> NetId {
        let index = self.instances.stubs.len() + self.hidden.len();
        let net = self.add_net(name.clone(), BlockId(u32::try_from(index).unwrap_or(u32::MAX)));
        self.hidden.push(Block {
            name,
            span,
            kind,
            inputs: vec![input],
            outputs: vec![net],
            max: None,
        });
        net
    }

    fn block(&mut self, index: usize) -> Made {
        let (text, name) = self.stub(index);
        let scope = self.instances.stubs[index].scope;
        let before = self.faults.count();
        let (mut kind, mut inputs, mut max, mut note) = (None, Vec::new(), None, None);
        if let Some((word, word_span)) = &text.kind {
            let mut fields = Fields::new(self, scope, &name, text.span, &text.fields);
            match kind::named(word) {
                None => {
                    let help = suggestion(word, kind::KINDS.iter().map(|(facts, _)| facts.name));
                    fields.board.faults.push(
                        *word_span,
                        Flaw::UnknownKind { kind: word.clone() },
                        help,
                    );
                }
                Some((facts, read)) => {
                    inputs = inputs_of(&mut fields, facts.inputs, word);
                    max = fields.maybe("max", |f| f.positive("max", None));
                    note = fields.text_or_none("note");
                    kind = read(&mut fields);
                    fields.finish(&format!("{} `{name}`", article(word)));
                }
            }
        }
        let is_broken = kind.is_none() || self.faults.count() > before;
        let first = self.first_net[index];
        let outputs = (0..outputs(text).len().max(1)).map(|i| NetId(first.0 + i as u32)).collect();
        Made {
            block: Block {
                name,
                span: text.span,
                kind: kind.unwrap_or(Kind::Constant(Constant { value: 0.0 })),
                inputs,
                outputs,
                max,
            },
            is_broken,
            note,
        }
    }

    fn integration(&mut self, entries: &[Entry]) -> Integration {
        let mut fields = Fields::new(self, 0, "[integration]", Span::default(), entries);
        let integration = settings::integration(&mut fields);
        fields.finish("[integration]");
        integration.unwrap_or_default()
    }

    fn expected(&mut self, entries: &[Entry]) -> Vec<Expected> {
        let mut out = Vec::new();
        for entry in entries {
            let Data::Table(table) = &entry.value.data else {
                self.faults.wrong_type(
                    &entry.key,
                    "a table such as { output = 1.0, tolerance = 1e-9 }",
                    &entry.value,
                );
                continue;
            };
            let net = self.net(0, &entry.key, entry.key_span);
            let mut fields = Fields::new(self, 0, &entry.key, entry.key_span, table);
            let output = fields.maybe("output", |f| f.number("output", None));
            let derivative = fields.maybe("derivative", |f| f.number("derivative", None));
            let tolerance = fields.positive("tolerance", Some(1e-9));
            let wants_derivative = fields.place("derivative");
            fields.finish(&format!("[expect] of `{}`", entry.key));
            let Some(((net, _), tolerance)) = net.zip(tolerance) else {
                continue;
            };
            if let Some(at) = wants_derivative {
                self.check_has_derivative(net, &entry.key, at);
            }
            out.push(Expected { net, output, derivative, tolerance });
        }
        out
    }

    fn check_has_derivative(&mut self, net: NetId, name: &str, at: Span) {
        let driver = self.nets[net.index()].driver.index();
        if driver >= self.instances.stubs.len() {
            return;
        }
        let (text, _) = self.stub(driver);
        let has = text.kind.as_ref().is_none_or(|(word, _)| {
            kind::named(word).is_some_and(|(facts, _)| facts.storage == Storage::State)
        });
        if !has {
            let help = "integrators, lags, rate limiters and backlashes have derivatives; check the output of other blocks";
            self.faults.push(at, Flaw::NoDerivative { net: name.to_owned() }, help);
        }
    }
}

/// Ends of the names of a block's nets, where it drives several.
fn outputs(text: &BlockText) -> &'static [&'static str] {
    let kind = text.kind.as_ref().and_then(|(word, _)| kind::named(word));
    kind.map_or(&[], |(facts, _)| facts.outputs)
}

fn article(kind: &str) -> String {
    let vowel = kind.starts_with(['a', 'e', 'i', 'o']);
    format!("{} {kind}", if vowel { "an" } else { "a" })
}
