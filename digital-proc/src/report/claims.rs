//! The claims table: a sentence, its criterion, what was measured, and whether it holds.

use crate::study::claim;
use maud::{Markup, html};
use serde::Serialize;

/// How a claim came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The criterion is met.
    Holds,
    /// It is not met.
    Fails,
    /// What would decide it was not run.
    NotJudged,
}

impl Verdict {
    /// The mark that stands beside the words.
    pub fn mark(self) -> char {
        match self {
            Verdict::Holds => '✓',
            Verdict::Fails => '✗',
            Verdict::NotJudged => '·',
        }
    }

    /// The verdict in words.
    pub fn words(self) -> &'static str {
        match self {
            Verdict::Holds => "holds",
            Verdict::Fails => "does not hold",
            Verdict::NotJudged => "not judged",
        }
    }
}

/// One line of the table.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Claim {
    /// Its label (`P1`).
    pub id: String,
    /// The sentence that is tested.
    pub sentence: String,
    /// What must be measured for it to hold.
    pub criterion: String,
    /// What was measured, with units.
    pub measured: String,
    /// The outcome.
    pub verdict: Verdict,
    /// Where it holds only in part, or a remark; may be empty.
    pub note: String,
    /// The figure or table that shows it (`#fig-pitch`).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub evidence: Option<String>,
}

impl Claim {
    /// A study's claim as a report shows it, with the anchor of what shows it.
    pub fn of(claim: &claim::Claim, evidence: Option<String>) -> Claim {
        Claim {
            id: claim.id.to_owned(),
            sentence: claim.sentence.to_owned(),
            criterion: claim.criterion.clone(),
            measured: claim.measured.clone(),
            verdict: match claim.verdict {
                claim::Verdict::Holds => Verdict::Holds,
                claim::Verdict::Fails => Verdict::Fails,
                claim::Verdict::NotJudged => Verdict::NotJudged,
            },
            note: claim.remark.clone().unwrap_or_default(),
            evidence,
        }
    }
}

/// The table for a page, under a line that counts the verdicts.
pub fn claims_table(claims: &[Claim]) -> Markup {
    html! {
        p { (count(claims)) }
        div.wide { table.claims {
            thead { tr { @for head in ["", "Sentence", "Criterion", "Measured", "Verdict"] { th scope="col" { (head) } } } }
            tbody { @for claim in claims {
                tr id={ "claim-" (claim.id) } {
                    td { (claim.id) }
                    td { blockquote { (claim.sentence) } }
                    td { (claim.criterion) }
                    td {
                        (claim.measured)
                        @if let Some(href) = &claim.evidence { " " a href=(href) { "shown here" } }
                        @if !claim.note.is_empty() { small { (claim.note) } }
                    }
                    td.v.{ (class(claim.verdict)) } { (claim.verdict.mark()) "\u{202f}" (claim.verdict.words()) }
                }
            } }
        } }
    }
}

/// The table for a terminal: a line a claim.
pub fn claims_text(claims: &[Claim]) -> String {
    let width = |text: fn(&Claim) -> &str| {
        claims.iter().map(|c| text(c).chars().count()).max().unwrap_or(0)
    };
    let (ids, words) = (width(|c| &c.id), width(|c| c.verdict.words()));
    let mut out = String::new();
    for claim in claims {
        let verdict = claim.verdict.words();
        out.push_str(&format!(
            "{} {verdict:words$}  {:ids$}  {}  (criterion: {})\n",
            claim.verdict.mark(),
            claim.id,
            claim.measured,
            claim.criterion
        ));
        if claim.verdict != Verdict::Holds && !claim.note.is_empty() {
            out.push_str(&format!("  {:words$}  {:ids$}  {}\n", "", "", claim.note));
        }
    }
    out.push_str(&count(claims));
    out.push('\n');
    out
}

fn count(claims: &[Claim]) -> String {
    let of = |verdict| claims.iter().filter(|c| c.verdict == verdict).count();
    let mut parts = vec![format!("{} of {} claims hold", of(Verdict::Holds), claims.len())];
    if of(Verdict::Fails) > 0 {
        parts.push(format!("{} not", of(Verdict::Fails)));
    }
    if of(Verdict::NotJudged) > 0 {
        parts.push(format!("{} not judged", of(Verdict::NotJudged)));
    }
    format!("{}.", parts.join(", "))
}

fn class(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Holds => "holds",
        Verdict::Fails => "fails",
        Verdict::NotJudged => "not-judged",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Flights that were not flown must not read as a success of any kind.
    #[test]
    fn a_claim_without_its_runs_is_not_judged() {
        let claim = Claim::of(
            &claim::Claim {
                id: "L2b",
                sentence: "the same over the envelope",
                criterion: "exactly one mode".to_owned(),
                measured: "none".to_owned(),
                verdict: claim::Verdict::NotJudged,
                remark: None,
            },
            None,
        );
        assert_eq!(claim.verdict, Verdict::NotJudged);
        let text = claims_text(&[claim]);
        assert!(
            text.contains("· not judged") && text.contains("0 of 1 claims hold, 1 not judged."),
            "{text}"
        );
    }

    #[test]
    fn a_failed_claim_is_said_in_words_and_counted() {
        let claims = [Verdict::Holds, Verdict::Fails].map(|verdict| Claim {
            id: "P1".to_owned(),
            sentence: "quite <satisfactory>".to_owned(),
            criterion: "≤ 25 %".to_owned(),
            measured: "31 %".to_owned(),
            verdict,
            note: "at 47 s".to_owned(),
            evidence: None,
        });
        let html = claims_table(&claims).into_string();
        assert!(html.contains("1 of 2 claims hold, 1 not."));
        assert!(html.contains("✗\u{202f}does not hold") && html.contains("&lt;satisfactory&gt;"));
        let text = claims_text(&claims);
        assert!(text.contains("✗ does not hold") && text.contains("at 47 s"), "{text}");
    }
}
