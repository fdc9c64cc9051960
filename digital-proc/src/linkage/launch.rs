//! Starting the analog side, and making sure that it ends.
//!
//! The partner is this very executable in the analog role, so that it is never
//! a stale build. A guard owns it: whatever happens, it is asked to end, then
//! killed, and always reaped. With the memory link the same analog code runs
//! within this thread. With `--attach` somebody else's analog-proc is
//! joined and left running.

use desk::command_line::expect_files;
use interface::{
    Side,
    link::{
        DigitalPort, LinkFault, Patience,
        direct::{Direct, MakeAnalog},
        shm::ShmDigital,
    },
    session::{Session, SessionError},
};
use rustix::process::{Pid, Signal, kill_process};
use std::{
    os::unix::process::CommandExt,
    process::{Child, Command, ExitStatus, Stdio},
    sync::{Arc, atomic::AtomicBool},
    time::{Duration, Instant},
};

/// How long a partner may take to leave by itself after a goodbye.
const GOODBYE: Duration = Duration::from_millis(50);
/// How long a partner that was told to end may take.
const FAREWELL: Duration = Duration::from_secs(2);

/// The analog side as the root binary hands it in: the processors do not know each other.
#[derive(Clone, Copy)]
pub struct AnalogEntry {
    /// An analog side for this process.
    pub side: MakeAnalog,
}

/// Which link joins the two sides.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LinkChoice {
    /// Two processes joined by shared memory.
    Shm,
    /// One thread.
    Memory,
    /// Shared memory with an analog-proc that runs already.
    Attach(String),
}

/// Why the analog side could not be started or joined.
#[derive(Debug, thiserror::Error)]
pub enum LaunchFault {
    /// The session could not be made or joined.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// The link could not be opened.
    #[error(transparent)]
    Link(#[from] LinkFault),
    /// Too few files may be opened for a link.
    #[error("{0}")]
    Files(String),
    /// The process could not be started.
    #[error("cannot start analog-proc: {0}")]
    Spawn(#[source] std::io::Error),
}

/// A started machine: the digital end of its link and whatever must end with it.
pub struct Started {
    // Field order is drop order: the port closes before the partner is awaited.
    port: Box<dyn DigitalPort>,
    _partner: Partner,
    fellow: Option<Fellow>,
}

/// A machine like another one that is not started yet, to be carried into another thread.
#[derive(Clone)]
pub struct Fellow {
    link: LinkChoice,
    analog: AnalogEntry,
}

impl Fellow {
    /// Starts it with nothing loaded; it gives up once `interrupted` is set.
    ///
    /// # Errors
    /// [`LaunchFault`], as of the first one.
    pub fn start(&self, interrupted: &Arc<AtomicBool>) -> Result<Started, LaunchFault> {
        Started::new(&self.link, self.analog, interrupted.clone())
    }

    /// Whether it is a pair of processes.
    pub fn is_pair(&self) -> bool {
        self.link != LinkChoice::Memory
    }
}

/// What is kept only to be dropped.
#[allow(dead_code)]
enum Partner {
    Process(Guard),
    Within,
    Foreign(Session),
}

impl Started {
    /// Starts or joins the analog side.
    pub fn new(
        link: &LinkChoice,
        analog: AnalogEntry,
        interrupted: Arc<AtomicBool>,
    ) -> Result<Started, LaunchFault> {
        let patience = Patience::interrupted_by(interrupted);
        let fellow = Some(Fellow { link: link.clone(), analog });
        if *link != LinkChoice::Memory {
            expect_files().map_err(LaunchFault::Files)?;
        }
        match link {
            LinkChoice::Memory => {
                let port = Direct::new(analog.side, &patience);
                Ok(Started { port: Box::new(port), _partner: Partner::Within, fellow })
            }
            LinkChoice::Shm => {
                let session = Session::create(Side::Digital, None)?;
                let child = Command::new("/proc/self/exe")
                    .arg0("analog-proc")
                    .args(["serve", "--session", session.name(), "--joined"])
                    // A Ctrl-C in the terminal is for the digital side, which ends both.
                    .process_group(0)
                    .stdin(Stdio::null())
                    .stdout(Stdio::null())
                    .spawn()
                    .map_err(LaunchFault::Spawn)?;
                let guard = Guard { child, session: session.clone() };
                let port = ShmDigital::open(&session, Some(guard.child.id()), &patience)?;
                Ok(Started { port: Box::new(port), _partner: Partner::Process(guard), fellow })
            }
            LinkChoice::Attach(name) => {
                let session = Session::join(Side::Digital, name)?;
                let port = ShmDigital::open(&session, None, &patience)?;
                let partner = Partner::Foreign(session);
                Ok(Started { port: Box::new(port), _partner: partner, fellow: None })
            }
        }
    }

    /// The digital end of the link, and what starts another machine like this one; nothing does
    /// where somebody else started it.
    pub(super) fn parts(&mut self) -> (&mut dyn DigitalPort, Option<Fellow>) {
        (self.port.as_mut(), self.fellow.clone())
    }
}

/// Owns the partner process: on drop it is awaited, killed if it lingers, and reaped.
struct Guard {
    child: Child,
    #[allow(dead_code)] // dropped after the child, so that the last trace is removed here
    session: Session,
}

impl Guard {
    fn wait(&mut self, patience: Duration) -> Option<ExitStatus> {
        let deadline = Instant::now() + patience;
        loop {
            match self.child.try_wait() {
                Ok(Some(status)) => return Some(status),
                Ok(None) if Instant::now() < deadline => {
                    std::thread::sleep(Duration::from_micros(200));
                }
                _ => return None,
            }
        }
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        if self.wait(GOODBYE).is_some() {
            return;
        }
        // No goodbye was said: this side was interrupted or failed.
        if let Some(pid) = i32::try_from(self.child.id()).ok().and_then(Pid::from_raw) {
            let _ = kill_process(pid, Signal::TERM);
            // One that is stopped hears of it only when it goes on.
            let _ = kill_process(pid, Signal::CONT);
        }
        if self.wait(FAREWELL).is_none() {
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}
