//! Where the keys of a vehicle file stand, for faults found after reading.

use desk::faults::Source;
use toml::de::{DeTable, DeValue};

/// Finds where keys stand in a text.
pub(crate) struct Places<'t> {
    source: Source<'t>,
    document: Option<DeTable<'t>>,
}

impl<'t> Places<'t> {
    /// Of a text that has already been read once without error.
    pub(crate) fn of(source: Source<'t>) -> Self {
        Self { source, document: DeTable::parse(source.text).ok().map(toml::Spanned::into_inner) }
    }

    /// Place of `section.key`, or of its element `index`; of the section when
    /// the key is absent.
    pub(crate) fn find(
        &self,
        section: &str,
        key: &str,
        index: Option<usize>,
    ) -> Option<(usize, usize)> {
        let table = self.document.as_ref()?.get(section)?;
        let mut start = table.span().start;
        if let Some(value) = table.get_ref().as_table().and_then(|t| t.get(key)) {
            start = value.span().start;
            if let (Some(index), DeValue::Array(array)) = (index, value.get_ref())
                && let Some(element) = array.get(index)
            {
                start = element.span().start;
            }
        }
        Some(self.source.line_and_column(start))
    }
}
