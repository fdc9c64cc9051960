//! The four-quadrant arctangent, continuous within a step.

/// `atan2(y, x)`, continued across the negative x axis on the sheet in force:
/// `sheet` 0 was entered with y ≥ 0, 1 with y < 0. The sheet changes by an event.
#[inline]
pub(crate) fn arctangent(y: f64, x: f64, sheet: u32) -> f64 {
    let principal = libm::atan2(y, x);
    if x >= 0.0 {
        principal
    } else if sheet == 0 && y < 0.0 {
        principal + std::f64::consts::TAU
    } else if sheet == 1 && y >= 0.0 {
        principal - std::f64::consts::TAU
    } else {
        principal
    }
}
