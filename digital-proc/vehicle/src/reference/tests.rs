//! Tests of the reference flight: figures of the data set, step-size and
//! partition errors, and the failure study.

use super::*;
use crate::slice;
use crate::{DeadZone, flight_mode::FlightMode};

/// Rate at which the tests fly, 1/s.
const RATE: u32 = LEAST_STEPS_PER_SECOND;

#[test]
fn the_undisturbed_flight_has_the_published_figures() {
    let vehicle = Vehicle::shipped().unwrap();
    let flight = fly(&vehicle, &FlightCase::undisturbed(), RATE, |_| {}).unwrap();
    let peak = flight.max_dynamic_pressure;
    // Known figures are "95 kPa, 32 s, Mach 2.2, 9.7 km; 67°, 23.6 km": half a
    // unit of the last digit each.
    assert!((peak.value / 1e3 - 95.0).abs() < 0.5, "{peak:?}");
    assert!((peak.time_s - 32.0).abs() < 0.5, "{peak:?}");
    assert!((peak.mach - 2.2).abs() < 0.05, "{peak:?}");
    assert!((peak.altitude_m / 1e3 - 9.7).abs() < 0.05, "{peak:?}");
    assert!((flight.end.path_angle_rad.to_degrees() - 67.0).abs() < 0.5, "{flight:?}");
    assert!((flight.end.altitude_m / 1e3 - 23.6).abs() < 0.05, "{flight:?}");
    // "1053 m/s" is met by the point-mass flight, half a unit; with its loops
    // the vehicle follows the programme late, climbs 0.2° steeper and pays for
    // it by less than 0.2 % of its speed.
    let point_mass = slice::points(&vehicle, &[("end", 49.0)]).unwrap()[0].trajectory;
    assert!((point_mass.speed_mps - 1053.0).abs() < 0.5, "{point_mass:?}");
    assert!((flight.end.speed_mps / point_mass.speed_mps - 1.0).abs() < 2e-3);
    assert!(flight.edges.is_empty());
    assert_eq!(flight.end_time_s, 49.0);
}

#[test]
fn one_millisecond_is_fine_enough() {
    let vehicle = Vehicle::shipped().unwrap();
    let case = FlightCase::design(&vehicle, FlightMode::Normal.script()).unwrap();
    let coarse = fly(&vehicle, &case, RATE, |_| {}).unwrap();
    let fine = fly(&vehicle, &case, 2 * RATE, |_| {}).unwrap();
    // A corner (limiter, dead zone, wind breakpoint) inside a step h leaves a
    // local error of order h²·jump of the rate: an angular acceleration jumps
    // by less than 1 rad/s³·h, so each of some hundred corners leaves less than
    // 1e-6·1e-3 rad; over 49 s at 1000 m/s that is under 1e-7·1e5 m = 1 cm.
    assert!((coarse.end.altitude_m - fine.end.altitude_m).abs() < 1e-2);
    assert!((coarse.end.speed_mps - fine.end.speed_mps).abs() < 1e-4);
    // The peak lies between samples: half a step of a load that changes by at
    // most the gust's edge, 8 m/s in 30 m at 650 m/s (7e5·1.2e-2/0.05 Pa·deg/s
    // ≈ 2e5…2e6), 1e-3 s.
    assert!((coarse.max_q_alpha.value - fine.max_q_alpha.value).abs() < 2e3);
}

#[test]
fn the_partition_error_is_first_order_and_halved_by_extrapolation() {
    let vehicle = Vehicle::shipped().unwrap();
    let case = FlightCase::undisturbed();
    let exact = fly(&vehicle, &case, RATE, |_| {}).unwrap().end.to_array();
    let error = |steps: u32, stages: StagePitch| -> [f64; 6] {
        let flight = fly_partitioned(&vehicle, &case, RATE, steps, stages, |_| {}).unwrap();
        let end = flight.end.to_array();
        std::array::from_fn(|i| end[i] - exact[i])
    };
    let (whole, half) = (error(100, StagePitch::Held), error(50, StagePitch::Held));
    let carried = error(100, StagePitch::Extrapolated);
    for i in 0..4 {
        // Order 1, in the customary band of ±0.2 for a measured order.
        let order = (whole[i] / half[i]).log2();
        assert!((order - 1.0).abs() < 0.2, "{i}: {whole:?} {half:?}");
        // Two lags of T/2 each, that of θ in the stages and that of the held
        // θ_c and γ_air: extrapolation removes the first. They are equal to
        // second order in T, so a half within T·(fastest rate of the
        // programme's changes, about 1/s) = 0.1.
        let left = carried[i] / whole[i];
        assert!((left - 0.5).abs() < 0.1, "{i}: {left}");
    }
}

