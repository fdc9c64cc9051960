//! The frames as iceoryx2 carries them.
//!
//! Wrappers with fixed type names, since the default name differs between
//! binaries and languages. An observer in another language subscribes with the
//! same names and the layout of [`crate::frame`]; other layouts are refused by
//! their size.

use crate::frame::{Samples, Updates};
use iceoryx2::prelude::ZeroCopySend;
use std::fmt::Debug;

/// A frame that crosses shared memory.
///
/// # Safety
/// It is `repr(C)`, holds neither pointers nor handles and owns nothing; every bit pattern of its
/// integers and floats is a value.
pub unsafe trait Frame: Copy + Debug + 'static {
    /// The service that carries it.
    const SERVICE: &'static str;
    /// Under which other languages declare the same layout.
    const LAYOUT: &'static str;
}

// SAFETY: plain integers and floats in `repr(C)`.
unsafe impl Frame for Samples {
    const SERVICE: &'static str = "samples";
    const LAYOUT: &'static str = "hybrid_computer_samples_1";
}

// SAFETY: as for `Samples`.
unsafe impl Frame for Updates {
    const SERVICE: &'static str = "updates";
    const LAYOUT: &'static str = "hybrid_computer_updates_1";
}

/// A frame in shared memory.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Shared<F>(pub F);

// SAFETY: as [`Frame`] promises of what it wraps.
unsafe impl<F: Frame> ZeroCopySend for Shared<F> {
    unsafe fn type_name() -> &'static str {
        F::LAYOUT
    }
}
