//! Stand-alone entry to the analog processor.
fn main() {}
