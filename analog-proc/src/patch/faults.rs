//! Collecting faults, so that one run shows all of them, and showing them.

use super::diagnostic::{Flaw, PatchFault, Source};
use crate::net::Span;
use desk::faults::{FileFault, MOST_FAULTS};
use interface::control::PatchBundle;
use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme, NamedSource, SourceSpan};
use std::collections::HashSet;
use std::fmt;
use std::sync::Arc;

/// The files of a patch, for messages. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Sources {
    files: Arc<[Source]>,
}

impl Sources {
    /// The files of a bundle, in its order. A bundle without files gets one
    /// empty file, so that span 0 always has a text.
    pub fn new(bundle: &PatchBundle) -> Self {
        let mut files: Vec<Source> = bundle
            .files
            .iter()
            .map(|(name, text)| Arc::new(NamedSource::new(name, printable(text))))
            .collect();
        if files.is_empty() {
            files.push(Arc::new(NamedSource::new(&bundle.root, String::new())));
        }
        Sources { files: files.into() }
    }

    /// Name of a file.
    pub fn name(&self, file: u32) -> &str {
        self.source(file).name()
    }

    fn source(&self, file: u32) -> &Source {
        // `new` makes at least one file, and every span is made from a bundle index.
        self.files.get(file as usize).unwrap_or(&self.files[0])
    }

    /// Text of a span.
    pub fn text(&self, span: Span) -> &str {
        let text = self.source(span.file).inner();
        text.get(span.start as usize..span.end as usize).unwrap_or("")
    }

    /// Source and byte range, cut to the text, as diagnostics want them.
    pub fn place(&self, span: Span) -> (Source, SourceSpan) {
        let source = self.source(span.file).clone();
        let length = source.inner().len();
        let start = (span.start as usize).min(length);
        let end = (span.end as usize).clamp(start, length);
        (source, (start..end).into())
    }

    /// Line and column (in characters) of the start of a span, both from 1.
    pub fn line_column(&self, span: Span) -> (usize, usize) {
        place_of(self.source(span.file), span.start as usize)
    }
}

/// A text that may go to a terminal: control characters are `?`, of the same length.
pub(crate) fn printable(text: &str) -> String {
    let is_safe = |c: char| !c.is_control() || matches!(c, '\n' | '\r' | '\t');
    text.chars()
        .flat_map(|c| {
            let times = if is_safe(c) { 1 } else { c.len_utf8() };
            std::iter::repeat_n(if is_safe(c) { c } else { '?' }, times)
        })
        .collect()
}

fn place_of(source: &Source, offset: usize) -> (usize, usize) {
    desk::faults::Source { file: source.name(), text: source.inner() }.line_and_column(offset)
}

/// Faults while they are being collected.
#[derive(Debug)]
pub(crate) struct Faults {
    pub(crate) sources: Sources,
    root: String,
    list: Vec<PatchFault>,
    seen: HashSet<(&'static str, String, usize, String)>,
    omitted: usize,
}

impl Faults {
    pub(crate) fn new(sources: Sources, root: &str) -> Self {
        Faults {
            sources,
            root: root.to_owned(),
            list: Vec::new(),
            seen: HashSet::new(),
            omitted: 0,
        }
    }

    /// Adds a fault at a place.
    pub(crate) fn push(&mut self, at: Span, flaw: impl Into<Flaw>, help: impl Into<String>) {
        self.push_beside(at, flaw, help, &[]);
    }

    /// The same with further places, of which those in the same file are shown. A sub-patch that is
    /// used many times shows each of its faults once.
    pub(crate) fn push_beside(
        &mut self,
        span: Span,
        flaw: impl Into<Flaw>,
        help: impl Into<String>,
        beside: &[Span],
    ) {
        if self.is_full() {
            self.omitted += 1;
            return;
        }
        let (src, at) = self.sources.place(span);
        let (flaw, help, name) = (flaw.into(), help.into(), src.name().to_owned());
        let others = beside.iter().filter(|other| other.file == span.file && **other != span);
        let beside = others.map(|other| self.sources.place(*other).1).collect();
        let fault = PatchFault { src, at, flaw, help, beside };
        let key = (fault.code_name(), name, at.offset(), fault.to_string());
        if self.seen.insert(key) {
            self.list.push(fault);
        }
    }

