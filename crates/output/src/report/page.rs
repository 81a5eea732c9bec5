//! Page of a report as plain data, rendered as one HTML file or as Markdown for GitHub.
//!
//! minijinja escapes all texts in the HTML. Only figures that [`Page::check`] has checked, and series from
//! [`super::sequences::json`], pass unescaped. The content security policy of the page lets it load only
//! files beside it and run only its own script.

use super::claims::Finding;
use super::sequences::Tallies;
use crate::results::ResultsError;
use crate::table::layout::TableLayout;
use crate::table::render::{self as tables, markdown_escape};
use base64::prelude::{BASE64_STANDARD, Engine};
use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{Environment, UndefinedBehavior, context};
use serde::Serialize;
use sha2::{Digest, Sha256};
use trackfail_dataset::DatasetError;
use trackfail_dataset::text::visible;
use trackfail_engine::store::StoreError;
use trackfail_methods::score::tracker_metric::TRACKER_METRICS;

/// Data of a report, in the order of the page.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Page {
    /// Title of the page.
    pub title: String,
    /// Relative URL of the page over all experiments; empty without one.
    pub home: String,
    /// Name of the experiment.
    pub experiment: String,
    /// The paper that is replicated; may be empty.
    pub paper: String,
    /// The table or figure of the paper: `Table 1`; may be empty.
    pub object: String,
    /// Data that were present: `12 of 21 targets present; missing: ...`; may be empty.
    pub data_note: String,
    /// Answer of the page in one or two sentences, below the title.
    pub verdict: Vec<String>,
    /// Stretches of frames behind the answer, as a small table: headings, then rows; may be empty.
    pub stretches: Vec<Vec<String>>,
    /// Warnings at the head of the page.
    pub warnings: Vec<String>,
    /// Paragraphs on how to read the numbers, after the main table.
    pub summary: Vec<String>,
    /// Claims of the paper, with their outcomes here.
    pub claims: Vec<Finding>,
    /// Tables, the main one first.
    pub tables: Vec<TableLayout>,
    /// True if numbers in the tables link to the sequences behind them, provided that these are shown.
    pub links: bool,
    /// Figures, the one at the head first.
    pub figures: Vec<FigureView>,
    /// True if the page loads figures from their files instead of embedding them.
    pub figures_beside: bool,
    /// Counts of all methods on all tracks.
    pub sequences: Tallies,
    /// Series for strips and viewer, as JSON that is safe in a script element; empty without tracks.
    pub series: String,
    /// True if the page needs files beside it: series, stills or figures.
    pub beside: bool,
    /// True if the folder `tables` beside the page has the files of its tables.
    pub downloads: bool,
    /// Cells without a result (sequence, tracker, run and method), each with the reason.
    pub failed: Vec<(String, String)>,
    /// Origin of the numbers: names and values.
    pub provenance: Vec<(String, String)>,
    /// Number of origins that are always shown. The page folds the others.
    pub provenance_head: usize,
}

/// A figure as the page shows it.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct FigureView {
    /// Number of the figure: `Figure 3`.
    pub name: String,
    /// Text below the figure.
    pub caption: String,
    /// SVG element made by [`crate::figure`], embedded in the page.
    pub svg: String,
    /// SVG element for narrow screens; empty if there is none.
    pub narrow: String,
    /// File beside the report: `figures/fig3.svg`.
    pub file: String,
    /// Endings of the figure's files: `svg`, `pdf`, `png`, and `column.svg` and `column.pdf` if it is wider
    /// than a column.
    pub endings: Vec<&'static str>,
    /// True if the figure is wider than a column.
    pub is_wide: bool,
}

