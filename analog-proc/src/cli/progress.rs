//! Progress of a long run: a bar on a terminal, and a word where a stiff patch crawls.

use desk::note;
use engine::{integration::Method, simulation::Pulse};
use indicatif::{ProgressBar, ProgressStyle};
use interface::Tick;
use std::time::{Duration, Instant};

/// A run shorter than this shows no bar.
const QUIET: Duration = Duration::from_secs(1);
/// Time between two drawings.
const DRAWN: Duration = Duration::from_millis(100);
/// After this time a run that crawls is judged …
const JUDGED: Duration = Duration::from_secs(5);
/// … and told to be stiff where more than this is left of it,
const LONG: Duration = Duration::from_secs(60);
/// and in most of its steps the length times the fastest rate was above this. The stability
/// region of the explicit method ends at 3.3 on the real axis; where accuracy rules, at the
/// default tolerance, the product is below 0.1.
const AT_THE_EDGE: f64 = 2.5;
/// Parts of the bar.
const PARTS: u64 = 100_000;

/// Progress of one run.
pub struct Progress {
    bar: Option<ProgressBar>,
    started: Instant,
    drawn: Instant,
    from_s: f64,
    until_s: f64,
    until: Tick,
    /// Whether a stiff method is there to be recommended.
    explicit: bool,
    pulses: u64,
    at_the_edge: u64,
    told: bool,
}

impl Progress {
    /// Of a run that stands at `from`.
    pub fn new(from: Tick, until: Tick, method: Method) -> Progress {
        let now = Instant::now();
        Progress {
            bar: None,
            started: now,
            drawn: now,
            from_s: from.secs(),
            until_s: until.secs(),
            until,
            explicit: method == Method::DormandPrince,
            pulses: 0,
            at_the_edge: 0,
            told: false,
        }
    }

    /// So far it has come.
    pub fn at(&mut self, pulse: &Pulse) {
        self.pulses += 1;
        self.at_the_edge += u64::from(pulse.step_rate.is_some_and(|r| r > AT_THE_EDGE));
        if self.drawn.elapsed() < DRAWN {
            return;
        }
        self.drawn = Instant::now();
        let elapsed = self.started.elapsed();
        if elapsed >= QUIET {
            self.draw(pulse.t_s);
        }
        if elapsed >= JUDGED && !self.told && self.is_stiff(pulse.t_s, elapsed) {
            self.told = true;
            let text = "note: the patch looks stiff: its steps are as short as stability asks, not accuracy; try method = \"sdirk4\" under [integration]";
            match &self.bar {
                Some(bar) => bar.suspend(|| note!("{text}")),
                None => note!("{text}"),
            }
        }
    }

    fn is_stiff(&self, time_s: f64, elapsed: Duration) -> bool {
        let left_s = elapsed.as_secs_f64() * (self.until_s - time_s) / (time_s - self.from_s);
        self.explicit && left_s > LONG.as_secs_f64() && 2 * self.at_the_edge > self.pulses
    }

    fn draw(&mut self, time_s: f64) {
        let bar = self.bar.get_or_insert_with(|| {
            let bar = ProgressBar::new(PARTS).with_elapsed(self.started.elapsed());
            if let Ok(style) = ProgressStyle::with_template("{bar:30} {msg}, {eta} left") {
                bar.set_style(style);
            }
            bar
        });
        bar.set_message(format!("{time_s:.6} s of {}", self.until));
        bar.set_position((PARTS as f64 * time_s / self.until_s) as u64);
    }

    /// Takes the bar away.
    pub fn done(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