    /// Counts a fault that is not told.
    pub(crate) fn omit(&mut self) {
        self.omitted += 1;
    }

    /// Whether further faults are only counted; the search for near names then stops too.
    pub(crate) fn is_full(&self) -> bool {
        self.list.len() >= MOST_FAULTS
    }

    pub(crate) fn root(&self) -> &str {
        &self.root
    }

    /// How many there are so far, those beyond the limit included.
    pub(crate) fn count(&self) -> usize {
        self.list.len() + self.omitted
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Everything found, in order of file and place. Only where something was.
    pub(crate) fn into_faults(mut self) -> PatchFaults {
        let files: Vec<String> = self.sources.files.iter().map(|s| s.name().to_owned()).collect();
        let file_index = |fault: &PatchFault| {
            let name = fault.src.name();
            files.iter().position(|f| f == name).unwrap_or(files.len())
        };
        self.list.sort_by_cached_key(|fault| (file_index(fault), fault.at.offset()));
        PatchFaults { root: self.root, faults: self.list, omitted: self.omitted }
    }

    pub(crate) fn into_result(self) -> Result<(), PatchFaults> {
        if self.is_empty() { Ok(()) } else { Err(self.into_faults()) }
    }
}

/// All faults of a patch (at least one).
#[derive(Clone, Debug)]
pub struct PatchFaults {
    root: String,
    faults: Vec<PatchFault>,
    omitted: usize,
}

impl PatchFaults {
    /// A single fault, where nothing else can be looked at.
    pub(crate) fn single(root: &str, fault: PatchFault) -> Self {
        PatchFaults { root: root.to_owned(), faults: vec![fault], omitted: 0 }
    }

    /// The faults, in order of file and place.
    pub fn faults(&self) -> &[PatchFault] {
        &self.faults
    }

    /// The faults without their texts.
    pub fn to_list(&self) -> Vec<FileFault> {
        let flat = |fault: &PatchFault| FileFault {
            code: Some(fault.code_name()),
            file: fault.src.name().to_owned(),
            place: Some(place_of(&fault.src, fault.at.offset())),
            fault: fault.to_string(),
            remedy: fault.help.clone(),
        };
        self.faults.iter().map(flat).collect()
    }

    /// All faults with source excerpts, without colour.
    pub fn render(&self) -> String {
        self.render_with(GraphicalTheme::unicode_nocolor())
    }

    /// All faults with source excerpts, in terminal colours.
    pub fn render_coloured(&self) -> String {
        self.render_with(GraphicalTheme::unicode())
    }

    fn render_with(&self, theme: GraphicalTheme) -> String {
        let handler = GraphicalReportHandler::new_themed(theme).with_width(100);
        let mut out = String::new();
        for fault in &self.faults {
            if handler.render_report(&mut out, fault).is_err() {
                out.push_str(&format!("{fault}\n  help: {}\n", fault.help));
            }
            out.push('\n');
        }
        out.push_str(&format!("{self}\n"));
        out
    }
}

impl fmt::Display for PatchFaults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let total = self.faults.len() + self.omitted;
        let noun = if total == 1 { "fault" } else { "faults" };
        write!(f, "{total} {noun} in patch `{}`", self.root)?;
        if self.omitted > 0 {
            write!(f, " (the first {} are shown)", self.faults.len())?;
        }
        Ok(())
    }
}

impl std::error::Error for PatchFaults {}

impl Diagnostic for PatchFaults {
    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        Some(Box::new(self.faults.iter().map(|fault| fault as &dyn Diagnostic)))
    }
}
