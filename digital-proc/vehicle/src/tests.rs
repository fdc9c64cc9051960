//! Tests of the data set's reading, validation and derived quantities.

use desk::faults::FileFault;
use proptest::prelude::*;

use super::*;

#[test]
fn the_derived_table_is_reproduced_to_its_digits() {
    let vehicle = Vehicle::shipped().unwrap();
    let derived = vehicle.data().derived.clone().unwrap();
    // Half a unit of the last printed digit of each column, plus rounding.
    let near = |what: &str, t: f64, got: f64, printed: f64, unit: f64| {
        assert!((got - printed).abs() <= 0.501 * unit, "{what} at {t} s: {got}, printed {printed}");
    };
    for (i, &t) in derived.time_s.iter().enumerate() {
        let (mass, motor) = vehicle.mass_at(t);
        near("mass", t, mass.mass_kg, derived.mass_kg[i], 0.1);
        near("xcg", t, mass.cg_x_m, derived.cg_x_m[i], 1e-4);
        near("Iyy", t, mass.pitch_inertia_kgm2, derived.pitch_inertia_kgm2[i], 1.0);
        near("Ixx", t, mass.roll_inertia_kgm2, derived.roll_inertia_kgm2[i], 0.1);
        near("F_vac", t, motor.vacuum_thrust_n, derived.vacuum_thrust_n[i], 1.0);
        near("mdot", t, motor.mass_flow_kgps, derived.mass_flow_kgps[i], 1e-3);
    }
    // The factor is printed with six digits.
    assert!((vehicle.motor().scale() - 0.996_964).abs() <= 0.5e-6);
}

#[test]
fn the_rate_of_inertia_is_the_derivative_of_inertia() {
    let vehicle = Vehicle::shipped().unwrap();
    for t in [1.0, 17.0, 33.0, 43.0, 48.0] {
        let h = 1e-3;
        let slope = (vehicle.mass_at(t + h).0.pitch_inertia_kgm2
            - vehicle.mass_at(t - h).0.pitch_inertia_kgm2)
            / (2.0 * h);
        let rate = vehicle.mass_at(t).0.pitch_inertia_rate_kgm2ps;
        // Rounding of 5e5 over 2e-3 s: 6e-8; the third derivative times h²/6 is
        // far below 1e-3 of 7e3 kg·m²/s.
        assert!((slope - rate).abs() < 1e-2, "{t}: {slope} against {rate}");
    }
}

#[test]
fn thrust_is_zero_and_flagged_where_the_nozzle_is_unfilled() {
    let vehicle = Vehicle::shipped().unwrap();
    let motor = vehicle.motor();
    let sea = motor.net_thrust(motor.at(0.0).vacuum_thrust_n, 101_325.0);
    assert!(!sea.nozzle_unfilled);
    let end = motor.net_thrust(motor.at(49.0).vacuum_thrust_n, 3_000.0);
    assert_eq!((end.thrust_n, end.nozzle_unfilled), (0.0, true));
}

fn faults_of(text: &str) -> Vec<FileFault> {
    Vehicle::from_toml("user.toml", text).unwrap_err().0
}

fn line_of(needle: &str) -> usize {
    SHIPPED_TEXT.lines().position(|line| line.starts_with(needle)).unwrap() + 1
}

#[test]
fn every_semantic_fault_is_reported_with_its_line() {
    let text = SHIPPED_TEXT
        .replace("m0            = 17610.0", "m0            = -17610.0")
        .replace("env_h   = [0.0, 2.0e3, 4.0e3", "env_h   = [0.0, 2.0e3, 2.0e3")
        .replace("tau        = 0.05", "tau        = nan")
        .replace("K_F   = [0.0,    8.0,  12.0]", "K_F   = [0.0,    8.0]");
    let faults = faults_of(&text);
    let place_of = |key: &str| {
        let fault = faults.iter().find(|f| f.fault.contains(&format!("`{key}`")));
        fault.unwrap_or_else(|| panic!("no fault at {key}: {faults:#?}")).place.unwrap()
    };
    assert_eq!(place_of("mass.m0").0, line_of("m0 "));
    assert_eq!(place_of("wind.env_h").0, line_of("env_h"));
    assert_eq!(place_of("ftc.tau").0, line_of("tau        = 0.05"));
    assert_eq!(place_of("gains_reduced.K_F").0, line_of("K_F   = [0.0,    8.0,"));
    assert!(faults.iter().all(|f| f.file == "user.toml" && !f.remedy.is_empty()));
    assert_eq!(faults.len(), 4, "{faults:#?}");

    // What is wrong between sections is told once each of them is sound.
    let text = SHIPPED_TEXT
        .replace("m0            = 17610.0", "m0            = 17010.0")
        .replace("burn_time     = 49.0", "burn_time     = 50.0")
        .replace("t_sw  = [0.0,  10.0,", "t_sw  = [1.0,  10.0,");
    let lines: Vec<_> = faults_of(&text).iter().map(|f| f.place.unwrap().0).collect();
    assert_eq!(lines, [line_of("components ="), line_of("t = "), line_of("t_sw  = [0.0,  10.0")]);
}

#[test]
fn data_in_memory_is_validated_too() {
    let mut data = Vehicle::shipped().unwrap().data().clone();
    data.gyro.natural_frequency_radps = f64::INFINITY;
    let faults = Vehicle::from_data(data).unwrap_err().to_string();
    assert!(faults.contains("`gyro.wn` is not a finite number"), "{faults}");
}

proptest! {
    /// A line replaced by anything is refused or accepted, never a panic; an
    /// accepted set flies its point-mass trajectory to numbers or to an error.
    #[test]
    fn no_damaged_file_panics(line in 0usize..190, with in "\\PC{0,40}") {
        let mut lines: Vec<&str> = SHIPPED_TEXT.lines().collect();
        let at = line % lines.len();
        lines[at] = &with;
        if let Ok(vehicle) = Vehicle::from_toml("damaged.toml", &lines.join("\n")) {
            let _ = crate::slice::points(&vehicle, &[("early", 2.0)]);
        }
    }

    /// Any number in place of any other: faults name their key and line.
    #[test]
    fn no_number_panics(pick in 0usize..400, value in any::<f64>()) {
        let written = format!("{value:?}").replace("NaN", "nan");
        let numbers: Vec<_> = SHIPPED_TEXT
            .match_indices(|c: char| c.is_ascii_digit())
            .filter(|(at, _)| SHIPPED_TEXT[..*at].ends_with("= ") || SHIPPED_TEXT[..*at].ends_with(", "))
            .collect();
        let start = numbers[pick % numbers.len()].0;
        let rest = &SHIPPED_TEXT[start..];
        let end = start + rest.find([',', ']', ' ', '\n']).unwrap_or(rest.len());
        let text = format!("{}{written}{}", &SHIPPED_TEXT[..start], &SHIPPED_TEXT[end..]);
        match Vehicle::from_toml("number.toml", &text) {
            Ok(vehicle) => {
                let _ = crate::slice::points(&vehicle, &[("early", 2.0)]);
            }
            Err(FileFaults(faults)) => {
                prop_assert!(faults.iter().all(|f| f.place.is_some()), "{faults:?}");
            }
        }
    }
}
