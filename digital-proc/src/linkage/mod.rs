//! The digital side of the linkage: a partner started, a patch loaded, runs operated by a law.

pub mod console;
pub mod executive;
pub mod launch;
pub mod saturation;
