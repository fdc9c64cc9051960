//! Every point over the stations of the gyro, and its loops opened.

use super::{
    flexible::{Actuator, Flexible, OpenLoop},
    margins::{self, ModeMargin},
};
use crate::{
    linkage::console::{Console, ConsoleFault},
    study::{
        fault::StudyFault,
        short_period::{
            coefficients::{Disturbance, Plane, Settings},
            higher_modes::{free_free_slope, higher_modes},
            linear::{ChannelGains, model_matrix, model_roots},
            point::FrozenPoint,
        },
    },
};
use interface::control::LinearModel;
use nalgebra::DMatrix;
use vehicle::{Vehicle, beam_shape::MODES, slice::SlicePoint};

/// A filter so fast that it is none, rad/s: thirty times the third mode.
const NO_FILTER_RADPS: f64 = 3e4;
/// Corners of the bending filter that are compared, rad/s.
pub const FILTERS_RADPS: [f64; 9] =
    [10.0, 15.0, 20.0, 30.0, 45.0, 70.0, 100.0, 200.0, NO_FILTER_RADPS];
/// A step that takes the injection beyond its dead zone, rad.
const BEYOND_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// Gains that the channels may show: all at work, or one saturated, lost or in its dead zone.
const STATES: [ChannelGains; 3] =
    [ChannelGains::BOTH, ChannelGains::FTC_ONLY, ChannelGains::TVC_ONLY];

/// A mode's damping at one point with the gyro at one station.
#[derive(Clone, Debug)]
pub struct Station {
    pub point: String,
    pub time_s: f64,
    pub station_m: f64,
    /// Damping ratio of each mode, the least over what the channels may show; none where a mode is
    /// overdamped or the matrix has no eigenvalues.
    pub damping: [Option<f64>; MODES],
    /// The first mode's by the machine's linear model of the patch, and by the matrix of one mode.
    pub machine: [Option<f64>; 2],
}

/// A mode's margins in one loop.
#[derive(Clone, Debug)]
pub struct LoopMargin {
    pub point: String,
    pub time_s: f64,
    pub actuator: Actuator,
    pub filtered: bool,
    /// 0 is the first.
    pub mode: usize,
    pub margin: ModeMargin,
    /// ζ of the mode with the loop closed.
    pub closed_damping: Option<f64>,
    /// Of the attitude loop, degrees.
    pub attitude_margin_deg: Option<f64>,
    /// The first mode's gain margin by the machine's linear model of the patch, and by the matrix
    /// of one mode, dB.
    pub machine_gain_db: Option<[f64; 2]>,
}

/// Least margins over all points for one corner of the filter.
#[derive(Clone, Copy, Debug)]
pub struct FilterChoice {
    pub corner_radps: f64,
    /// Of the tips' loop at each mode, dB.
    pub gain_db: [f64; MODES],
    /// Of the attitude, degrees.
    pub attitude_margin_deg: f64,
    /// Of the first mode with the loop closed.
    pub damping: f64,
}

/// What the survey found.
#[derive(Clone, Debug, Default)]
pub struct Survey {
    pub stations: Vec<Station>,
    pub margins: Vec<LoopMargin>,
    pub filters: Vec<FilterChoice>,
    /// |L| of the tips' loop at the greatest dynamic pressure, with and without the filter, dB
    /// over rad/s.
    pub bode: Vec<(&'static str, Vec<(f64, f64)>)>,
}

/// The pitch plane at a point with the gyro at a station.
fn flexible(vehicle: &Vehicle, point: &FrozenPoint, station_m: f64, modes: usize) -> Flexible {
    let plane = Plane::new(point, &Disturbance::NONE);
    Flexible::new(plane, &higher_modes(vehicle, point, station_m)[..modes - 1])
}

/// What the channels may show at a point.
fn states(plane: &Plane) -> &'static [ChannelGains] {
    if plane.ftc_gain == 0.0 { &STATES[2..] } else { &STATES }
}

fn least_damping(flexible: &Flexible, mode: usize) -> Option<f64> {
    let of =
        |gains: &ChannelGains| Some(flexible.mode_roots(*gains).get(mode)?.as_ref()?.damping());
    states(&flexible.plane)
        .iter()
        .map(of)
        .collect::<Option<Vec<f64>>>()?
        .into_iter()
        .min_by(f64::total_cmp)
}

