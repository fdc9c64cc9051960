//! What the case study's report shows of its claims.

use desk::claim::Evidence;

pub(crate) const FIGURE_4: Evidence = Evidence::at("figure-4");
pub(crate) const FIGURE_5: Evidence = Evidence::at("figure-5");
pub(crate) const FIGURE_8: Evidence = Evidence::at("figure-8");
pub(crate) const BENDING_GROWTH: Evidence = Evidence::at("bending-growth");
pub(crate) const OVERSHOOTS: Evidence = Evidence::at("matrix-overshoot");
pub(crate) const BENDING: Evidence = Evidence::at("matrix-bending");
pub(crate) const MODES: Evidence = Evidence::at("modes");
pub(crate) const LOADS: Evidence = Evidence::at("loads");
pub(crate) const Q_ALPHA: Evidence = Evidence::at("q-alpha");
