//! Error budget of one channel of the linkage, by a loop-back test of each stage.
//!
//! A generated patch puts a sine on an ADC, the digital side passes what it read to a DAC, and two
//! correlators on the analog side (sine and cosine products integrated over whole cycles and whole
//! frames, which is the least-squares fit of a sine) take the fundamental of the output. Only the
//! linkage is measured: a user's patch lends its channels with their numbers and full scales, not
//! its dynamics. The frequency is moved to the nearest one that has whole cycles in whole frames,
//! so that the images of the staircase drop out. Long by the patch that it writes.

use super::{
    bench::chosen,
    identify::{angle_difference_rad, correlated_phase_rad},
    theory::budget::{BudgetRow, Chain},
    *,
};
use desk::{bundle::bundle_from_path, faults::suggestion};
use interface::{
    control::{Channel, ChannelKind, PatchBundle},
    profile::Profile,
};
use std::path::PathBuf;

/// Theory and a run with ideal resolution may differ by this, degrees and relative gain.
const LIMIT_DEG: f64 = 1e-3;
const LIMIT_GAIN: f64 = 1e-5;
/// Frames over which is correlated, at least.
const LEAST_FRAMES: f64 = 400.0;

/// Gain and phase that each stage of a channel adds at one frequency
///
/// Gain and phase that each stage of a channel adds at one frequency, from theory and from runs.
///
/// The linkage of a patch is put in loop-back: a sine on the ADC, passed on by the digital side to
/// the DAC, taken by correlators over whole cycles. Each stage is measured alone against a bare
/// zero-order hold, and the whole chain at once. Stages come from --profile and from the flags.
///
///     digital-proc sampling budget --frequency 1
///     digital-proc sampling budget --patch patch-files/long-period.toml --adc adc_alpha --profile ad4
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
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
    /// Reconstruction [default: the profile's]
    #[arg(long, value_enum, value_name = "HOLD")]
    hold: Option<Hold>,
    /// Settling time constant of the DAC [default: the profile's]
    #[arg(long, value_name = "TIME")]
    settling: Option<Tick>,
    /// Lead of the digital law, frames: u = m + a (m - m before)
    #[arg(long, default_value_t = 0.0, value_name = "FRAMES", allow_negative_numbers = true)]
    lead: f64,
}

/// The channels under test.
#[derive(Debug, PartialEq)]
struct Route {
    /// ADC numbers, in order of the scan.
    scan: Vec<u32>,
    /// Place of the tested one in the scan.
    place: usize,
    dac: u32,
    /// ± full scale of both, problem units.
    full_scale: f64,
}

impl Route {
    /// The channels of a loaded patch: the ADC and DAC named, else the first of each.
    fn of(channels: &[Channel], adc: Option<&str>, dac: Option<&str>) -> Result<Route, String> {
        let find = |kind, what: &str, name: Option<&str>| {
            let mut all: Vec<&Channel> = channels.iter().filter(|c| c.kind == kind).collect();
            all.sort_by_key(|c| c.number);
            let place = match name {
                None if all.is_empty() => return Err(format!("the patch has no {what}")),
                None => 0,
                Some(name) => all.iter().position(|c| c.name == name).ok_or_else(|| {
                    let remedy = suggestion(name, all.iter().map(|c| c.name.as_str()));
                    format!("the patch has no {what} `{name}`; {remedy}")
                })?,
            };
            Ok((all, place))
        };
        let (adcs, place) = find(ChannelKind::Adc, "ADC", adc)?;
        let (dacs, at) = find(ChannelKind::Dac, "DAC", dac)?;
        Ok(Route {
            scan: adcs.iter().map(|c| c.number).collect(),
            place,
            dac: dacs[at].number,
            full_scale: adcs[place].full_scale.or(dacs[at].full_scale).unwrap_or(1.0),
        })
    }

    fn bare(&self, frame: Tick) -> Chain {
        Chain::bare(self.place as i64, self.full_scale, frame)
    }
}

/// Frequency and frames over which is correlated.
#[derive(Clone, Copy, Debug)]
struct Window {
    frequency_hz: f64,
    frames: u32,
}

impl Window {
    /// The window for a frequency near `wanted_hz`.
    fn near(wanted_hz: f64, frame: Tick) -> Result<Window, LabError> {
        let t = frame.secs();
        require(
            "the frequency",
            wanted_hz,
            wanted_hz > 0.0 && wanted_hz * t < 0.5 && wanted_hz * t > 1e-5,
            "between 1e-5 and one half of the sampling rate, in Hz",
        )?;
        let frames = LEAST_FRAMES.max((4.0 / (wanted_hz * t)).ceil());
        let cycles = (wanted_hz * frames * t).round().max(1.0);
        Ok(Window { frequency_hz: cycles / (frames * t), frames: frames as u32 })
    }
}

