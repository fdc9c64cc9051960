//! Instances of patch files: which names mean what, where.
//!
//! The root file is one scope, and each use of a sub-patch is another, with its
//! own prefix, parameters and port bindings. A sub-patch sees only what it is
//! given: its parameters and its ports.

use super::diagnostic::Flaw;
use super::expression::parse;
use super::faults::Faults;
use super::number::{not_finite, number};
use super::text::{PatchText, UseText};
use crate::net::Span;
use desk::bundle::join;
use desk::faults::suggestion;
use desk::reader::{Data, Entry};
use std::collections::{HashMap, HashSet};

/// Most blocks, and most instances, of one patch. The largest hybrid machines had a thousand or two.
pub const MOST_BLOCKS: usize = 100_000;
/// Deepest nesting of sub-patches.
pub const DEEPEST: usize = 32;

/// One instance of a file.
#[derive(Debug)]
pub(crate) struct Scope {
    /// Index of the file.
    pub(crate) file: u32,
    /// Prefix of its nets: empty, or `gyro.`.
    pub(crate) prefix: String,
    /// Parameters; `None` where the value is faulty.
    pub(crate) params: HashMap<String, Option<f64>>,
    /// Scope that the bindings are written in.
    pub(crate) parent: usize,
    /// Binding of each port; `None` where it is faulty or missing.
    pub(crate) ports: HashMap<String, Option<Entry>>,
}

/// A block of a file in a scope.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stub {
    pub(crate) scope: usize,
    pub(crate) index: usize,
}

/// All instances of a patch.
#[derive(Debug, Default)]
pub(crate) struct Instances {
    pub(crate) scopes: Vec<Scope>,
    pub(crate) stubs: Vec<Stub>,
    /// Prefixes of instances that could not be made; their nets are not reported again.
    pub(crate) dead: HashSet<String>,
    pub(crate) is_too_large: bool,
}

/// Makes all instances, the root's first.
pub(crate) fn expand(
    names: &HashMap<&str, u32>,
    texts: &[PatchText],
    root: u32,
    overrides: &[(String, f64)],
    faults: &mut Faults,
) -> Instances {
    let mut expander =
        Expander { names, texts, out: Instances::default(), stack: Vec::new(), faults };
    let text = &texts[root as usize];
    let given = expander.root_overrides(root, text, overrides);
    let ports = expander.unbound_root_ports(root, text);
    expander.instantiate(root, String::new(), 0, given, ports);
    expander.out
}

struct Expander<'a> {
    names: &'a HashMap<&'a str, u32>,
    texts: &'a [PatchText],
    out: Instances,
    stack: Vec<u32>,
    faults: &'a mut Faults,
}

type Given = HashMap<String, Option<f64>>;

