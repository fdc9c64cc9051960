//! The frames as iceoryx2 carries them.
//!
//! Wrappers with fixed type names, since the default name differs between
//! binaries and languages. An observer in another language subscribes with the
//! same names and the layout of [`crate::frame`]; other layouts are refused by
//! their size.

use crate::frame::{Samples, Updates};
use iceoryx2::prelude::ZeroCopySend;

/// Samples in shared memory.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct SamplesWire(pub Samples);

/// Updates in shared memory.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct UpdatesWire(pub Updates);

// SAFETY: `Samples` is `repr(C)`, holds neither pointers nor handles and owns
// nothing; every bit pattern of its integers and floats is a value. The name is
// the one under which other languages declare the same layout.
unsafe impl ZeroCopySend for SamplesWire {
    unsafe fn type_name() -> &'static str {
        "hybrid_computer_samples_1"
    }
}

// SAFETY: as for `SamplesWire`.
unsafe impl ZeroCopySend for UpdatesWire {
    unsafe fn type_name() -> &'static str {
        "hybrid_computer_updates_1"
    }
}
