//! What the command lines of both processors share: exit codes, the signals that end a
//! run, and output whose failure is told.
//!
//! Standard output may be a full disk, standard error a terminal that was closed. A line
//! that cannot be written never stops a program that still has a session to leave in good
//! order: as with the stream errors of C, the first failure is kept, and
//! [`exit`] turns it into a message and an exit code.

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use signal_hook::consts::{SIGHUP, SIGINT, SIGPIPE, SIGQUIT, SIGTERM};
use std::{
    fmt,
    io::{self, Write},
    process::ExitCode,
    sync::{Arc, OnceLock, atomic::AtomicBool},
};

/// Exit code for a claim or check that failed.
pub const CHECK_FAILED: u8 = 1;
/// Exit code for bad input or usage.
pub const BAD_INPUT: u8 = 2;
/// Exit code for a failed partner process.
pub const PARTNER_FAILED: u8 = 3;
/// Exit code for output that could not be written.
pub const OUTPUT_FAILED: u8 = 4;
/// Exit code after a signal that ends a run (128 + SIGINT, whichever of them it was).
pub const INTERRUPTED: u8 = 130;

/// Files that one side of a session has open at most, with some to spare: 32 suffice.
const FILES: u64 = 64;

/// The first failure of standard output.
static FAILED: OnceLock<io::Error> = OnceLock::new();

/// Lets a reader that has seen enough (`| head`) end this program quietly. To be called
/// before anything is written.
pub fn end_without_reader() {
    let always = Arc::new(AtomicBool::new(true));
    if let Err(error) = signal_hook::flag::register_conditional_default(SIGPIPE, always) {
        crate::note!("cannot catch signal {SIGPIPE}: {error}");
    }
}

/// A flag that each signal that ends a run sets: an interrupt, a request to end, a closed
/// terminal. Under `nohup` a closed terminal ends nothing.
pub fn interrupt_flag() -> io::Result<Arc<AtomicBool>> {
    let flag = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM, SIGHUP, SIGQUIT] {
        if signal != SIGHUP || !is_ignored(signal) {
            signal_hook::flag::register(signal, flag.clone())?;
        }
    }
    Ok(flag)
}

/// Whether this process was started with `signal` ignored.
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|l| l.strip_prefix("SigIgn:"));
    mask.and_then(|m| u64::from_str_radix(m.trim(), 16).ok())
        .is_some_and(|m| m >> (signal - 1) & 1 == 1)
}

/// Sees to it that this process may open as many files as a session needs.
pub fn expect_files() -> Result<(), String> {
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    let enough = |limit: Option<u64>| limit.is_none_or(|n| n >= FILES);
    let wanted = Rlimit { current: maximum.map_or(Some(FILES), |m| Some(m.min(FILES))), maximum };
    if enough(current) || (enough(maximum) && setrlimit(Resource::Nofile, wanted).is_ok()) {
        return Ok(());
    }
    Err(format!(
        "this process may open {} files only, and a session needs up to {FILES}; raise the limit, for example with `ulimit -n 1024`",
        maximum.unwrap_or_default()
    ))
}

/// Writes to standard output; a failure is kept for [`exit`]. Used through [`crate::say!`].
pub fn write_out(text: fmt::Arguments<'_>) {
    if FAILED.get().is_none()
        && let Err(error) = io::stdout().write_fmt(text)
    {
        let _ = FAILED.set(error);
    }
}

/// Writes a line to standard error; there is nobody to be told of a failure. Used through
/// [`crate::note!`].
pub fn write_note(text: fmt::Arguments<'_>) {
    let _ = writeln!(io::stderr(), "{text}");
}

/// Ends a program that comes to `code` and has `text` to say about it. Where standard
/// output failed too, and all else went well, the code is [`OUTPUT_FAILED`].
pub fn exit(code: u8, text: &str) -> ExitCode {
    if !text.trim().is_empty() {
        crate::note!("{}", text.trim_end());
    }
    let flushed = io::stdout().flush();
    let failed = FAILED.get().or(flushed.as_ref().err());
    let Some(error) = failed.filter(|e| e.kind() != io::ErrorKind::BrokenPipe) else {
        return ExitCode::from(code);
    };
    crate::note!("cannot write to standard output: {error}");
    ExitCode::from(if code == 0 { OUTPUT_FAILED } else { code })
}

/// As `println!`, but a failure is kept for `command_line::exit`.
#[macro_export]
macro_rules! say {
    () => { $crate::command_line::write_out(format_args!("\n")) };
    ($($text:tt)*) => {
        $crate::command_line::write_out(format_args!("{}\n", format_args!($($text)*)))
    };
}

/// As `eprintln!`, but never a panic.
#[macro_export]
macro_rules! note {
    ($($text:tt)*) => { $crate::command_line::write_note(format_args!($($text)*)) };
}
