//! Error budget of one channel of the linkage.

use super::{Measure, hold, outcome::Outcome};
use crate::lab::{
    bench::Bench,
    loop_back::{Response, Route, Stages, window},
    theory::hold::Hold,
};
use desk::failure::Failure;
use desk::{
    bundle::bundle_from_path,
    report::{
        Cell, Heading, Table,
        plot::{Axis, Compared, measured_vs_theory},
    },
};
use interface::{Tick, profile::Profile};
use nalgebra::ComplexField;
use std::path::PathBuf;

/// Theory and a run with ideal resolution may differ by this, degrees and relative gain.
const LIMIT_DEG: f64 = 1e-3;
const LIMIT_GAIN: f64 = 1e-5;

/// Settings of [`super::Experiment::Budget`], whose text is the help.
#[derive(clap::Args)]
pub struct Budget {
    /// Frequency in Hz; moved to the nearest with whole cycles in whole frames
    #[arg(long, default_value_t = 1.0, value_name = "HZ")]
    frequency: f64,
    /// A patch that lends its channels, with their numbers and full scales [default: one ADC, one DAC]
    #[arg(long, value_name = "FILE")]
    patch: Option<PathBuf>,
    /// ADC of the patch [default: its first]
    #[arg(long, value_name = "NAME", requires = "patch")]
    adc: Option<String>,
    /// DAC of the patch [default: its first]
    #[arg(long, value_name = "NAME", requires = "patch")]
    dac: Option<String>,
    /// Frame period
    #[arg(long, default_value = "20ms", value_name = "TIME")]
    frame: Tick,
    /// Latency from sample to transfer, at most one frame [default: the profile's]
    #[arg(long, value_name = "TIME")]
    latency: Option<Tick>,
    /// Multiplexer skew between neighbouring ADC channels [default: the profile's]
    #[arg(long, value_name = "TIME")]
    skew: Option<Tick>,
    /// Aperture of the track-and-hold [default: the profile's]
    #[arg(long, value_name = "TIME")]
    aperture: Option<Tick>,
    /// Bits of ADC and DAC [default: the profile's]
    #[arg(long, value_name = "BITS")]
    bits: Option<u32>,
    /// Reconstruction: zero-order, extrapolating, interpolating [default: the profile's]
    #[arg(long, value_parser = hold, value_name = "HOLD")]
    hold: Option<Hold>,
    /// Settling time constant of the DAC [default: the profile's]
    #[arg(long, value_name = "TIME")]
    settling: Option<Tick>,
    /// Lead of the digital law, frames: u = m + a (m - m before)
    #[arg(long, default_value_t = 0.0, value_name = "FRAMES", allow_negative_numbers = true)]
    lead: f64,
}

impl Budget {
    fn stages(&self, profile: &Profile, channels: u32) -> Result<Stages, Failure> {
        let settling = profile.settling().time_constant_s();
        let of_profile = match profile.hold() {
            interface::hold::HoldKind::ZeroOrder => Hold::ZeroOrder,
            interface::hold::HoldKind::Extrapolating => Hold::Extrapolating,
            interface::hold::HoldKind::Interpolating => Hold::Interpolating,
        };
        if !self.lead.is_finite() {
            return Err(Failure::input("--lead must be finite"));
        }
        let skew = self.skew.unwrap_or_else(|| profile.skew());
        let scan = skew * i64::from(channels.saturating_sub(1));
        let latency = self
            .latency
            .unwrap_or_else(|| profile.total_latency(channels).max(scan).min(self.frame));
        let bits = |own: Option<&interface::profile::Sourced<u32>>| {
            self.bits.or_else(|| own.map(|b| b.value))
        };
        Ok(Stages {
            frame: self.frame,
            latency,
            skew,
            aperture: self.aperture.unwrap_or_else(|| profile.aperture()),
            adc_bits: bits(profile.adc.bits.as_ref()),
            dac_bits: bits(profile.dac.bits.as_ref()),
            hold: self.hold.unwrap_or(of_profile),
            settling: self.settling.or_else(|| Tick::from_secs(settling)).unwrap_or(Tick::ZERO),
            lead_frames: self.lead,
        })
    }
}

