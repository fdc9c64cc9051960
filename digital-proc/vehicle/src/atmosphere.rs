//! US Standard Atmosphere 1976, from 5 km below sea level to 86 km.
//!
//! Source: *U.S. Standard Atmosphere, 1976* (NOAA/NASA/USAF), part 1: eq. (18)
//! for the geopotential altitude, eqs. (23), (33a), (33b) for temperature and
//! pressure, (42) for density, (50) for the speed of sound; its tables I and II
//! for the constants. Geometric altitude outside −5 000…86 000 m is an error:
//! above it the standard changes its formulation.
//!
//! The temperature returned is the molecular-scale temperature T_M, which is
//! what density and speed of sound need. It equals the kinetic temperature to
//! 80 km and exceeds it by at most 0.08 K at 86 km.

use std::sync::LazyLock;

pub const LOWEST_ALTITUDE_M: f64 = -5_000.0;
pub const HIGHEST_ALTITUDE_M: f64 = 86_000.0;

/// Effective Earth radius of the standard, m (45° latitude).
const EARTH_RADIUS_M: f64 = 6_356_766.0;
/// Standard gravity, m/s² (also the geopotential metre's unit).
const G0_MPS2: f64 = 9.806_65;
/// Mean molecular weight at sea level, kg/mol.
const MOLAR_MASS_KGPMOL: f64 = 28.9644e-3;
/// Gas constant of the standard (its value of 1976), J/(mol·K).
const GAS_CONSTANT_JPMOLK: f64 = 8.314_32;
/// Ratio of specific heats.
const HEAT_RATIO: f64 = 1.40;
pub const SEA_LEVEL_PRESSURE_PA: f64 = 101_325.0;
/// Sea-level temperature, K.
const SEA_LEVEL_TEMPERATURE_K: f64 = 288.15;

/// (base geopotential altitude m, lapse rate K/m) of the seven layers.
const LAYERS: [(f64, f64); 7] = [
    (0.0, -6.5e-3),
    (11_000.0, 0.0),
    (20_000.0, 1.0e-3),
    (32_000.0, 2.8e-3),
    (47_000.0, 0.0),
    (51_000.0, -2.8e-3),
    (71_000.0, -2.0e-3),
];

/// Air at one altitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Air {
    /// Molecular-scale temperature, K.
    pub temperature_k: f64,
    pub pressure_pa: f64,
    /// Density, kg/m³.
    pub density_kgpm3: f64,
    pub speed_of_sound_mps: f64,
}

/// An altitude that the model does not cover.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "altitude {altitude_m} m is outside the standard atmosphere ({LOWEST_ALTITUDE_M} to {HIGHEST_ALTITUDE_M} m)"
)]
pub struct AtmosphereError {
    pub altitude_m: f64,
}

/// Geopotential altitude of a geometric one, m: H = r0·Z/(r0 + Z), eq. (18).
pub fn geopotential_altitude_m(altitude_m: f64) -> f64 {
    EARTH_RADIUS_M * altitude_m / (EARTH_RADIUS_M + altitude_m)
}

/// Temperature and pressure at the base of each layer, chained upwards once.
static BASES: LazyLock<[(f64, f64); 7]> = LazyLock::new(|| {
    let mut bases = [(SEA_LEVEL_TEMPERATURE_K, SEA_LEVEL_PRESSURE_PA); 7];
    for i in 1..LAYERS.len() {
        bases[i] = within_layer(i - 1, bases[i - 1], LAYERS[i].0);
    }
    bases
});

/// (temperature K, pressure Pa) at a geopotential altitude of layer `layer`.
fn within_layer(layer: usize, base: (f64, f64), geopotential_m: f64) -> (f64, f64) {
    let (base_m, lapse) = LAYERS[layer];
    let (base_k, base_pa) = base;
    let hydrostatic = G0_MPS2 * MOLAR_MASS_KGPMOL / GAS_CONSTANT_JPMOLK;
    let rise_m = geopotential_m - base_m;
    let temperature_k = base_k + lapse * rise_m;
    let pressure_pa = if lapse == 0.0 {
        base_pa * libm::exp(-hydrostatic * rise_m / base_k)
    } else {
        base_pa * libm::pow(base_k / temperature_k, hydrostatic / lapse)
    };
    (temperature_k, pressure_pa)
}

