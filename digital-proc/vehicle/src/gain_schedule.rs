//! The gain sequencer: gains constant between switch times.
//!
//! At a switch time the new gains hold (intervals are [t_k, t_{k+1})). A failed
//! sequencer stays in the state it has at the failure. Gains leave here in SI
//! units, per radian.

use crate::{ScheduleData, VehicleData, data::DeadZone};

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
    /// e_dz, half-width of the TVC dead zone while roll asks nothing of the tips, rad.
    pub dead_zone_rad: f64,
    /// By how much it shrinks in yaw for each rad of tip that roll has taken, rad/rad.
    pub dead_zone_yield: f64,
}

/// Where the dead zone of an interval comes from. Half width in yaw: `dead_zone_rad` −
/// `dead_zone_yield`·½|δ_2 − δ_4|, never below zero.
///
/// It follows the *deflections*, not the commands, by which the TVC would open before a tip has
/// moved, and the gain that the sequencer gives, not what a failure leaves of it: a lost FTC gain
/// would widen the zone without bound and shut the TVC when nothing else is left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DeadZoneLaw {
    /// The authority that the tips have left, in error: travel/K_F, less 1/K_F for each rad of tip.
    Remaining { travel_rad: f64 },
    /// `e_dz_deg` of the schedule, whatever the tips do.
    Scheduled,
}

impl DeadZoneLaw {
    pub fn new(data: &VehicleData) -> DeadZoneLaw {
        match data.tvc.dead_zone {
            DeadZone::Scheduled => DeadZoneLaw::Scheduled,
            DeadZone::Remaining => {
                DeadZoneLaw::Remaining { travel_rad: data.ftc.delta_max_deg.to_radians() }
            }
        }
    }
}

impl LoopGains {
    /// Of interval `i` of a validated schedule.
    pub fn of(schedule: &ScheduleData, i: usize, law: DeadZoneLaw) -> LoopGains {
        let ftc_gain = schedule.ftc_gain[i];
        let (dead_zone_rad, dead_zone_yield) = match law {
            DeadZoneLaw::Scheduled => (schedule.dead_zone_deg[i].to_radians(), 0.0),
            // Without tips there is no authority, and the TVC acts at once.
            DeadZoneLaw::Remaining { .. } if ftc_gain == 0.0 => (0.0, 0.0),
            DeadZoneLaw::Remaining { travel_rad } => (travel_rad / ftc_gain, 1.0 / ftc_gain),
        };
        LoopGains {
            ftc_gain,
            ftc_lead_s: schedule.ftc_lead_s[i],
            tvc_gain_nprad: schedule.tvc_gain_npdeg[i] / 1f64.to_radians(),
            tvc_lead_s: schedule.tvc_lead_s[i],
            dead_zone_rad,
            dead_zone_yield,
        }
    }
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
    pub(crate) fn new(data: &ScheduleData, law: DeadZoneLaw) -> Self {
        let of = |i| LoopGains::of(data, i, law);
        let gains = (0..data.switch_time_s.len()).map(of).collect();
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
    use crate::{Vehicle, data::DeadZone};

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
        // e_dz = δ_max/K_F from 17 s on; the file prints it to 0.01°, and the law of the tips'
        // remaining authority has it exactly.
        let mut data = Vehicle::shipped().unwrap().data().clone();
        for law in DeadZone::ALL {
            data.tvc.dead_zone = law;
            let vehicle = Vehicle::from_data(data.clone()).unwrap();
            for schedule in [vehicle.designed_schedule(), vehicle.reduced_schedule()] {
                for gains in schedule.gains().iter().filter(|g| g.ftc_gain > 0.0) {
                    let saturating = vehicle.data().ftc.delta_max_deg / gains.ftc_gain;
                    let (within, taken) = match law {
                        DeadZone::Scheduled => (0.0051, 0.0),
                        DeadZone::Remaining => (1e-14, gains.ftc_gain.recip()),
                    };
                    let off = (gains.dead_zone_rad.to_degrees() - saturating).abs();
                    assert!(off <= within && gains.dead_zone_yield == taken, "{gains:?}");
                }
            }
        }
    }
}
