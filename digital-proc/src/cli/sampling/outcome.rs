//! What an experiment came to, and how it leaves the program: terminal, CSV, report, JSON.

use super::super::MachineArgs;
use desk::failure::Failure;
use desk::say;
use desk::{
    report::{
        Cell, Numbering, Section, Table, page,
        plot::{HeatMap, LineChart, heat_map, line_chart},
        provenance,
    },
    run_dir::{PatchIdentity, RunDirectory, RunRecord, Seed, UtcSecond},
};
use maud::html;
use std::{collections::BTreeMap, path::Path};

/// A table with its name (of the CSV file) and caption.
pub struct Titled {
    pub name: &'static str,
    pub caption: String,
    pub table: Table,
}

/// What a figure draws.
pub enum Drawing {
    /// Curves.
    Chart(Box<LineChart>),
    /// A matrix.
    Matrix(HeatMap),
}

/// A figure with its anchor and caption.
pub struct Figure {
    pub id: &'static str,
    pub caption: String,
    pub drawing: Drawing,
}

/// A statement that the run makes true or false.
pub struct Check {
    pub statement: String,
    pub holds: bool,
}

/// What an experiment came to.
pub struct Outcome {
    /// Name of the command, `circle`.
    pub name: &'static str,
    pub title: String,
    /// What the reader sees, in a sentence or two.
    pub lead: String,
    /// Patch, as named.
    pub patch: String,
    pub tables: Vec<Titled>,
    pub figures: Vec<Figure>,
    pub checks: Vec<Check>,
    /// What the tables' own remarks mean.
    pub remarks: Vec<String>,
    /// What was measured but not judged.
    pub not_judged: Vec<String>,
    /// Converters and coefficients that reached the end of their range, by name.
    pub saturated: Vec<String>,
    /// Settings, for the record.
    pub parameters: toml::Table,
    pub seeds: BTreeMap<String, Seed>,
}

impl Outcome {
    pub fn new(
        name: &'static str,
        patch: impl Into<String>,
        title: impl Into<String>,
        lead: impl Into<String>,
    ) -> Outcome {
        Outcome {
            name,
            title: title.into(),
            lead: lead.into(),
            patch: patch.into(),
            tables: Vec::new(),
            figures: Vec::new(),
            checks: Vec::new(),
            remarks: Vec::new(),
            not_judged: Vec::new(),
            saturated: Vec::new(),
            parameters: toml::Table::new(),
            seeds: BTreeMap::new(),
        }
    }

    pub fn table(&mut self, name: &'static str, caption: impl Into<String>, table: Table) {
        let caption = caption.into();
        self.tables.push(Titled { name, caption, table });
    }

    pub fn chart(&mut self, id: &'static str, caption: impl Into<String>, chart: LineChart) {
        self.figures.push(Figure {
            id,
            caption: caption.into(),
            drawing: Drawing::Chart(Box::new(chart)),
        });
    }

    pub fn matrix(&mut self, id: &'static str, caption: impl Into<String>, map: HeatMap) {
        self.figures.push(Figure { id, caption: caption.into(), drawing: Drawing::Matrix(map) });
    }

    pub fn check(&mut self, holds: bool, statement: impl Into<String>) {
        let statement = statement.into();
        self.checks.push(Check { statement, holds });
    }

    pub fn set(&mut self, name: &str, value: impl Into<toml::Value>) {
        self.parameters.insert(name.to_owned(), value.into());
    }

