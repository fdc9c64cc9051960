//! Entry to the digital processor.
fn main() {}
