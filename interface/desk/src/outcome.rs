//! What a command came to, and how it leaves the program: terminal, page, JSON, CSV.
//!
//! Every command fills an [`Outcome`] and nothing else; [`Outcome::publish`] and, where there is no
//! run to keep, [`Outcome::tell`] alone know how it is shown. With `--json` every command writes one
//! object to standard output, whatever becomes of it (`tests/outcome.schema.json`):
//!
//! ```text
//! command   as in the list of runs, `sampling circle`
//! run       the run's directory, or null
//! title     in words
//! results   named numbers, snake_case with the unit: {"max_q_pa": 94871.2}
//! tables    by name, each a list of rows keyed like `results`
//! claims    id, sentence, criterion, falsified_by, measured, verdict, remark
//! remarks   what a reader of the numbers must know
//! error     null, or exit_code, text and the faults of a user's file: code, file, line, column,
//!           fault, remedy
//! ```
//!
//! A command that fails before it has an outcome ([`crate::shell`]) has all but `command`, `run`
//! and `error` empty.

pub use crate::run::Run;
use crate::{
    claim::{Claim, Verdict},
    failure::Failure,
    note,
    report::{
        Numbering, Section, Summary, Table, claims_table, claims_text, page,
        plot::{LineChart, line_chart},
        provenance, side_by_side,
    },
    run_dir::{Curves, RunRecord, Seed},
    say,
};
use maud::{Markup, html};
use serde_json::{Map, Value, json};
use std::{collections::BTreeMap, path::Path};

/// A table of more rows is folded on a page.
const MOST_ROWS: usize = 60;
/// Rows that a page has of one table; its CSV file has all.
const MOST_ON_PAGE: usize = 1_000;

/// What a command came to.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Heading of the page and first line on the terminal.
    pub title: String,
    /// What the reader sees, in a sentence or two.
    pub lead: String,
    /// Named numbers.
    pub results: Summary,
    /// Statements, judged.
    pub claims: Vec<Claim>,
    /// What a reader of the numbers must know.
    pub remarks: Vec<String>,
    /// What was set, for the run's record.
    pub parameters: toml::Table,
    /// Seeds of random sources, for the same.
    pub seeds: BTreeMap<String, Seed>,
    /// What beside a claim that fails makes the command end with exit code 1.
    pub refused: Vec<String>,
    /// Curves by the name of their trace.
    pub traces: Vec<(&'static str, Curves)>,
    /// The page's sections in order.
    sections: Vec<(String, Vec<Part>)>,
}

/// A part of a section.
#[derive(Clone, Debug)]
enum Part {
    /// A table with its name in JSON and for links, and its caption.
    Table {
        name: String,
        caption: String,
        table: Table,
        on_terminal: bool,
    },
    Figure(Figure),
    /// Figures side by side where the page is wide enough.
    Beside(Vec<Figure>),
    /// A paragraph.
    Words {
        text: String,
        on_terminal: bool,
    },
    /// Anything else that only a page can show.
    Markup(Markup),
}

/// A drawing with its anchor and caption.
#[derive(Clone, Debug)]
pub struct Figure {
    /// What links point to.
    pub id: String,
    pub caption: String,
    pub drawing: Markup,
}

impl Figure {
    /// A drawing under `id`.
    pub fn new(id: impl Into<String>, caption: impl Into<String>, drawing: Markup) -> Figure {
        Figure { id: id.into(), caption: caption.into(), drawing }
    }

    fn markup(&self, numbering: &mut Numbering) -> Markup {
        numbering.figure(&self.id, &self.caption, self.drawing.clone())
    }
}

impl Outcome {
    pub fn new(title: impl Into<String>, lead: impl Into<String>) -> Outcome {
        Outcome { title: title.into(), lead: lead.into(), ..Outcome::default() }
    }

    /// Notes a parameter of the run.
    pub fn set(&mut self, name: &str, value: impl Into<toml::Value>) {
        self.parameters.insert(name.to_owned(), value.into());
    }

    /// A statement about the run itself, true or false.
    pub fn check(&mut self, id: &'static str, statement: impl Into<String>, holds: bool) {
        self.claims.push(Claim::check(id, statement, holds));
    }