/// Reason why a report, its parts, or the page over all reports cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A figure cannot be drawn, or parts of the page contradict each other or are not safe to embed.
    #[error("{0}")]
    Unfit(String),
    /// There are no data for a figure, for the reason given.
    #[error("{0}")]
    NoData(String),
    /// The template does not fit the data.
    #[error("the page could not be rendered: {0}")]
    Template(#[from] minijinja::Error),
    /// The results cannot be read.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// A frame cannot be decoded.
    #[error(transparent)]
    Frame(#[from] DatasetError),
    /// A picture cannot be encoded.
    #[error("a thumbnail cannot be encoded: {0}")]
    Picture(#[from] image::ImageError),
    /// A file cannot be written.
    #[error(transparent)]
    Store(#[from] StoreError),
}

impl Page {
    /// Checks that all parts of the page are consistent and safe to embed.
    ///
    /// # Errors
    /// When a row has more or fewer cells than its table has columns, the series could close their script
    /// element, or the SVG of a figure has scripts, foreign content, ids or links.
    pub fn check(&self) -> Result<(), ReportError> {
        for table in &self.tables {
            let expected = table.columns.len();
            if let Some(row) = table.groups.iter().flat_map(|g| &g.rows).find(|r| r.cells.len() != expected) {
                let (name, row, got) = (&table.name, &row.label.name, row.cells.len());
                let message = format!("row `{row}` of table `{name}` has {got} cells for {expected} columns");
                return Err(ReportError::Unfit(message));
            }
        }
        if self.series.contains(['<', '>', '&', '\u{2028}', '\u{2029}']) {
            return Err(ReportError::Unfit("the series of the sequences are not packed for a page".into()));
        }
        let is_bad =
            |f: &&FigureView| !(is_picture(&f.svg) && (f.narrow.is_empty() || is_picture(&f.narrow)));
        self.figures.iter().find(is_bad).map_or(Ok(()), |figure| {
            Err(ReportError::Unfit(format!("figure `{}` is not an SVG made by this program", figure.name)))
        })
    }
}

/// True if a text is one SVG element as [`crate::figure`] makes them, and is safe to embed.
fn is_picture(svg: &str) -> bool {
    let svg = svg.trim();
    // Figures escape quotes and angle brackets in texts, so these words can only be markup.
    let foreign = ["<script", "<foreignObject", "<style", "<!", "<?", "<a ", " id=\"", "href=\"http"];
    let is_handler =
        |word: &str| word.len() > 2 && word.as_bytes()[..2].eq_ignore_ascii_case(b"on") && word.contains('=');
    let tags = svg.split('<').filter_map(|tag| tag.split('>').next());
    let has_handler = tags.flat_map(str::split_whitespace).any(is_handler);
    let is_foreign = has_handler || foreign.iter().any(|word| svg.contains(word));
    svg.starts_with("<svg ") && svg.ends_with("</svg>") && !is_foreign
}

/// Renders `index.html`.
///
/// # Errors
/// See [`ReportError`].
pub fn render(page: &Page) -> Result<String, ReportError> {
    page.check()?;
    let script = concat!(include_str!("templates/page.js"), include_str!("templates/viewer.js"));
    fill(include_str!("templates/page.html"), include_str!("templates/page.css"), script, page)
}

/// Renders `report.md`. Figures are linked by their files.
///
/// # Errors
/// The errors of [`render()`].
pub fn markdown(page: &Page) -> Result<String, ReportError> {
    page.check()?;
    let environment = environment("report.md", include_str!("templates/report.md"))?;
    let grids: Vec<String> = page.tables.iter().map(tables::markdown).collect();
    let about = context! { grids => Serde(&grids), ..Serde(page) };
    let text = environment.get_template("report.md")?.render(about)?;
    let lines: Vec<&str> = text.trim_end().lines().map(str::trim_end).collect();
    Ok(lines.join("\n") + "\n")
}

/// Fills the template of an HTML file. Its content security policy allows only the given script.
///
/// # Errors
/// When the template does not fit the data, which would be a bug.
pub(super) fn fill(
    template: &'static str,
    style: &'static str,
    script: &'static str,
    about: &impl Serialize,
) -> Result<String, ReportError> {
    // minijinja escapes because the name ends in .html.
    let mut environment = environment("page.html", template)?;
    environment.add_global("script", script);
    environment
        .add_global("script_digest", format!("sha256-{}", BASE64_STANDARD.encode(Sha256::digest(script))));
    environment.add_global("style", style);
    Ok(environment.get_template("page.html")?.render(Serde(about))?)
}

/// Template environment with a single template.
pub(super) fn environment(
    name: &'static str,
    template: &'static str,
) -> Result<Environment<'static>, ReportError> {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.set_syntax(SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build()?);
    type Filter = fn(&str) -> String;
    let filters: [(&'static str, Filter); 6] = [
        ("visible", visible),
        ("in_words", in_words),
        ("address", address),
        ("text", markdown_escape),
        ("begin", begin),
        ("target", target),
    ];
    for (filter, change) in filters {
        environment.add_filter(filter, move |text: String| change(&text));
    }
    environment.add_template(name, template)?;
    Ok(environment)
}

/// Name of a table or figure as a heading. A metric of trackers at its end is spelled out:
/// `uncertainty-success_auc` becomes `uncertainty, success AUC`.
fn in_words(name: &str) -> String {
    let metric = |(what, metric): (&str, &str)| {
        let known = TRACKER_METRICS.iter().find(|m| m.name == metric)?;
        Some(format!("{what}, {}", known.heading))
    };
    name.split_once('-').and_then(metric).unwrap_or_else(|| name.to_string())
}

/// Path below the page's folder as a URL, with special characters percent-encoded.
fn address(path: &str) -> String {
    let plain = |b: u8| b.is_ascii_alphanumeric() || b"-_./".contains(&b);
    path.bytes().map(|b| if plain(b) { char::from(b).to_string() } else { format!("%{b:02X}") }).collect()
}

/// Escapes the start of a Markdown paragraph if it would be read as a list, a rule or an underlined heading.
fn begin(escaped: &str) -> String {
    let rest = escaped.trim_start_matches(|c: char| c.is_ascii_digit());
    let digits = &escaped[..escaped.len() - rest.len()];
    match (rest.starts_with(['-', '+', '=']), rest.starts_with(['.', ')'])) {
        (true, _) if digits.is_empty() => format!("\\{rest}"),
        (_, true) if !digits.is_empty() => format!("{digits}\\{rest}"),
        _ => escaped.to_owned(),
    }
}

/// Target of a Markdown link, in angle brackets.
fn target(path: &str) -> String {
    let encoded = |c: char| match c {
        '<' | '>' | '\\' | '|' => format!("%{:02X}", u32::from(c)),
        c if c.is_control() => "%20".to_owned(),
        c => c.to_string(),
    };
    path.chars().map(encoded).collect()
}
