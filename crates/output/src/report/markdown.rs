//! The page as Markdown for GitHub.

use super::claims::ClaimView;
use super::page::{Page, ReportError};
use crate::table::render::{self, markdown_escape as text};
use std::fmt::Write;

/// Renders `report.md`; figures are referred to by their files.
///
/// # Errors
/// As [`super::render`].
pub fn markdown(page: &Page) -> Result<String, ReportError> {
    page.check()?;
    let mut out = String::new();
    // Writing to a string cannot fail.
    let mut line = |text: &str| {
        let _ = writeln!(out, "{}\n", text.trim_end());
    };
    line(&format!("# {}", text(&page.title)));
    let about = [("Experiment", &page.experiment), ("Paper", &page.paper), ("Object", &page.object)];
    for (name, value) in about.into_iter().chain([("Data", &page.data_note)]).filter(|a| !a.1.is_empty()) {
        line(&format!("**{name}:** {}", text(value)));
    }
    for sentence in &page.verdict {
        line(&format!("**{}**", text(sentence)));
    }
    for warning in &page.warnings {
        line(&format!("> **Warning:** {}", text(warning)));
    }
    for paragraph in &page.summary {
        line(&begin(&text(paragraph)));
    }
    if !page.tables.is_empty() {
        line("## Tables");
    }
    for t in &page.tables {
        line(&format!("### {}", text(&t.name)));
        line(&render::markdown(t));
    }
    if !page.claims.is_empty() {
        line("## Claims");
        let row = |c: &ClaimView| {
            let details: Vec<String> =
                std::iter::once(&c.predicate).chain(&c.details).map(|d| text(d)).collect();
            vec![text(&c.text), format!("**{}**", text(&c.headline())), details.join("<br>")]
        };
        let rows: Vec<Vec<String>> = page.claims.iter().map(row).collect();
        line(&grid(&["claim".into(), "verdict".into(), "numbers".into()], &rows));
    }
    if !page.figures.is_empty() {
        line("## Figures");
    }
    for figure in &page.figures {
        line(&format!("![{}](<{}>)", text(&figure.name), target(&figure.file)));
        line(&format!("**{}.** {}", text(&figure.name), text(&figure.caption)));
    }
    if !page.failed.is_empty() {
        line("## Without a result");
        let rows: Vec<Vec<String>> =
            page.failed.iter().map(|f| vec![text(&f.cell), text(&f.reason)]).collect();
        line(&grid(&["cell".into(), "reason".into()], &rows));
    }
    if !page.provenance.is_empty() {
        line("## Where the numbers come from");
        let rows: Vec<Vec<String>> = page.provenance.iter().map(|(k, v)| vec![text(k), text(v)]).collect();
        line(&grid(&["what".into(), "value".into()], &rows));
    }
    out.truncate(out.trim_end().len());
    out.push('\n');
    Ok(out)
}

/// The paragraph with its first characters escaped where they would make it a list, a rule or an underlined heading.
fn begin(escaped: &str) -> String {
    let digits = escaped.len() - escaped.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    match escaped.get(digits..).and_then(|rest| rest.chars().next()) {
        Some('-' | '+' | '=') if digits == 0 => format!("\\{escaped}"),
        Some('.' | ')') if digits > 0 => format!("{}\\{}", &escaped[..digits], &escaped[digits..]),
        _ => escaped.to_owned(),
    }
}

fn grid(head: &[String], rows: &[Vec<String>]) -> String {
    let row = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let mut out = row(head);
    let rules = vec!["---".to_string(); head.len()];
    out.push_str(&row(&rules));
    for cells in rows {
        out.push_str(&row(cells));
    }
    out
}

/// A link target in angle brackets.
fn target(path: &str) -> String {
    path.chars()
        .map(|c| match c {
            '<' => "%3C".to_owned(),
            '>' => "%3E".to_owned(),
            '\\' => "%5C".to_owned(),
            '|' => "%7C".to_owned(),
            c if c.is_control() => "%20".to_owned(),
            c => c.to_string(),
        })
        .collect()
}