/// What `a` has that `b` has not.
fn ratio(a: Response, b: Response) -> Response {
    Response {
        gain: a.gain / b.gain,
        phase_rad: crate::lab::identify::angle_difference_rad(a.phase_rad, b.phase_rad),
    }
}

impl Measure for Budget {
    fn measure(&self, bench: &mut Bench<'_, '_>) -> Result<Outcome, Failure> {
        if self.frame <= Tick::ZERO {
            return Err(Failure::input("--frame must be positive"));
        }
        let profile = bench.base().clone();
        let route = match &self.patch {
            None => Route::simple(),
            Some(path) => {
                let bundle = bundle_from_path(path).map_err(Failure::input)?;
                bench.console().load(bundle, Vec::new(), Profile::ideal())?;
                Route::of(bench.console().channels(), self.adc.as_deref(), self.dac.as_deref())
                    .map_err(Failure::input)?
            }
        };
        let all = self.stages(&profile, route.scan.len() as u32)?;
        let window = window(self.frequency, self.frame)?;
        let omega = std::f64::consts::TAU * window.frequency_hz;
        let bare = Stages::bare(self.frame);
        let reference = bench.loop_back(&route, window, &bare)?;
        let mut alone = |change: &dyn Fn(&mut Stages), against: Response| {
            let mut stages = bare;
            change(&mut stages);
            bench.loop_back(&route, window, &stages).map(|r| ratio(r, against))
        };
        let theory = all.chain(&route).budget(omega);
        let mut measured: Vec<Option<Response>> = Vec::new();
        let later = alone(&|s| s.latency = all.latency, Response { gain: 1.0, phase_rad: 0.0 })?;
        for row in &theory {
            measured.push(match row.stage {
                "multiplexer skew" if all.skew > Tick::ZERO => {
                    Some(alone(&|s| (s.skew, s.latency) = (all.skew, all.latency), later)?)
                }
                "aperture" if all.aperture > Tick::ZERO => {
                    Some(alone(&|s| s.aperture = all.aperture, reference)?)
                }
                "analog-to-digital" if all.adc_bits.is_some() => {
                    Some(alone(&|s| s.adc_bits = all.adc_bits, reference)?)
                }
                "latency" if all.latency > Tick::ZERO => {
                    Some(alone(&|s| s.latency = all.latency, reference)?)
                }
                "digital lead" if all.lead_frames != 0.0 => {
                    Some(alone(&|s| s.lead_frames = all.lead_frames, reference)?)
                }
                "digital-to-analog" if all.dac_bits.is_some() => {
                    Some(alone(&|s| s.dac_bits = all.dac_bits, reference)?)
                }
                "hold" => {
                    Some(alone(&|s| s.hold = all.hold, Response { gain: 1.0, phase_rad: 0.0 })?)
                }
                "settling" if all.settling > Tick::ZERO => {
                    Some(alone(&|s| s.settling = all.settling, reference)?)
                }
                _ => None,
            });
        }
        let whole = bench.loop_back(&route, window, &all)?;
        if let Some(last) = measured.last_mut() {
            *last = Some(whole);
        }
        let mut table = Table::new(vec![
            Heading::new("stage", ""),
            Heading::new("gain theory", "").digits(7),
            Heading::new("gain measured", "").digits(7),
            Heading::new("phase theory", "deg").digits(6),
            Heading::new("phase measured", "deg").digits(6),
            Heading::new("delay, first order", "ms").digits(4),
            Heading::new("noise rms", "").digits(3),
        ]);
        let cell = |value: Option<f64>| value.map_or_else(|| Cell::from("off"), Cell::from);
        for (row, response) in theory.iter().zip(&measured) {
            table.row([
                row.stage.into(),
                row.gain.into(),
                cell(response.map(|r| r.gain)),
                row.phase_deg.into(),
                cell(response.map(|r| r.phase_rad.to_degrees())),
                (1e3 * row.delay_s).into(),
                row.noise_rms.into(),
            ]);
        }
        let mut outcome = Outcome::new(
            "budget",
            self.patch.as_ref().map_or("loop-back".to_owned(), |p| p.display().to_string()),
            format!("Error budget of a channel at {:.6} Hz", window.frequency_hz),
            "Gain and phase that each stage of the linkage adds at one frequency. Each stage is \
             measured alone against a bare zero-order hold, the whole chain at once.",
        );
        outcome.set("frequency-hz", window.frequency_hz);
        outcome.set("frame", self.frame.to_string());
        outcome.set("latency", all.latency.to_string());
        outcome.set("skew", all.skew.to_string());
        outcome.table(
            "budget",
            format!(
                "Place {} of {} in the scan, DAC {}; latency {}, skew {}.",
                route.position + 1,
                route.scan.len(),
                route.dac,
                all.latency,
                all.skew
            ),
            table,
        );
        let exact = all.chain(&route).transfer(omega);
        if all.adc_bits.is_none() && all.dac_bits.is_none() {
            let phase =
                crate::lab::identify::angle_difference_rad(whole.phase_rad, exact.argument())
                    .to_degrees()
                    .abs();
            let gain = (whole.gain / exact.modulus() - 1.0).abs();
            outcome.check(
                phase < LIMIT_DEG && gain < LIMIT_GAIN,
                format!(
                    "the whole chain is that of theory: {phase:.1e}° and {gain:.1e} of gain apart"
                ),
            );
        }
        self.over_frequency(bench, &route, &all, &mut outcome)?;
        Ok(outcome)
    }
}

