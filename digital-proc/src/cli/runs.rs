//! `digital-proc list | export | plot`: what runs have left behind.

use desk::failure::Failure;
use desk::note;
use desk::{
    report::trace_report,
    run_dir::{
        DEFAULT_BASE, RunDirectory, RunState, TRANSFERS_FILE, Trace, list_runs, resolve, write_csv,
    },
};
use std::{
    io::{self, Write},
    path::{Path, PathBuf},
};

/// Name of the page that `plot` writes into the run's directory.
const PLOTS_FILE: &str = "plots.html";

/// The runs so far, oldest first.
#[derive(clap::Args)]
pub struct List {
    /// Directory where runs are kept
    #[arg(long, default_value = DEFAULT_BASE, value_name = "DIR")]
    runs: PathBuf,
    /// Print the list as JSON
    #[arg(long)]
    json: bool,
}

/// Which run is meant.
#[derive(clap::Args)]
struct Which {
    /// The run: its directory, its name, a beginning of its name, or `last`
    run: String,
    /// Directory where runs are kept
    #[arg(long, default_value = DEFAULT_BASE, value_name = "DIR")]
    runs: PathBuf,
}

/// A run's trace as comma-separated values.
///
/// One line a row: time in integer nanoseconds and in seconds, then every column with
/// its unit, in digits that determine each value to the last bit.
#[derive(clap::Args)]
pub struct Export {
    #[command(flatten)]
    which: Which,
    /// Comma-separated values, the one format so far
    #[arg(long)]
    csv: bool,
    /// The transfers of a flight on the wall clock, in place of the trace
    #[arg(long)]
    transfers: bool,
    /// File to write [default: standard output]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Every column of a run against time, as one HTML page.
#[derive(clap::Args)]
pub struct Plot {
    #[command(flatten)]
    which: Which,
    /// File to write [default: plots.html in the run's directory]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

impl Which {
    fn open(&self) -> Result<RunDirectory, Failure> {
        open_run(&self.runs, &self.run)
    }
}

/// The run that a user means by `text`. Where it is only the beginning of a name, the run that
/// was taken is told.
pub(super) fn open_run(base: &Path, text: &str) -> Result<RunDirectory, Failure> {
    let directory = resolve(base, text).map_err(Failure::input)?;
    let name = directory.name();
    if name != text && name.starts_with(text) {
        eprintln!("run {name}");
    }
    Ok(directory)
}

impl List {
    pub fn execute(self) -> Result<(), Failure> {
        let runs = list_runs(&self.runs)?;
        if self.json {
            let text = serde_json::to_string_pretty(&runs).map_err(Failure::input)?;
            return print(|out| writeln!(out, "{text}"));
        }
        if runs.is_empty() {
            let base = self.runs.display();
            return print(|out| writeln!(out, "no runs in `{base}`"));
        }
        let width = runs.iter().map(|r| r.name.chars().count()).max().unwrap_or(0);
        print(|out| {
            for run in &runs {
                let state = match run.state {
                    RunState::Complete => "complete  ",
                    RunState::Unreadable => "unreadable",
                    RunState::Unfinished => "unfinished",
                };
                writeln!(out, "{:width$}  {state}  {}", run.name, run.command)?;
            }
            Ok(())
        })
    }
}

impl Export {
    pub fn execute(self) -> Result<(), Failure> {
        // `--csv` names the format; without it there is the same one.
        let Export { which, csv: _, transfers, out } = self;
        let directory = which.open()?;
        let trace = if transfers {
            Trace::read(&directory.file(TRANSFERS_FILE))
        } else {
            directory.read_trace()
        }
        .map_err(Failure::input)?;
        if !trace.is_complete() {
            note!("the run was cut off: {} rows are whole", trace.rows());
        }
        match out {
            Some(path) => {
                trace.export_csv(&path)?;
                let (rows, path) = (trace.rows(), path.display());
                print(|out| writeln!(out, "{rows} rows: {path}"))
            }
            None => print(|out| write_csv(&trace, out)),
        }
    }
}

impl Plot {
    pub fn execute(self) -> Result<(), Failure> {
        let directory = self.which.open()?;
        let record = directory.read_record()?;
        let trace = directory.read_trace_thinned()?;
        let html = trace_report(&directory.name(), &trace, &record);
        let path = match self.out {
            Some(path) => {
                std::fs::write(&path, html).map_err(|e| {
                    Failure::output(format!("cannot write `{}`: {e}", path.display()))
                })?;
                path
            }
            None => {
                directory.write_file(PLOTS_FILE, html.as_bytes())?;
                directory.file(PLOTS_FILE)
            }
        };
        print(|out| writeln!(out, "plots: {}", path.display()))
    }
}

/// Writes to standard output. A reader that has seen enough (`| head`) is no fault.
fn print(write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Failure> {
    let mut out = io::BufWriter::new(io::stdout().lock());
    match write(&mut out).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::output(format!("cannot write the output: {error}")))
        }
        _ => Ok(()),
    }
}
