//! The stored open-loop pitch programme.
//!
//! θ_c(t) = θ_0 − ∫ rate dt, piecewise linear: constant before the first node,
//! nose-down at a constant rate between nodes, held after the last one (and
//! flagged, because the data set says nothing there). The attitude is inertial
//! pitch from the launch horizontal, nose-up positive, 90° on the pad.
//! Departs from the paper, eq. (3): there pitch counts from the launch vertical.

use crate::PitchProgrammeData;
use crate::table::{Edge, Table, TableError};

/// Commanded attitude at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PitchCommand {
    /// θ_c, rad.
    pub pitch_rad: f64,
    /// θ̇_c just after this time, rad/s; zero outside the programme.
    pub pitch_rate_radps: f64,
    /// `Above` after the last node; before the first one `Inside`, since the
    /// launch attitude is then the command.
    pub edge: Edge,
}

/// The programme.
#[derive(Debug, Clone, PartialEq)]
pub struct PitchProgramme {
    pitch_rad: Table,
}

impl PitchProgramme {
    /// Integrates the rates of the data set.
    pub fn new(data: &PitchProgrammeData) -> Result<Self, TableError> {
        let nodes = &data.node_time_s;
        let mut pitch_deg = data.theta0_deg;
        let mut pitches_rad = vec![pitch_deg.to_radians()];
        for (interval, rate_dps) in nodes.windows(2).zip(&data.rate_dps) {
            pitch_deg -= rate_dps * (interval[1] - interval[0]);
            pitches_rad.push(pitch_deg.to_radians());
        }
        Ok(Self { pitch_rad: Table::new(nodes.clone(), pitches_rad)? })
    }

    /// The command at a flight time.
    pub fn at(&self, time_s: f64) -> PitchCommand {
        let found = self.pitch_rad.lookup(time_s);
        PitchCommand {
            pitch_rad: found.value,
            pitch_rate_radps: found.slope,
            edge: match found.edge {
                Edge::Below => Edge::Inside,
                edge => edge,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_integrates_the_rates() {
        let data = PitchProgrammeData {
            node_time_s: vec![4.0, 6.0, 9.0],
            rate_dps: vec![1.0, 2.0],
            theta0_deg: 90.0,
        };
        let programme = PitchProgramme::new(&data).unwrap();
        for (t, deg) in [
            (0.0, 90.0),
            (4.0, 90.0),
            (5.0, 89.0),
            (6.0, 88.0),
            (8.0, 84.0),
            (9.0, 82.0),
            (50.0, 82.0),
        ] {
            // A few roundings of numbers near 1.6 rad.
            let command = programme.at(t);
            assert!((command.pitch_rad - f64::to_radians(deg)).abs() < 1e-14, "{t}");
        }
        assert_eq!(programme.at(0.0).edge, Edge::Inside);
        assert_eq!(programme.at(9.5).edge, Edge::Above);
        assert!((programme.at(7.0).pitch_rate_radps + f64::to_radians(2.0)).abs() < 1e-14);
    }
}
