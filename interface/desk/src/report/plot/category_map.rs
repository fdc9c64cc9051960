//! A matrix of few kinds of outcome, each cell a letter and a tint.
//!
//! A table, not a picture, as the heat map is: it can be read aloud, copied and printed. The letter
//! says what the tint says, so that no colour need be told from another.

use maud::{Markup, html};

/// Labels of columns that there is room for.
const MOST_LABELS: usize = 12;

/// The matrix.
#[derive(Clone, Debug, PartialEq)]
pub struct CategoryMap {
    /// Heading of the corner (`Failure at, s`).
    pub corner: String,
    pub rows: Vec<String>,
    /// Labels of the columns; of many some are shown.
    pub columns: Vec<String>,
    /// What a cell may be, by names whose first letters differ; the first is the good one.
    pub categories: Vec<String>,
    /// Number of the category of each cell, by row; what is missing is blank.
    pub cells: Vec<Vec<usize>>,
}

/// The matrix as a table, with what its letters mean.
pub fn category_map(map: &CategoryMap) -> Markup {
    let letter = |category: usize| {
        let name = map.categories.get(category);
        name.and_then(|n| n.chars().next()).map(|c| c.to_ascii_uppercase()).unwrap_or(' ')
    };
    let every = map.columns.len().div_ceil(MOST_LABELS).max(1);
    // The next round number of columns: labels of 0, 5, 10 are read more easily than of 0, 4, 8.
    let every = [1, 2, 5, 10, 20, 50, 100].into_iter().find(|n| *n >= every).unwrap_or(every);
    html! {
        div.wide {
            table.kinds {
                thead { tr {
                    th scope="col" { (map.corner) }
                    @for group in map.columns.chunks(every) {
                        th scope="colgroup" colspan=(group.len()) { (group[0]) }
                    }
                } }
                tbody {
                    @for (row, cells) in map.rows.iter().zip(&map.cells) {
                        tr {
                            th scope="row" { (row) }
                            @for cell in cells { td class=(format!("k{cell}")) { (letter(*cell)) } }
                        }
                    }
                }
            }
        }
        p.scale {
            @for (i, name) in map.categories.iter().enumerate() {
                span class=(format!("nobreak kind k{i}")) { (letter(i)) } " " (name) "  "
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_bears_its_letter_and_columns_share_labels() {
        let html = category_map(&CategoryMap {
            corner: "at, s".to_owned(),
            rows: vec!["roll-lost".to_owned()],
            columns: (0..30).map(|t| t.to_string()).collect(),
            categories: vec!["salvageable".to_owned(), "load".to_owned()],
            cells: vec![(0..30).map(|t| usize::from(t > 20)).collect()],
        })
        .into_string();
        assert_eq!(html.matches(">S</td>").count(), 21, "{html}");
        assert_eq!(html.matches(">L</td>").count(), 9);
        assert_eq!(html.matches("colspan=\"5\"").count(), 6);
        assert!(html.contains(">25</th>"));
        assert!(html.contains("<span class=\"nobreak kind k1\">L</span> load"), "{html}");
    }
}
