//! The page as Markdown for GitHub.

use super::html::environment;
use super::page::{Page, ReportError};
use crate::table::render::{self, markdown_escape};
use minijinja::context;
use minijinja::value::Serde;

/// Renders `report.md`; figures are referred to by their files.
///
/// # Errors
/// As [`super::render`].
pub fn markdown(page: &Page) -> Result<String, ReportError> {
    page.check()?;
    let mut environment = environment("report.md", include_str!("templates/report.md"))?;
    environment.add_filter("text", |raw: String| markdown_escape(&raw));
    environment.add_filter("begin", |paragraph: String| begin(&paragraph));
    environment.add_filter("target", |path: String| target(&path));
    let grids: Vec<String> = page.tables.iter().map(render::markdown).collect();
    let about = context! { grids => Serde(&grids), ..Serde(page) };
    let text = environment.get_template("report.md")?.render(about)?;
    let lines: Vec<&str> = text.trim_end().lines().map(str::trim_end).collect();
    Ok(lines.join("\n") + "\n")
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

/// A link target in angle brackets.
fn target(path: &str) -> String {
    let encoded = |c: char| match c {
        '<' | '>' | '\\' | '|' => format!("%{:02X}", u32::from(c)),
        c if c.is_control() => "%20".to_owned(),
        c => c.to_string(),
    };
    path.chars().map(encoded).collect()
}
