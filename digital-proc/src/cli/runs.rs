//! `digital-proc list | export | plot`: what runs have left behind.

use crate::study::short_period::point::{QUANTITIES, Quantity};
use desk::{
    failure::Failure,
    note,
    outcome::{Figure, Outcome},
    report::{
        Column, Table, anchor,
        plot::{Axis, LineChart, Series, Size, line_chart},
    },
    run_dir::{
        DEFAULT_BASE, RunDirectory, RunEntry, RunState, TRANSFERS_FILE, Trace, list_runs, resolve,
        write_csv,
    },
};
use std::{
    io::{self, Write},
    path::{Path, PathBuf},
};

/// Name of the page that `plot` writes into the run's directory.
const PLOTS_FILE: &str = "plots.html";

/// The runs so far, oldest first, or what a study or dispersion file may change.
#[derive(clap::Args)]
pub struct List {
    /// What to list
    #[arg(value_enum, default_value = "runs")]
    what: Listed,
    /// Directory where runs are kept
    #[arg(long, default_value = DEFAULT_BASE, value_name = "DIR")]
    runs: PathBuf,
    /// Print the list as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Listed {
    /// The runs so far, oldest first
    Runs,
    /// Quantities of a trajectory point that a study or dispersion file may change
    Quantities,
}

/// Which run is meant.
#[derive(clap::Args)]
pub(super) struct Which {
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
    /// Print what was written as JSON
    #[arg(long, requires = "out")]
    json: bool,
}

/// Every column of a run against time, as one HTML page.
#[derive(clap::Args)]
pub struct Plot {
    #[command(flatten)]
    which: Which,
    /// File to write [default: plots.html in the run's directory]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Print what was written as JSON
    #[arg(long)]
    json: bool,
}

impl Which {
    /// The run that is meant. Where `last` or the beginning of a name leads to it, it is told.
    pub(super) fn open(&self) -> Result<RunDirectory, Failure> {
        let directory = resolve(&self.runs, &self.run)?;
        let name = directory.name();
        if name != self.run && Path::new(&self.run).components().count() == 1 {
            note!("run {name}");
        }
        Ok(directory)
    }
}

impl List {
    pub fn execute(self) -> Result<(), Failure> {
        match self.what {
            Listed::Runs => self.runs(),
            Listed::Quantities => self.quantities(),
        }
    }

    fn quantities(&self) -> Result<(), Failure> {
        let columns = [
            Column::new("Name", "", |q: &Quantity| q.name.into()),
            Column::new("Unit", "", |q: &Quantity| q.unit.into()),
            Column::new("Range", "", |q: &Quantity| q.range.words().into()),
        ];
        let mut outcome = Outcome::default();
        let caption = "Quantities that a study file may change; a unit of a `set` is this one.";
        outcome.section("").table("quantities", caption, Table::of(&columns, QUANTITIES));
        outcome.tell("list", None, self.json)
    }

    fn runs(&self) -> Result<(), Failure> {
        let runs = list_runs(&self.runs)?;
        let base = self.runs.display();
        let title = if runs.is_empty() { format!("no runs in `{base}`") } else { String::new() };
        let columns = [
            Column::new("Name", "", |run: &RunEntry| run.name.as_str().into()),
            Column::new("State", "", |run: &RunEntry| match run.state {
                RunState::Complete => "complete".into(),
                RunState::Unreadable => "unreadable".into(),
                RunState::Unfinished => "unfinished".into(),
            }),
            Column::new("Command", "", |run: &RunEntry| run.command.as_str().into()),
            Column::new("Started", "", |run: &RunEntry| run.started.as_str().into()),
            Column::new("Path", "", |run: &RunEntry| run.path.display().to_string().into()),
        ];
        let mut outcome = Outcome::new(title, "");
        let table = Table::of(&columns, &runs);
        if self.json {
            outcome.section("").long_table("runs", "", table);
        } else if !runs.is_empty() {
            outcome.title = Table::of(&columns[..3], &runs).text();
        }
        outcome.tell("list", None, self.json)
    }
}

impl Export {
    pub fn execute(self) -> Result<(), Failure> {
        // `--csv` names the format; without it there is the same one.
        let Export { which, csv: _, transfers, out, json } = self;
        let directory = which.open()?;
        let trace = if transfers {
            Trace::read(&directory.file(TRANSFERS_FILE))
        } else {
            directory.read_trace()
        }?;
        if !trace.is_complete() {
            note!("the run was cut off: {} rows are whole", trace.rows());
        }
        match out {
            Some(path) => {
                trace.export_csv(&path)?;
                let title = format!("{} rows: {}", trace.rows(), path.display());
                let rows = Some(trace.rows());
                tell_file("export", title, rows, &path, &directory, json)
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
        let mut outcome = Outcome::new(directory.name(), "");
        let time_s = trace.time_s();
        let columns = trace.columns().iter().enumerate();
        let figures = columns.filter_map(|(index, column)| {
            let series = Series::line("", &time_s, trace.values(index)?);
            let (x, y) = (Axis::new("Time", "s"), Axis::new(&*column.name, &*column.unit));
            let chart = LineChart::new("", x, y, vec![series]).size(Size::HALF);
            let caption = format!("{} against time.", column.name);
            Some(Figure::new(anchor(&column.name), caption, line_chart(&chart)))
        });
        let mut extent = format!("{} rows of {} columns.", trace.recorded(), trace.columns().len());
        if !trace.is_complete() {
            extent +=
                " The run did not end its trace: rows after the last complete batch are lost.";
        }
        outcome.section("Time histories").aside(extent).beside(figures.collect());
        let html = outcome.page(&record);
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
        let title = format!("plots: {}", path.display());
        tell_file("plot", title, None, &path, &directory, self.json)
    }
}

/// Says which file was made of a run.
fn tell_file(
    command: &str,
    title: String,
    rows: Option<usize>,
    path: &Path,
    run: &RunDirectory,
    json: bool,
) -> Result<(), Failure> {
    let mut outcome = Outcome::new(title, "");
    if json && let Some(rows) = rows {
        outcome.results.add("rows", "Rows", rows as f64, 17, "", "");
    }
    let columns = [Column::new("File", "", |path: &&Path| path.display().to_string().into())];
    outcome.section("").long_table("files", "", Table::of(&columns, [&path]));
    outcome.tell(command, Some(run.path()), json)
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
