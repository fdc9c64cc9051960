//! Tests of the reference flight.
use super::*;

#[test]
fn explore() {
    let vehicle = Vehicle::shipped().unwrap();
    let case = FlightCase::undisturbed();
    let t0 = std::time::Instant::now();
    let s = fly(&vehicle, &case, 1000, |_| {}).unwrap();
    println!("{:?} {s:#?} range {}", t0.elapsed(), s.range_m);
    println!("gamma {}", s.end.path_angle_rad.to_degrees());
    let nominal = s;
    for (name, sign) in [("calm", 0.0), ("head", -1.0), ("tail", 1.0)] {
        for mode in FlightMode::ALL {
            let mut case = FlightCase::design(&vehicle, mode).unwrap();
            case.wind = if sign == 0.0 {
                Wind::Calm
            } else {
                Wind::Synthetic(
                    crate::wind::SyntheticWind::new(&vehicle.data().wind, sign).unwrap(),
                )
            };
            match fly(&vehicle, &case, 1000, |_| {}) {
                Ok(s) => println!(
                    "{name} {:18} dV {:+.3}% dg {:+.3} dh {:+.3}% dR {:+.3} km Qa {:.1} @ {:.2} roll {:.1} impP {:.0} impY {:.0} kg {:.1}",
                    mode.name(),
                    100.0 * (s.end.speed_mps / nominal.end.speed_mps - 1.0),
                    (s.end.path_angle_rad - nominal.end.path_angle_rad).to_degrees(),
                    100.0 * (s.end.altitude_m / nominal.end.altitude_m - 1.0),
                    (s.range_m - nominal.range_m) / 1e3,
                    s.max_q_alpha.value / 1e3,
                    s.max_q_alpha.time_s,
                    s.max_roll_rad.to_degrees(),
                    s.tvc_pitch_impulse_ns,
                    s.tvc_yaw_impulse_ns,
                    s.injectant_kg
                ),
                Err(e) => println!("{name} {} {e}", mode.name()),
            }
        }
    }
}