/// Gain and phase of a channel.
#[derive(Clone, Copy, Debug)]
struct Response {
    gain: f64,
    /// (−π, π]; negative is lag.
    phase_rad: f64,
}

impl Response {
    /// What this has that `other` has not.
    fn over(self, other: Response) -> Response {
        Response {
            gain: self.gain / other.gain,
            phase_rad: angle_difference_rad(self.phase_rad, other.phase_rad),
        }
    }
}

/// What a stage that is off has not.
fn off(value: Option<f64>) -> Cell {
    value.map_or_else(|| "off".into(), Cell::from)
}

/// The generated patch.
fn loop_back_patch(route: &Route, window: Window, frame: Tick) -> PatchBundle {
    let Route { scan, dac, full_scale, .. } = route;
    // Half of full scale: no code saturates, whatever the lead adds.
    let amplitude = full_scale / 2.0;
    let f = window.frequency_hz;
    let start = frame.secs() * f64::from(window.frames);
    let quarter = std::f64::consts::FRAC_PI_2;
    let adcs: String = scan
        .iter()
        .map(|n| format!("adc_{n} = {{ kind = \"adc\", in = [\"signal\"], channel = {n}, max = {full_scale:?} }}\n"))
        .collect();
    let text = format!(
        "title = \"Loop-back of the linkage\"\n\
         [blocks]\n\
         clock = {{ kind = \"time\" }}\n\
         running = {{ kind = \"comparator\", in = [\"clock\"], threshold = {start:?} }}\n\
         signal = {{ kind = \"signal-generator\", wave = \"sine\", amplitude = {amplitude:?}, frequency = {f:?} }}\n\
         sine = {{ kind = \"signal-generator\", wave = \"sine\", frequency = {f:?} }}\n\
         cosine = {{ kind = \"signal-generator\", wave = \"sine\", frequency = {f:?}, phase = {quarter:?} }}\n\
         {adcs}\
         output = {{ kind = \"dac\", channel = {dac}, max = {full_scale:?} }}\n\
         by_sine = {{ kind = \"multiplier\", in = [\"output\", \"sine\"] }}\n\
         by_cosine = {{ kind = \"multiplier\", in = [\"output\", \"cosine\"] }}\n\
         in_phase = {{ kind = \"integrator\", in = [\"by_sine\"], operate = \"running\" }}\n\
         quadrature = {{ kind = \"integrator\", in = [\"by_cosine\"], operate = \"running\" }}\n"
    );
    let root = "loop-back.toml".to_owned();
    PatchBundle { files: vec![(root.clone(), text)], root }
}

/// A machine with the stages of a chain and nothing else.
fn profile_of(chain: &Chain) -> Profile {
    let mut profile = Profile::ideal();
    let on = |time: Tick| Some(time).filter(|t| *t > Tick::ZERO).and_then(chosen);
    profile.adc.bits = chain.adc_bits.and_then(chosen);
    profile.dac.bits = chain.dac_bits.and_then(chosen);
    profile.adc.aperture = on(chain.aperture);
    profile.dac.settling = on(chain.settling);
    profile.dac.hold = chosen(chain.hold.into());
    profile
}

/// Gain and phase of one channel in loop-back.
fn loop_back(
    bench: &mut Bench<'_, '_>,
    route: &Route,
    window: Window,
    chain: &Chain,
) -> Result<Response, LabError> {
    let patch = loop_back_patch(route, window, chain.frame);
    bench.load(patch, Vec::new(), profile_of(chain))?;
    let (adc, dac) = (route.scan[route.place] as usize, route.dac as usize);
    let stop = chain.frame * (2 * i64::from(window.frames));
    let spec = lock_step(chain.frame, chain.latency, chain.skew, stop);
    let mut before = None;
    let saturated = bench.operate(&spec, &mut |samples, updates| {
        let m = samples.adc[adc];
        let last = before.replace(m).unwrap_or(m);
        updates.set_dac(dac, m + chain.lead_frames * (m - last));
    })?;
    let sums = bench.finish(saturated, &["in_phase", "quadrature"])?;
    let span_s = chain.frame.secs() * f64::from(window.frames);
    Ok(Response {
        gain: 2.0 * libm::hypot(sums[0], sums[1]) / (span_s * route.full_scale / 2.0),
        phase_rad: angle_difference_rad(correlated_phase_rad(sums[0], sums[1]), 0.0),
    })
}

