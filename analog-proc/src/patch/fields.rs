//! Reading the fields of a block: what `desk::reader` gives, and what only a patch has.

mod nets;

use super::diagnostic::Flaw;
use super::number;
use super::resolve::Resolver;
use crate::block::kind::linkage;
use crate::net::Span;
use desk::reader::{self, Board, Entry, Fault, Value};
use interface::control::ChannelKind;
use std::ops::{Deref, DerefMut};

impl Board for Resolver<'_> {
    fn tell(&mut self, at: Span, fault: Fault, help: String) {
        let help = match &fault {
            Fault::NotPositive { field, .. } => match field.as_str() {
                "tau" => "a follower without time constant is a `gain` block".to_owned(),
                "delay" => "without delay, wire the net directly".to_owned(),
                "max" => "give the largest magnitude that the net is to reach".to_owned(),
                _ => help,
            },
            _ => help,
        };
        self.faults.push(at, fault, help);
    }

    /// A number, or arithmetic with the parameters of the scope being read.
    fn number(&mut self, field: &str, value: &Value) -> Option<f64> {
        let params = &self.instances.scopes[self.scope].params;
        number::number(field, value, params, self.faults)
    }
}

/// The fields of a block, or of a section that names nets.
pub(crate) struct Fields<'r, 'a> {
    fields: reader::Fields<'r, Resolver<'a>>,
    /// Full name of the block.
    pub(crate) block: String,
}

impl<'r, 'a> Deref for Fields<'r, 'a> {
    type Target = reader::Fields<'r, Resolver<'a>>;

    fn deref(&self) -> &Self::Target {
        &self.fields
    }
}

impl DerefMut for Fields<'_, '_> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.fields
    }
}

impl<'r, 'a> Fields<'r, 'a> {
    pub(crate) fn new(
        resolver: &'r mut Resolver<'a>,
        scope: usize,
        block: &str,
        at: Span,
        entries: &'r [Entry],
    ) -> Self {
        resolver.scope = scope;
        let fields = reader::Fields::new(resolver, &format!("`{block}`"), at, entries);
        Fields { fields, block: block.to_owned() }
    }

    /// Tells of keys that nobody asked for.
    pub(crate) fn finish(self, owner: &str) {
        self.fields.finish(owner);
    }

    /// Tells of a fault at the value of a field, or at the owner where the field is left out.
    pub(crate) fn fault_at(&mut self, key: &str, flaw: Flaw, help: impl Into<String>) {
        let at = self.place(key).unwrap_or(self.at);
        self.board.faults.push(at, flaw, help);
    }

    /// A time that problem time resolves, s.
    pub(crate) fn duration(&mut self, key: &'static str) -> Option<f64> {
        let value = self.positive(key, None)?;
        if value >= 1e-9 {
            return Some(value);
        }
        self.out_of_range(key, value, "a nanosecond or more");
        None
    }

    /// A converter channel or line.
    pub(crate) fn channel(
        &mut self,
        key: &'static str,
        kind: ChannelKind,
        needed: usize,
    ) -> Option<u32> {
        let (what, count) = linkage(kind);
        let entry = self.required(key, "0")?;
        let first = self.board.number(key, &entry.value)?;
        let last_used = first + needed.max(1) as f64 - 1.0;
        let is_whole = first >= 0.0 && first.fract() == 0.0;
        if is_whole && last_used < count as f64 {
            return Some(first as u32);
        }
        let number = if is_whole { last_used } else { first };
        let help = format!("the linkage numbers them 0 to {}", count - 1);
        self.fault_at(key, Flaw::ChannelOutOfRange { what, number, last: count as u32 - 1 }, help);
        None
    }
}
