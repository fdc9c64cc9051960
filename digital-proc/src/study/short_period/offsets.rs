//! The yaw and roll loops from initial attitudes and from the corresponding initial rates.
//!
//! An offset in attitude and one in rate correspond where the loop first asks as much of the tips
//! for both: the rate is the attitude over the loop's lead. Each offset stands alone and all
//! together, the tips shared, without disturbances, at every point where there are tips; beside
//! each run stands the second formulation ([`mod@reference`]).

use super::{
    coefficients::{Disturbance, Offsets, Settings},
    control_loop::{ControlLoop, Response},
    machine::{Bench, Patches},
    measure::{ROLL_BAND_DEG, SATURATED, YAW_BAND},
    metrics::{settling_s, time_beyond_s, worst_of},
    plan::Plan,
    point::FrozenPoint,
    reference,
    study_file::YawRollTest,
};
use crate::linkage::console::{Console, ConsoleFault};
use desk::{
    outcome::Outcome,
    report::{
        Column, Table,
        plot::{Axis, LineChart, Series, Size},
    },
};
use interface::profile::Profile;
use vehicle::Vehicle;

/// Step of the reference, s; across a corner its error is of second order.
const REFERENCE_STEP_S: f64 = 1e-3;
/// What machine and reference may differ by, of the greatest value: (100 rad/s · 1 ms)² / 2 of what
/// a corner switches, a few times a run.
const WITHIN: f64 = 1e-3;

interface::named! {
    /// What is offset, in the order of the tables.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Offset, name {
        /// ψ.
        Yaw "yaw attitude"
        /// ψ̇.
        YawRate "yaw rate"
        /// φ.
        Roll "roll attitude"
        /// φ̇.
        RollRate "roll rate"
        /// Both attitudes.
        Attitudes "both attitudes"
        /// Both rates.
        Rates "both rates"
    }
}

/// Rates that the user's study states, rad/s; zero asks for the corresponding ones.
fn offsets(which: Offset, test: &YawRollTest, point: &FrozenPoint) -> Offsets {
    let (yaw, roll) = (test.yaw_deg.to_radians(), test.roll_deg.to_radians());
    let rate = |stated_dps: f64, attitude: f64, lead_s: f64| {
        if stated_dps != 0.0 {
            stated_dps.to_radians()
        } else if lead_s > 0.0 {
            attitude / lead_s
        } else {
            0.0
        }
    };
    let yaw_rate = rate(test.yaw_rate_dps, yaw, point.ftc_lead_s);
    let roll_rate = rate(test.roll_rate_dps, roll, point.roll_lead_s);
    let only = |of: &[Offset], value: f64| if of.contains(&which) { value } else { 0.0 };
    Offsets {
        yaw_rad: only(&[Offset::Yaw, Offset::Attitudes], yaw),
        yaw_rate_radps: only(&[Offset::YawRate, Offset::Rates], yaw_rate),
        roll_rad: only(&[Offset::Roll, Offset::Attitudes], roll),
        roll_rate_radps: only(&[Offset::RollRate, Offset::Rates], roll_rate),
    }
}

/// One run.
pub struct Row {
    point: String,
    time_s: f64,
    pressure_pa: f64,
    which: Offset,
    initial: Offsets,
    response: Response,
    /// Settling of ψ and φ, s.
    settling_s: [Option<f64>; 2],
    /// Greatest |ψ| and |φ|, rad.
    greatest_rad: [f64; 2],
    /// How long a tip is saturated, s.
    saturated_s: f64,
    /// Greatest force of the thrust vector over its maximum.
    tvc_share: f64,
    /// Greatest difference from the reference over the greatest value, of ψ and φ.
    apart: [f64; 2],
}

fn greatest(column: &[f64]) -> f64 {
    column.iter().fold(0.0, |m: f64, v| m.max(v.abs()))
}

