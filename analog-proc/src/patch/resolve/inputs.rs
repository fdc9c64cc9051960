//! Weighted inputs: from `"-2 * k * x"` to a net and its coefficient.
//!
//! A name that stands for nothing is a fault with the nearest name beside it; names
//! of instances that could not be read are passed over, since their fault is told
//! already. A parameter is no net, and a number alone is none either.

use super::{Resolver, Weighted, article};
use crate::block::kind::Inputs;
use crate::net::{Input, Span};
use crate::patch::diagnostic::Flaw;
use crate::patch::expression::{Expression, parse};
use crate::patch::fields::Fields;
use crate::patch::number::{self, bad_coefficient, evaluate, part_of};
use crate::patch::scope::Scope;
use desk::faults::suggestion;
use desk::reader::{Board, Data, Value};

/// In a patch of more nets than this …
const MOST_SEARCHED: usize = 2000;
/// … near names are looked for in the first so many faults only, since each search reads all names.
const FIRST_FAULTS: usize = 10;

impl Resolver<'_> {
    /// A weighted input in the scope being read.
    pub(crate) fn own_input(&mut self, field: &str, value: &Value) -> Option<Input> {
        self.input(self.scope, field, value)
    }

    /// A weighted input in a scope.
    pub(crate) fn input(&mut self, scope: usize, field: &str, value: &Value) -> Option<Input> {
        let Data::Text(text) = &value.data else {
            self.faults.wrong_type(field, "the name of a net in quotes, such as \"-2 * x\"", value);
            return None;
        };
        let place = part_of(self.faults, value.span, text);
        let input = match parse(text).and_then(Expression::into_input) {
            Ok(input) => input,
            Err(error) => {
                bad_coefficient(text, place(error.range), error.why, error.help, self.faults);
                return None;
            }
        };
        let params = &self.instances.scopes[scope].params;
        let coefficient = match &input.coefficient {
            Some(coefficient) => evaluate(coefficient, params, &place, field, self.faults),
            None => Some(1.0),
        };
        let (net, weight) = self.net(scope, input.net, place(input.range))?;
        let coefficient = coefficient? * weight;
        if !coefficient.is_finite() {
            number::not_finite(field, value.span, self.faults);
            return None;
        }
        Some(Input { net, coefficient, span: value.span })
    }

    /// The net for which a name stands in a scope: a port, or a block of the scope itself.
    pub(super) fn net(&mut self, scope: usize, name: &str, at: Span) -> Option<Weighted> {
        if let Some(binding) = self.bound.get(scope).and_then(|ports| ports.get(name)) {
            return *binding;
        }
        let Scope { prefix, params, .. } = &self.instances.scopes[scope];
        if let Some(&net) = self.by_name.get(&format!("{prefix}{name}")) {
            return Some((net, 1.0));
        }
        let is_dead = name.match_indices('.').any(|(dot, _)| {
            let instance = format!("{prefix}{}", &name[..=dot]);
            self.instances.dead.contains(&instance)
        });
        if is_dead {
            return None;
        }
        if self.faults.is_full() {
            // Only counted: the search for a near name over all nets costs too much to repeat.
            self.faults.omit();
            return None;
        }
        let help = if params.contains_key(name) {
            format!(
                "`{name}` is a parameter; to use it as a signal, make it a block: {{ kind = \"constant\", value = \"{name}\" }}"
            )
        } else if self.nets.len() > MOST_SEARCHED && self.faults.count() >= FIRST_FAULTS {
            "check the spelling against [blocks]; near names are shown for the first faults only"
                .into()
        } else {
            let ports = self.bound.get(scope).into_iter().flat_map(|p| p.keys());
            let nets = self.nets.iter().filter_map(|net| net.name.strip_prefix(prefix.as_str()));
            suggestion(name, ports.map(String::as_str).chain(nets))
        };
        self.faults.push(at, Flaw::UnknownNet { net: name.to_owned() }, help);
        None
    }
}

/// The inputs of a block from its field `in`, as many as its kind takes.
pub(super) fn inputs_of(fields: &mut Fields<'_, '_>, arity: Inputs, kind: &str) -> Vec<Input> {
    let owner = format!("{} `{}`", article(kind), fields.block);
    let at = fields.at;
    let Some(entry) = fields.entry("in") else {
        if arity.least > 0 {
            unconnected(owner, at, arity, fields);
        }
        return Vec::new();
    };
    let items: Vec<&Value> = match &entry.value.data {
        Data::List(items) => items.iter().collect(),
        // A single input may stand without brackets.
        Data::Text(_) => vec![&entry.value],
        _ => {
            fields.board.wrong_type(
                "in",
                "a list of nets such as [\"x\", \"-2 * y\"]",
                &entry.value,
            );
            return Vec::new();
        }
    };
    let found = items.len();
    if found == 0 && arity.least > 0 {
        unconnected(owner, entry.value.span, arity, fields);
    } else if found < arity.least || arity.most.is_some_and(|most| found > most) {
        let help = if arity.most == Some(0) {
            "it is a source: remove `in`".to_owned()
        } else if arity.most.is_some_and(|most| found > most) {
            "sum the inputs in a `summer` first, or leave some out".to_owned()
        } else {
            "name each input in the list `in`".to_owned()
        };
        fields.board.faults.push(
            entry.value.span,
            Flaw::Arity { owner, wanted: arity.words(), found },
            help,
        );
    }
    items.into_iter().filter_map(|item| fields.board.own_input("in", item)).collect()
}

fn unconnected(owner: String, at: Span, arity: Inputs, fields: &mut Fields<'_, '_>) {
    let help = format!(
        "it takes {}: in = [\"NET\"]; for a fixed input wire a `constant` block",
        arity.words()
    );
    fields.board.faults.push(at, Flaw::UnconnectedInput { owner }, help);
}
