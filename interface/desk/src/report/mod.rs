//! The parts of a report: figures, tables and pages.
//!
//! Every component is a function from data to markup. A page is one file without
//! references to anything outside itself, complete without its script; it is read on a light
//! or a dark screen and on paper. Nothing here judges: verdicts and numbers come from the caller.

mod claims;
pub mod format;
mod page;
pub mod plot;
mod provenance;
mod summary;
mod table;

pub use claims::{claims_table, claims_text};
pub use page::{Numbering, Section, anchor, page, side_by_side};
pub use provenance::provenance;
pub use summary::Summary;
pub use table::{Cell, Column, Heading, Table, definition_list};
