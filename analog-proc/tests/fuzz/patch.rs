//! A patch as a value: to be written as text, perturbed, and made smaller.

use crate::random::Random;

/// A net of one, for offsets; no name of the generator's.
const OFFSET: &str = "offset";

/// One weighted net.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    pub c: f64,
    pub net: String,
}

/// What a field of a block holds.
#[derive(Clone, Debug, PartialEq)]
pub enum Field {
    Number(f64),
    Whole(u32),
    Flag(bool),
    Word(&'static str),
    List(Vec<f64>),
    Table(Vec<Vec<f64>>),
    Net(String),
    Term(Term),
}

/// One line of `[blocks]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    pub name: String,
    pub kind: &'static str,
    pub inputs: Vec<Term>,
    pub fields: Vec<(&'static str, Field)>,
}

/// A patch and how long it runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    pub blocks: Vec<Block>,
    pub until_s: f64,
}

impl Term {
    fn text(&self) -> String {
        if self.c == 1.0 {
            format!("\"{}\"", self.net)
        } else {
            format!("\"{:?} * {}\"", self.c, self.net)
        }
    }
}

fn list(values: &[f64]) -> String {
    let values: Vec<String> = values.iter().map(|v| format!("{v:?}")).collect();
    format!("[{}]", values.join(", "))
}

impl Field {
    fn text(&self) -> String {
        match self {
            Field::Number(v) => format!("{v:?}"),
            Field::Whole(v) => v.to_string(),
            Field::Flag(v) => v.to_string(),
            Field::Word(word) => format!("\"{word}\""),
            Field::List(values) => list(values),
            Field::Table(rows) => {
                let rows: Vec<String> = rows.iter().map(|r| list(r)).collect();
                format!("[{}]", rows.join(", "))
            }
            Field::Net(net) => format!("\"{net}\""),
            Field::Term(term) => term.text(),
        }
    }

    fn net(&mut self) -> Option<&mut String> {
        match self {
            Field::Net(net) => Some(net),
            Field::Term(term) => Some(&mut term.net),
            _ => None,
        }
    }

    fn numbers(&mut self, each: &mut impl FnMut(&mut f64)) {
        match self {
            Field::Number(v) => each(v),
            Field::List(values) => values.iter_mut().for_each(each),
            Field::Table(rows) => rows.iter_mut().flatten().for_each(each),
            Field::Term(term) => each(&mut term.c),
            _ => {}
        }
    }
}

impl Block {
    /// Whether its kind is one of these words.
    pub fn is(&self, kinds: &str) -> bool {
        kinds.split(' ').any(|kind| kind == self.kind)
    }

    pub fn is_logic(&self) -> bool {
        self.is("comparator and or not flip-flop one-shot")
    }

    /// Whether it may stand in a closed path.
    pub fn is_store(&self) -> bool {
        self.is("integrator lag rate-limiter backlash transport-delay flip-flop one-shot counter")
    }

    pub fn drives(&self, net: &str) -> bool {
        net.strip_suffix(".x").or(net.strip_suffix(".y")).unwrap_or(net) == self.name
    }

    /// The nets it drives.
    pub fn nets(&self) -> Vec<String> {
        if self.kind == "resolver" {
            vec![format!("{}.x", self.name), format!("{}.y", self.name)]
        } else {
            vec![self.name.clone()]
        }
    }

    /// Every net it reads.
    pub fn reads(&mut self) -> impl Iterator<Item = &mut String> {
        let fields = self.fields.iter_mut().filter_map(|f| f.1.net());
        self.inputs.iter_mut().map(|t| &mut t.net).chain(fields)
    }

    fn line(&self) -> String {
        let mut text = format!("{} = {{ kind = \"{}\"", self.name, self.kind);
        if !self.inputs.is_empty() {
            let inputs: Vec<String> = self.inputs.iter().map(Term::text).collect();
            text += &format!(", in = [{}]", inputs.join(", "));
        }
        for (key, field) in &self.fields {
            text += &format!(", {key} = {}", field.text());
        }
        text + " }"
    }
}

impl Patch {
    /// The patch file.
    pub fn text(&self) -> String {
        let lines: Vec<String> = self.blocks.iter().map(Block::line).collect();
        format!("[blocks]\n{}\n", lines.join("\n"))
    }

    /// The same with every number off by up to `relative`, and the input of all that integrates by as
    /// much of one: what errors of the size `relative` in every step can do.
    pub fn perturbed(&self, relative: f64, random: &mut Random) -> Patch {
        let mut patch = self.clone();
        for block in &mut patch.blocks {
            let mut each = |v: &mut f64| *v *= 1.0 + relative * random.between(-1.0, 1.0);
            // A weight of one is a wire: it stays so in logic, where nothing may be weighted.
            for term in block.inputs.iter_mut().filter(|t| t.c != 1.0) {
                each(&mut term.c);
            }
            for (_, field) in &mut block.fields {
                field.numbers(&mut each);
            }
            if block.is("integrator lag rate-limiter") && relative > 0.0 {
                let c = relative * random.between(-1.0, 1.0);
                block.inputs.push(Term { c, net: OFFSET.into() });
            }
        }
        patch.blocks.push(Block {
            name: OFFSET.into(),
            kind: "constant",
            inputs: Vec::new(),
            fields: vec![("value", Field::Number(1.0))],
        });
        patch
    }
}
