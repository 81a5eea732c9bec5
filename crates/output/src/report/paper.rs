//! Selected tables and figures of reports for a paper: LaTeX and PDF files in one folder, with a document
//! that shows them.

use super::page::{FigureView, Page, ReportError};
use super::sentences::say;
use crate::table::latex::latex_escape;
use crate::table::layout::TableLayout;
use serde_json::json;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use trackfail_engine::store::{self, StoreError};

/// Name of the document.
pub const DOCUMENT: &str = "paper.tex";

/// A table or a figure of a report.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Item {
    /// Name in the experiment: `table1`.
    pub name: String,
    /// Text below a figure; `None` for a table, whose file has its own.
    pub caption: Option<String>,
    /// True if a figure is as wide as the text of a page.
    pub is_wide: bool,
}

/// Tables and figures of a page, in its order.
pub(super) fn items(page: &Page) -> Vec<Item> {
    let table = |t: &TableLayout| Item { name: t.name.clone(), caption: None, is_wide: false };
    let figure = |f: &FigureView| {
        let (name, caption) = (f.name.clone(), Some(f.caption.clone()));
        Item { name, caption, is_wide: f.is_wide }
    };
    page.tables.iter().map(table).chain(page.figures.iter().map(figure)).collect()
}

/// Name of an experiment, folder of its report, and the tables and figures in it.
pub type Rendered<'a> = (&'a str, PathBuf, Vec<Item>);

/// Copies the items with the names `only` (all if there are none) into a folder as `EXPERIMENT-NAME.tex` or
/// `.pdf`, with the numbers of their experiments as macros, and [`DOCUMENT`], which shows all items.
///
/// # Errors
/// When a file cannot be read or written.
pub fn write(reports: &[Rendered<'_>], only: &[String], folder: &Path) -> Result<(), ReportError> {
    let (mut macros, mut shown, mut names) = (Vec::new(), Vec::new(), BTreeSet::new());
    for (experiment, report, items) in reports {
        let is_wanted = |item: &&Item| only.is_empty() || only.contains(&item.name);
        let items: Vec<&Item> = items.iter().filter(is_wanted).collect();
        if items.is_empty() {
            continue;
        }
        let stem = experiment.replace('/', "-");
        let mut copy = |from: &str, name: String| -> Result<(), ReportError> {
            if names.contains(&name) {
                let message = "the name of several files; write these experiments into folders of their own";
                return Err(StoreError::new(&folder.join(name), message).into());
            }
            let path = report.join(from);
            let bytes = std::fs::read(&path).map_err(|e| StoreError::new(&path, e))?;
            store::write_derived(&folder.join(&name), &bytes)?;
            names.insert(name);
            Ok(())
        };
        // A report without tables has no numbers.
        if report.join("tables/macros.tex").is_file() {
            copy("tables/macros.tex", format!("{stem}-macros.tex"))?;
            macros.push(format!("{stem}-macros"));
        }
        for Item { name, caption, is_wide } in items {
            let label = format!("{stem}-{name}");
            let (place, ending) = if caption.is_none() { ("tables", "tex") } else { ("figures", "pdf") };
            copy(&format!("{place}/{name}.{ending}"), format!("{label}.{ending}"))?;
            let caption = caption.as_deref().map(latex_escape);
            shown.push(json!({ "label": label, "caption": caption, "is_wide": is_wide }));
        }
    }
    let document = say("paper", json!({ "macros": macros, "items": shown })) + "\n";
    Ok(store::write_derived(&folder.join(DOCUMENT), document.as_bytes())?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_testing::{assert_says, folder};

    #[test]
    fn a_table_and_a_figure_may_have_one_name_and_two_files_may_not() {
        let names = ["tables/macros.tex", "tables/changes.tex", "figures/changes.pdf", "figures/macros.pdf"];
        let report = folder(names.map(|name| (name, name)));
        let item = |(name, caption): (&str, Option<&str>)| {
            let (name, caption) = (name.to_string(), caption.map(str::to_string));
            Item { name, caption, is_wide: false }
        };
        let items = [("changes", None), ("changes", Some("Changes")), ("macros", Some("Macros"))].map(item);
        let of = |experiment: &'static str| (experiment, report.path().to_path_buf(), items.to_vec());
        let paper = tempfile::tempdir().unwrap();
        write(&[of("a/b")], &[], paper.path()).unwrap();
        for (file, from) in [("macros.tex", 0), ("changes.tex", 1), ("changes.pdf", 2), ("macros.pdf", 3)] {
            let copied = std::fs::read_to_string(paper.path().join(format!("a-b-{file}"))).unwrap();
            assert_eq!(copied, names[from]);
        }
        let error = write(&[of("a/b"), of("a-b")], &[], paper.path()).unwrap_err();
        assert_says(error, "a-b-macros.tex: the name of several files");
    }
}
