//! The running state as bytes, and back, to the last bit.
//!
//! All that is not the program: a field that is forgotten here does not compile. What the program
//! makes of the state (pieces and weights from the coefficients held) is made anew. It refuses the
//! state of another program or of other settings.

use super::Engine;
use crate::machine::Frozen;
use bincode::config::{Configuration, standard};
use bincode::error::{DecodeError, EncodeError};
use sha2::{Digest, Sha256};
use std::fmt::Write;

/// Why a state is not taken over.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SnapshotFault {
    /// There is none to keep.
    #[error("a run that has ended by a fault has no state to go on from")]
    Faulted,
    /// It belongs to another program.
    #[error("the state is that of another program: patch, parameters, profile or settings differ")]
    Foreign,
    /// The bytes are none.
    #[error("the state cannot be read: {0}")]
    Damaged(String),
}

const CONFIG: Configuration = standard();

macro_rules! state {
    ($owner:ident { $($field:ident),* } beside { $($rest:ident),* }) => {
        impl $owner {
            fn write_fields(&self, out: &mut Vec<u8>) -> Result<(), EncodeError> {
                let $owner { $($field,)* $($rest: _,)* } = self;
                $(bincode::serde::encode_into_std_write($field, out, CONFIG)?;)*
                Ok(())
            }

            fn read_fields(&mut self, from: &mut &[u8]) -> Result<(), DecodeError> {
                let $owner { $($field,)* $($rest: _,)* } = self;
                $(*$field = bincode::serde::decode_from_std_read(from, CONFIG)?;)*
                Ok(())
            }
        }
    };
}

state!(Frozen {
    region, held, piece, holds, dcus, tracked, tracking, started, running, previous, timer_s,
    timer_count, noises, lines
} beside { pieces, steps, weights, moving });

state!(Engine {
    ics, nets, probe, before, step, scheme, atol, largest, turned, grain, greatest, t_s, next_step_s,
    former_error, rated_start, rated, doubted, nodes, errors, thirds, former_thirds, former_cube,
    followed, former_region, active, doubts, probes, cuts, margins, margins_low, margins_high, paces,
    fixed_steps, past, missed, happenings, overloads, chatter_from_s, chatter, switched, statistics
} beside { machine, integration, frozen });

/// A digest that text is written to.
struct Digested(Sha256);

impl Write for Digested {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        self.0.update(text);
        Ok(())
    }
}

impl Engine {
    /// SHA-256 of the program and its settings, down to the last coefficient.
    fn identity(&self) -> [u8; 32] {
        let mut digest = Digested(Sha256::new());
        // A digest takes everything.
        let _ = write!(digest, "{:?} {:?}", self.machine, self.integration);
        digest.0.finalize().into()
    }

    /// The state, headed by the program that it belongs to.
    pub(crate) fn snapshot(&self) -> Result<Vec<u8>, SnapshotFault> {
        let mut bytes = self.identity().to_vec();
        let written =
            self.frozen.write_fields(&mut bytes).and_then(|()| self.write_fields(&mut bytes));
        written.map_err(|e| SnapshotFault::Damaged(e.to_string()))?;
        Ok(bytes)
    }

    /// Takes over a state; gives what follows it.
    pub(crate) fn restore<'b>(&mut self, bytes: &'b [u8]) -> Result<&'b [u8], SnapshotFault> {
        let identity = self.identity();
        let Some(mut rest) = bytes.strip_prefix(&identity) else {
            return Err(SnapshotFault::Foreign);
        };
        let read = self.frozen.read_fields(&mut rest).and_then(|()| self.read_fields(&mut rest));
        read.map_err(|e| SnapshotFault::Damaged(e.to_string()))?;
        self.load_functions();
        Ok(rest)
    }
}
