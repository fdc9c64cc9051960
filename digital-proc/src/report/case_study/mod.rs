//! The case study's report: claims, figures 4 to 8, condition matrix, provenance.

mod long_period;
mod sensitivity;
mod short_period;

use maud::{Markup, html};

use super::{Claim, Numbering, Partition, Section, block_diagram, claims_table, page, provenance};
use crate::run_dir::RunRecord;
use crate::study::case_study::{CasePlan, CaseResults};
use crate::study::claim;

/// Which figure or table shows a claim.
const EVIDENCE: [(&str, &str); 14] = [
    ("P1", "matrix-overshoot"),
    ("P2", "figure-4"),
    ("P3", "figure-4"),
    ("P4", "bending-growth"),
    ("P5", "matrix-bending"),
    ("P6", "matrix-bending"),
    ("Y1", "figure-5"),
    ("Y2", "figure-5"),
    ("Y3", "figure-5"),
    ("Y4", "figure-5"),
    ("L1", "modes"),
    ("L2", "q-alpha"),
    ("L2b", "loads"),
    ("L3", "figure-8"),
];

/// A study's claims as a report shows them; `shown` says whether an anchor exists.
pub fn report_claims(claims: &[claim::Claim], shown: impl Fn(&str) -> bool) -> Vec<Claim> {
    claims
        .iter()
        .map(|claim| {
            let evidence = EVIDENCE
                .iter()
                .find(|(id, anchor)| *id == claim.id && shown(anchor))
                .map(|(_, anchor)| format!("#{anchor}"));
            Claim::of(claim, evidence)
        })
        .collect()
}

/// The report as a page.
pub fn case_study_report(results: &CaseResults, plan: &CasePlan, record: &RunRecord) -> String {
    let mut numbering = Numbering::new();
    let partition = numbering.figure(
        "partition",
        "Who computes what in the long-period flights: control dynamics in the analog processor, trajectory dynamics in the digital one. In the short-period runs the whole loop is patched; the digital side sets coefficients, initial conditions, disturbances and modes, and reads the answers.",
        block_diagram(&Partition::long_period()),
    );
    let mut sections = vec![Section::new("Partition", partition)];
    sections.extend(short_period::sections(&mut numbering, results));
    sections.extend(long_period::sections(&mut numbering, results));
    if let Some(dispersions) = &plan.dispersions {
        sections.push(sensitivity::section(&mut numbering, &results.sensitivity, dispersions));
    }
    let shown = |anchor: &str| {
        let id = format!("id=\"{anchor}\"");
        sections.iter().any(|s| s.body.0.contains(&id))
    };
    let claims = report_claims(&results.claims(), shown);
    sections.insert(0, Section::new("Claims of the paper", claims_section(&claims)));
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

fn claims_section(claims: &[Claim]) -> Markup {
    html! {
        p { "Each sentence of the paper, the criterion that it was given here, and what the runs of this session measured." }
        (claims_table(claims))
    }
}
