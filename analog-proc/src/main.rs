//! Stand-alone entry to the analog processor.

use std::process::ExitCode;

fn main() -> ExitCode {
    analog_proc::cli::main()
}
