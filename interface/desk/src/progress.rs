//! Progress of long work: a bar that appears only after the first second.

use indicatif::{ProgressBar, ProgressStyle};
use std::time::{Duration, Instant};

/// Work shorter than this shows no bar.
const QUIET: Duration = Duration::from_secs(1);

/// Progress of one piece of work.
pub struct Progress {
    bar: Option<ProgressBar>,
    started: Instant,
    total: u64,
    unit: &'static str,
}

impl Progress {
    /// `total` pieces of `unit` are to be done.
    pub fn new(total: u64, unit: &'static str) -> Progress {
        Progress { bar: None, started: Instant::now(), total, unit }
    }

    /// `done` pieces are done.
    pub fn at(&mut self, done: u64) {
        if self.bar.is_none() && self.started.elapsed() >= QUIET {
            let bar = ProgressBar::new(self.total);
            let template = format!("{{bar:40}} {{pos}} of {{len}} {}, {{eta}} left", self.unit);
            if let Ok(style) = ProgressStyle::with_template(&template) {
                bar.set_style(style);
            }
            self.bar = Some(bar);
        }
        if let Some(bar) = &self.bar {
            bar.set_position(done);
        }
    }

    /// Takes the bar away.
    pub fn done(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
