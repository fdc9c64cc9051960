//! The figures and tables of flights, made of the parts in [`desk::report`].

mod block_diagram;
pub mod flight;
pub mod impact;
pub mod pacing;

pub use block_diagram::block_diagram;