impl Budget {
    fn route(&self, bench: &mut Bench<'_, '_>) -> Result<Route, Failure> {
        let Some(path) = &self.patch else {
            return Ok(Route { scan: vec![0], place: 0, dac: 0, full_scale: 1.0 });
        };
        let bundle = bundle_from_path(path).map_err(Failure::input)?;
        let channels = bench.load(bundle, Vec::new(), Profile::ideal())?;
        Route::of(channels, self.adc.as_deref(), self.dac.as_deref()).map_err(Failure::input)
    }

    /// All stages that are asked for, else those of the profile.
    fn chain(&self, profile: &Profile, route: &Route) -> Result<Chain, Failure> {
        if self.frame <= Tick::ZERO {
            return Err(Failure::input("--frame must be positive"));
        }
        if !self.lead.is_finite() {
            return Err(Failure::input("--lead must be finite"));
        }
        let channels = route.scan.len() as u32;
        let skew = self.skew.unwrap_or_else(|| profile.skew());
        let scan = skew * i64::from(channels.saturating_sub(1));
        let latency = || profile.total_latency(channels).max(scan).min(self.frame);
        Ok(Chain {
            latency: self.latency.unwrap_or_else(latency),
            skew,
            aperture: self.aperture.unwrap_or_else(|| profile.aperture()),
            adc_bits: self.bits.or(profile.adc.bits.as_ref().map(|b| b.value)),
            dac_bits: self.bits.or(profile.dac.bits.as_ref().map(|b| b.value)),
            hold: self.hold.unwrap_or_else(|| profile.hold().into()),
            settling: self.settling.unwrap_or_else(|| profile.settling()),
            lead_frames: self.lead,
            ..route.bare(self.frame)
        })
    }
}

impl Experiment for Budget {
    const NAME: &'static str = "budget";
    const TITLE: &'static str = "Error budget of a channel";
    const LEAD: &'static str = "Gain and phase that each stage of the linkage adds at one frequency. \
        Each stage is measured alone against a bare zero-order hold, the whole chain at once.";

    fn measure(&self, bench: &mut Bench<'_, '_>, outcome: &mut Outcome) -> Result<(), Failure> {
        let route = self.route(bench)?;
        let all = self.chain(&bench.base().clone(), &route)?;
        let window = Window::near(self.frequency, self.frame)?;
        outcome.title = format!("Error budget of a channel at {:.6} Hz", window.frequency_hz);
        if let Some(patch) = &self.patch {
            outcome.set("channels-of", patch.display().to_string());
        }
        outcome.set("frequency-hz", window.frequency_hz);
        outcome.set("frame", self.frame.to_string());
        outcome.set("latency", all.latency.to_string());
        outcome.set("skew", all.skew.to_string());

        let bare = route.bare(self.frame);
        let late = Chain { latency: all.latency, ..bare };
        let mut run = |chain: &Chain| loop_back(bench, &route, window, chain);
        let unity = Response { gain: 1.0, phase_rad: 0.0 };
        let hold_alone = run(&bare)?;
        let late_alone = run(&late)?;
        // A stage that is on, alone, and what the same run has without it; in the order of theory.
        let stages = [
            (all.skew > Tick::ZERO, Chain { skew: all.skew, ..late }, late_alone),
            (all.aperture > Tick::ZERO, Chain { aperture: all.aperture, ..bare }, hold_alone),
            (all.adc_bits.is_some(), Chain { adc_bits: all.adc_bits, ..bare }, hold_alone),
            (all.latency > Tick::ZERO, late, hold_alone),
            (all.lead_frames != 0.0, Chain { lead_frames: all.lead_frames, ..bare }, hold_alone),
            (all.dac_bits.is_some(), Chain { dac_bits: all.dac_bits, ..bare }, hold_alone),
            (true, Chain { hold: all.hold, ..bare }, unity),
            (all.settling > Tick::ZERO, Chain { settling: all.settling, ..bare }, hold_alone),
            (true, all, unity),
        ];
        let omega = TAU * window.frequency_hz;
        let mut rows: Vec<(BudgetRow, Option<Response>)> = Vec::new();
        for (theory, (on, chain, without)) in all.budget(omega).into_iter().zip(stages) {
            let measured = on.then(|| run(&chain)).transpose()?;
            rows.push((theory, measured.map(|r| r.over(without))));
        }
        let columns = [
            Column::new("stage", "", |(t, _): &(BudgetRow, Option<Response>)| t.stage.into()),
            Column::of("gain theory", "", 7, |(t, _)| t.gain.into()),
            Column::of("gain measured", "", 7, |(_, m)| off(m.map(|r| r.gain))),
            Column::of("phase theory", "deg", 6, |(t, _)| t.phase_deg.into()),
            Column::of("phase measured", "deg", 6, |(_, m)| {
                off(m.map(|r| r.phase_rad.to_degrees()))
            }),
            Column::new("delay, first order", "ms", |(t, _)| (1e3 * t.delay_s).into()),
            Column::of("noise rms", "", 3, |(t, _)| t.noise_rms.into()),
        ];
        let caption = format!(
            "Place {} of {} in the scan, DAC {}; latency {}, skew {}.",
            route.place + 1,
            route.scan.len(),
            route.dac,
            all.latency,
            all.skew
        );
        outcome.section("Numbers").table("budget", caption, Table::of(&columns, &rows));
        if let (Some((_, Some(whole))), None, None) = (rows.last(), all.adc_bits, all.dac_bits) {
            let exact = all.transfer(omega);
            let phase = angle_difference_rad(whole.phase_rad, exact.argument()).to_degrees().abs();
            let gain = (whole.gain / exact.modulus() - 1.0).abs();
            outcome.check(
                "chain",
                format!(
                    "the whole chain is that of theory: {phase:.1e}° and {gain:.1e} of gain apart"
                ),
                phase < LIMIT_DEG && gain < LIMIT_GAIN,
            );
        }
        self.over_frequency(bench, &route, &all, outcome)?;
        Ok(())
    }
}

