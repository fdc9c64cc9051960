//! The machine's own linear models against the matrices that the study is written with.

use crate::bench_top::{BenchTop, DIGITAL, expect, with_console};
use digital_proc::{
    linkage::console::Console,
    study::short_period::{
        coefficients::{Disturbance, Offsets, Settings},
        control_loop::ControlLoop,
        higher_modes::higher_modes,
        linear::{ChannelGains, plane_matrix, plane_roots},
        machine::{Bench, Patches},
        point::FrozenPoint,
    },
};
use interface::{control::LinearModel, profile::Profile};
use nalgebra::DMatrix;
use serde_json::Value;
use vehicle::{Vehicle, slice};

/// States of a plane in the order of the study's matrix, by block; the tip's is added.
const PLANE: [&str; 10] = [
    "plane.drift_rate",
    "plane.theta",
    "plane.theta_rate",
    "",
    "plane.tvc_force",
    "plane.gyro_rate",
    "plane.gyro_slope",
    "plane.eta",
    "plane.eta_rate",
    "plane.filtered_error",
];
const TIP: usize = 3;

fn points() -> Vec<FrozenPoint> {
    let vehicle = Vehicle::shipped().unwrap();
    let slices = slice::points(&vehicle, &[("tips", 20.0), ("max-q", 32.5)]).unwrap();
    slices.iter().map(|s| FrozenPoint::new(&vehicle, s, &s.settings.gains)).collect()
}

