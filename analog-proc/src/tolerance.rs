//! Component tolerance: no resistor has its nominal value.
//!
//! A machine of component error e has each coefficient c of each input at
//! c·(1 + d), with d fixed for that input and evenly spread over ±e. The spread
//! is a property of the machine, not of a run: it depends on the block's name and
//! the input's place alone, so a patch meets the same machine every time.
//! DCU and DAC settings are converters' business, not components'.

use crate::order::Ordered;
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Gives every coefficient of the patch its actual value.
pub fn apply(ordered: &mut Ordered, component_error: f64) {
    if component_error == 0.0 {
        return;
    }
    for block in &mut ordered.netlist.blocks {
        // FNV-1a, 64 bits, of the name: the same on every build.
        let seed = block.name.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
        });
        let mut spread = Xoshiro256PlusPlus::seed_from_u64(seed);
        for input in &mut block.inputs {
            // 53 random bits over [0, 1), then over ±e.
            let even = (spread.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
            input.coefficient *= 1.0 + component_error * (2.0 * even - 1.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use interface::control::PatchBundle;

    fn oscillator() -> Ordered {
        let text = "[blocks]\nx = { kind = \"integrator\", in = [\"v\"], ic = 1.0 }\nv = { kind = \"integrator\", in = [\"-4 * x\", \"-0.2 * v\"] }\n";
        let bundle = PatchBundle { root: "p".into(), files: vec![("p".into(), text.into())] };
        crate::patch::compile(&bundle, &[]).unwrap()
    }

    #[test]
    fn coefficients_stay_within_the_error_and_repeat() {
        let coefficients = |error: f64| {
            let mut ordered = oscillator();
            apply(&mut ordered, error);
            let blocks = ordered.netlist.blocks.iter();
            blocks.flat_map(|b| b.inputs.iter().map(|i| i.coefficient)).collect::<Vec<f64>>()
        };
        let (nominal, real) = (coefficients(0.0), coefficients(0.01));
        assert_eq!(nominal, [1.0, -4.0, -0.2]);
        for (c, actual) in nominal.iter().zip(&real) {
            // One rounding beyond the bound itself.
            let relative = (actual / c - 1.0).abs();
            assert!(relative > 0.0 && relative <= 0.01 * (1.0 + 1e-12), "{actual} of {c}");
        }
        assert_eq!(real, coefficients(0.01));
    }
}