    /// The section of that title, begun if need be: what follows is put there.
    pub fn section(&mut self, title: &str) -> SectionOf<'_> {
        let at = self.sections.iter().position(|(t, _)| t == title).unwrap_or_else(|| {
            self.sections.push((title.to_owned(), Vec::new()));
            self.sections.len() - 1
        });
        SectionOf(&mut self.sections[at].1)
    }

    /// Leaves all tables and words to the page: where the claims are what a terminal has room for.
    pub fn claims_on_terminal(&mut self) {
        for (_, parts) in &mut self.sections {
            for part in parts {
                if let Part::Table { on_terminal, .. } | Part::Words { on_terminal, .. } = part {
                    *on_terminal = false;
                }
            }
        }
    }

    /// The tables by name.
    pub fn tables(&self) -> impl Iterator<Item = (&str, &Table)> {
        self.parts().filter_map(|part| match part {
            Part::Table { name, table, .. } => Some((name.as_str(), table)),
            _ => None,
        })
    }

    fn parts(&self) -> impl Iterator<Item = &Part> {
        self.sections.iter().flat_map(|(_, parts)| parts)
    }

    /// For machines; `error` says why the command ends with another exit code than 0.
    pub fn json(&self, command: &str, run: Option<&Path>, error: Option<&Failure>) -> Value {
        let tables: Map<String, Value> =
            self.tables().map(|(name, table)| (name.to_owned(), table.json())).collect();
        json!({
            "command": command,
            "run": run,
            "title": self.title,
            "results": self.results.json(),
            "tables": tables,
            "claims": self.claims,
            "remarks": self.remarks,
            "error": error.map(Failure::json),
        })
    }

    /// On a terminal.
    pub fn text(&self) -> String {
        let mut out = String::new();
        if !self.title.is_empty() {
            out.push_str(&format!("{}\n", self.title));
        }
        out.push_str(&self.results.text());
        for part in self.parts() {
            match part {
                Part::Table { caption, table, on_terminal: true, .. } => {
                    out.push_str(&format!("\n{caption}\n{}", table.text()));
                }
                Part::Words { text, on_terminal: true } => out.push_str(&format!("\n{text}\n")),
                _ => {}
            }
        }
        if !self.claims.is_empty() {
            out.push_str(&format!("\n{}", claims_text(&self.claims)));
            // Of the others it stands beside the verdict.
            for claim in self.claims.iter().filter(|c| c.holds()) {
                if let Some(remark) = &claim.remark {
                    out.push_str(&format!("{}: {remark}\n", claim.id));
                }
            }
        }
        for remark in &self.remarks {
            out.push_str(&format!("{remark}\n"));
        }
        out
    }

    pub fn page(&self, record: &RunRecord) -> String {
        let mut numbering = Numbering::new();
        let mut sections = Vec::new();
        if !self.results.is_empty() {
            sections.push(Section::new("Results", self.results.table().markup()));
        }
        for (title, parts) in self.sections.iter().filter(|(_, parts)| !parts.is_empty()) {
            let body = html! { @for part in parts { (part.markup(&mut numbering)) } };
            sections.push(Section::new(title.as_str(), body));
        }
        if !self.claims.is_empty() {
            // Made last, since it links to what was drawn, and read first.
            let claims = claims_table(&self.claims, &numbering);
            sections.insert(0, Section::new("Claims", claims));
        }
        if !self.remarks.is_empty() {
            let list = html! { ul { @for remark in &self.remarks { li { (remark) } } } };
            sections.push(Section::new("Remarks", list));
        }
        sections.push(Section::new("Provenance", provenance(record)));
        page(&self.title, &self.lead, &sections)
    }

    /// What makes the command end with exit code 1: the claims that fail, and what is refused.
    pub fn verdict(&self) -> Option<Failure> {
        let failed: Vec<&str> =
            self.claims.iter().filter(|c| c.verdict == Verdict::Fails).map(|c| &*c.id).collect();
        let claims = (!failed.is_empty()).then(|| Failure::failed("does not hold", &failed));
        self.refused.iter().fold(claims, |all, refused| match all {
            Some(failure) => Some(failure.and(refused)),
            None => Some(Failure::failed(refused, &[])),
        })
    }

    /// Leaves record, traces, tables, summary and page in the run's directory and says where; `json`
    /// prints the summary instead.
    pub fn publish(&self, run: &Run, json: bool) -> Result<(), Failure> {
        let directory = &run.directory;
        let mut record = run.record.clone();
        record.parameters.extend(self.parameters.clone());
        record.seeds.extend(self.seeds.clone());
        directory.write_record(&record)?;
        for (name, curves) in &self.traces {
            curves.write(directory, name)?;
        }
        for (name, table) in self.tables() {
            directory.write_file(&format!("{name}.csv"), &table.csv().map_err(Failure::output)?)?;
        }
        let failed = self.verdict();
        let summary = self.json(&record.command, Some(directory.path()), failed.as_ref());
        directory.write_summary(&summary)?;
        let report = directory.write_report(&self.page(&record))?;
        match json {
            true => say!("{summary:#}"),
            false => say!("{}report: {}", self.text(), report.display()),
        }
        ended(failed, json)
    }

    /// Prints the outcome of a command that keeps no run of its own; `run` is the one it looked at.
    pub fn tell(&self, command: &str, run: Option<&Path>, json: bool) -> Result<(), Failure> {
        let failed = self.verdict();
        match json {
            true => say!("{:#}", self.json(command, run, failed.as_ref())),
            false => say!("{}", self.text().trim_matches('\n')),
        }
        ended(failed, json)
    }

    /// The same where standard output is taken by what the command makes: JSON goes to standard
    /// error, and words nowhere.
    pub fn tell_beside(&self, command: &str, json: bool) -> Result<(), Failure> {
        let failed = self.verdict();
        if json {
            note!("{:#}", self.json(command, None, failed.as_ref()));
        }
        ended(failed, true)
    }
}

