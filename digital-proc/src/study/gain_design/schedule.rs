//! A gain schedule being designed: its form in the vehicle file and back, and as charts.

use desk::{
    faults::FileFaults,
    report::{
        plot::{Axis, LineChart, Series, Size, line_chart},
        side_by_side,
    },
};
use maud::Markup;
use std::fmt::Write;
use vehicle::{ScheduleData, Vehicle, VehicleData, gain_schedule::LoopGains};

/// Appends an interval, its gains rounded to the digits of the vehicle file so
/// that what is printed is what was tried. The dead zone is left to [`close`].
pub(crate) fn push(schedule: &mut ScheduleData, switch_time_s: f64, gains: &LoopGains) {
    // By division: a multiple of 0.1 or 0.01 then is the nearest number to its print.
    let rounded =
        |value: f64, steps_per_unit: f64| (value * steps_per_unit).round() / steps_per_unit;
    schedule.switch_time_s.push(switch_time_s);
    schedule.ftc_gain.push(rounded(gains.ftc_gain, 10.0));
    schedule.ftc_lead_s.push(rounded(gains.ftc_lead_s, 100.0));
    schedule.tvc_gain_npdeg.push(rounded(gains.tvc_gain_nprad.to_radians(), 0.02));
    schedule.tvc_lead_s.push(rounded(gains.tvc_lead_s, 100.0));
    schedule.dead_zone_deg.push(0.0);
}

/// Sets every dead zone to the error at which the tips saturate, δ_max/K_F, and
/// to none where there are no tips.
pub(crate) fn close(schedule: &mut ScheduleData, tip_travel_deg: f64) {
    for (zone, gain) in schedule.dead_zone_deg.iter_mut().zip(&schedule.ftc_gain) {
        *zone = if *gain > 0.0 { (100.0 * tip_travel_deg / gain).round() / 100.0 } else { 0.0 };
    }
}

/// No intervals.
pub(crate) fn empty() -> ScheduleData {
    ScheduleData {
        switch_time_s: Vec::new(),
        ftc_gain: Vec::new(),
        ftc_lead_s: Vec::new(),
        tvc_gain_npdeg: Vec::new(),
        tvc_lead_s: Vec::new(),
        dead_zone_deg: Vec::new(),
    }
}

/// The vehicle with another designed schedule.
pub(crate) fn with_designed(
    vehicle: &Vehicle,
    schedule: &ScheduleData,
) -> Result<Vehicle, FileFaults> {
    let mut data: VehicleData = vehicle.data().clone();
    let gains = &mut data.gains;
    gains.switch_time_s.clone_from(&schedule.switch_time_s);
    gains.ftc_gain.clone_from(&schedule.ftc_gain);
    gains.ftc_lead_s.clone_from(&schedule.ftc_lead_s);
    gains.tvc_gain_npdeg.clone_from(&schedule.tvc_gain_npdeg);
    gains.tvc_lead_s.clone_from(&schedule.tvc_lead_s);
    gains.dead_zone_deg.clone_from(&schedule.dead_zone_deg);
    Vehicle::from_data(data)
}

/// The schedule as a section of the vehicle file, columns aligned.
pub(crate) fn as_toml(section: &str, comment: &str, schedule: &ScheduleData) -> String {
    let mut out = format!("[{section}]");
    let _ = writeln!(out, "  # {comment}");
    for (key, values, digits) in [
        ("t_sw ", &schedule.switch_time_s, 1),
        ("K_F  ", &schedule.ftc_gain, 1),
        ("T_F  ", &schedule.ftc_lead_s, 2),
        ("K_T  ", &schedule.tvc_gain_npdeg, 1),
        ("T_T  ", &schedule.tvc_lead_s, 2),
        ("e_dz_deg", &schedule.dead_zone_deg, 2),
    ] {
        let values: Vec<String> = values.iter().map(|v| format!("{v:7.digits$}")).collect();
        let _ = writeln!(out, "{key:8} = [{}]", values.join(", "));
    }
    out
}

/// The gains of schedules against flight time, each held from switch to switch.
pub(crate) fn charts(schedules: &[(&str, &ScheduleData)], end_s: f64) -> Markup {
    type Row = (&'static str, &'static str, f64, fn(&ScheduleData) -> &[f64]);
    let rows: [Row; 5] = [
        ("FTC gain K_F", "° fin/°", 1.0, |s| &s.ftc_gain),
        ("FTC rate gain T_F", "s", 1.0, |s| &s.ftc_lead_s),
        ("TVC gain K_T", "kN/°", 1e-3, |s| &s.tvc_gain_npdeg),
        ("TVC rate gain T_T", "s", 1.0, |s| &s.tvc_lead_s),
        ("TVC dead zone", "°", 1.0, |s| &s.dead_zone_deg),
    ];
    let chart = |(label, unit, factor, values): Row| {
        let curve = |(name, schedule): &(&str, &ScheduleData)| {
            let mut x = schedule.switch_time_s.clone();
            let mut y: Vec<f64> = values(schedule).iter().map(|v| v * factor).collect();
            x.push(end_s);
            y.extend(y.last().copied());
            Series::step(*name, &x, &y)
        };
        let axes = (Axis::new("Flight time", "s"), Axis::new(label, unit));
        let series = schedules.iter().map(curve).collect();
        line_chart(&LineChart::new(label, axes.0, axes.1, series).size(Size::HALF))
    };
    side_by_side(&rows.map(chart))
}

#[cfg(test)]
mod tests {
    use super::*;
    use vehicle::gain_schedule::DeadZoneLaw;

    #[test]
    fn the_printed_schedule_reads_back_as_the_one_tried() {
        let vehicle = Vehicle::shipped().unwrap();
        let mut schedule = empty();
        for (time, g) in [0.0, 17.0, 31.5].iter().zip([0.0, 8.0394, 12.61]) {
            let mut all = vehicle.designed_schedule().at(*time);
            all.ftc_gain = g;
            all.tvc_lead_s = 0.123_456;
            push(&mut schedule, *time, &all);
        }
        close(&mut schedule, 10.0);
        assert_eq!(schedule.ftc_gain, [0.0, 8.0, 12.6]);
        assert_eq!(schedule.dead_zone_deg, [0.0, 1.25, 0.79]);
        let text = as_toml("gains_reduced", "tried", &schedule);
        let read: toml::Table = toml::from_str(&text).unwrap();
        let read: ScheduleData = read["gains_reduced"].clone().try_into().unwrap();
        assert_eq!(read, schedule);
        let flown = with_designed(&vehicle, &schedule).unwrap();
        let law = DeadZoneLaw::new(flown.data());
        assert_eq!(flown.designed_schedule().at(20.0), LoopGains::of(&schedule, 1, law));
    }
}
