//! `analog-proc serve`: the analog side of a session.

use super::{BAD_INPUT, Failure, PARTNER_FAILED};
use crate::serve;
use interface::{
    Side,
    link::{LinkFault, Patience, shm::ShmAnalog},
    session::Session,
};
use std::sync::{Arc, atomic::AtomicBool};

/// Exit code after an interrupt (128 + SIGINT).
const INTERRUPTED: u8 = 130;

/// Serve a session.
#[derive(clap::Args)]
pub struct Serve {
    /// Name of the session, which the digital side gives to --attach
    #[arg(long)]
    session: String,
    /// Join a session that the digital side has made, and end with it
    #[arg(long, hide = true)]
    joined: bool,
}

impl Serve {
    pub fn execute(self) -> Result<(), Failure> {
        let interrupted = Arc::new(AtomicBool::new(false));
        for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
            signal_hook::flag::register(signal, interrupted.clone()).map_err(Failure::input)?;
        }
        let side = Side::Analog;
        let session = if self.joined {
            Session::join(side, &self.session)
        } else {
            Session::create(side, Some(&self.session))
        }
        .map_err(Failure::input)?;
        let mut patience = Patience::interrupted_by(interrupted);
        if !self.joined {
            // Somebody will come from another terminal, whenever that is.
            patience.arrival = None;
            println!(
                "session `{}` waits; join it by: digital-proc fly --attach {}",
                self.session, self.session
            );
        }
        let served =
            ShmAnalog::open(&session, None, &patience).and_then(|mut port| serve::serve(&mut port));
        served.map_err(|fault| Failure {
            code: match &fault {
                LinkFault::Interrupted { .. } => INTERRUPTED,
                LinkFault::Transport { .. } => BAD_INPUT,
                _ => PARTNER_FAILED,
            },
            text: match fault {
                // The digital side that started this one has said why.
                LinkFault::Interrupted { .. } if self.joined => String::new(),
                fault => fault.to_string(),
            },
        })
    }
}
