//! Loop-back test of one channel of the linkage: its gain and phase at one frequency.
//!
//! A generated patch puts a sine on an ADC, the digital side passes what it read to a DAC, and two
//! correlators on the analog side (sine and cosine products integrated over whole cycles and whole
//! frames, which is the least-squares fit of a sine) take the fundamental of the output. Only the
//! linkage is measured: a user's patch lends its channels with their numbers and full scales, not
//! its dynamics. The frequency is moved to the nearest one that has whole cycles in whole frames,
//! so that the images of the staircase drop out.

use super::{
    bench::{Bench, BenchFault, chosen, hold_kind},
    identify::{angle_difference_rad, correlated_phase_rad},
    plan::{LabError, require},
    theory::{budget::Chain, hold::Hold},
};
use interface::{
    Tick,
    control::{Channel, ChannelKind, PatchBundle},
    profile::Profile,
};

/// Frames over which is correlated, at least.
const LEAST_FRAMES: f64 = 400.0;

/// The channels under test.
#[derive(Clone, Debug, PartialEq)]
pub struct Route {
    /// ADC numbers, in order of the scan.
    pub scan: Vec<u32>,
    /// Place of the tested one in the scan.
    pub position: usize,
    /// DAC number.
    pub dac: u32,
    /// Full scale of both, problem units.
    pub full_scale: f64,
}

impl Route {
    /// One ADC and one DAC of full scale 1.
    pub fn simple() -> Route {
        Route { scan: vec![0], position: 0, dac: 0, full_scale: 1.0 }
    }

    /// The channels of a loaded patch: the ADC and DAC named, else the first of each.
    ///
    /// # Errors
    /// A text that names what the patch lacks.
    pub fn of(channels: &[Channel], adc: Option<&str>, dac: Option<&str>) -> Result<Route, String> {
        let of_kind = |kind| {
            let mut all: Vec<&Channel> = channels.iter().filter(|c| c.kind == kind).collect();
            all.sort_by_key(|c| c.number);
            all
        };
        let (adcs, dacs) = (of_kind(ChannelKind::Adc), of_kind(ChannelKind::Dac));
        let find = |list: &[&Channel], name: Option<&str>, what: &str| match name {
            None if list.is_empty() => Err(format!("the patch has no {what}")),
            None => Ok(0),
            Some(name) => list.iter().position(|c| c.name == name).ok_or_else(|| {
                let names: Vec<&str> = list.iter().map(|c| c.name.as_str()).collect();
                format!("the patch has no {what} `{name}`; it has {}", names.join(", "))
            }),
        };
        let position = find(&adcs, adc, "ADC")?;
        let dac = dacs[find(&dacs, dac, "DAC")?];
        Ok(Route {
            scan: adcs.iter().map(|c| c.number).collect(),
            position,
            dac: dac.number,
            full_scale: adcs[position].full_scale.or(dac.full_scale).unwrap_or(1.0),
        })
    }
}

/// Stages of the linkage, and the lead of the digital law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stages {
    /// Frame T.
    pub frame: Tick,
    /// Latency τ.
    pub latency: Tick,
    /// Skew δ between neighbouring channels.
    pub skew: Tick,
    /// Aperture.
    pub aperture: Tick,
    /// Bits of the ADC.
    pub adc_bits: Option<u32>,
    /// Bits of the DAC.
    pub dac_bits: Option<u32>,
    /// Hold.
    pub hold: Hold,
    /// Settling time constant.
    pub settling: Tick,
    /// Lead of the law, frames.
    pub lead_frames: f64,
}

impl Stages {
    /// A zero-order hold and nothing else.
    pub fn bare(frame: Tick) -> Stages {
        Stages {
            frame,
            latency: Tick::ZERO,
            skew: Tick::ZERO,
            aperture: Tick::ZERO,
            adc_bits: None,
            dac_bits: None,
            hold: Hold::ZeroOrder,
            settling: Tick::ZERO,
            lead_frames: 0.0,
        }
    }

    /// The same stages as theory takes them.
    pub fn chain(&self, route: &Route) -> Chain {
        let resolution = |bits: Option<u32>| {
            bits.map(|bits| super::theory::budget::Resolution {
                bits,
                full_scale: route.full_scale,
            })
        };
        Chain {
            frame_s: self.frame.secs(),
            skew_s: (self.skew * route.position as i64).secs(),
            aperture_s: self.aperture.secs(),
            adc: resolution(self.adc_bits),
            latency_s: self.latency.secs(),
            lead_frames: self.lead_frames,
            dac: resolution(self.dac_bits),
            hold: self.hold,
            settling_s: self.settling.secs(),
        }
    }