impl Expander<'_> {
    fn root_overrides(&mut self, root: u32, text: &PatchText, given: &[(String, f64)]) -> Given {
        let top = Span { file: root, ..Span::default() };
        let mut out = Given::new();
        for (name, value) in given {
            let own = text.params.iter().find(|p| p.key == *name);
            let at = own.or(text.params.first()).map_or(top, |p| p.key_span);
            if own.is_none() {
                let help = suggestion(name, text.params.iter().map(|p| p.key.as_str()));
                self.faults.push(at, Flaw::UnknownParam { param: name.clone() }, help);
            } else if !value.is_finite() {
                not_finite(name, at, self.faults);
            }
            out.insert(name.clone(), Some(*value).filter(|v| v.is_finite()));
        }
        out
    }

    /// Tells of each port once; what reads it is no further fault.
    fn unbound_root_ports(
        &mut self,
        root: u32,
        text: &PatchText,
    ) -> HashMap<String, Option<Entry>> {
        for (port, at) in &text.ports {
            let file = self.faults.sources.name(root).to_owned();
            let help = format!(
                "this file is a sub-patch: use it from another patch, with u = {{ patch = \"{file}\", in = {{ {port} = \"NET\" }} }} under [use]"
            );
            self.faults.push(*at, Flaw::UnboundPort { port: port.clone(), file }, help);
        }
        let unbound = |(port, _): &(String, Span)| (port.clone(), None);
        text.ports.iter().map(unbound).collect()
    }

    fn instantiate(
        &mut self,
        file: u32,
        prefix: String,
        parent: usize,
        given: Given,
        ports: HashMap<String, Option<Entry>>,
    ) {
        let text = &self.texts[file as usize];
        let params = self.own_params(text, &given);
        self.check_names(text);
        let scope = self.out.scopes.len();
        self.out.scopes.push(Scope { file, prefix, params, parent, ports });
        self.stack.push(file);
        // Uses and blocks in the order in which they stand.
        let mut lines: Vec<(u32, Result<usize, usize>)> = Vec::new();
        lines.extend(text.uses.iter().enumerate().map(|(i, u)| (u.span.start, Err(i))));
        lines.extend(text.blocks.iter().enumerate().map(|(i, b)| (b.span.start, Ok(i))));
        lines.sort_unstable_by_key(|line| line.0);
        for (_, line) in lines {
            let at = match line {
                Ok(index) => {
                    self.out.stubs.push(Stub { scope, index });
                    text.blocks[index].span
                }
                Err(index) => {
                    self.use_one(scope, &text.uses[index]);
                    text.uses[index].span
                }
            };
            self.check_size(at);
            if self.out.is_too_large {
                break;
            }
        }
        self.stack.pop();
    }

    /// The parameters of a file, each after those that it is made of.
    fn own_params(&mut self, text: &PatchText, given: &Given) -> HashMap<String, Option<f64>> {
        let all = &text.params;
        let index: HashMap<&str, usize> =
            all.iter().enumerate().map(|(i, param)| (param.key.as_str(), i)).collect();
        let made_of = |i: usize| match &all[i].value.data {
            Data::Text(text) => parse(text).map_or_else(|_| Vec::new(), |e| e.names()),
            _ => Vec::new(),
        };
        let mut params = HashMap::new();
        let mut seen = vec![false; all.len()];
        // A parameter on its way, and what it is made of that was not looked at yet.
        let mut way: Vec<(usize, Vec<&str>)> = Vec::new();
        for first in 0..all.len() {
            if !std::mem::replace(&mut seen[first], true) {
                way.push((first, made_of(first)));
            }
            while let Some((at, rest)) = way.last_mut() {
                let at = *at;
                let Some(next) = rest.pop().and_then(|name| index.get(name).copied()) else {
                    if !rest.is_empty() {
                        continue;
                    }
                    way.pop();
                    let param = &all[at];
                    // Evaluated even where it is overridden, so that a faulty line does not hide.
                    let own = number(&param.key, &param.value, &params, self.faults);
                    let value = given.get(&param.key).copied().unwrap_or(own);
                    params.insert(param.key.clone(), value);
                    continue;
                };
                if !std::mem::replace(&mut seen[next], true) {
                    way.push((next, made_of(next)));
                } else if let Some(from) = way.iter().position(|(open, _)| *open == next) {
                    let circle = way[from..].iter().map(|(i, _)| *i).chain([next]);
                    let chain: Vec<String> = circle.map(|i| format!("`{}`", all[i].key)).collect();
                    let help = "give one of them a number of its own";
                    let flaw = Flaw::ParamCircle { chain: chain.join(" → ") };
                    self.faults.push(all[at].value.span, flaw, help);
                    params.insert(all[next].key.clone(), None);
                }
            }
        }
        params
    }

    fn check_size(&mut self, at: Span) {
        let size = self.out.stubs.len().max(self.out.scopes.len());
        if size > MOST_BLOCKS && !self.out.is_too_large {
            self.out.is_too_large = true;
            self.too_large(at, "blocks", MOST_BLOCKS);
        }
    }

    fn too_large(&mut self, at: Span, what: &'static str, limit: usize) {
        let help = "sub-patches that use sub-patches multiply; check how often each is used";
        self.faults.push(at, Flaw::TooLarge { what, limit }, help);
    }

    fn use_one(&mut self, scope: usize, instance: &UseText) {
        let prefix = format!("{}{}.", self.out.scopes[scope].prefix, instance.name);
        let Some(file) = self.find(instance) else {
            self.out.dead.insert(prefix);
            return;
        };
        if self.stack.len() >= DEEPEST {
            self.too_large(instance.span, "levels of sub-patches", DEEPEST);
            self.out.dead.insert(prefix);
            return;
        }
        let given = self.given_params(scope, instance, file);
        let ports = self.bindings(instance, file);
        self.instantiate(file, prefix, scope, given, ports);
    }

    fn find(&mut self, instance: &UseText) -> Option<u32> {
        let (path, at) = instance.path.as_ref()?;
        let user = self.faults.sources.name(at.file).to_owned();
        let key = join(&user, path);
        let Some(&file) = key.as_deref().and_then(|key| self.names.get(key)) else {
            let why = if key.is_some() {
                "it is not there, or is not a text file"
            } else {
                "it must be a path relative to this file"
            };
            let help = suggestion(path, self.names.keys().copied());
            let help = format!("the path is taken from the folder of `{user}`; {help}");
            self.faults.push(*at, Flaw::MissingFile { file: path.clone(), why: why.into() }, help);
            return None;
        };
        if let Some(from) = self.stack.iter().position(|f| *f == file) {
            let mut chain: Vec<String> = self.stack[from..]
                .iter()
                .chain([&file])
                .map(|f| format!("`{}`", self.faults.sources.name(*f)))
                .collect();
            if chain.len() == 2 {
                chain.truncate(1);
                chain.push("itself".into());
            }
            let help = "a sub-patch is wired in, not called: it cannot contain itself";
            self.faults.push(*at, Flaw::RecursiveUse { chain: chain.join(" → ") }, help);
            return None;
        }
        Some(file).filter(|f| self.texts[*f as usize].is_toml)
    }

    fn given_params(&mut self, scope: usize, instance: &UseText, file: u32) -> Given {
        let known = &self.texts[file as usize].params;
        let mut given = Given::new();
        for entry in &instance.with {
            let params = &self.out.scopes[scope].params;
            let value = number(&entry.key, &entry.value, params, self.faults);
            if !known.iter().any(|p| p.key == entry.key) {
                let name = self.faults.sources.name(file).to_owned();
                let help = suggestion(&entry.key, known.iter().map(|p| p.key.as_str()));
                let help = format!("in `{name}`: {help}");
                self.faults.push(
                    entry.key_span,
                    Flaw::UnknownParam { param: entry.key.clone() },
                    help,
                );
            }
            given.insert(entry.key.clone(), value);
        }
        given
    }

    fn bindings(&mut self, instance: &UseText, file: u32) -> HashMap<String, Option<Entry>> {
        let text = &self.texts[file as usize];
        let name = self.faults.sources.name(file).to_owned();
        let mut bound: HashMap<String, Option<Entry>> = HashMap::new();
        for entry in &instance.inputs {
            if text.ports.iter().any(|(port, _)| *port == entry.key) {
                bound.insert(entry.key.clone(), Some(entry.clone()));
                continue;
            }
            let help = suggestion(&entry.key, text.ports.iter().map(|(port, _)| port.as_str()));
            self.faults.push(
                entry.key_span,
                Flaw::UnknownPort { port: entry.key.clone(), file: name.clone() },
                help,
            );
        }
        for (port, _) in &text.ports {
            if !bound.contains_key(port) {
                bound.insert(port.clone(), None);
                let help = format!("bind it to a net of this patch: in = {{ {port} = \"NET\" }}");
                self.faults.push(
                    instance.span,
                    Flaw::UnboundPort { port: port.clone(), file: name.clone() },
                    help,
                );
            }
        }
        bound
    }

    /// Parameters, ports, instances and blocks of a file share one space of names.
    fn check_names(&mut self, text: &PatchText) {
        let params: HashMap<&str, Span> =
            text.params.iter().map(|p| (p.key.as_str(), p.key_span)).collect();
        let mut nets: HashMap<&str, Span> = HashMap::new();
        let ports = text.ports.iter().map(|(name, at)| (name.as_str(), *at));
        let uses = text.uses.iter().map(|u| (u.name.as_str(), u.span));
        let blocks = text.blocks.iter().map(|b| (b.name.as_str(), b.span));
        for (name, at) in ports.chain(uses).chain(blocks) {
            if let Some(first) = params.get(name) {
                let help = "in `k * x` nobody could tell them apart: rename one";
                self.faults.push_beside(
                    at,
                    Flaw::ParamNetClash { name: name.to_owned() },
                    help,
                    &[*first],
                );
            }
            if let Some(first) = nets.insert(name, at) {
                let help =
                    "ports, sub-patches and blocks of a file share one space of names: rename one";
                self.faults.push_beside(
                    at,
                    Flaw::DuplicateName { name: name.to_owned() },
                    help,
                    &[first],
                );
            }
        }
    }
}
