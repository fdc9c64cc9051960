//! The command line of `analog-proc`. Exit codes stand in [`desk::command_line`].

mod check;
mod draw;
mod estimate;
mod linearise;
mod picture;
mod progress;
mod run;
mod serve;
mod sweep;

use crate::order::Ordered;
use clap::{Args, Parser, Subcommand};
use desk::{
    failure::Failure,
    outcome::Outcome,
    report::{Column, Table},
    run_dir::{PatchIdentity, RunRecord, UtcSecond},
    shell::{self, Manual},
};
use engine::{id::NetId, overload::LatchedOverload, simulation::Simulation};
use serde::{Deserialize, Serialize};
use std::{
    io::IsTerminal,
    path::{Path, PathBuf},
    process::ExitCode,
    time::SystemTime,
};

/// The analog processor: a parallel array of continuously integrated blocks, wired by a patch file.
///
/// Try it on a shipped patch:
///
///   analog-proc check patch-files/van-der-pol.toml
///   analog-proc run   patch-files/van-der-pol.toml --until 20s --out vdp.csv
///   analog-proc sweep patch-files/van-der-pol.toml --set mu=0.1:5:8 --until 30s --page mu.html
///   analog-proc draw  patch-files/van-der-pol.toml --out vdp.svg
///
/// The language of patch files and six exercises are in patch-files/README.md.
#[derive(Parser)]
#[command(name = "analog-proc", version, verbatim_doc_comment, propagate_version = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Check(check::Check),
    Run(run::Run),
    Resume(run::Resume),
    Sweep(sweep::Sweep),
    /// Draw a patch as an SVG wiring diagram in analog-computer symbols
    Draw(draw::Draw),
    Linearise(linearise::Linearise),
    /// Serve a session: the digital side joins it with `digital-proc --attach NAME`
    Serve(serve::Serve),
    #[command(flatten)]
    Manual(Manual),
}

/// What every command that reads a patch takes.
#[derive(Clone, Args, Serialize, Deserialize)]
struct PatchArgs {
    /// The patch file
    patch: PathBuf,
    /// Override a parameter of the patch, e.g. `--set mu=5`; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = parameter)]
    params: Vec<(String, f64)>,
    /// Machine profile: ideal, paper-class, ad4, or a file
    #[arg(long, default_value = "ideal")]
    profile: String,
    /// Print results and faults as JSON
    #[arg(long)]
    json: bool,
}

fn parameter(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.split_once('=').ok_or("write NAME=VALUE, for example mu=5")?;
    match value.trim().parse::<f64>() {
        Ok(v) if v.is_finite() => Ok((name.trim().to_owned(), v)),
        _ => Err(format!("`{value}` is not a finite number")),
    }
}

/// The net of that name.
fn find_net(ordered: &Ordered, name: &str) -> Result<NetId, Failure> {
    ordered.netlist.net(name).map_err(Failure::input)
}

/// Overloads and remarks of a run, in words.
fn happenings(ordered: &Ordered, simulation: &Simulation) -> Vec<String> {
    let overload = |o: &LatchedOverload| {
        format!("overload: {} at {} s", ordered.netlist.blocks[o.block.index()].name, o.t_s)
    };
    let remarks = simulation.remarks();
    let remarks = remarks.iter().map(ToString::to_string);
    simulation.overloads().iter().map(overload).chain(remarks).collect()
}

/// Refuses a page that is no file of its own.
fn expect_page(page: &Path, patch: &Path) -> Result<(), Failure> {
    if page.extension().is_none_or(|e| e != "html") {
        return Err(Failure::input("--page takes the name of a file, ending in .html"));
    }
    expect_output(page, patch, &["html"])
}

/// What a page says of the run that starts now.
fn page_record(
    command: &str,
    PatchArgs { patch, profile, params, .. }: &PatchArgs,
    hash: String,
) -> RunRecord {
    let mut record =
        RunRecord::begin(command, UtcSecond::from_system(SystemTime::now()), profile, "none");
    record.patch = Some(PatchIdentity { name: patch.display().to_string(), sha256: hash });
    record.parameters =
        params.iter().map(|(name, value)| (name.clone(), (*value).into())).collect();
    record
}

/// Writes the outcome's page.
fn write_page(outcome: &Outcome, record: &RunRecord, page: &Path) -> Result<(), Failure> {
    std::fs::write(page, outcome.page(record))
        .map_err(|e| Failure::output(format!("cannot write {}: {e}", page.display())))
}

/// Names the files that a command wrote; `-` is none.
fn add_files<'p>(outcome: &mut Outcome, files: impl IntoIterator<Item = &'p Path>) {
    let columns = [Column::new("File", "", |path: &&Path| path.display().to_string().into())];
    let written: Vec<&Path> = files.into_iter().filter(|file| file.as_os_str() != "-").collect();
    outcome.section("").long_table("files", "", Table::of(&columns, &written));
}

/// Whether messages go to a terminal whose user has not refused colours.
fn is_coloured() -> bool {
    std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty())
}

/// Refuses a file in a folder that is not there, before any work is done for it.
fn expect_folder(file: &Path) -> Result<(), Failure> {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            Err(Failure::input(format!(
                "cannot write {}: there is no folder {}; make it first, or name another file",
                file.display(),
                folder.display()
            )))
        }
        _ => Ok(()),
    }
}

/// Refuses an output that would replace the patch, or whose name promises a format that
/// is not written; `-` is standard output.
fn expect_output(out: &Path, patch: &Path, formats: &[&str]) -> Result<(), Failure> {
    if out.as_os_str() == "-" {
        return Ok(());
    }
    let named = formats.join(" or .");
    let same = matches!((out.canonicalize(), patch.canonicalize()), (Ok(o), Ok(p)) if o == p);
    if same {
        return Err(Failure::input(format!(
            "--out {} is the patch itself, which would be lost; name another file, ending in .{named}",
            out.display()
        )));
    }
    match out.extension() {
        Some(e) if !formats.iter().any(|f| e == *f) => Err(Failure::input(format!(
            "cannot write {}: its format is not known; name a file ending in .{named}, or `-` for standard output",
            out.display()
        ))),
        _ => expect_folder(out),
    }
}

/// Runs `analog-proc` on this process' arguments.
pub fn main() -> ExitCode {
    shell::main(|cli: Cli| match cli.command {
        Command::Check(c) => c.execute(),
        Command::Run(c) => c.execute(),
        Command::Resume(c) => c.execute(),
        Command::Sweep(c) => c.execute(),
        Command::Draw(c) => c.execute(),
        Command::Linearise(c) => c.execute(),
        Command::Serve(c) => c.execute(),
        Command::Manual(c) => c.execute::<Cli>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_output_replaces_the_patch_or_has_an_unknown_format() {
        let folder = tempfile::tempdir().expect("a folder");
        let patch = folder.path().join("p.toml");
        std::fs::write(&patch, "").expect("a patch");
        let around = folder.path().join(".").join("p.toml");
        let refusal = |out: &Path| {
            let failure = expect_output(out, &patch, &["csv", "arrow"]).err()?;
            assert_eq!(failure.code, 2);
            Some(failure.text)
        };
        assert!(refusal(&around).is_some_and(|t| t.contains("the patch itself")));
        let other = folder.path().join("q.toml");
        assert!(refusal(&other).is_some_and(|t| t.contains(".csv or .arrow")));
        for written in ["q.csv", "q.arrow", "q"] {
            assert_eq!(refusal(&folder.path().join(written)), None);
        }
        assert_eq!(refusal(Path::new("-")), None);
    }
}
