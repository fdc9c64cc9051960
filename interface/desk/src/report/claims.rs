//! The claims table: a sentence, its criterion and what would falsify it, what was measured, and
//! whether it holds.

use super::Numbering;
use crate::claim::{Claim, Verdict};
use maud::{Markup, html};

impl Verdict {
    /// Mark, words, and class in the style sheet.
    fn told(self) -> (char, &'static str, &'static str) {
        match self {
            Verdict::Holds => ('✓', "holds", "holds"),
            Verdict::InPart => ('◐', "holds in part", "in-part"),
            Verdict::Fails => ('✗', "does not hold", "fails"),
            Verdict::NotJudged => ('·', "not judged", "not-judged"),
        }
    }
}

/// The table for a page, under a line that counts the verdicts. `drawn` has numbered what
/// the page shows; a claim leads to its evidence where that was drawn.
pub fn claims_table(claims: &[Claim], drawn: &Numbering) -> Markup {
    // Checks say all in their sentences.
    let checks = claims.iter().all(|c| c.criterion.is_empty() && c.measured.is_empty());
    let heads = if checks {
        &["", "Check", "Verdict"][..]
    } else {
        &["", "Sentence", "Criterion", "Falsified by", "Measured", "Verdict"]
    };
    html! {
        p { (count(claims)) }
        div.wide { table.claims {
            thead { tr { @for head in heads { th scope="col" { (head) } } } }
            tbody { @for claim in claims {
                tr id={ "claim-" (claim.id) } {
                    td { (claim.id) }
                    @if !checks {
                        td { blockquote { (claim.sentence) } }
                        td { (claim.criterion) }
                        td { (claim.falsified_by) }
                    }
                    td {
                        @if checks { (claim.sentence) } @else { (claim.measured) }
                        @if drawn.has(claim.evidence.anchor()) { " " a href={ "#" (claim.evidence.anchor()) } { "shown here" } }
                        @if let Some(remark) = &claim.remark { small { (remark) } }
                    }
                    @let (mark, words, class) = claim.verdict.told();
                    td.v.{ (class) } { (mark) "\u{202f}" (words) }
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
    let (ids, words) = (width(|c| &*c.id), width(|c| c.verdict.told().1));
    let mut out = String::new();
    for claim in claims {
        let (mark, verdict, _) = claim.verdict.told();
        // A check says all in its sentence.
        let said = match claim.criterion.as_str() {
            "" => claim.sentence.to_string(),
            criterion => format!("{}  (criterion: {criterion})", claim.measured),
        };
        out.push_str(&format!("{mark} {verdict:words$}  {:ids$}  {said}\n", claim.id));
        if !claim.falsified_by.is_empty() {
            let by = &claim.falsified_by;
            out.push_str(&format!("  {:words$}  {:ids$}  falsified by: {by}\n", "", ""));
        }
        if let (false, Some(remark)) = (claim.holds(), &claim.remark) {
            out.push_str(&format!("  {:words$}  {:ids$}  {remark}\n", "", ""));
        }
    }
    out.push_str(&count(claims));
    out.push('\n');
    out
}

fn count(claims: &[Claim]) -> String {
    let of = |verdict| claims.iter().filter(|c| c.verdict == verdict).count();
    let mut parts = vec![format!("{} of {} claims hold", of(Verdict::Holds), claims.len())];
    if of(Verdict::InPart) > 0 {
        parts.push(format!("{} in part", of(Verdict::InPart)));
    }
    if of(Verdict::Fails) > 0 {
        parts.push(format!("{} not", of(Verdict::Fails)));
    }
    if of(Verdict::NotJudged) > 0 {
        parts.push(format!("{} not judged", of(Verdict::NotJudged)));
    }
    format!("{}.", parts.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::claim::Evidence;

    fn claim(verdict: Verdict) -> Claim {
        Claim {
            id: "P1".into(),
            evidence: Evidence::at("figure-4"),
            sentence: "quite <satisfactory>".into(),
            criterion: "≤ 25 %".to_owned(),
            falsified_by: "a point above 25 %".into(),
            measured: "31 %".to_owned(),
            verdict,
            remark: Some("at 47 s".to_owned()),
        }
    }

    /// Flights that were not flown must not read as a success of any kind.
    #[test]
    fn a_claim_without_its_runs_is_not_judged() {
        let text = claims_text(&[claim(Verdict::NotJudged)]);
        assert!(
            text.contains("· not judged") && text.contains("0 of 1 claims hold, 1 not judged."),
            "{text}"
        );
    }

    #[test]
    fn every_verdict_is_said_in_words_and_counted() {
        let claims = [Verdict::Holds, Verdict::InPart, Verdict::Fails].map(claim);
        let html = claims_table(&claims, &Numbering::new()).into_string();
        assert!(html.contains("1 of 3 claims hold, 1 in part, 1 not."));
        for said in ["✗\u{202f}does not hold", "◐\u{202f}holds in part", "&lt;satisfactory&gt;"]
        {
            assert!(html.contains(said) && html.contains("a point above 25 %"), "{said}");
        }
        let text = claims_text(&claims);
        assert!(text.contains("✗ does not hold") && text.contains("◐ holds in part"), "{text}");
        assert!(text.matches("at 47 s").count() == 2, "{text}");
        assert!(text.matches("falsified by: a point above 25 %").count() == 3, "{text}");
    }

    #[test]
    fn a_claim_leads_to_its_evidence_where_that_was_drawn() {
        let mut numbering = Numbering::new();
        let links = |drawn: &Numbering| {
            let table = claims_table(&[claim(Verdict::Holds)], drawn).into_string();
            table.matches("href=\"#figure-4\"").count()
        };
        assert_eq!(links(&numbering), 0);
        let _ = numbering.figure(Evidence::at("figure-4").anchor(), "", html! {});
        assert_eq!(links(&numbering), 1);
    }
}