#[test]
fn a_later_failure_leaves_the_flight_before_it_untouched() {
    let vehicle = Vehicle::shipped().unwrap();
    let record = |failure_start_s: f64, mode: FlightMode| {
        let mut case = FlightCase::design(&vehicle, mode.script()).unwrap();
        case.failure_start_s = failure_start_s;
        let mut seen = Vec::new();
        fly(&vehicle, &case, RATE, |s| seen.push(*s)).unwrap();
        seen
    };
    let sound = record(0.0, FlightMode::Normal);
    let failed = record(30.0, FlightMode::FtcElectronics);
    // Bit-equal up to and including the sample at which the failure sets in.
    let parts = sound.iter().zip(&failed).position(|(a, b)| a != b).unwrap();
    assert!(sound[parts].time_s > 30.0 && sound[parts].time_s < 30.1, "{}", sound[parts].time_s);
}

#[test]
fn settings_that_cannot_be_flown_are_refused() {
    let vehicle = Vehicle::shipped().unwrap();
    let case = FlightCase::undisturbed();
    assert!(matches!(fly(&vehicle, &case, 999, |_| {}), Err(FlightError::BadSetting { .. })));
    let frames = fly_partitioned(&vehicle, &case, RATE, 0, StagePitch::Held, |_| {});
    assert!(matches!(frames, Err(FlightError::BadSetting { .. })));
}

#[test]
fn an_uncontrolled_vehicle_ends_in_numbers_or_an_error_not_a_panic() {
    let mut data = Vehicle::shipped().unwrap().data().clone();
    for gains in [&mut data.gains.tvc_gain_npdeg, &mut data.gains.ftc_gain] {
        gains.iter_mut().for_each(|g| *g = 0.0);
    }
    let vehicle = Vehicle::from_data(data).unwrap();
    let case = FlightCase::design(&vehicle, FlightMode::Normal.script()).unwrap();
    match fly(&vehicle, &case, RATE, |_| {}) {
        Ok(flight) => assert!(flight.end.to_array().iter().all(|v| v.is_finite())),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// Without fin cant, nothing tells starboard from port.
#[test]
fn a_mirrored_disturbance_gives_the_mirrored_flight() {
    let mut data = Vehicle::shipped().unwrap().data().clone();
    data.aero.fin_cant_deg = 0.0;
    let fly_from = |side: f64| {
        let mut data = data.clone();
        data.wind.cross_fraction *= side;
        let vehicle = Vehicle::from_data(data).unwrap();
        let mut case = FlightCase::design(&vehicle, FlightMode::RollLost.script()).unwrap();
        case.yaw_misalignment *= side;
        fly(&vehicle, &case, RATE, |_| {}).unwrap()
    };
    let (port, starboard) = (fly_from(1.0), fly_from(-1.0));
    // Negating is exact, and so is the mirror.
    assert_eq!(port.end.cross_m, -starboard.end.cross_m);
    assert_eq!(port.end.cross_speed_mps, -starboard.end.cross_speed_mps);
    assert_eq!(port.end.speed_mps, starboard.end.speed_mps);
    assert_eq!(port.max_total_q_alpha, starboard.max_total_q_alpha);
    // A headwind's share across blows to port and carries the vehicle there.
    assert!(
        port.end.cross_m < -100.0 && port.end.azimuth_departure_rad().unwrap() < 0.0,
        "{:?}",
        port.end
    );
}

/// What the law of the dead zone makes of a dead yaw tip, with a crosswind to starboard: an
/// independent formulation has 28.1 kN·s of injection with the scheduled width and 25.6 with the
/// tips' remaining authority, and with either the same peaks of load (kPa deg).
#[test]
fn a_dead_yaw_tip_takes_less_injection_where_the_dead_zone_follows_the_tips() {
    let mut data = Vehicle::shipped().unwrap().data().clone();
    for (law, impulse_kns) in [(DeadZone::Scheduled, 28.1), (DeadZone::Remaining, 25.6)] {
        data.tvc.dead_zone = law;
        let vehicle = Vehicle::from_data(data.clone()).unwrap();
        let design = |mode: FlightMode| FlightCase::design(&vehicle, mode.script()).unwrap();
        let starboard = Wind::signed(&vehicle, -1.0, 1.0).unwrap();
        let case = FlightCase { wind: starboard, ..design(FlightMode::TipFourDead) };
        let flight = fly(&vehicle, &case, RATE, |_| {}).unwrap();
        let found = (flight.tvc_pitch_impulse_ns + flight.tvc_yaw_impulse_ns) / 1e3;
        assert!((found - impulse_kns).abs() <= 0.05, "{law:?}: {found}");
        for (mode, kpadeg) in [(FlightMode::Normal, 284.7), (FlightMode::FtcElectronics, 516.5)] {
            let flight = fly(&vehicle, &design(mode), RATE, |_| {}).unwrap();
            let found = flight.max_q_alpha.value / 1e3;
            // It samples in frames of 2 ms; nothing is sampled here.
            assert!((found / kpadeg - 1.0).abs() <= 1e-3, "{law:?}, {mode:?}: {found}");
        }
    }
}