/// Runs every offset at every point with tips.
pub fn run(
    console: &mut Console<'_>,
    plan: &Plan,
    vehicle: &Vehicle,
    test: &YawRollTest,
    profile: &Profile,
    mut progress: impl FnMut(usize),
) -> Result<Vec<Row>, ConsoleFault> {
    let bench = Bench::load(console, ControlLoop::YawRoll, &Patches::shipped(), profile)?;
    let grid = reference::grid(plan, REFERENCE_STEP_S);
    let mut asked = Vec::new();
    for point in &plan.points {
        let frozen = FrozenPoint::new(vehicle, &point.slice, &point.slice.settings.gains);
        if frozen.ftc_gain == 0.0 {
            continue;
        }
        for which in Offset::ALL {
            let initial = offsets(which, test, &frozen);
            let settings = Settings::yaw_roll(&frozen, &Disturbance::NONE, initial, false);
            asked.push((point, which, initial, settings));
        }
    }
    let stop = plan.sample * plan.samples() as i64;
    let mut rows = Vec::with_capacity(asked.len());
    let mut next = asked.iter();
    let runs = asked.iter().map(|(.., settings)| (*settings, stop));
    bench.run(console, plan.sample, runs, |response, _| {
        let Some((point, which, initial, settings)) = next.next() else { return };
        let plane = &settings.plane;
        let second = reference::run(settings, &grid);
        let names = ["yaw_attitude", "roll_attitude"];
        let sample_s = response.sample_s;
        // An angle that stays at zero is no scale for its difference: the greater one is.
        let scale = names.iter().map(|n| greatest(response.of(n))).fold(0.0, f64::max);
        let bands = [YAW_BAND * test.yaw_deg.abs(), ROLL_BAND_DEG].map(f64::to_radians);
        let beyond = |adc| time_beyond_s(response.of(adc), sample_s, SATURATED * plane.tip_travel);
        rows.push(Row {
            point: point.name.clone(),
            time_s: point.slice.time_s,
            pressure_pa: point.slice.airframe.dynamic_pressure_pa,
            which: *which,
            initial: *initial,
            settling_s: [0, 1].map(|i| settling_s(response.of(names[i]), sample_s, 0.0, bands[i])),
            greatest_rad: names.map(|n| greatest(response.of(n))),
            saturated_s: beyond("tip2_deflection").max(beyond("tip4_deflection")),
            tvc_share: greatest(response.of("tvc_yaw_force")) / plane.tvc_limit,
            apart: names.map(|n| {
                let pairs = response.of(n).iter().zip(second.of(n));
                pairs.fold(0.0_f64, |m, (a, b)| m.max((a - b).abs())) / scale
            }),
            response,
        });
        progress(rows.len());
    })?;
    Ok(rows)
}

/// What the runs came to.
pub fn outcome(rows: &[Row]) -> Outcome {
    let mut out = Outcome::new(
        "Yaw and roll from initial attitudes and rates",
        "The yaw and roll loops, their tips shared, from offsets in attitude and from the rates that first ask as much of the tips: the attitude over the loop's lead.",
    );
    let columns = [
        Column::new("Point", "", |r: &Row| r.point.as_str().into()),
        Column::of("Time", "s", 3, |r| r.time_s.into()),
        Column::new("Offset", "", |r| r.which.name().into()),
        Column::of("Yaw", "deg", 3, |r| r.initial.yaw_rad.to_degrees().into()),
        Column::of("Yaw rate", "deg/s", 3, |r| r.initial.yaw_rate_radps.to_degrees().into()),
        Column::of("Roll", "deg", 3, |r| r.initial.roll_rad.to_degrees().into()),
        Column::of("Roll rate", "deg/s", 3, |r| r.initial.roll_rate_radps.to_degrees().into()),
        Column::of("Greatest yaw", "deg", 3, |r| r.greatest_rad[0].to_degrees().into()),
        Column::of("Greatest roll", "deg", 3, |r| r.greatest_rad[1].to_degrees().into()),
        Column::of("Yaw settling", "s", 3, |r| r.settling_s[0].into()),
        Column::of("Roll settling", "s", 3, |r| r.settling_s[1].into()),
        Column::of("A tip saturated", "s", 3, |r| r.saturated_s.into()),
        Column::of("Greatest TVC force", "%", 3, |r| (100.0 * r.tvc_share).into()),
        Column::of("Differs from the reference", "", 2, |r| r.apart[0].max(r.apart[1]).into()),
    ];
    out.section("Numbers").table(
        "offsets",
        format!(
            "Settling is to {:.0} % of the yaw offset in yaw and to {ROLL_BAND_DEG}° in roll about zero.",
            100.0 * YAW_BAND
        ),
        Table::of(&columns, rows),
    );
    let apart = worst_of(rows.iter().flat_map(|r| r.apart));
    out.check(
        "reference",
        format!(
            "every run is that of the second formulation: worst {apart:.1e} of the greatest angle"
        ),
        apart < WITHIN,
    );
    let Some(shown) = rows.iter().max_by(|a, b| a.pressure_pa.total_cmp(&b.pressure_pa)) else {
        return out;
    };
    let here: Vec<&Row> = rows.iter().filter(|r| r.point == shown.point).collect();
    let figures = [
        ("yaw_attitude", "Yaw ψ", "°", 1f64.to_degrees()),
        ("roll_attitude", "Roll φ", "°", 1f64.to_degrees()),
        ("tip2_deflection", "Tip 2", "°", 1f64.to_degrees()),
        ("tvc_yaw_force", "TVC force, yaw", "kN", 1e-3),
    ];
    for (adc, label, unit, factor) in figures {
        let series = here.iter().map(|r| {
            let points = r.response.of(adc).iter().enumerate();
            let points = points.map(|(n, v)| (n as f64 * r.response.sample_s, factor * v));
            Series::of(r.which.name(), points.take_while(|(t, _)| *t <= 6.0))
        });
        let title = format!("{label} at {}", shown.point);
        let (x, y) = (Axis::new("time", "s"), Axis::new(label, unit));
        let chart = LineChart::new(title, x, y, series.collect()).size(Size::FULL);
        out.section("Figures").chart(
            format!("offsets-{}", adc.replace('_', "-")),
            "From offsets in attitude and from the corresponding rates.",
            &chart,
        );
    }
    out
}
