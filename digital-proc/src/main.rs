//! Role choice: this executable is the digital processor, and in the analog
//! role (by the name that it is started with) the analog one, so that the two
//! always come from one build.

use std::{path::Path, process::ExitCode};

fn main() -> ExitCode {
    let role = std::env::args_os().next();
    let is_analog = role
        .as_deref()
        .and_then(|name| Path::new(name).file_name())
        .is_some_and(|name| name == "analog-proc");
    if is_analog {
        // Started by way of /proc/self/exe it would be `exe` in a list of processes. Where
        // the system refuses, only that list is the poorer.
        let _ = rustix::thread::set_name(c"analog-proc");
        analog_proc::cli::main()
    } else {
        digital_proc::cli::main(digital_proc::linkage::launch::AnalogEntry {
            side: || Box::new(analog_proc::session::serve::Server::default()),
        })
    }
}