/// Presets the patch to a point and opens or keeps its loop.
fn model(
    console: &mut Console<'_>,
    settings: &Settings,
    inputs: &[&str],
    outputs: &[&str],
) -> Result<LinearModel, ConsoleFault> {
    let updates = console.settings(&settings.values())?;
    console.preset(&updates)?;
    console.linearise(inputs, outputs)
}

/// ζ of the first mode by the machine, with both channels at work.
fn machine_damping(
    console: &mut Console<'_>,
    point: &FrozenPoint,
    first_radps: f64,
) -> Result<Option<f64>, ConsoleFault> {
    let settings = Settings::pitch(point, &Disturbance::NONE, BEYOND_RAD);
    let model = model(console, &settings, &[], &[])?;
    let roots = model_roots(&model);
    let pairs = roots.iter().filter(|r| r.imaginary > 0.0);
    let off = |imaginary: f64| (imaginary - first_radps).abs();
    let nearest = pairs.min_by(|a, b| off(a.imaginary).total_cmp(&off(b.imaginary)));
    Ok(nearest.map(|root| root.damping()))
}

/// The machine's loop opened at an actuator, the other channel at work.
fn machine_opened(
    console: &mut Console<'_>,
    point: &FrozenPoint,
    at: Actuator,
) -> Result<OpenLoop, ConsoleFault> {
    let settings = Settings::pitch(point, &Disturbance::NONE, BEYOND_RAD);
    let (input, output, gain) = match at {
        Actuator::Tips => ("plane.fin_demand", "plane.filtered_error", point.ftc_gain),
        Actuator::Injection => ("plane.tvc_command", "plane.tvc_error", point.tvc_gain_nprad),
    };
    let model = model(console, &settings, &[input], &[output])?;
    let order = model.states.len();
    Ok(OpenLoop {
        a: model_matrix(&model),
        b: DMatrix::from_row_slice(order, 1, &model.b),
        c: DMatrix::from_row_slice(1, order, &model.c) * gain,
    })
}

/// Surveys the points; the pitch loop is loaded. `progress` is told the points done.
pub fn run(
    console: &mut Console<'_>,
    vehicle: &Vehicle,
    slices: &[SlicePoint],
    stations_m: &[f64],
    mut progress: impl FnMut(usize),
) -> Result<Survey, StudyFault> {
    let bending = &vehicle.data().bending;
    let nominal_m = nominal_station_m(vehicle);
    let mut survey = Survey::default();
    for (done, slice) in slices.iter().enumerate() {
        let nominal = FrozenPoint::new(vehicle, slice, &slice.settings.gains);
        for station_m in stations_m {
            let Some(slope) = vehicle.gyro_slope_at_station(*station_m) else { continue };
            let point = FrozenPoint { gyro_slope_pm: slope, ..nominal };
            let flexible_at = flexible(vehicle, &point, *station_m, MODES);
            let machine = if bending.alternative_gyro_x_m.contains(station_m) {
                let one = flexible(vehicle, &point, *station_m, 1);
                let gains = if point.ftc_gain == 0.0 { STATES[2] } else { ChannelGains::BOTH };
                let hand = one.mode_roots(gains)[0].map(|r| r.damping());
                [machine_damping(console, &point, one.frequency_radps[0])?, hand]
            } else {
                [None; 2]
            };
            survey.stations.push(Station {
                point: slice.name.clone(),
                time_s: slice.time_s,
                station_m: *station_m,
                damping: std::array::from_fn(|mode| least_damping(&flexible_at, mode)),
                machine,
            });
        }
        for at in Actuator::ALL {
            if at == Actuator::Tips && nominal.ftc_gain == 0.0 {
                continue;
            }
            let machine_open = machine_opened(console, &nominal, at)?;
            for filtered in [true, false] {
                // The injection has no filter of its own; it is beside the filtered tips.
                if at == Actuator::Injection && !filtered {
                    continue;
                }
                let mut point = nominal;
                if !filtered {
                    point.filter_pole_radps = NO_FILTER_RADPS;
                }
                let flexible = flexible(vehicle, &point, nominal_m, MODES);
                let one = self::flexible(vehicle, &point, nominal_m, 1);
                let gains = if point.ftc_gain == 0.0 { STATES[2] } else { ChannelGains::BOTH };
                let open = flexible.opened(at, gains);
                let attitude_margin_deg =
                    margins::of_attitude_deg(&open, flexible.frequency_radps[0]);
                let roots = flexible.mode_roots(gains);
                for (mode, frequency) in flexible.frequency_radps.iter().enumerate() {
                    let Some(margin) = margins::of_mode(&open, *frequency) else { continue };
                    let machine = || {
                        let loops = [&machine_open, &one.opened(at, gains)];
                        let [machine, hand] = loops.map(|l| margins::of_mode(l, *frequency));
                        Some([machine?.gain_db, hand?.gain_db])
                    };
                    survey.margins.push(LoopMargin {
                        point: slice.name.clone(),
                        time_s: slice.time_s,
                        actuator: at,
                        filtered,
                        mode,
                        margin,
                        closed_damping: roots[mode].map(|r| r.damping()),
                        attitude_margin_deg,
                        machine_gain_db: (filtered && mode == 0).then(machine).flatten(),
                    });
                }
            }
        }
        progress(done + 1);
    }
    survey.filters =
        FILTERS_RADPS.iter().map(|corner| filter(vehicle, slices, nominal_m, *corner)).collect();
    survey.bode = bode(vehicle, slices, nominal_m);
    Ok(survey)
}

