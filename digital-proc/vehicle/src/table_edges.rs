//! Record of table edges that were passed.
//!
//! Every function that looks something up hands its edges back in an
//! [`EdgeRecord`]; a flight merges them, so that a run that used a held end
//! value says so. The record is a pair of bit sets: merging is cheap enough for
//! every derivative evaluation, and nothing is lost or counted twice.

use crate::table::Edge;

interface::named! {
    /// The tables of the data set whose edges are recorded, in the order of the bits.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum TableName, label {
        Thrust "vacuum thrust (time)"
        RollInertia "roll inertia (time)"
        Aerodynamics "aerodynamic coefficients (Mach number)"
        /// Before its first node the attitude is the launch attitude by definition, so only the
        /// upper edge counts.
        PitchProgramme "pitch programme (time)"
        Wind "wind profile (altitude)"
        Bending "bending mode (time)"
    }
}

/// Set of (table, edge) pairs that were met.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub struct EdgeRecord {
    below: u8,
    above: u8,
}

impl EdgeRecord {
    pub const NONE: Self = Self { below: 0, above: 0 };

    pub fn note(&mut self, table: TableName, edge: Edge) {
        let bit = 1u8 << table as u8;
        match edge {
            Edge::Inside => {}
            Edge::Below => self.below |= bit,
            Edge::Above => self.above |= bit,
        }
    }

    pub fn merge(&mut self, other: Self) {
        self.below |= other.below;
        self.above |= other.above;
    }

    pub fn is_empty(self) -> bool {
        self.below == 0 && self.above == 0
    }

    pub fn iter(self) -> impl Iterator<Item = (TableName, Edge)> {
        TableName::ALL.into_iter().flat_map(move |table| {
            let bit = 1u8 << table as u8;
            let below = (self.below & bit != 0).then_some((table, Edge::Below));
            let above = (self.above & bit != 0).then_some((table, Edge::Above));
            below.into_iter().chain(above)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn merged_edges_are_listed_once_each() {
        let mut record = EdgeRecord::NONE;
        record.note(TableName::Wind, Edge::Inside);
        assert!(record.is_empty());
        record.note(TableName::Wind, Edge::Above);
        let mut other = EdgeRecord::NONE;
        other.note(TableName::Wind, Edge::Above);
        other.note(TableName::Thrust, Edge::Below);
        record.merge(other);
        let met: Vec<_> = record.iter().collect();
        assert_eq!(met, [(TableName::Thrust, Edge::Below), (TableName::Wind, Edge::Above)]);
    }
}
