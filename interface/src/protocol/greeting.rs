//! The greeting: both sides compare version and frame layout before anything else.

use super::ProtocolError;
use crate::{
    control::{Reply, Request},
    frame::{self, Edge, Samples, Updates},
};
use std::mem::{align_of, offset_of, size_of};

/// Version of the protocol; raised whenever a message changes its meaning.
pub const VERSION: u32 = 5;

/// Hash of everything on which the meaning of a frame's bytes depends: sizes,
/// alignments, offsets and channel counts. Equal layouts have equal hashes on
/// every build; the handshake refuses unequal ones.
pub fn layout_hash() -> u64 {
    let numbers = [
        size_of::<Samples>(),
        align_of::<Samples>(),
        offset_of!(Samples, frame),
        offset_of!(Samples, tick),
        offset_of!(Samples, adc),
        offset_of!(Samples, adc_saturated),
        offset_of!(Samples, dac_saturated),
        offset_of!(Samples, dcu_saturated),
        offset_of!(Samples, sense),
        offset_of!(Samples, overloads),
        offset_of!(Samples, state),
        offset_of!(Samples, edge_count),
        offset_of!(Samples, edges_lost),
        offset_of!(Samples, edges),
        offset_of!(Samples, transfer_count),
        offset_of!(Samples, transfers),
        offset_of!(Samples, late),
        size_of::<Edge>(),
        offset_of!(Edge, tick),
        offset_of!(Edge, line),
        offset_of!(Edge, rising),
        size_of::<Updates>(),
        align_of::<Updates>(),
        offset_of!(Updates, frame),
        offset_of!(Updates, effective),
        offset_of!(Updates, dac_mask),
        offset_of!(Updates, dcu_mask),
        offset_of!(Updates, control_mask),
        offset_of!(Updates, control),
        offset_of!(Updates, mode),
        offset_of!(Updates, reserved),
        offset_of!(Updates, dac),
        offset_of!(Updates, dcu),
        frame::ADC_CHANNELS,
        frame::DAC_CHANNELS,
        frame::DCU_CHANNELS,
        frame::SENSE_LINES,
        frame::CONTROL_LINES,
        frame::INTERRUPT_LINES,
        frame::EDGES_PER_FRAME,
        frame::TRANSFERS_PER_FRAME,
    ];
    // FNV-1a, 64 bits: stable across builds, which `std::hash` does not promise.
    numbers
        .iter()
        .flat_map(|n| (*n as u64).to_le_bytes())
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
        })
}

/// The greeting of this build.
pub fn hello() -> Request {
    Request::Hello { version: VERSION, layout_hash: layout_hash() }
}

/// This build's answer to [`hello`].
pub fn hello_reply() -> Reply {
    Reply::Hello { version: VERSION, layout_hash: layout_hash() }
}

/// Compares the partner's greeting with this build's.
pub fn check_hello(version: u32, layout: u64) -> Result<(), ProtocolError> {
    let ours = layout_hash();
    if version != VERSION {
        Err(ProtocolError::Version { ours: VERSION, theirs: version })
    } else if layout != ours {
        Err(ProtocolError::Layout { ours, theirs: layout })
    } else {
        Ok(())
    }
}