impl Budget {
    /// The whole chain from a hundredth to near half of the sampling rate.
    fn over_frequency(
        &self,
        bench: &mut Bench<'_, '_>,
        route: &Route,
        all: &Chain,
        outcome: &mut Outcome,
    ) -> Result<(), LabError> {
        let rate = 1.0 / self.frame.secs();
        let grid = |count| ratios(0.01 * rate, 0.45 * rate, count);
        let theory = grid(80).map(|hz| {
            let h = all.transfer(TAU * hz);
            (hz, Response { gain: h.modulus(), phase_rad: h.argument() })
        });
        let measured = bench.each(grid(10), |bench, wanted| {
            let window = Window::near(wanted, self.frame)?;
            Ok::<_, LabError>((window.frequency_hz, loop_back(bench, route, window, all)?))
        })?;
        let (theory, measured) = (unwrapped(theory), unwrapped(measured));
        let caption = "Whole chain from a hundredth to near half of the sampling rate.";
        for (id, title, y, of) in [
            ("gain", "Gain of the channel", Axis::new("gain", ""), 0),
            ("phase", "Phase of the channel", Axis::new("phase", "°"), 1),
        ] {
            let points = |all: &[(f64, [f64; 2])]| all.iter().map(|(hz, r)| (*hz, r[of])).unzip();
            let (theory, measured) = (points(&theory), points(&measured));
            let compared = Compared { name: String::new(), theory, measured };
            let x = Axis::new("frequency", "Hz").log();
            let chart = measured_vs_theory(title, x, y, &[compared]);
            outcome.section("Figures").chart(id, caption, &chart);
        }
        Ok(())
    }
}

/// Gains and phases in degrees, these without jumps of whole turns, in the order of frequency.
fn unwrapped(responses: impl IntoIterator<Item = (f64, Response)>) -> Vec<(f64, [f64; 2])> {
    let mut before: Option<f64> = None;
    let mut one = |(hz, r): (f64, Response)| {
        let deg = r.phase_rad.to_degrees();
        let turns = before.map_or(0.0, |before| ((before - deg) / 360.0).round());
        let deg = deg + 360.0 * turns;
        before = Some(deg);
        (hz, [r.gain, deg])
    };
    responses.into_iter().map(&mut one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_window_has_whole_cycles_in_whole_frames() {
        let frame = Tick(10_000_000);
        let w = Window::near(1.0, frame).unwrap();
        assert_eq!((w.frequency_hz, w.frames), (1.0, 400));
        // 37 Hz at 100 frames a second is the nearest multiple of 1/4 s⁻¹ itself.
        assert!((Window::near(36.9, frame).unwrap().frequency_hz - 37.0).abs() < 0.126);
        for bad in [0.0, -1.0, 50.0, 1e9, f64::NAN] {
            assert!(Window::near(bad, frame).is_err(), "{bad}");
        }
    }

    #[test]
    fn channels_are_found_by_name() {
        let channel = |kind, name: &str, number, full_scale| Channel {
            kind,
            name: name.to_owned(),
            number,
            full_scale,
        };
        let all = [
            channel(ChannelKind::Adc, "b", 3, Some(5.0)),
            channel(ChannelKind::Adc, "a", 1, None),
            channel(ChannelKind::Dac, "u", 2, Some(7.0)),
        ];
        let route = Route { scan: vec![1, 3], place: 1, dac: 2, full_scale: 5.0 };
        assert_eq!(Route::of(&all, Some("b"), None).unwrap(), route);
        assert_eq!(Route::of(&all, None, Some("u")).unwrap().full_scale, 7.0);
        assert!(Route::of(&all, Some("x"), None).unwrap_err().contains("has no ADC `x`"));
    }
}