    fn profile(&self) -> Profile {
        let mut profile = Profile::ideal();
        profile.adc.bits = self.adc_bits.and_then(chosen);
        profile.dac.bits = self.dac_bits.and_then(chosen);
        profile.adc.aperture = Some(self.aperture).filter(|t| *t > Tick::ZERO).and_then(chosen);
        profile.dac.settling = Some(self.settling).filter(|t| *t > Tick::ZERO).and_then(chosen);
        profile.dac.hold = chosen(hold_kind(self.hold));
        profile
    }
}

/// Frequency and correlation window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Cycles.
    pub cycles: u32,
    /// Frames.
    pub frames: u32,
}

/// The window for a frequency near `wanted_hz`.
///
/// # Errors
/// When the frequency is not positive or not below half of the sampling rate.
pub fn window(wanted_hz: f64, frame: Tick) -> Result<Window, LabError> {
    let t = frame.secs();
    require(
        "the frequency",
        wanted_hz,
        wanted_hz > 0.0 && wanted_hz * t < 0.5 && wanted_hz * t > 1e-5,
        "between 1e-5 and one half of the sampling rate, in Hz",
    )?;
    let frames = LEAST_FRAMES.max((4.0 / (wanted_hz * t)).ceil());
    let cycles = (wanted_hz * frames * t).round().max(1.0);
    Ok(Window { frequency_hz: cycles / (frames * t), cycles: cycles as u32, frames: frames as u32 })
}

/// Gain and phase of a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    /// Output over input amplitude.
    pub gain: f64,
    /// Phase, rad, (−π, π]; negative is lag.
    pub phase_rad: f64,
}

/// The generated patch.
pub fn patch(route: &Route, window: Window, frame: Tick) -> PatchBundle {
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
    PatchBundle {
        root: "loop-back.toml".to_owned(),
        files: vec![("loop-back.toml".to_owned(), text)],
    }
}

impl Bench<'_, '_> {
    /// Gain and phase of one channel.
    ///
    /// # Errors
    /// [`BenchFault`] from the machine.
    pub fn loop_back(
        &mut self,
        route: &Route,
        window: Window,
        stages: &Stages,
    ) -> Result<Response, BenchFault> {
        let bundle = patch(route, window, stages.frame);
        self.console().load(bundle, Vec::new(), stages.profile())?;
        let channel = route.scan.get(route.position).copied().unwrap_or(0) as usize;
        let (dac, lead) = (route.dac as usize, stages.lead_frames);
        let stop = stages.frame * (2 * i64::from(window.frames));
        let mut before = None;
        self.operate(stages.frame, stages.latency, stages.skew, stop, |samples, updates| {
            let m = samples.adc[channel];
            let last = before.replace(m).unwrap_or(m);
            updates.set_dac(dac, m + lead * (m - last));
        })?;
        let values = self.console().read(vec!["in_phase".to_owned(), "quadrature".to_owned()])?;
        let at = |i: usize| values.get(i).copied().unwrap_or(f64::NAN);
        let (sine, cosine) = (at(0), at(1));
        let span_s = stages.frame.secs() * f64::from(window.frames);
        Ok(Response {
            gain: 2.0 * libm::hypot(sine, cosine) / (span_s * route.full_scale / 2.0),
            phase_rad: angle_difference_rad(correlated_phase_rad(sine, cosine), 0.0),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_window_has_whole_cycles_in_whole_frames() {
        let frame = Tick(10_000_000);
        let w = window(1.0, frame).unwrap();
        assert_eq!((w.cycles, w.frames), (4, 400));
        // 37 Hz at 100 frames a second is the nearest multiple of 1/4 s⁻¹ itself.
        assert!((window(36.9, frame).unwrap().frequency_hz - 37.0).abs() < 0.126);
        for bad in [0.0, -1.0, 50.0, 1e9, f64::NAN] {
            assert!(window(bad, frame).is_err(), "{bad}");
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
        let route = Route::of(&all, Some("b"), None).unwrap();
        assert_eq!((route.scan, route.position, route.dac), (vec![1, 3], 1, 2));
        assert_eq!(route.full_scale, 5.0);
        assert_eq!(Route::of(&all, None, Some("u")).unwrap().full_scale, 7.0);
        assert!(Route::of(&all, Some("x"), None).unwrap_err().contains("it has a, b"));
    }
}