fn model(console: &mut Console<'_>, settings: &Settings) -> LinearModel {
    let owned = |(name, value): (&'static str, f64)| (name.to_owned(), value);
    let mut ics = settings.initial_conditions();
    if settings.roll.is_some() {
        // At rest the tips' difference stands on the corner of its absolute value, which the dead
        // zone takes: a hair of roll lies beside it.
        ics.extend([("tip2.deflection", 1e-3), ("tip4.deflection", -1e-3)]);
    }
    console.set_ics(ics.into_iter().map(owned).collect()).unwrap();
    console.preset(&console.settings(&settings.values()).unwrap()).unwrap();
    console.linearise(&[], &[]).unwrap()
}

/// Entry of A by the blocks of row and column.
fn entry(model: &LinearModel, row: &str, column: &str) -> f64 {
    let at = |name: &str| model.states.iter().position(|state| state == name).unwrap();
    model.a[at(row) * model.states.len() + at(column)]
}

fn agree(found: f64, truth: f64, what: &str) {
    assert!((found - truth).abs() <= 1e-9 * truth.abs(), "{what}: {found} for {truth}");
}

#[test]
fn the_pitch_loop_is_the_matrix_of_the_study() {
    with_console(|console| {
        Bench::load(console, ControlLoop::Pitch, &Patches::shipped(), &Profile::ideal()).unwrap();
        // At rest the thrust vector is inside its dead zone; a step of 2 degrees takes it beyond.
        for (command_rad, gains) in
            [(0.0, ChannelGains::FTC_ONLY), (2f64.to_radians(), ChannelGains::BOTH)]
        {
            for point in points() {
                let settings = Settings::pitch(&point, &Disturbance::NONE, command_rad);
                let model = model(console, &settings);
                assert_eq!(model.states.len(), 10);
                let truth = plane_matrix(&settings.plane, gains);
                let names = PLANE.map(|name| if name.is_empty() { "tip.deflection" } else { name });
                for (i, row) in names.iter().enumerate() {
                    for (j, column) in names.iter().enumerate() {
                        let what = format!("{row} by {column}");
                        agree(entry(&model, row, column), truth[(i, j)], &what);
                    }
                }
            }
        }
    });
}

/// The higher modes in the machine's own model: each entry as the sub-patch states it, and the
/// damping that an independent formulation found (mode 2 0.011 to 0.020, mode 3 0.0096 to 0.0100).
#[test]
fn the_higher_modes_hang_in_the_pitch_loop_and_stay_stable() {
    let vehicle = Vehicle::shipped().unwrap();
    let gyro_x_m = vehicle.data().bending.gyro_x_m;
    with_console(|console| {
        let patches = Patches::with_modes(3);
        Bench::load(console, ControlLoop::Pitch, &patches, &Profile::ideal()).unwrap();
        for point in points() {
            // A step of 2 degrees opens the dead zone.
            let mut settings = Settings::pitch(&point, &Disturbance::NONE, 2f64.to_radians());
            let higher = higher_modes(&vehicle, &point, gyro_x_m);
            settings.plane.higher = Some(higher);
            let model = model(console, &settings);
            assert_eq!(model.states.len(), 14);
            let plane = &settings.plane;
            for (mode, name) in higher.iter().zip(["mode2", "mode3"]) {
                let [eta, rate] = ["eta", "eta_rate"].map(|block| format!("{name}.{block}"));
                for (row, column, truth) in [
                    (eta.as_str(), rate.as_str(), 1.0),
                    (&rate, &eta, -mode.spring()),
                    (&rate, &rate, -mode.drag()),
                    (&rate, "plane.tvc_force", mode.drive),
                    (&rate, "tip.deflection", mode.drive * plane.tip_force),
                    ("plane.gyro_slope", &rate, plane.gyro_spring * mode.gyro_slope),
                    ("plane.filtered_error", &eta, -plane.filter_pole * mode.imu_slope),
                    (
                        "plane.tvc_force",
                        &eta,
                        -plane.tvc_bandwidth * plane.tvc_gain * mode.imu_slope,
                    ),
                ] {
                    agree(entry(&model, row, column), truth, &format!("{row} by {column}"));
                }
            }
            let a = DMatrix::from_row_slice(14, 14, &model.a);
            let ours = plane_roots(plane, ChannelGains::BOTH).higher.map(Option::unwrap);
            let found = a.complex_eigenvalues();
            for (root, range) in ours.iter().zip([0.0105..0.0205, 0.00955..0.01005]) {
                let off = |re: f64, im: f64| (re - root.real).hypot(im - root.imaginary);
                let near = found.iter().map(|s| off(s.re, s.im)).fold(f64::INFINITY, f64::min);
                assert!(near < 1e-6 * root.frequency_radps(), "{root:?}: {near}");
                assert!(range.contains(&root.damping()), "{root:?}: {}", root.damping());
            }
        }
    });
}

/// Half the sum of the tips is the plane's tip; half their difference rolls.
#[test]
fn the_yaw_and_roll_loops_fall_apart_into_the_plane_and_the_roll() {
    with_console(|console| {
        let patches = Patches::shipped();
        Bench::load(console, ControlLoop::YawRoll, &patches, &Profile::ideal()).unwrap();
        for point in points() {
            let still =
                Offsets { yaw_rad: 0.0, yaw_rate_radps: 0.0, roll_rad: 0.0, roll_rate_radps: 0.0 };
            let settings = Settings::yaw_roll(&point, &Disturbance::NONE, still, false);
            let model = model(console, &settings);
            let tips = ["tip2.deflection", "tip4.deflection"];
            let truth = plane_matrix(&settings.plane, ChannelGains::FTC_ONLY);
            let roll = settings.roll.unwrap();
            // By the mean of the tips (sense 1) or half their difference (−1); of it likewise.
            let by = |row: &str, sense: f64| {
                entry(&model, row, tips[0]) + sense * entry(&model, row, tips[1])
            };
            let of = |column: &str, sense: f64| {
                0.5 * (entry(&model, tips[0], column) + sense * entry(&model, tips[1], column))
            };
            for (i, row) in PLANE.iter().enumerate().filter(|(i, _)| *i != TIP) {
                for (j, column) in PLANE.iter().enumerate().filter(|(j, _)| *j != TIP) {
                    agree(entry(&model, row, column), truth[(i, j)], &format!("{row} by {column}"));
                }
                agree(by(row, 1.0), truth[(i, TIP)], row);
                agree(of(row, 1.0), truth[(TIP, i)], row);
                assert_eq!(
                    (by(row, -1.0), of(row, -1.0)),
                    (0.0, 0.0),
                    "{row} knows nothing of roll"
                );
            }
            let demand = -settings.plane.tip_bandwidth * roll.gain;
            let rolling = [
                ("roll_angle", "roll_rate", 1.0),
                ("roll_rate", "roll_rate", roll.damping),
                ("roll_gyro_slope", "roll_rate", settings.plane.gyro_spring),
                ("roll_gyro_slope", "roll_gyro_rate", -settings.plane.gyro_spring),
                ("roll_gyro_slope", "roll_gyro_slope", -settings.plane.gyro_drag),
                ("roll_gyro_rate", "roll_gyro_slope", 1.0),
            ];
            for (row, column, truth) in rolling {
                agree(entry(&model, row, column), truth, &format!("{row} by {column}"));
            }
            agree(
                by("roll_rate", -1.0),
                roll.moment * settings.plane.tip_force,
                "roll by the tips",
            );
            agree(of("roll_angle", -1.0), demand, "the tips by roll");
            agree(of("roll_gyro_rate", -1.0), demand * roll.lead, "the tips by its gyro");
        }
    });
}

/// The mode found in the record of a run, and the pole of the machine's own linear model closed
/// through the law: neither knows of the other.
#[test]
fn a_users_loop_is_measured_as_its_exact_poles_say() {
    let top = BenchTop::new();
    let study = concat!(env!("CARGO_MANIFEST_DIR"), "/patch-files/studies/servo-loop.toml");
    let mut command = top.command(DIGITAL, &["sampling", "loop", study, "--json"]);
    let output = expect(command.arg("--out").arg(top.runs()), 0);
    let told: Value = serde_json::from_slice(&output.stdout).unwrap();
    let rows = told["tables"]["loop"].as_array().unwrap();
    assert_eq!(rows.len(), 8);
    for row in rows {
        let number = |key: &str| row[key].as_f64().unwrap();
        for (measured, exact) in [("zeta", "zeta_exact"), ("omega_rad_s", "omega_exact_rad_s")] {
            let (measured, exact) = (number(measured), number(exact));
            assert!((measured / exact - 1.0).abs() < 1e-9, "{row}");
        }
        let frame_s = number("frame_s");
        let shrinks = (-number("zeta") * number("omega_rad_s") * frame_s).exp();
        // No mode of this loop is slower than the measured one.
        assert!((number("spectral_radius") / shrinks - 1.0).abs() < 1e-9, "{row}");
    }
}