/// The air at a geometric altitude in m; an error outside −5…86 km or for NaN.
pub fn air_at(altitude_m: f64) -> Result<Air, AtmosphereError> {
    if !(LOWEST_ALTITUDE_M..=HIGHEST_ALTITUDE_M).contains(&altitude_m) {
        return Err(AtmosphereError { altitude_m });
    }
    let geopotential_m = geopotential_altitude_m(altitude_m);
    let layer = LAYERS.partition_point(|&(base_m, _)| base_m <= geopotential_m).saturating_sub(1);
    let (temperature_k, pressure_pa) = within_layer(layer, BASES[layer], geopotential_m);
    let specific_gas_constant = GAS_CONSTANT_JPMOLK / MOLAR_MASS_KGPMOL;
    Ok(Air {
        temperature_k,
        pressure_pa,
        density_kgpm3: pressure_pa / (specific_gas_constant * temperature_k),
        speed_of_sound_mps: (HEAT_RATIO * specific_gas_constant * temperature_k).sqrt(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of the standard's main table against geometric altitude:
    /// m, K, Pa, kg/m³, m/s, as printed.
    const PUBLISHED: [(f64, f64, f64, f64, f64); 12] = [
        (0.0, 288.150, 101_325.0, 1.2250, 340.29),
        (1_000.0, 281.651, 8.9876e4, 1.1117, 336.43),
        (5_000.0, 255.676, 5.4048e4, 7.3643e-1, 320.55),
        (10_000.0, 223.252, 2.6500e4, 4.1351e-1, 299.53),
        (15_000.0, 216.650, 1.2112e4, 1.9476e-1, 295.07),
        (20_000.0, 216.650, 5.5293e3, 8.8910e-2, 295.07),
        (25_000.0, 221.552, 2.5492e3, 4.0084e-2, 298.39),
        (30_000.0, 226.509, 1.1970e3, 1.8410e-2, 301.71),
        (50_000.0, 270.650, 7.9779e1, 1.0269e-3, 329.80),
        (60_000.0, 247.021, 2.1958e1, 3.0968e-4, 315.07),
        (70_000.0, 219.585, 5.2209, 8.2829e-5, 297.06),
        (80_000.0, 198.639, 1.0524, 1.8458e-5, 282.54),
    ];

    #[test]
    fn published_values_are_met_to_their_last_digit() {
        for (altitude_m, kelvin, pa, density, sound) in PUBLISHED {
            let air = air_at(altitude_m).unwrap();
            // One unit of the last printed digit: temperatures to 0.001 K,
            // speeds to 0.01 m/s, pressure and density to five digits.
            assert!((air.temperature_k - kelvin).abs() <= 1e-3, "{altitude_m}: {air:?}");
            assert!((air.speed_of_sound_mps - sound).abs() <= 1e-2, "{altitude_m}: {air:?}");
            assert!((air.pressure_pa / pa - 1.0).abs() <= 1e-4, "{altitude_m}: {air:?}");
            assert!((air.density_kgpm3 / density - 1.0).abs() <= 1e-4, "{altitude_m}: {air:?}");
        }
    }

    #[test]
    fn the_geopotential_altitude_is_the_published_one() {
        // The standard's own pair, to its printed metre.
        assert!((geopotential_altitude_m(86_000.0) - 84_852.0).abs() <= 0.5);
    }

    #[test]
    fn outside_its_range_the_model_refuses() {
        for altitude_m in [-5_000.1, 86_000.1, f64::NAN, f64::INFINITY] {
            assert!(air_at(altitude_m).is_err(), "{altitude_m}");
        }
        assert!(air_at(-5_000.0).is_ok());
        assert!(air_at(86_000.0).is_ok());
    }
}
