//! The page of a report as plain data, before it becomes HTML or Markdown.

use super::claims::Finding;
use super::sequences::Tallies;
use crate::table::layout::TableLayout;
use serde::Serialize;

/// The data of a report, in the order of the page.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Page {
    /// Title of the page.
    pub title: String,
    /// Relative URL of the page over all experiments; empty where there is none.
    pub home: String,
    /// Name of the experiment.
    pub experiment: String,
    /// The paper that is replicated; may be empty.
    pub paper: String,
    /// The table or figure of the paper: `Table 1`; may be empty.
    pub object: String,
    /// The data that were present: `12 of 21 targets present; missing: ...`; may be empty.
    pub data_note: String,
    /// The answer of the page, in a sentence or two below the title.
    pub verdict: Vec<String>,
    /// What the answer rests on, as a small table: headings, then rows; may be empty.
    pub stretches: Vec<Vec<String>>,
    /// Warnings, at the head of the page.
    pub warnings: Vec<String>,
    /// Notes on how to read the numbers, in paragraphs behind the main table.
    pub summary: Vec<String>,
    /// The conclusions of the paper, and whether they hold here.
    pub claims: Vec<Finding>,
    /// Tables, the main one first.
    pub tables: Vec<TableLayout>,
    /// Whether their numbers lead to the sequences that they come from, where these are shown.
    pub links: bool,
    /// Figures, the one that stands at the head first.
    pub figures: Vec<FigureView>,
    /// Whether the page shows figures from their files instead of embedding them.
    pub figures_beside: bool,
    /// Counts of every method on every track.
    pub sequences: Tallies,
    /// The series of strips and viewer, as JSON that is safe in a script element; empty without tracks.
    pub series: String,
    /// Whether the page needs files beside it: series, stills, figures.
    pub beside: bool,
    /// Whether the files of its tables are in the folder `tables` beside it.
    pub downloads: bool,
    /// Cells without a result.
    pub failed: Vec<FailedCell>,
    /// Where the numbers come from: names and values.
    pub provenance: Vec<(String, String)>,
    /// Number of these that the page always shows; it folds the others.
    pub provenance_head: usize,
}

/// A figure.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct FigureView {
    /// Name: `Figure 3`.
    pub name: String,
    /// Caption.
    pub caption: String,
    /// The picture as made by [`crate::figure`]; it becomes part of the page.
    pub svg: String,
    /// The same picture for narrow screens, where the page has one; else empty.
    pub narrow: String,
    /// Its file beside the report: `figures/fig3.svg`.
    pub file: String,
    /// Endings of its files: `svg`, `png`, and `column.svg` of the one that is as wide as a column.
    pub endings: Vec<&'static str>,
}

/// A cell without a result.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct FailedCell {
    /// Sequence, tracker, run and method.
    pub cell: String,
    /// Why it has none.
    pub reason: String,
}

/// A report that cannot be rendered.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A row has more or fewer cells than its table has columns.
    #[error("row `{row}` of table `{table}` has {got} cells for {expected} columns")]
    Row {
        /// Name of the table.
        table: String,
        /// Label of the row.
        row: String,
        /// Number of its cells.
        got: usize,
        /// Number of columns.
        expected: usize,
    },
    /// The SVG of a figure has scripts, foreign content, ids or links, which a page must not have.
    #[error("figure `{0}` is not an SVG made by this program")]
    NotAFigure(String),
    /// The series have characters that could end their element in the page.
    #[error("the series of the sequences are not packed for a page")]
    NotPacked,
    /// The template does not fit the data.
    #[error("the page could not be rendered: {0}")]
    Template(#[from] minijinja::Error),
}

impl Page {
    /// Checks that all parts fit together and are safe to embed.
    ///
    /// # Errors
    /// See [`ReportError`].
    pub fn check(&self) -> Result<(), ReportError> {
        for table in &self.tables {
            let expected = table.columns.len();
            let rows = table.groups.iter().flat_map(|g| &g.rows);
            if let Some(row) = rows.into_iter().find(|r| r.cells.len() != expected) {
                let (table, row, got) = (table.name.clone(), row.label.name.clone(), row.cells.len());
                return Err(ReportError::Row { table, row, got, expected });
            }
        }
        if self.series.contains(['<', '>', '&', '\u{2028}', '\u{2029}']) {
            return Err(ReportError::NotPacked);
        }
        for figure in &self.figures {
            if !is_picture(&figure.svg) || !(figure.narrow.is_empty() || is_picture(&figure.narrow)) {
                return Err(ReportError::NotAFigure(figure.name.clone()));
            }
        }
        Ok(())
    }
}

/// Whether a text is one SVG element as [`crate::figure`] makes them, safe to embed.
fn is_picture(svg: &str) -> bool {
    let svg = svg.trim();
    // Figures escape quotes and angle brackets in texts, so these words can only be markup.
    let foreign = ["<script", "<foreignObject", "<style", "<!", "<?", "<a ", " id=\"", "href=\"http"];
    let markup = has_handler(svg) || foreign.iter().any(|word| svg.contains(word));
    svg.starts_with("<svg ") && svg.ends_with("</svg>") && !markup
}

/// Whether a tag has an event handler: `onload=`.
fn has_handler(svg: &str) -> bool {
    svg.split('<').filter_map(|tag| tag.split('>').next()).any(|tag| {
        tag.split_whitespace().any(|word| {
            word.len() > 2
                && word.get(..2).is_some_and(|w| w.eq_ignore_ascii_case("on"))
                && word.contains('=')
        })
    })
}
