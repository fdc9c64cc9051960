//! Fields that name nets: mode control, inputs of their own, levels that follow a net.

use super::Fields;
use crate::block::kind::{Inverter, Summer};
use crate::net::{Input, Kind, Level, Span};
use crate::patch::diagnostic::Flaw;
use crate::patch::number::not_finite;
use desk::reader::{Board, Data, Value};
use engine::id::NetId;

impl Fields<'_, '_> {
    /// A net for logic control, without coefficient; `None` inside where it is left out.
    pub(crate) fn net_or_none(&mut self, key: &'static str) -> Option<Option<NetId>> {
        let Some(entry) = self.entry(key) else {
            return Some(None);
        };
        let input = self.board.own_input(key, &entry.value)?;
        if input.coefficient == 1.0 {
            return Some(Some(input.net));
        }
        let net = self.board.faults.sources.text(input.span).to_owned();
        let net = net.trim_matches(['"', '\'']).to_owned();
        let help = "logic is 0 or 1; invert it with a `not` block";
        self.fault_at(key, Flaw::LogicCoefficient { net }, help);
        None
    }

    /// A net for logic control that must be there.
    pub(crate) fn net(&mut self, key: &'static str) -> Option<NetId> {
        self.required(key, "\"NET\"")?;
        self.net_or_none(key)?
    }

    /// A weighted input in a field of its own; `None` inside where it is left out.
    pub(crate) fn input_or_none(&mut self, key: &'static str) -> Option<Option<Input>> {
        let Some(entry) = self.entry(key) else {
            return Some(None);
        };
        self.board.own_input(key, &entry.value).map(Some)
    }

    /// A number or a net. A weighted net becomes a hidden gain block `NAME.part`.
    pub(crate) fn level(&mut self, key: &'static str, value: &Value, part: &str) -> Option<Level> {
        if let Data::Text(text) = &value.data {
            let last = text.rsplit('*').next().unwrap_or("");
            let last = last.trim().trim_start_matches('-').trim();
            let is_word = last.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
            if is_word && !self.board.params().contains_key(last) {
                let input = self.board.own_input(key, value)?;
                return Some(Level::Net(self.weighted(input, part)));
            }
        }
        let number = self.board.number(key, value)?;
        if number.is_finite() {
            return Some(Level::Fixed(number));
        }
        not_finite(key, value.span, self.board.faults);
        None
    }

    /// A pair `[low, high]`, each a number or a net.
    pub(crate) fn levels(&mut self, key: &'static str, value: &Value) -> Option<[Level; 2]> {
        let Data::List(items) = &value.data else {
            self.board.wrong_type(key, "a list [low, high]", value);
            return None;
        };
        let [low, high] = &items[..] else {
            self.table_size(key, items.len(), "2 (low and high)".into());
            return None;
        };
        let low = self.level(key, low, "low");
        let high = self.level(key, high, "high");
        Some([low?, high?])
    }

    /// The net of an input with its coefficient applied.
    pub(crate) fn weighted(&mut self, input: Input, part: &str) -> NetId {
        if input.coefficient == 1.0 {
            return input.net;
        }
        let name = format!("{}.{part}", self.block);
        let at = self.at;
        self.board.hide(name, at, Kind::Summer(Summer), input)
    }

    /// Makes a hidden inverter of a net.
    pub(crate) fn inverted(&mut self, net: NetId, part: &str, span: Span) -> NetId {
        let name = format!("{}.{part}", self.block);
        let input = Input { net, coefficient: 1.0, span };
        let at = self.at;
        self.board.hide(name, at, Kind::Inverter(Inverter), input)
    }
}
