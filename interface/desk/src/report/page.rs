//! The page: one self-contained file with contents, numbered figures and tables.

use maud::{DOCTYPE, Markup, PreEscaped, html};

/// The style sheet: light, dark and paper, in one page. Figures carry classes only; their colours are
/// defined here once for each surroundings. The eight line colours stay apart for the common colour
/// deficiencies and each has its own dash, so that a black-and-white print tells them apart as well.
const STYLE: &str = include_str!("page.css");
/// What makes the charts answer the pointer; without it the page shows all the same.
const SCRIPT: &str = include_str!("chart.js");

/// One part of a page.
#[derive(Clone, Debug)]
pub struct Section {
    /// Anchor, unique within the page.
    pub id: String,
    pub title: String,
    pub body: Markup,
}

impl Section {
    /// A section; its anchor is made from its title.
    pub fn new(title: impl Into<String>, body: Markup) -> Section {
        let title = title.into();
        Section { id: anchor(&title), title, body }
    }
}

/// Numbers figures and tables in the order in which they are made.
#[derive(Clone, Debug, Default)]
pub struct Numbering {
    figures: u32,
    tables: u32,
    ids: Vec<String>,
}

impl Numbering {
    pub fn new() -> Numbering {
        Numbering::default()
    }

    /// `drawing` with the next figure number and a caption; `id` is what links point to.
    pub fn figure(&mut self, id: &str, caption: &str, drawing: Markup) -> Markup {
        self.figures += 1;
        self.ids.push(id.to_owned());
        html! {
            figure id=(id) {
                div.drawing { (drawing) }
                figcaption { b { "Figure " (self.figures) "." } " " (caption) }
            }
        }
    }

    /// `table` (any markup) with the next table number and a caption above it.
    pub fn table(&mut self, id: &str, caption: &str, table: Markup) -> Markup {
        self.tables += 1;
        self.ids.push(id.to_owned());
        html! {
            figure id=(id) {
                figcaption { b { "Table " (self.tables) "." } " " (caption) }
                (table)
            }
        }
    }

    /// Whether a figure or table was made under `id`.
    pub fn has(&self, id: &str) -> bool {
        self.ids.iter().any(|made| made == id)
    }
}

/// Figures side by side where the page is wide enough.
pub fn side_by_side(figures: &[Markup]) -> Markup {
    html! { div.pair { @for figure in figures { (figure) } } }
}

/// The whole page as text. `lead` says in a sentence or two what the reader sees; the
/// contents appear from four sections on.
pub fn page(title: &str, lead: &str, sections: &[Section]) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    h1 { (title) }
                    @if !lead.is_empty() { p.lead { (lead) } }
                }
                @if sections.len() >= 4 {
                    nav aria-label="Contents" {
                        strong { "Contents" }
                        ol { @for s in sections { li { a href={ "#" (s.id) } { (s.title) } } } }
                    }
                }
                main {
                    @for s in sections {
                        section id=(s.id) { h2 { (s.title) } (s.body) }
                    }
                }
                footer { "Generated from the run’s own data; the page refers to nothing outside itself." }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
    .into_string()
}

/// A heading or a name as an anchor: lower case, hyphens, ASCII.
pub fn anchor(text: &str) -> String {
    let mut anchor = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_ascii_alphanumeric() {
            anchor.push(c.to_ascii_lowercase());
        } else if !anchor.is_empty() && !anchor.ends_with('-') {
            anchor.push('-');
        }
    }
    let anchor = anchor.trim_end_matches('-');
    if anchor.is_empty() { "section".to_owned() } else { anchor.to_owned() }
}
