//! Every command of the teaching text does what the text says: the `sh` blocks of
//! patch-files/README.md are run as they stand, and the `text` block after one is
//! compared with what the command wrote.
//!
//! A command line may end in `# exits with N`. The words of a `text` line must stand
//! side by side in a line of the output, and these lines in order; a number agrees
//! if it is the number found, rounded to the digits that the text shows.

use crate::bench_top::{ANALOG, BenchTop, DIGITAL, wait_within};
use std::{
    path::{Path, PathBuf},
    process::{Command, Stdio},
    time::Duration,
};

/// No command of a lesson may take longer than this, on a loaded machine without optimisation.
const PATIENCE: Duration = Duration::from_secs(600);

fn teaching_text() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("patch-files/README.md");
    std::fs::read_to_string(path).unwrap()
}

/// One command with what it is to do.
#[derive(Debug, PartialEq)]
struct Step {
    command: String,
    code: i32,
    shows: Vec<String>,
}

/// A chapter: its heading and its commands.
#[derive(Debug)]
struct Chapter {
    heading: String,
    steps: Vec<Step>,
}

fn chapters(text: &str) -> Vec<Chapter> {
    let mut chapters: Vec<Chapter> = Vec::new();
    let mut fence: Option<String> = None;
    for line in text.lines() {
        if let Some(language) = line.strip_prefix("```") {
            fence = match fence {
                None => Some(language.trim().to_owned()),
                Some(_) => None,
            };
            continue;
        }
        if fence.is_none() {
            if let Some(heading) = line.strip_prefix("## ") {
                chapters.push(Chapter { heading: heading.to_owned(), steps: Vec::new() });
            }
            continue;
        }
        let Some(chapter) = chapters.last_mut().filter(|_| !line.trim().is_empty()) else {
            continue;
        };
        match fence.as_deref() {
            Some("sh") => chapter.steps.push(step(line)),
            Some("text") => {
                let step = chapter.steps.last_mut();
                step.expect("a text block follows a command").shows.push(line.to_owned());
            }
            _ => {}
        }
    }
    chapters
}

fn step(line: &str) -> Step {
    let (command, code) = match line.split_once("# exits with ") {
        Some((command, code)) => (command, code.trim().parse().unwrap()),
        None => (line, 0),
    };
    Step {
        command: command.trim().replace("cargo run --release -- ", "digital-proc "),
        code,
        shows: Vec::new(),
    }
}

fn words(line: &str) -> Vec<&str> {
    line.split([' ', ',', ':', '(', ')']).filter(|w| !w.is_empty()).collect()
}

/// Whether `found` is `shown`, or rounds to it at the digits shown.
fn agree(shown: &str, found: &str) -> bool {
    if shown == found {
        return true;
    }
    let (Ok(a), Ok(b)) = (shown.parse::<f64>(), found.parse::<f64>()) else {
        return false;
    };
    let (mantissa, exponent) = shown.split_once('e').unwrap_or((shown, "0"));
    let decimals = mantissa.split_once('.').map_or(0, |(_, d)| d.len());
    let unit = 10_f64.powi(exponent.parse::<i32>().unwrap() - decimals as i32);
    // Half a unit of the last place shown, and the rounding of this sum.
    (a - b).abs() <= 0.5 * unit * (1.0 + 1e-9)
}

fn shows(output: &str, lines: &[String]) -> Result<(), String> {
    let mut rest = output.lines();
    for line in lines {
        let wanted = words(line);
        let is_it = |found: &str| {
            let found = words(found);
            let mut parts = found.windows(wanted.len());
            parts.any(|part| wanted.iter().zip(part).all(|(w, f)| agree(w, f)))
        };
        if !rest.any(is_it) {
            return Err(format!("does not show `{line}`"));
        }
    }
    Ok(())
}

/// A copy of the patches, where a lesson may make files.
fn desk(bench: &BenchTop) -> PathBuf {
    fn copy(from: &Path, to: &Path) {
        std::fs::create_dir_all(to).unwrap();
        for entry in std::fs::read_dir(from).unwrap() {
            let entry = entry.unwrap();
            let target = to.join(entry.file_name());
            if entry.path().is_dir() {
                copy(&entry.path(), &target);
            } else {
                std::fs::copy(entry.path(), target).unwrap();
            }
        }
    }
    let desk = bench.runs();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("patch-files");
    copy(&shipped, &desk.join("patch-files"));
    desk
}

fn run_chapter(heading: &str) {
    let chapters = chapters(&teaching_text());
    let chapter = chapters
        .iter()
        .find(|c| c.heading.starts_with(heading))
        .unwrap_or_else(|| panic!("the teaching text has no chapter `{heading}`"));
    assert!(!chapter.steps.is_empty(), "{heading}: no commands");
    let bench = BenchTop::new();
    let desk = desk(&bench);
    let folders = [ANALOG, DIGITAL].map(|b| Path::new(b).parent().unwrap().to_owned());
    let own = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths(folders.into_iter().chain(std::env::split_paths(&own)));
    let path = path.unwrap();
    for step in &chapter.steps {
        let child = Command::new("sh")
            .args(["-c", &format!("( {} ) >.said 2>&1", step.command)])
            .current_dir(&desk)
            .env("PATH", &path)
            .env("HYBRID_BASE", bench.base())
            .stdin(Stdio::null())
            .spawn()
            .unwrap();
        let (output, _) = wait_within(child, PATIENCE);
        let said = std::fs::read_to_string(desk.join(".said")).unwrap();
        assert_eq!(output.status.code(), Some(step.code), "{heading}: {}\n{said}", step.command);
        if let Err(why) = shows(&said, &step.shows) {
            panic!("{heading}: {}: {why}\n{said}", step.command);
        }
    }
}

/// A test for each chapter with commands.
macro_rules! lessons {
    ($($test:ident $heading:literal)+) => {
        const TESTED: &[&str] = &[$($heading),+];

        $(
            #[test]
            fn $test() {
                run_chapter($heading);
            }
        )+
    };
}

lessons! {
    the_language "The language"
    the_shipped_patches "The shipped patches"
    exercise_1_decay "Exercise 1"
    exercise_2_offset "Exercise 2"
    exercise_3_scaling "Exercise 3"
    exercise_4_circle "Exercise 4"
    exercise_5_redundant_integrator "Exercise 5"
    exercise_6_gain_schedule "Exercise 6"
    a_loop_of_your_own "A loop of your own"
}

#[test]
fn every_chapter_with_commands_is_run() {
    for chapter in chapters(&teaching_text()) {
        let is_tested = TESTED.iter().any(|t| chapter.heading.starts_with(t));
        let heading = chapter.heading;
        assert!(is_tested || chapter.steps.is_empty(), "no test runs the commands of `{heading}`");
    }
}

#[test]
fn a_number_agrees_to_the_digits_shown() {
    assert!(agree("0.37", "3.6787944117036830e-1"));
    assert!(!agree("0.36", "3.6787944117036830e-1"));
    assert!(agree("-1.5e-3", "-0.00151"));
    assert!(!agree("x", "0.0"));
    let output = "time,x\n0,1.0\n0.5,0.3679\n";
    assert!(shows(output, &["time x".into(), "0.5 0.37".into()]).is_ok());
    assert!(shows(output, &["0.5 0.37".into(), "time x".into()]).is_err());
}
