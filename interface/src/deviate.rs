//! Seeded normal deviates: the same bits from a seed on every processor.
//!
//! The ziggurat of Marsaglia and Tsang in Doornik's variant ("An Improved Ziggurat
//! Method to Generate Normal Random Samples", 2005), 256 layers of equal area under
//! f(x) = exp(−x²/2), over the generator Xoshiro256++. Its tables, wedges and tail take
//! logarithm and exponential from `libm`; the usual crate takes them from the C library,
//! whose last bits depend on the processor.

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};
use std::sync::LazyLock;

/// Layers; the lowest is the rectangle under [`TAIL`] and the tail beyond it.
const LAYERS: usize = 256;
/// Where the tail begins, for 256 layers (Doornik, table 1).
const TAIL: f64 = 3.654_152_885_361_009;
/// Area of each layer, as printed there.
const AREA: f64 = 0.004_928_673_233_99;

/// Right edge of each layer and the density there, from below; the last edge is 0.
static EDGES: LazyLock<[(f64, f64); LAYERS + 1]> = LazyLock::new(|| {
    let mut edges = [(0.0, 1.0); LAYERS + 1];
    // The lowest layer drawn as if it were a rectangle of the same area.
    edges[0] = (AREA / density(TAIL), 0.0);
    edges[1] = (TAIL, density(TAIL));
    for i in 2..LAYERS {
        let (x, f) = edges[i - 1];
        let above = f + AREA / x;
        edges[i] = ((-2.0 * libm::log(above)).sqrt(), above);
    }
    edges
});

fn density(x: f64) -> f64 {
    libm::exp(-0.5 * x * x)
}

/// A source of deviates of mean 0 and variance 1.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Normal {
    generator: Xoshiro256PlusPlus,
}

impl Normal {
    /// The sequence of `seed`.
    pub fn seeded(seed: u64) -> Normal {
        Normal { generator: Xoshiro256PlusPlus::seed_from_u64(seed) }
    }

    pub fn draw(&mut self) -> f64 {
        let edges = &*EDGES;
        loop {
            let bits = self.generator.next_u64();
            // The lowest byte picks a layer, the 52 highest bits a place in it, −1 to 1.
            let layer = (bits & 0xff) as usize;
            let place = (bits >> 12) as f64 / (1_u64 << 51) as f64 - 1.0;
            let x = place * edges[layer].0;
            if x.abs() < edges[layer + 1].0 {
                return x;
            }
            if layer == 0 {
                return self.tail().copysign(place);
            }
            let (low, high) = (edges[layer].1, edges[layer + 1].1);
            let even = (self.generator.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
            if high + (low - high) * even < density(x) {
                return x;
            }
        }
    }

    /// A deviate beyond [`TAIL`], by Marsaglia's rejection: an exponential one under a parabola.
    fn tail(&mut self) -> f64 {
        loop {
            let beyond = -libm::log(self.above_zero()) / TAIL;
            if -2.0 * libm::log(self.above_zero()) >= beyond * beyond {
                return TAIL + beyond;
            }
        }
    }

    /// Even between 0 and 1, neither included.
    fn above_zero(&mut self) -> f64 {
        ((self.generator.next_u64() >> 12) as f64 + 0.5) / (1_u64 << 52) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shares_within_bounds_are_those_of_the_normal_distribution() {
        const DRAWS: u32 = 4_000_000;
        let mut source = Normal::seeded(3);
        let bounds = [0.1, 0.25, 0.7, 1.0, 2.0, 3.0, TAIL, 4.2];
        let (mut within, mut above) = ([0_u32; 8], 0_u32);
        for _ in 0..DRAWS {
            let x = source.draw();
            above += u32::from(x > 0.0);
            for (count, bound) in within.iter_mut().zip(bounds) {
                *count += u32::from(x.abs() < bound);
            }
        }
        let close = |count: u32, share: f64, what: f64| {
            // Four standard errors of a count of independent draws.
            let error = 4.0 * (share * (1.0 - share) / f64::from(DRAWS)).sqrt();
            let found = f64::from(count) / f64::from(DRAWS);
            assert!((found - share).abs() < error, "{what}: {found} for {share}");
        };
        close(above, 0.5, 0.0);
        for (count, bound) in within.into_iter().zip(bounds) {
            close(count, libm::erf(bound / std::f64::consts::SQRT_2), bound);
        }
    }

    #[test]
    fn deviates_are_those_of_another_ziggurat_on_the_same_generator() {
        // `StandardNormal` of rand_distr 0.6.0 over seed 1, whose tables carry 18 digits. The
        // edges here gather a rounding a layer: 256 · 2ε.
        let mut source = Normal::seeded(1);
        for expected in [0.843_998_613_622_176_1, 0.715_560_712_730_593_1, -1.915_871_443_618_758_5]
        {
            let found = source.draw();
            let expected: f64 = expected;
            assert!((found / expected - 1.0).abs() < 512.0 * f64::EPSILON, "{found} {expected}");
        }
    }
}