/// The station of the nominal gyro: where the mode's table has its slope, m.
pub fn nominal_station_m(vehicle: &Vehicle) -> f64 {
    let bending = &vehicle.data().bending;
    let table =
        bending.alternative_gyro_x_m.windows(2).zip(bending.alternative_gyro_slope_pm.windows(2));
    let slope = bending.gyro_slope_pm;
    let inside = |s: &[f64]| (s[0] - slope) * (s[1] - slope) <= 0.0 && s[0] != s[1];
    table
        .filter(|(_, s)| inside(s))
        .map(|(x, s)| x[0] + (x[1] - x[0]) * (slope - s[0]) / (s[1] - s[0]))
        .next()
        .unwrap_or(bending.alternative_gyro_x_m[0])
}

/// Least margins of the tips' loop over all points with one corner of the filter.
fn filter(
    vehicle: &Vehicle,
    slices: &[SlicePoint],
    station_m: f64,
    corner_radps: f64,
) -> FilterChoice {
    let mut choice = FilterChoice {
        corner_radps,
        gain_db: [f64::INFINITY; MODES],
        attitude_margin_deg: f64::INFINITY,
        damping: f64::INFINITY,
    };
    for slice in slices {
        let mut point = FrozenPoint::new(vehicle, slice, &slice.settings.gains);
        if point.ftc_gain == 0.0 {
            continue;
        }
        point.filter_pole_radps = corner_radps;
        let flexible = flexible(vehicle, &point, station_m, MODES);
        let open = flexible.opened(Actuator::Tips, ChannelGains::FTC_ONLY);
        for (least, frequency) in choice.gain_db.iter_mut().zip(&flexible.frequency_radps) {
            if let Some(margin) = margins::of_mode(&open, *frequency) {
                *least = least.min(margin.gain_db);
            }
        }
        if let Some(margin) = margins::of_attitude_deg(&open, flexible.frequency_radps[0]) {
            choice.attitude_margin_deg = choice.attitude_margin_deg.min(margin);
        }
        choice.damping = choice.damping.min(least_damping(&flexible, 0).unwrap_or(f64::NAN));
    }
    choice
}

/// Bode diagrams where the dynamic pressure is greatest.
fn bode(
    vehicle: &Vehicle,
    slices: &[SlicePoint],
    station_m: f64,
) -> Vec<(&'static str, Vec<(f64, f64)>)> {
    let pressure = |s: &&SlicePoint| s.airframe.dynamic_pressure_pa;
    let Some(slice) = slices.iter().max_by(|a, b| pressure(a).total_cmp(&pressure(b))) else {
        return Vec::new();
    };
    let point = FrozenPoint::new(vehicle, slice, &slice.settings.gains);
    [("with the filter", point.filter_pole_radps), ("without", NO_FILTER_RADPS)]
        .map(|(name, filter_pole_radps)| {
            let point = FrozenPoint { filter_pole_radps, ..point };
            let flexible = flexible(vehicle, &point, station_m, MODES);
            (name, margins::bode(&flexible.opened(Actuator::Tips, ChannelGains::FTC_ONLY)))
        })
        .into()
}

/// Slope of a mode at a station for the tables: the first by the data set.
pub fn slope_pm(vehicle: &Vehicle, mode: usize, station_m: f64) -> f64 {
    match mode {
        0 => vehicle.gyro_slope_at_station(station_m).unwrap_or(f64::NAN),
        _ => free_free_slope(vehicle, mode, station_m),
    }
}
