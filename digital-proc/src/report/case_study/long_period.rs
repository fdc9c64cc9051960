//! Long-period part: figure 6 (trajectory variables), flights, figures 7 and 8 (gains).

use maud::{Markup, html};

use crate::report::gain_design::schedule_charts;
use crate::report::long_period::{fuel_table, fuel_words, load_table, mode_table, variable_charts};
use crate::report::{Numbering, Section, side_by_side};
use crate::study::case_study::CaseResults;
use crate::study::long_period::results::LongPeriodResults;
use crate::vehicle::ScheduleData;

/// The sections in order.
pub(super) fn sections(numbering: &mut Numbering, results: &CaseResults) -> Vec<Section> {
    let long = &results.long;
    vec![
        Section::new(
            "Trajectories (figure 6 of the paper)",
            figure_6(numbering, long),
        ),
        Section::new("Flights and side-force fuel", flights(numbering, long)),
        Section::new(
            "Gain schedules (figures 7 and 8 of the paper)",
            schedules(numbering, long),
        ),
    ]
}

fn figure_6(numbering: &mut Numbering, long: &LongPeriodResults) -> Markup {
    let mut load = None;
    let mut others = Vec::new();
    for (id, label, chart) in variable_charts(long) {
        if id == "q-alpha" {
            load = Some(numbering.figure(
                id,
                "Load indicator Qα of the modes against its design limit, judged from the take-over of the fin tips on.",
                chart,
            ));
        } else {
            others.push(numbering.figure(id, &format!("{label} against time."), chart));
        }
    }
    html! {
        p { "The modes of operation in the design wind with nominal misalignments." }
        @if let Some(load) = load { (load) }
        (side_by_side(&others))
    }
}

fn flights(numbering: &mut Numbering, long: &LongPeriodResults) -> Markup {
    html! {
        dl { @for mode in &long.modes { dt { (mode.name) } dd { (mode.text) } } }
        (numbering.table("modes",
            "Departure of each mode's burn-out from that of the undisturbed normal flight, its load and its fluid; design case.",
            mode_table(long).markup()))
        (numbering.table("loads",
            "Greatest |Qα| over misalignments and winds.",
            load_table(long).markup()))
        (numbering.table("fuel",
            "Side-force fluid over misalignments and winds.",
            fuel_table(long).markup()))
        p { (fuel_words(long)) "." }
    }
}

fn schedules(numbering: &mut Numbering, long: &LongPeriodResults) -> Markup {
    let end_s = long.nominal_history.time_s.last().copied().unwrap_or(0.0);
    let switchings = |s: &ScheduleData| s.switch_time_s.len().saturating_sub(1);
    let designed = schedule_charts(&[("designed", &long.designed)], end_s);
    let reduced = schedule_charts(
        &[("reduced", &long.reduced), ("designed", &long.designed)],
        end_s,
    );
    html! {
        (numbering.figure("figure-7",
            &format!("The designed gain schedules, {} switchings.", switchings(&long.designed)),
            side_by_side(&designed)))
        (numbering.figure("figure-8",
            &format!("The gain schedules reduced by long-period trials to {} switchings, beside the designed ones.", switchings(&long.reduced)),
            side_by_side(&reduced)))
    }
}
