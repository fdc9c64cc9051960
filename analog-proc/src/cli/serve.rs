//! `analog-proc serve`: the analog side of a session.

use super::Failure;
use crate::session::serve;
use desk::{
    command_line::{BAD_INPUT, INTERRUPTED, PARTNER_FAILED, expect_files, interrupt_flag},
    say,
};
use interface::{
    Side,
    link::{LinkFault, Patience, shm::ShmAnalog},
    session::{Session, SessionError},
};

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
        let interrupted = interrupt_flag().map_err(Failure::input)?;
        expect_files().map_err(Failure::input)?;
        let side = Side::Analog;
        let session = if self.joined {
            Session::join(side, &self.session)
        } else {
            Session::create(side, Some(&self.session))
        }
        .map_err(|fault| Failure {
            // The digital side started this one, and ended before it could come.
            code: match fault {
                SessionError::Deserted { .. } | SessionError::Unknown { .. } if self.joined => {
                    PARTNER_FAILED
                }
                _ => BAD_INPUT,
            },
            text: fault.to_string(),
        })?;
        let mut patience = Patience::interrupted_by(interrupted);
        if !self.joined {
            // Somebody will come from another terminal, whenever that is.
            patience.arrival = None;
            say!(
                "session `{}` waits; join it by: digital-proc fly --attach {}",
                self.session,
                self.session
            );
        }
        let served =
            ShmAnalog::open(&session, None, &patience).and_then(|mut port| serve::serve(&mut port));
        served.map_err(|fault| Failure {
            code: match &fault {
                LinkFault::Interrupted { .. } => INTERRUPTED,
                LinkFault::Transport { .. } if !self.joined => BAD_INPUT,
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
