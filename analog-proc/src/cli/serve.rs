//! `analog-proc serve`: the analog side of a session.

use crate::session::serve;
use desk::{
    command_line::{expect_files, interrupt_flag},
    failure::Failure,
    say,
};
use interface::{
    Side,
    link::{LinkFault, Patience, shm::ShmAnalog},
    session::{Session, SessionError},
};

/// Serve a session, until the command that joins it has ended.
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
        .map_err(|fault| match fault {
            // The digital side started this one, and ended before it could come.
            SessionError::Deserted { .. } | SessionError::Unknown { .. } if self.joined => {
                Failure::partner(fault)
            }
            _ => Failure::input(fault),
        })?;
        let mut patience = Patience::interrupted_by(interrupted);
        if !self.joined {
            // Somebody will come from another terminal, whenever that is.
            patience.arrival = None;
            say!(
                "session `{}` waits for one command and ends with it; join it by: digital-proc fly --attach {}",
                self.session,
                self.session
            );
        }
        let served =
            ShmAnalog::open(&session, None, &patience).and_then(|mut port| serve::serve(&mut port));
        served.map_err(|fault| match fault {
            // The digital side that started this one has said why.
            LinkFault::Interrupted { .. } if self.joined => Failure::interrupted(""),
            LinkFault::Transport { .. } if !self.joined => Failure::input(fault),
            fault => fault.into(),
        })
    }
}
