//! Figures of an independent formulation of the same beam, at the slice of 32.5 s.

use super::*;
use crate::slice::{self, SlicePoint};

fn at_max_q() -> (Vehicle, Structure, SlicePoint) {
    let vehicle = Vehicle::shipped().unwrap();
    let structure = Structure::new(&vehicle);
    let point = slice::points(&vehicle, &[("max-q", 32.5)]).unwrap().remove(0);
    (vehicle, structure, point)
}

const ALPHA: Loads = Loads {
    incidence_rad: 4.0 * std::f64::consts::PI / 180.0,
    tip_force_n: 0.0,
    tvc_force_n: 0.0,
    misalignment: 0.0,
};
const TIPS: Loads = Loads { tip_force_n: 10e3, incidence_rad: 0.0, ..ALPHA };
const MISALIGNED: Loads = Loads { misalignment: 1.0, incidence_rad: 0.0, ..ALPHA };

fn moments(beam: &Beam, loads: &Loads, modes_mps2: [f64; MODES]) -> Vec<f64> {
    let mut moment_nm = vec![0.0; beam.columns[0].len()];
    beam.add_quasi_static(loads, &mut moment_nm);
    beam.add_modes(modes_mps2, &mut moment_nm);
    moment_nm
}

fn worst(structure: &Structure, moment_nm: &[f64]) -> (f64, f64) {
    let pairs = structure.stations_m().iter().zip(moment_nm);
    let worst = pairs.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap();
    (*worst.0, worst.1 / 1e3)
}

/// To half a per cent of the largest, which is far above the printed digits.
fn close(what: &str, found: f64, printed: f64, largest: f64) {
    assert!((found - printed).abs() <= 0.005 * largest.abs(), "{what}: {found}, printed {printed}");
}

#[test]
fn quasi_static_moments_are_those_of_the_independent_formulation() {
    let (vehicle, structure, point) = at_max_q();
    let beam = structure.beam(&Applied::new(&vehicle, 32.5, &point.airframe)).unwrap();
    close("Q", point.airframe.dynamic_pressure_pa, 95_327.0, 95_327.0);
    close("m", beam.mass_kg, 11_283.98, 2.0);
    close("x_cg", beam.cg_x_m, 11.2535, 0.02);
    close("I", beam.inertia_kgm2, 388_891.0, 200.0);
    // The masses of the beam are those of the equations of motion.
    close("m", beam.mass_kg / point.airframe.mass_kg, 1.0, 1e-9);
    close("I", beam.inertia_kgm2 / point.airframe.pitch_inertia_kgm2, 1.0, 1e-9);

    let alpha = [8.52, 19.53, 28.59, 35.48, 40.33, 45.40, 46.26, 41.37, 30.46, 13.61];
    let tips = [-11.81, -22.50, -27.29, -27.32, -23.95, -19.77, -13.96, -7.74, -2.87, -0.48];
    for (loads, rigid, printed, (x_m, largest)) in [
        (ALPHA, [-2.0746, 0.05295], alpha, (13.30, 46.59)),
        (TIPS, [0.8862, 0.27652], tips, (7.00, -27.83)),
    ] {
        let found = beam.rigid_acceleration(&loads);
        close("a0", found[0], rigid[0], rigid[0]);
        close("turning", found[1], rigid[1], rigid[1]);
        let moment_nm = moments(&beam, &loads, [0.0; MODES]);
        for (x, printed) in TEN_STATIONS_M.into_iter().zip(printed) {
            let found = moment_nm[structure.nearest(x)] / 1e3;
            close(&format!("at {x} m"), found, printed, printed);
        }
        let (at, value) = worst(&structure, &moment_nm);
        assert!((at - x_m).abs() < 0.051, "{at}");
        close("worst", value, largest, largest);
    }
    let moment_nm = moments(&beam, &MISALIGNED, [0.0; MODES]);
    close("misalignment", moment_nm[structure.nearest(6.0)] / 1e3, -5.74, 5.74);
    close("side force", beam.rigid[3][0] * beam.mass_kg, 1_892.5, 1_892.5);
}

