//! The gain sequencer: gains constant between switch times.
//!
//! At a switch time the new gains hold (intervals are [t_k, t_{k+1})). A failed
//! sequencer stays in the state it has at the failure. Gains leave here in SI
//! units, per radian.

use crate::ScheduleData;

/// Gains of the pitch and yaw channels (they share them).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopGains {
    /// K_F, rad of fin tip per rad of error.
    pub ftc_gain: f64,
    /// T_F, weight of the rate in the FTC error, s.
    pub ftc_lead_s: f64,
    /// K_T, N per rad beyond the dead zone.
    pub tvc_gain_nprad: f64,
    /// T_T, weight of the rate in the TVC error, s.
    pub tvc_lead_s: f64,
    /// e_dz, half-width of the TVC dead zone, rad.
    pub dead_zone_rad: f64,
}

/// A schedule: switch times, strictly increasing from 0 s, and as many gains.
#[derive(Debug, Clone, PartialEq)]
pub struct GainSchedule {
    switch_time_s: Vec<f64>,
    gains: Vec<LoopGains>,
}

impl GainSchedule {
    /// Of a validated section; extra entries of longer lists are not there,
    /// since validation refuses unequal lengths.
    pub(crate) fn new(data: &ScheduleData) -> Self {
        let gains = (0..data.switch_time_s.len())
            .map(|i| LoopGains {
                ftc_gain: data.ftc_gain[i],
                ftc_lead_s: data.ftc_lead_s[i],
                tvc_gain_nprad: data.tvc_gain_npdeg[i] / 1f64.to_radians(),
                tvc_lead_s: data.tvc_lead_s[i],
                dead_zone_rad: data.dead_zone_deg[i].to_radians(),
            })
            .collect();
        Self { switch_time_s: data.switch_time_s.clone(), gains }
    }

    /// Gains in force at a flight time; before 0 s those of the first interval.
    pub fn at(&self, time_s: f64) -> LoopGains {
        let after = self.switch_time_s.partition_point(|&t| t <= time_s);
        self.gains[after.max(1) - 1]
    }

    /// Gains of a sequencer that stopped at `stuck_s`.
    pub fn stuck_at(&self, time_s: f64, stuck_s: f64) -> LoopGains {
        self.at(time_s.min(stuck_s))
    }

    pub fn switch_time_s(&self) -> &[f64] {
        &self.switch_time_s
    }

    pub fn gains(&self) -> &[LoopGains] {
        &self.gains
    }
}

#[cfg(test)]
mod tests {
    use crate::Vehicle;

    #[test]
    fn gains_change_at_the_switch_time_itself() {
        let vehicle = Vehicle::shipped().unwrap();
        let schedule = vehicle.designed_schedule();
        assert_eq!(schedule.at(16.999).ftc_gain, 0.0);
        assert_eq!(schedule.at(17.0).ftc_gain, 9.5);
        assert_eq!(schedule.at(60.0).ftc_gain, 16.0);
        assert_eq!(schedule.at(-1.0), schedule.at(0.0));
        // 4500 N/deg is 4500·180/π N/rad; one rounding of 2.6e5.
        let expected = 4500.0 * 180.0 / std::f64::consts::PI;
        assert!((schedule.at(0.0).tvc_gain_nprad / expected - 1.0).abs() < 1e-15);
    }

    #[test]
    fn a_stuck_sequencer_keeps_its_state() {
        let vehicle = Vehicle::shipped().unwrap();
        let schedule = vehicle.designed_schedule();
        assert_eq!(schedule.stuck_at(40.0, 17.5), schedule.at(17.0));
        assert_eq!(schedule.stuck_at(5.0, 17.5), schedule.at(5.0));
    }

    #[test]
    fn the_dead_zone_begins_where_the_tips_saturate() {
        // e_dz = δ_max/K_F from 17 s on; the file prints it to 0.01°.
        let vehicle = Vehicle::shipped().unwrap();
        for schedule in [vehicle.designed_schedule(), vehicle.reduced_schedule()] {
            for gains in schedule.gains().iter().filter(|g| g.ftc_gain > 0.0) {
                let saturating = vehicle.data().ftc.delta_max_deg / gains.ftc_gain;
                assert!(
                    (gains.dead_zone_rad.to_degrees() - saturating).abs() <= 0.0051,
                    "{gains:?}"
                );
            }
        }
    }
}
