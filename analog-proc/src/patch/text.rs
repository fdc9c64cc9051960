//! First stage: one file's text, its sections and lines with their places.
//!
//! Knows the shape of a file (which sections there are, and that a block is a
//! table with a kind), and nothing of what kinds mean or which nets exist. A
//! file that is not TOML goes no further, since half-read lines would only
//! breed false faults.

use super::coefficient::is_name;
use super::diagnostic::PatchFault;
use super::faults::{Faults, suggestion};
use super::value::{Data, Entry, Value, entries, span};
use crate::net::Span;
use miette::LabeledSpan;
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
    /// Whether the file could be read as TOML.
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

const SECTIONS: [&str; 7] = ["title", "params", "use", "ports", "blocks", "integration", "expect"];

/// Paths of the sub-patches that a text uses, as far as it can be read, without any complaint.
pub(crate) fn used_paths(text: &str) -> Vec<String> {
    let (document, _) = DeTable::parse_recoverable(text);
    let uses = document.get_ref().get("use");
    uses.and_then(|uses| uses.get_ref().as_table())
        .into_iter()
        .flat_map(|table| table.values())
        .filter_map(|instance| instance.get_ref().get("patch"))
        .filter_map(|path| path.get_ref().as_str().map(str::to_owned))
        .collect()
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
            faults.push(at, |src, at| PatchFault::TomlSyntax {
                src,
                at,
                what,
                help: "each line is `name = value`; a block is `x = { kind = \"integrator\", in = [\"v\"], ic = 1.0 }`; strings stand in quotes".into(),
            });
        }
    }
    let mut patch = PatchText { is_toml, ..PatchText::default() };
    if is_toml {
        let mut reader = Reader { faults };
        for section in entries(file, document.get_ref()) {
            reader.section(section, &mut patch);
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
            first.push(LabeledSpan::new(None, start, name.len()));
            break;
        }
        offset += line.len();
    }
    faults.push(at, |src, at| PatchFault::DuplicateName {
        src,
        at,
        first,
        help: format!(
            "give one of them another name, or remove one; `{name}` can stand for one thing only"
        ),
        name,
    });
}

struct Reader<'a> {
    faults: &'a mut Faults,
}

impl Reader<'_> {
    fn section(&mut self, section: Entry, patch: &mut PatchText) {
        match section.key.as_str() {
            "title" => patch.title = self.text(section).map(|(text, _)| text),
            "params" => {
                patch.params = self.table(section);
                for param in &patch.params {
                    self.check_name(&param.key, param.key_span);
                }
            }
            "use" => {
                for entry in self.table(section) {
                    let instance = self.instance(entry);
                    patch.uses.push(instance);
                }
            }
            "ports" => self.ports(section, patch),
            "blocks" => {
                for entry in self.table(section) {
                    let block = self.block(entry);
                    patch.blocks.push(block);
                }
            }
            "integration" => patch.integration = self.table(section),
            "expect" => patch.expect = self.table(section),
            _ => self.unknown_key(&section, "a patch", &SECTIONS),
        }
    }

    fn instance(&mut self, entry: Entry) -> UseText {
        self.check_name(&entry.key, entry.key_span);
        let (name, at) = (entry.key.clone(), entry.key_span);
        let mut path = None;
        let mut inputs = Vec::new();
        let mut with = Vec::new();
        for field in self.table(entry) {
            match field.key.as_str() {
                "patch" => path = Some(self.text(field)),
                "in" => inputs = self.table(field),
                "with" => with = self.table(field),
                _ => self.unknown_key(&field, &format!("`{name}`"), &["patch", "in", "with"]),
            }
        }
        if path.is_none() {
            let owner = format!("sub-patch `{name}`");
            self.faults.push(at, |src, at| PatchFault::MissingField {
                src,
                at,
                owner,
                field: "patch".into(),
                help: "write the file: patch = \"rate-gyro.toml\"".into(),
            });
        }
        UseText { name, span: at, path: path.flatten(), inputs, with }
    }

    fn ports(&mut self, section: Entry, patch: &mut PatchText) {
        for field in self.table(section) {
            if field.key != "in" {
                self.unknown_key(&field, "[ports]", &["in"]);
                continue;
            }
            let Data::List(items) = field.value.data else {
                self.wrong_type("in", "a list of names", &field.value);
                continue;
            };
            for item in items {
                match item.data {
                    Data::Text(name) => {
                        self.check_name(&name, item.span);
                        patch.ports.push((name, item.span));
                    }
                    _ => self.wrong_type("in", "names in quotes", &item),
                }
            }
        }
    }

    fn block(&mut self, entry: Entry) -> BlockText {
        self.check_name(&entry.key, entry.key_span);
        let (name, at) = (entry.key.clone(), entry.key_span);
        let Data::Table(all) = entry.value.data else {
            self.wrong_type(
                &name,
                "a table such as { kind = \"summer\", in = [\"x\"] }",
                &entry.value,
            );
            return BlockText { name, span: at, kind: None, fields: Vec::new() };
        };
        let mut kind = None;
        let mut has_kind = false;
        let mut fields = Vec::new();
        for field in all {
            if field.key == "kind" {
                has_kind = true;
                kind = self.text(field);
            } else {
                fields.push(field);
            }
        }
        if !has_kind {
            let owner = format!("block `{name}`");
            self.faults.push(at, |src, at| PatchFault::MissingField {
                src,
                at,
                owner,
                field: "kind".into(),
                help: "say what the block is: kind = \"integrator\", \"summer\", …".into(),
            });
        }
        BlockText { name, span: at, kind, fields }
    }

    fn table(&mut self, entry: Entry) -> Vec<Entry> {
        match entry.value.data {
            Data::Table(entries) => entries,
            _ => {
                self.wrong_type(&entry.key, "a table", &entry.value);
                Vec::new()
            }
        }
    }

    fn text(&mut self, entry: Entry) -> Option<(String, Span)> {
        match entry.value.data {
            Data::Text(text) => Some((text, entry.value.span)),
            _ => {
                self.wrong_type(&entry.key, "a string", &entry.value);
                None
            }
        }
    }

    fn check_name(&mut self, name: &str, at: Span) {
        if !is_name(name) {
            let name = name.to_owned();
            self.faults.push(at, |src, at| PatchFault::InvalidName {
                src,
                at,
                name,
                help: "names begin with a letter or `_` and go on with letters, digits and `_`; a dot stands only between a sub-patch and its net".into(),
            });
        }
    }

    fn wrong_type(&mut self, field: &str, wanted: &'static str, value: &Value) {
        let field = field.to_owned();
        let found = value.type_name();
        self.faults.push(value.span, |src, at| PatchFault::WrongType {
            src,
            at,
            help: format!("write {wanted}"),
            field,
            wanted,
            found,
        });
    }

    fn unknown_key(&mut self, entry: &Entry, owner: &str, known: &[&str]) {
        let (key, owner) = (entry.key.clone(), owner.to_owned());
        let help = suggestion(&key, "keys", known.iter().copied());
        self.faults.push(entry.key_span, |src, at| PatchFault::UnknownKey {
            src,
            at,
            key,
            owner,
            help,
        });
    }
}
