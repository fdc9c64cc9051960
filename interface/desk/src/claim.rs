//! A sentence of the paper with its criterion, what was measured, the verdict, and where a
//! report shows it.

use std::borrow::Cow;

/// Whether a claim came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The criterion is met wherever it asks.
    Holds,
    /// Its core is met, and the remark says where it is not, and why.
    InPart,
    Fails,
    /// The runs that would decide it are not there.
    NotJudged,
}

impl Verdict {
    /// Holds or fails.
    pub fn of(holds: bool) -> Verdict {
        if holds { Verdict::Holds } else { Verdict::Fails }
    }

    /// What holds at its core does so only in part where it does not `everywhere`.
    pub fn in_part_unless(self, everywhere: bool) -> Verdict {
        match self {
            Verdict::Holds if !everywhere => Verdict::InPart,
            verdict => verdict,
        }
    }

    /// The lesser of two that are asked together; what is not judged stays so unless the other
    /// fails.
    pub fn and(self, other: Verdict) -> Verdict {
        use Verdict::{Fails, Holds, InPart, NotJudged};
        match (self, other) {
            (Fails, _) | (_, Fails) => Fails,
            (NotJudged, _) | (_, NotJudged) => NotJudged,
            (InPart, _) | (_, InPart) => InPart,
            (Holds, Holds) => Holds,
        }
    }
}

/// The figure or table of a report that shows a claim: the judge names it and the report
/// draws it under that name, so that neither can misspell it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Evidence(&'static str);

impl Evidence {
    /// Shown under `anchor`.
    pub const fn at(anchor: &'static str) -> Evidence {
        Evidence(anchor)
    }

    pub const fn anchor(self) -> &'static str {
        self.0
    }
}

/// One claim, judged.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Claim {
    /// Short name, such as `P1`.
    pub id: Cow<'static, str>,
    /// What the paper says: the whole sentence, of which the criterion takes its part.
    pub sentence: Cow<'static, str>,
    /// What was asked of the runs.
    pub criterion: String,
    /// What would show the sentence to be false.
    pub falsified_by: Cow<'static, str>,
    /// What was found: the worst value and where.
    pub measured: String,
    pub verdict: Verdict,
    /// Where it holds only in part, or what else was noticed.
    pub remark: Option<String>,
    /// What shows it.
    #[serde(skip)]
    pub evidence: Evidence,
}

impl Claim {
    /// A statement about a run itself, true or false, under a name that links can point to.
    pub fn check(id: &'static str, statement: impl Into<String>, holds: bool) -> Claim {
        Claim {
            id: id.into(),
            sentence: statement.into().into(),
            criterion: String::new(),
            falsified_by: "".into(),
            measured: String::new(),
            verdict: Verdict::of(holds),
            remark: None,
            evidence: Evidence::at(id),
        }
    }

    pub fn holds(&self) -> bool {
        self.verdict == Verdict::Holds
    }
}
