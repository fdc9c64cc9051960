//! Tables of the short-period runs: measures beside eigenvalues, and linear agreement.

use crate::study::short_period::agreement::Compared;
use crate::study::short_period::linear::ChannelGains;
use crate::study::short_period::outcome::{Outcome, Run};
use crate::study::short_period::plan::YawRollCase;
use desk::report::{Cell, Heading, Table};

/// Table of the pitch measures, for terminal, page and machines.
pub fn pitch_table(outcome: &Outcome) -> Table {
    let mut table = Table::new(vec![
        Heading::new("Point", ""),
        Heading::new("Condition", ""),
        Heading::new("Test", ""),
        Heading::new("Overshoot", "%").digits(3),
        Heading::new("Settling", "s").digits(3),
        Heading::new("Residual", "%").digits(3),
        Heading::new("η by 6.5 s", "%").digits(3),
        Heading::new("η by 9.5 s", "%").digits(3),
        Heading::new("Tips limited", "s").digits(3),
        Heading::new("TVC limited", "s").digits(3),
        Heading::new("Greatest α", "deg").digits(3),
        Heading::new("ω, attitude", "rad/s").digits(3),
        Heading::new("ζ, attitude", "").digits(3),
        Heading::new("ζ, bending", "").digits(3),
    ]);
    for Run { point, condition, case, measures: m, .. } in &outcome.pitch {
        let percent = |v: Option<f64>| number(v.map(|v| 100.0 * v));
        table.row([
            point.as_str().into(),
            condition.as_str().into(),
            if case.disturbed { "disturbed" } else { "step only" }.into(),
            percent(m.overshoot),
            number(m.settling_s),
            percent(m.residual),
            percent(m.bending_ratio(1)),
            percent(m.bending_ratio(2)),
            m.tip_saturation_s.into(),
            m.tvc_saturation_s.into(),
            m.greatest_incidence_rad.to_degrees().into(),
            number(m.roots_both.attitude.map(|r| r.frequency_radps())),
            number(m.roots_both.attitude.map(|r| r.damping())),
            number(m.roots_both.bending.map(|r| r.damping())),
        ]);
    }
    table
}

/// Table of the yaw–roll measures.
pub fn yaw_roll_table(outcome: &Outcome) -> Table {
    let mut table = Table::new(vec![
        Heading::new("Point", ""),
        Heading::new("Condition", ""),
        Heading::new("Tips", ""),
        Heading::new("Given to roll", "s").digits(3),
        Heading::new("TVC called", "s").digits(3),
        Heading::new("Roll fallen", "s").digits(3),
        Heading::new("Yaw share then", "%").digits(3),
        Heading::new("Yaw settling", "s").digits(3),
        Heading::new("Roll settling", "s").digits(3),
        Heading::new("Final yaw", "deg").digits(3),
        Heading::new("Final roll", "deg").digits(3),
        Heading::new("ω, yaw", "rad/s").digits(3),
        Heading::new("ζ, yaw", "").digits(3),
    ]);
    for Run { point, condition, case, measures: m, .. } in &outcome.yaw_roll {
        table.row([
            point.as_str().into(),
            condition.as_str().into(),
            allocation(case).into(),
            m.tips_given_to_roll_s.into(),
            number(m.tvc_called_s),
            number(m.roll_fallen_s),
            number(m.yaw_share_after.map(|s| 100.0 * s)),
            number(m.yaw_settling_s),
            number(m.roll_settling_s),
            m.final_yaw_rad.to_degrees().into(),
            m.final_roll_rad.to_degrees().into(),
            number(m.roots_both.attitude.map(|r| r.frequency_radps())),
            number(m.roots_both.attitude.map(|r| r.damping())),
        ]);
    }
    table
}

/// Table of the runs held against linear theory.
pub fn agreement_table(outcome: &Outcome) -> Table {
    let mut table = Table::new(vec![
        Heading::new("Run", ""),
        Heading::new("Linear range", ""),
        Heading::new("Attitude differs by", "% of the step").digits(2),
        Heading::new("ω, eigenvalue", "rad/s"),
        Heading::new("ω, measured", "rad/s"),
        Heading::new("ζ, eigenvalue", "").digits(3),
        Heading::new("ζ, measured", "").digits(3),
        Heading::new("Agrees", ""),
    ]);
    for agreement in &outcome.agreement {
        let agrees = if agreement.agrees() { "yes" } else { "NO" };
        let name = outcome.pitch[agreement.run].name.as_str();
        let mut row: Vec<Cell> = vec![name.into(), range(agreement.gains).into()];
        row.extend(match agreement.compared {
            Compared::Response { attitude, .. } => {
                [(100.0 * attitude).into(), "".into(), "".into(), "".into(), "".into()]
            }
            Compared::Decay { measured, root } => [
                "".into(),
                root.frequency_radps().into(),
                measured.frequency_radps.into(),
                root.damping().into(),
                measured.damping.into(),
            ],
        });
        row.push(agrees.into());
        table.row(row);
    }
    table
}

fn range(gains: ChannelGains) -> &'static str {
    match (gains.ftc > 0.0, gains.tvc > 0.0) {
        (true, true) => "tips and thrust vector",
        (true, false) => "tips alone, in the dead zone",
        (false, true) => "thrust vector alone",
        (false, false) => "no control, in the dead zone",
    }
}

/// How a run shares the tips.
pub fn allocation(case: &YawRollCase) -> &'static str {
    if case.settings.dedicated { "roll only" } else { "shared" }
}

/// The same table with a dash for each number that does not exist, for a terminal.
pub fn dashed(mut table: Table) -> Table {
    for cell in table.rows.iter_mut().flatten() {
        if matches!(cell, Cell::Number(v) if v.is_nan()) {
            *cell = "-".into();
        }
    }
    table
}

/// A measure that may be absent: no number on a page, null for machines.
fn number(value: Option<f64>) -> Cell {
    Cell::Number(value.unwrap_or(f64::NAN))
}