    /// Prints, and leaves run directory, CSV files and report.
    pub fn publish(
        self,
        machine: &MachineArgs,
        out: &Path,
        started: UtcSecond,
        profile: &str,
        patch_hash: String,
    ) -> Result<(), Failure> {
        let command = format!("sampling-{}", self.name);
        let directory = RunDirectory::create(out, &command, started)?;
        let link = machine.join.link_name();
        let record = RunRecord {
            patch: Some(PatchIdentity { name: self.patch.clone(), sha256: patch_hash }),
            seeds: self.seeds.clone(),
            parameters: self.parameters.clone(),
            ..RunRecord::begin(format!("sampling {}", self.name), started, profile, link)
        };
        directory.write_record(&record)?;
        for titled in &self.tables {
            let csv = csv(&titled.table).map_err(Failure::input)?;
            directory.write_file(&format!("{}.csv", titled.name), &csv)?;
        }
        let json = self.json();
        directory.write_summary(&json)?;
        let report = directory.write_report(&self.html(&record))?;
        if machine.json {
            say!("{json:#}");
        } else {
            say!("{}", self.title);
            for titled in &self.tables {
                say!("\n{}\n{}", titled.caption, titled.table.text().trim_end());
            }
            if !self.checks.is_empty() {
                say!();
            }
            for check in &self.checks {
                let verdict = if check.holds { "holds" } else { "FAILS" };
                say!("{verdict}: {}", check.statement);
            }
            for remark in self.all_remarks() {
                say!("{remark}");
            }
            say!("report: {}", report.display());
        }
        let failed: Vec<&str> =
            self.checks.iter().filter(|c| !c.holds).map(|c| c.statement.as_str()).collect();
        if failed.is_empty() {
            return Ok(());
        }
        Err(Failure::failed("does not hold", &failed))
    }

    /// Checks are against theory of ideal converters: on another machine what fails is not judged.
    pub fn note_real_machine(&mut self, profile: &str) {
        let (held, others): (Vec<Check>, Vec<Check>) =
            std::mem::take(&mut self.checks).into_iter().partition(|c| c.holds);
        self.checks = held;
        self.not_judged = others
            .into_iter()
            .map(|c| {
                format!("not judged on {profile}, whose converters are not ideal: {}", c.statement)
            })
            .collect();
    }

    fn all_remarks(&self) -> Vec<String> {
        let saturated = (!self.saturated.is_empty())
            .then(|| format!("saturated: {}", self.saturated.join(", ")));
        let own = self.remarks.iter().chain(&self.not_judged).cloned();
        own.chain(saturated).collect()
    }

    fn json(&self) -> serde_json::Value {
        let tables: serde_json::Map<String, serde_json::Value> =
            self.tables.iter().map(|t| (t.name.to_owned(), t.table.json())).collect();
        let checks: Vec<serde_json::Value> = self
            .checks
            .iter()
            .map(|c| serde_json::json!({ "statement": c.statement, "holds": c.holds }))
            .collect();
        serde_json::json!({ "title": self.title, "tables": tables, "checks": checks, "remarks": self.remarks, "not_judged": self.not_judged, "saturated": self.saturated })
    }

    fn html(&self, record: &RunRecord) -> String {
        let mut numbering = Numbering::new();
        let figures = html! {
            @for figure in &self.figures {
                (numbering.figure(figure.id, &figure.caption, match &figure.drawing {
                    Drawing::Chart(chart) => line_chart(chart),
                    Drawing::Matrix(map) => heat_map(map),
                }))
            }
        };
        let tables = html! {
            @for titled in &self.tables {
                (numbering.table(titled.name, &titled.caption, titled.table.markup()))
            }
        };
        let checks = html! {
            ul { @for check in &self.checks {
                li { (if check.holds { "✓ " } else { "✗ " }) (check.statement) }
            } }
        };
        let mut sections = vec![Section::new("Figures", figures)];
        if !self.checks.is_empty() {
            sections.push(Section::new("Checks", checks));
        }
        let remarks = self.all_remarks();
        if !remarks.is_empty() {
            let list = html! { ul { @for remark in &remarks { li { (remark) } } } };
            sections.push(Section::new("Remarks", list));
        }
        sections.push(Section::new("Numbers", tables));
        sections.push(Section::new("Provenance", provenance(record)));
        page(&self.title, &self.lead, &sections)
    }
}

/// A table with every digit of its numbers; the unit stands in brackets in the heading.
fn csv(table: &Table) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(table.headings.iter().map(|h| {
        if h.unit.is_empty() { h.label.clone() } else { format!("{} [{}]", h.label, h.unit) }
    }))?;
    for row in &table.rows {
        let cell = |i: usize| match row.get(i) {
            Some(Cell::Number(value)) => value.to_string(),
            Some(Cell::Text(text) | Cell::Link(text, _)) => text.clone(),
            Some(Cell::Missing) | None => String::new(),
        };
        writer.write_record((0..table.headings.len()).map(cell))?;
    }
    writer.into_inner().map_err(|e| csv::Error::from(e.into_error()))
}
