//! A sentence of the paper with its criterion, what was measured, and the verdict.

use std::fmt;

/// Whether a claim came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The criterion is met at every point it names.
    Holds,
    /// The criterion is missed.
    Fails,
    /// The runs that would decide it are not there.
    NotJudged,
}

/// One claim, judged.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Claim {
    /// Short name, such as `P1`.
    pub id: &'static str,
    /// What the paper says.
    pub sentence: &'static str,
    /// What was asked of the runs.
    pub criterion: String,
    /// What was found: the worst value and where.
    pub measured: String,
    /// The verdict.
    pub verdict: Verdict,
    /// Where it holds only in part, or what else was noticed.
    pub remark: Option<String>,
}

impl Claim {
    /// Whether it holds.
    pub fn holds(&self) -> bool {
        self.verdict == Verdict::Holds
    }
}

impl fmt::Display for Claim {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let verdict = match self.verdict {
            Verdict::Holds => "holds",
            Verdict::Fails => "FAILS",
            Verdict::NotJudged => "not judged",
        };
        write!(f, "{} {verdict}: {}; measured {}", self.id, self.criterion, self.measured)?;
        if let Some(remark) = &self.remark {
            write!(f, " ({remark})")?;
        }
        Ok(())
    }
}
