//! The quantities of a frozen point by name, as a study file writes them.

use super::point::FrozenPoint;
pub use super::point::QUANTITIES;
use desk::reader::Range;

/// One quantity that a condition may multiply or replace.
#[derive(Clone, Copy, Debug)]
pub struct Quantity {
    /// Name in the study file.
    pub name: &'static str,
    /// Unit in which the study file states it.
    pub unit: &'static str,
    /// SI value of one such unit.
    pub unit_in_si: f64,
    /// Which values make sense.
    pub range: Range,
    /// Where it lies in the point.
    pub(super) field: fn(&mut FrozenPoint) -> &mut f64,
}

impl Quantity {
    /// All of them, as words of a file.
    pub fn by_name() -> Vec<(&'static str, &'static Quantity)> {
        QUANTITIES.iter().map(|q| (q.name, q)).collect()
    }

    /// Its value at a point, SI.
    pub fn get(&self, point: &FrozenPoint) -> f64 {
        let mut copy = *point;
        *(self.field)(&mut copy)
    }

    /// Sets it, SI.
    pub fn set(&self, point: &mut FrozenPoint, value_si: f64) {
        *(self.field)(point) = value_si;
    }
}

impl PartialEq for Quantity {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A macro line that names the wrong field would alias two quantities.
    #[test]
    fn every_quantity_is_a_field_of_its_own() {
        let mut point = super::super::point::tests::numbered();
        for (index, quantity) in QUANTITIES.iter().enumerate() {
            quantity.set(&mut point, 1000.0 + index as f64);
        }
        for (index, quantity) in QUANTITIES.iter().enumerate() {
            assert_eq!(quantity.get(&point), 1000.0 + index as f64, "{}", quantity.name);
        }
    }
}
