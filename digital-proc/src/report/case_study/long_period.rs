//! Long-period part: figure 6 (trajectory variables), flights, figures 7 and 8 (gains).

use maud::{Markup, html};

use crate::report::long_period::{mode_tables, schedule_figures, variable_figures};
use crate::study::case_study::CaseResults;
use crate::study::long_period::results::LongPeriodResults;
use desk::report::{Numbering, Section};

/// The sections in order.
pub(super) fn sections(numbering: &mut Numbering, results: &CaseResults) -> Vec<Section> {
    let long = &results.long;
    vec![
        Section::new("Trajectories (figure 6 of the paper)", figure_6(numbering, long)),
        Section::new("Flights and side-force fuel", flights(numbering, long)),
        Section::new(
            "Gain schedules (figures 7 and 8 of the paper)",
            schedule_figures(numbering, long),
        ),
    ]
}

fn figure_6(numbering: &mut Numbering, long: &LongPeriodResults) -> Markup {
    let (load, others) = variable_figures(numbering, long);
    html! {
        p { "The modes of operation in the design wind with nominal misalignments." }
        (load)
        (others)
    }
}

fn flights(numbering: &mut Numbering, long: &LongPeriodResults) -> Markup {
    html! {
        dl { @for mode in &long.modes { dt { (mode.name) } dd { (mode.text) } } }
        (mode_tables(numbering, long))
    }
}