#[test]
fn modes_are_those_of_the_independent_formulation() {
    let (vehicle, structure, point) = at_max_q();
    let beam = structure.beam(&Applied::new(&vehicle, 32.5, &point.airframe)).unwrap();
    for (mode, mass_kg) in beam.modes.iter().zip([2_602.2, 2_162.4, 2_805.8]) {
        close("M_i", mode.mass_kg, mass_kg, mass_kg);
    }
    let (w1, ratios) = (beam.modes[0].frequency_radps, [1.0, 2.757, 5.404]);
    for (mode, ratio) in beam.modes.iter().zip(ratios) {
        assert_eq!(mode.frequency_radps, ratio * w1);
        assert_eq!(mode.damping, 0.010);
    }
    for (i, x, printed) in [(0, 12.0, 7_353.0), (1, 6.0, 2_663.0), (2, 12.0, -1_425.0)] {
        let mut one = [0.0; MODES];
        one[i] = 1.0;
        let column = moments(&beam, &Loads::default(), one);
        close("M_eta", column[structure.nearest(x)], printed, printed);
    }
    let one = Loads { incidence_rad: 1.0, ..Loads::default() };
    close("f_1", beam.drive(&one)[0], -99.98, 99.98);
}

/// Both ends are free, whatever the time, the load, the mode and the changed slopes.
#[test]
fn the_ends_bear_no_moment() {
    let (vehicle, structure, _) = at_max_q();
    for time_s in [0.0, 7.5, 18.3, 32.5, 47.0] {
        let point = slice::points(&vehicle, &[("", time_s)]).unwrap().remove(0);
        let mut applied = Applied::new(&vehicle, time_s, &point.airframe);
        applied.moment_slope_nmprad *= 1.2;
        applied.tip_arm_m *= 0.9;
        let beam = structure.beam(&applied).unwrap();
        let loads = [ALPHA, TIPS, Loads { tvc_force_n: 1e4, ..MISALIGNED }];
        let of_modes = (0..MODES).map(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
        let cases = loads.map(|l| (l, [0.0; MODES])).into_iter();
        for (loads, modes) in cases.chain(of_modes.map(|m| (Loads::default(), m))) {
            let moment_nm = moments(&beam, &loads, modes);
            let (_, largest) = worst(&structure, &moment_nm);
            for end in [0, moment_nm.len() - 1] {
                let bound = 1e-9 * 1e3 * largest.abs();
                assert!(moment_nm[end].abs() <= bound, "{time_s} s, {loads:?}: {}", moment_nm[end]);
            }
        }
    }
}

/// The shares of the air load add up to the slopes of the tables at every Mach number.
#[test]
fn air_loads_have_the_slope_and_the_moment_of_the_tables() {
    let (vehicle, structure, point) = at_max_q();
    for mach in [0.0, 0.7, 1.05, 2.2, 4.5, 6.0] {
        let aero = vehicle.aero_at(mach);
        let body = BodyLoads::new(vehicle.data(), aero.body_slope, aero.body_x_m).unwrap();
        assert!((body.nose + body.cylinder - 1.0).abs() < 1e-15);
        let centre = body.nose * structure.nose_sum[1] + body.cylinder * body.extent_m / 2.0;
        assert!((centre / aero.body_x_m - 1.0).abs() < 1e-14, "{mach}: {centre}");
    }
    let applied = Applied::new(&vehicle, 32.5, &point.airframe);
    let beam = structure.beam(&applied).unwrap();
    let one = Loads { incidence_rad: 1.0, ..Loads::default() };
    let [lateral, turning] = beam.rigid_acceleration(&one);
    let lift = -lateral * beam.mass_kg / applied.normal_force_slope_nprad;
    let moment = turning * beam.inertia_kgm2 / applied.moment_slope_nmprad;
    assert!((lift - 1.0).abs() < 1e-13 && (moment - 1.0).abs() < 1e-11, "{lift} {moment}");
}

#[test]
fn what_makes_no_beam_is_refused() {
    let text = crate::SHIPPED_TEXT.replace("CN_nose  = 2.0", "CN_nose  = 3.0");
    let faults = Vehicle::from_toml("user.toml", &text).unwrap_err().0;
    assert_eq!(faults.len(), 1, "{faults:#?}");
    assert!(faults[0].fault.contains("Mach 0"), "{}", faults[0]);
    // A beam of 1e12 m would take more stations than there is memory.
    let text = crate::SHIPPED_TEXT.replace("4900.0, 14.2, 6.0", "4900.0, 1e12, 6.0");
    assert_eq!(Vehicle::from_toml("user.toml", &text).unwrap_err().0.len(), 1);
    let text = crate::SHIPPED_TEXT.replace("freq_ratio = [2.757, 5.404]", "freq_ratio = [2.757]");
    assert!(!Vehicle::from_toml("user.toml", &text).unwrap_err().0.is_empty());
}
