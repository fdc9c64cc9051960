//! Members of a wind ensemble for Monte Carlo flights.
//!
//! W(h) = sign·[f_m W_e(h) + f_σ W_e(h) g_1(h) + σ_s g_2(h)], with W_e the
//! envelope and g_1, g_2 independent, standard Gauss–Markov sequences along the
//! altitude with correlation lengths L_large and L_small:
//! g_{i+1} = e^{−Δh/L} g_i + √(1 − e^{−2Δh/L}) n_i, n standard normal. The
//! recursion is exact for any spacing. Numbers are those of `[windstat]`; with
//! mean + 1.65 σ close to the envelope, the envelope is a 95 % one.
//! A member depends on its seed alone, not on the platform or on the order of
//! drawing.

use interface::deviate::Normal;

use crate::Vehicle;
use crate::table::{Table, TableError};
use crate::wind::Wind;

/// Spacing of a member's altitudes, m: a tenth of the small scale of the
/// shipped statistics.
pub const SPACING_M: f64 = 25.0;
/// Most points of a member: a guard against absurd envelopes.
const MOST_POINTS: f64 = 100_000.0;

/// Sign of an ensemble against the flight on the average.
pub const HEADWIND: f64 = -1.0;

/// One member, drawn by `seed`, over the altitudes of the envelope; `sign`
/// scales it (−1 headwind on the average).
pub fn member(vehicle: &Vehicle, sign: f64, seed: u64) -> Result<Wind, TableError> {
    let wind = &vehicle.data().wind;
    let statistics = &vehicle.data().windstat;
    let envelope = Table::new(wind.envelope_altitude_m.clone(), wind.envelope_speed_mps.clone())?;
    let (lowest_m, highest_m) = match envelope.abscissae() {
        [first, .., last] => (*first, *last),
        _ => return Err(TableError::TooShort { points: 0 }),
    };
    let intervals = ((highest_m - lowest_m) / SPACING_M).ceil().clamp(1.0, MOST_POINTS);
    let spacing_m = (highest_m - lowest_m) / intervals;
    let mut random = Normal::seeded(seed);
    let mut large = GaussMarkov::start(statistics.large_length_m, spacing_m, &mut random);
    let mut small = GaussMarkov::start(statistics.small_length_m, spacing_m, &mut random);
    let (mut altitude_m, mut along_mps) = (Vec::new(), Vec::new());
    for i in 0..=intervals as u32 {
        let h = lowest_m + f64::from(i) * spacing_m;
        let envelope_mps = envelope.lookup(h).value;
        let speed = statistics.mean_fraction * envelope_mps
            + statistics.sigma_fraction * envelope_mps * large.value
            + statistics.small_sigma_mps * small.value;
        altitude_m.push(h);
        along_mps.push(sign * speed);
        large.advance(&mut random);
        small.advance(&mut random);
    }
    Ok(Wind::Profile {
        along_mps: Table::new(altitude_m, along_mps)?,
        cross_fraction: wind.cross_fraction,
    })
}

/// A standard Gauss–Markov sequence, stationary from its first value.
struct GaussMarkov {
    value: f64,
    carry: f64,
    fresh: f64,
}

impl GaussMarkov {
    fn start(length_m: f64, spacing_m: f64, random: &mut Normal) -> Self {
        let carry = libm::exp(-spacing_m / length_m);
        Self { value: random.draw(), carry, fresh: (1.0 - carry * carry).sqrt() }
    }

    fn advance(&mut self, random: &mut Normal) {
        self.value = self.carry * self.value + self.fresh * random.draw();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MEMBERS: u64 = 4_000;

    /// Deviations from the mean at two altitudes, over the ensemble.
    fn deviations(low_m: f64, high_m: f64) -> (Vec<f64>, Vec<f64>) {
        let vehicle = Vehicle::shipped().unwrap();
        (0..MEMBERS)
            .map(|seed| {
                let wind = member(&vehicle, 1.0, seed).unwrap();
                (wind.at(low_m).along_mps, wind.at(high_m).along_mps)
            })
            .unzip()
    }

    #[test]
    fn mean_spread_and_correlation_are_those_of_the_statistics() {
        // 12.0 and 14.5 km: envelope 42 and 51 m/s, one large length apart.
        let (low, high) = deviations(12_000.0, 14_500.0);
        let n = MEMBERS as f64;
        let moments = |x: &[f64], envelope: f64| {
            let mean = x.iter().sum::<f64>() / n;
            let variance = x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
            let expected = (0.27 * envelope).powi(2) + 1.8f64.powi(2);
            // Four standard errors: σ/√n for the mean, σ²√(2/n) for the variance.
            assert!((mean - 0.55 * envelope).abs() < 4.0 * (expected / n).sqrt(), "{mean}");
            assert!((variance / expected - 1.0).abs() < 4.0 * (2.0 / n).sqrt(), "{variance}");
            mean
        };
        let (mean_low, mean_high) = (moments(&low, 42.0), moments(&high, 51.0));
        let covariance =
            low.iter().zip(&high).map(|(a, b)| (a - mean_low) * (b - mean_high)).sum::<f64>() / n;
        // e^{-1} of the large scale, e^{-10} of the small one.
        let expected = 0.27 * 42.0 * 0.27 * 51.0 * (-1f64).exp() + 1.8 * 1.8 * (-10f64).exp();
        // Standard error of a covariance: under σ_a σ_b √((1 + ρ²)/n).
        let error = (0.27 * 42.0 + 1.8) * (0.27 * 51.0 + 1.8) * (1.14 / n).sqrt();
        assert!((covariance - expected).abs() < 4.0 * error, "{covariance} {expected}");
    }
}