impl Budget {
    /// The whole chain from a hundredth to near half of the sampling rate.
    fn over_frequency(
        &self,
        bench: &mut Bench<'_, '_>,
        route: &Route,
        all: &Stages,
        outcome: &mut Outcome,
    ) -> Result<(), Failure> {
        let rate = 1.0 / self.frame.secs();
        let chain = all.chain(route);
        let fundamental = |hz: f64| chain.transfer(std::f64::consts::TAU * hz);
        let turns = |list: &mut Vec<f64>| {
            // Unwrapped, in the order of frequency.
            for i in 1..list.len() {
                while list[i] - list[i - 1] > 180.0 {
                    list[i] -= 360.0;
                }
                while list[i] - list[i - 1] < -180.0 {
                    list[i] += 360.0;
                }
            }
        };
        let grid = |count: u32| {
            (0..count)
                .map(move |i| rate * 0.01 * libm::pow(45.0, f64::from(i) / f64::from(count - 1)))
        };
        let line: Vec<f64> = grid(80).collect();
        let line_gain: Vec<f64> = line.iter().map(|f| fundamental(*f).modulus()).collect();
        let mut line_phase: Vec<f64> =
            line.iter().map(|f| fundamental(*f).argument().to_degrees()).collect();
        turns(&mut line_phase);
        let (mut hz, mut gain, mut phase) = (Vec::new(), Vec::new(), Vec::new());
        for wanted in grid(10) {
            let window = window(wanted, self.frame)?;
            let response = bench.loop_back(route, window, all)?;
            hz.push(window.frequency_hz);
            gain.push(response.gain);
            phase.push(response.phase_rad.to_degrees());
        }
        turns(&mut phase);
        let axis = || Axis::new("frequency", "Hz").log();
        for (id, title, y, theory, measured) in [
            ("gain", "Gain of the channel", Axis::new("gain", ""), line_gain, gain),
            ("phase", "Phase of the channel", Axis::new("phase", "°"), line_phase, phase),
        ] {
            let compared = Compared {
                name: String::new(),
                theory: (line.clone(), theory),
                measured: (hz.clone(), measured),
            };
            outcome.chart(
                id,
                "Whole chain from a hundredth to near half of the sampling rate.",
                measured_vs_theory(title, axis(), y, &[compared]),
            );
        }
        Ok(())
    }
}
