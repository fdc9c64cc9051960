//! Reports: figures, tables and pages made from a run's data.
//!
//! Every component is a function from data to markup. A page is one file without
//! references to anything outside itself, complete without its script; it is read on a light
//! or a dark screen and on paper. Nothing here judges: verdicts and numbers come from the caller.

mod block_diagram;
pub mod case_study;
mod claims;
pub mod flight;
pub mod format;
pub mod gain_design;
pub mod long_period;
pub mod pacing;
mod page;
pub mod plot;
mod provenance;
pub mod sensitivity;
pub mod short_period;
mod summary;
mod table;
mod theme;
mod trace_figures;

pub use block_diagram::{Partition, block_diagram};
pub use claims::{claims_table, claims_text};
pub use flight::{FLIGHT_COLUMNS, FlightContext, flight_report, ten_variables};
pub use page::{Numbering, Section, anchor, page, side_by_side};
pub use provenance::provenance;
pub use summary::Summary;
pub use table::{Cell, Heading, Table, definition_list};
pub use trace_figures::{Curve, FigureSpec, trace_figure, trace_report};
