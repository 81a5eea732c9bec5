//! Names of the files of a report.

/// The page, whose presence says that a report folder is complete.
pub const INDEX: &str = "index.html";
/// The folders in a report folder that hold nothing but parts of the report.
pub const OWNED: [&str; 3] = ["figures", "data", "stills"];
/// The report as Markdown, beside its page.
pub const MARKDOWN: &str = "report.md";
/// The report in short, beside its page.
pub const SUMMARY: &str = "summary.json";