fn ended(failed: Option<Failure>, is_told: bool) -> Result<(), Failure> {
    failed.map_or(Ok(()), |failure| Err(Failure { is_told, ..failure }))
}

impl Part {
    fn markup(&self, numbering: &mut Numbering) -> Markup {
        match self {
            Part::Table { name, caption, table, .. } if table.rows.len() > MOST_ROWS => {
                let (rows, shown) = (table.rows.len(), table.rows.len().min(MOST_ON_PAGE));
                let first =
                    Table { headings: table.headings.clone(), rows: table.rows[..shown].to_vec() };
                let folded = html! { details {
                    summary { @if shown < rows { "the first " (shown) " of " } (rows) " rows" }
                    (first.markup())
                } };
                numbering.table(name, caption, folded)
            }
            Part::Table { name, caption, table, .. } => {
                numbering.table(name, caption, table.markup())
            }
            Part::Figure(figure) => figure.markup(numbering),
            Part::Beside(figures) => {
                let all: Vec<Markup> = figures.iter().map(|f| f.markup(numbering)).collect();
                side_by_side(&all)
            }
            Part::Words { text, .. } if text.contains('\n') => html! { pre { (text) } },
            Part::Words { text, .. } => html! { p { (text) } },
            Part::Markup(markup) => markup.clone(),
        }
    }
}

/// A section being filled.
pub struct SectionOf<'a>(&'a mut Vec<Part>);

impl SectionOf<'_> {
    /// A table: on the page, on the terminal, in JSON and as `NAME.csv`.
    pub fn table(self, name: impl Into<String>, caption: impl Into<String>, table: Table) -> Self {
        let (name, caption) = (name.into(), caption.into());
        self.0.push(Part::Table { name, caption, table, on_terminal: true });
        self
    }

    /// The same, too long for a terminal.
    pub fn long_table(
        self,
        name: impl Into<String>,
        caption: impl Into<String>,
        table: Table,
    ) -> Self {
        let (name, caption) = (name.into(), caption.into());
        self.0.push(Part::Table { name, caption, table, on_terminal: false });
        self
    }

    pub fn figure(self, figure: Figure) -> Self {
        self.0.push(Part::Figure(figure));
        self
    }

    /// A figure of curves.
    pub fn chart(
        self,
        id: impl Into<String>,
        caption: impl Into<String>,
        chart: &LineChart,
    ) -> Self {
        self.figure(Figure::new(id, caption, line_chart(chart)))
    }

    pub fn beside(self, figures: Vec<Figure>) -> Self {
        self.0.push(Part::Beside(figures));
        self
    }

    /// A paragraph, on the terminal too; one of several lines keeps them.
    pub fn words(self, text: impl Into<String>) -> Self {
        self.0.push(Part::Words { text: text.into(), on_terminal: true });
        self
    }

    /// A paragraph of the page.
    pub fn aside(self, text: impl Into<String>) -> Self {
        self.0.push(Part::Words { text: text.into(), on_terminal: false });
        self
    }

    /// Anything else that only a page can show.
    pub fn markup(self, markup: Markup) -> Self {
        self.0.push(Part::Markup(markup));
        self
    }
}
