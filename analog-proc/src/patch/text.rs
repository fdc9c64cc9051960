//! First stage: one file's text, its sections and lines with their places.
//!
//! Knows the shape of a file (which sections there are, and that a block is a
//! table with a kind), and nothing of what kinds mean or which nets exist. A
//! file that is not TOML goes no further, since half-read lines would only
//! breed false faults.

use super::diagnostic::Flaw;
use super::expression::is_name;
use super::faults::Faults;
use crate::net::Span;
use desk::reader::{Board, Data, Entry, Fields, FileKind, entries, span};
use toml::de::DeTable;

/// One patch file.
#[derive(Clone, Debug, Default)]
pub(crate) struct PatchText {
    pub(crate) title: Option<String>,
    pub(crate) params: Vec<Entry>,
    pub(crate) uses: Vec<UseText>,
    pub(crate) ports: Vec<(String, Span)>,
    pub(crate) blocks: Vec<BlockText>,
    pub(crate) integration: Vec<Entry>,
    pub(crate) expect: Vec<Entry>,
    /// Whether the file could be read as the TOML of a patch.
    pub(crate) is_toml: bool,
}

/// One instance of a sub-patch.
#[derive(Clone, Debug)]
pub(crate) struct UseText {
    pub(crate) name: String,
    pub(crate) span: Span,
    /// `None` where it is missing or not a string (a fault already).
    pub(crate) path: Option<(String, Span)>,
    pub(crate) inputs: Vec<Entry>,
    pub(crate) with: Vec<Entry>,
}

/// One block, its kind still a word.
#[derive(Clone, Debug)]
pub(crate) struct BlockText {
    pub(crate) name: String,
    pub(crate) span: Span,
    pub(crate) kind: Option<(String, Span)>,
    pub(crate) fields: Vec<Entry>,
}

/// Reads one file.
pub(crate) fn parse(file: u32, text: &str, faults: &mut Faults) -> PatchText {
    let (document, errors) = DeTable::parse_recoverable(text);
    let mut is_toml = true;
    for error in errors {
        let at = span(file, error.span().unwrap_or(0..0));
        if error.message() == "duplicate key" {
            report_duplicate_key(text, at, faults);
        } else {
            is_toml = false;
            let what = error.message().to_owned();
            let help = "each line is `name = value`; a block is `x = { kind = \"integrator\", in = [\"v\"], ic = 1.0 }`; strings stand in quotes";
            faults.push(at, Flaw::TomlSyntax { what }, help);
        }
    }
    let mut patch = PatchText { is_toml, ..PatchText::default() };
    if is_toml {
        let entries = entries(file, document.get_ref());
        if let Some((entry, what, help)) = FileKind::Patch.mistaken(&entries) {
            patch.is_toml = false;
            faults.push(entry.key_span, Flaw::WrongKind { what }, help);
        } else {
            let top = span(file, 0..0);
            let mut f = Fields::new(faults, "a patch", top, &entries);
            sections(&mut f, &mut patch);
            f.finish("a patch");
        }
    }
    patch
}

fn report_duplicate_key(text: &str, at: Span, faults: &mut Faults) {
    let name = faults.sources.text(at).trim_matches('"').to_owned();
    // The parser does not say where the first one stands; it is the line that begins alike.
    let mut offset = 0;
    let mut first = Vec::new();
    for line in text.split_inclusive('\n') {
        let key = line.trim_start();
        let is_same = key
            .trim_start_matches('"')
            .strip_prefix(name.as_str())
            .is_some_and(|rest| rest.trim_start_matches('"').trim_start().starts_with(['=', '.']));
        let start = offset + line.len() - key.len();
        if is_same && start < at.start as usize {
            first.push(span(at.file, start..start + name.len()));
            break;
        }
        offset += line.len();
    }
    let help = format!(
        "give one of them another name, or remove one; `{name}` can stand for one thing only"
    );
    faults.push_beside(at, Flaw::DuplicateName { name }, help, &first);
}

fn sections(f: &mut Fields<'_, Faults>, patch: &mut PatchText) {
    patch.title = f.text_or_none("title");
    patch.params = named_entries(f, "params");
    for entry in named_entries(f, "use") {
        let instance = instance(f.board, &entry);
        patch.uses.push(instance);
    }
    let ports = f.entries("ports");
    let mut below = Fields::new(&mut *f.board, "[ports]", Span::default(), ports);
    let names = below.maybe("in", |f| f.names("in")).unwrap_or_default();
    below.finish("[ports]");
    for port in &names {
        check_name(f.board, &port.name, port.span);
    }
    patch.ports = names.into_iter().map(|port| (port.name, port.span)).collect();
    for entry in named_entries(f, "blocks") {
        let block = block(f.board, entry);
        patch.blocks.push(block);
    }
    patch.integration = f.entries("integration").to_vec();
    patch.expect = f.entries("expect").to_vec();
}

/// The entries of a section, whose keys are names.
fn named_entries(f: &mut Fields<'_, Faults>, section: &'static str) -> Vec<Entry> {
    let entries = f.entries(section);
    for entry in entries {
        check_name(f.board, &entry.key, entry.key_span);
    }
    entries.to_vec()
}

fn instance(faults: &mut Faults, entry: &Entry) -> UseText {
    let (name, span) = (entry.key.clone(), entry.key_span);
    let owner = format!("sub-patch `{name}`");
    let entries = faults.entries_of(&name, &entry.value);
    let mut f = Fields::new(faults, &owner, span, entries);
    let path = f.named("patch");
    let (inputs, with) = (f.entries("in").to_vec(), f.entries("with").to_vec());
    f.finish(&owner);
    UseText { name, span, path: path.map(|path| (path.name, path.span)), inputs, with }
}

fn block(faults: &mut Faults, entry: Entry) -> BlockText {
    let (name, span) = (entry.key, entry.key_span);
    let Data::Table(mut fields) = entry.value.data else {
        let wanted = "a table such as { kind = \"summer\", in = [\"x\"] }";
        faults.wrong_type(&name, wanted, &entry.value);
        return BlockText { name, span, kind: None, fields: Vec::new() };
    };
    let mut f = Fields::new(faults, &format!("block `{name}`"), span, &fields);
    let kind = f.named("kind").map(|kind| (kind.name, kind.span));
    f.tell_missing(&[]);
    fields.retain(|field| field.key != "kind");
    BlockText { name, span, kind, fields }
}

fn check_name(faults: &mut Faults, name: &str, at: Span) {
    if !is_name(name) {
        let name = name.to_owned();
        let help = "names begin with a letter or `_` and go on with letters, digits and `_`; a dot stands only between a sub-patch and its net";
        faults.push(at, Flaw::InvalidName { name }, help);
    }
}
