//! The case study's report: claims, figures 4 to 8, condition matrix, provenance.

mod long_period;
mod sensitivity;
mod short_period;

use maud::html;

use super::block_diagram;
use crate::study::case_study::{CasePlan, CaseResults};
use desk::report::{Numbering, Section, claims_table, page, provenance};
use desk::run_dir::RunRecord;

/// The report as a page.
pub fn case_study_report(results: &CaseResults, plan: &CasePlan, record: &RunRecord) -> String {
    let mut numbering = Numbering::new();
    let partition = numbering.figure(
        "partition",
        "Who computes what in the long-period flights: control dynamics in the analog processor, trajectory dynamics in the digital one. In the short-period runs the whole loop is patched; the digital side sets coefficients, initial conditions, disturbances and modes, and reads the answers.",
        block_diagram(),
    );
    let mut sections = vec![Section::new("Partition", partition)];
    sections.extend(short_period::sections(&mut numbering, results));
    sections.extend(long_period::sections(&mut numbering, results));
    if let Some(dispersions) = &plan.dispersions {
        sections.push(sensitivity::section(&mut numbering, &results.sensitivity, dispersions));
    }
    let claims = html! {
        p { "Each sentence of the paper, the criterion that it was given here, and what the runs of this session measured." }
        (claims_table(&results.claims(), &numbering))
    };
    sections.insert(0, Section::new("Claims of the paper", claims));
    sections.push(Section::new("Provenance", provenance(record)));
    let (short, flights) = (&plan.short, plan.long.flights());
    page(
        "First-stage control system: the case study rerun",
        &format!(
            "Section 4 of the paper on the hybrid machine: {} pitch runs and {} yaw–roll runs at {} trajectory points, and {flights} flights to burn-out, all in one session.",
            short.pitch.len(),
            short.yaw_roll.len(),
            short.points.len()
        ),
        &sections,
    )
}
