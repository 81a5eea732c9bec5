//! Documentation of the columns, generated from their declarations.

use super::detections;
use super::files::{Judgement, TableRow, of_folder};
use super::rows::{Column, File, Rows};

/// All files with columns, in the order of the documentation.
fn files() -> impl Iterator<Item = File> {
    of_folder().into_iter().chain([TableRow::file(), detections::file(), Judgement::file()])
}

const HEAD: &str = "\
# Columns of the result files

A run writes these files into `results/<experiment>/`. Floats are written so that reading them gives the same bits;
a missing value is an empty field in CSV and null in Parquet, never 0. Places are in pixels: the upper left corner of
the upper left pixel is 0,0, x grows to the right and y downwards.

This page is made from the declarations in `crates/output/src/results/` by a test, which says how to write it anew.
";

/// Markdown page with a table of columns for each file.
pub fn columns_markdown() -> String {
    let mut text = HEAD.to_string();
    for file in files() {
        text.push_str(&format!("\n## {}\n\n{}\n\n", heading(file.name), file.about));
        text.push_str("| column | type | unit | meaning |\n|---|---|---|---|\n");
        for Column { name, kind, unit, meaning, empty, .. } in file.columns {
            let empty = if empty.is_empty() { String::new() } else { format!("; empty where {empty}") };
            text.push_str(&format!("| `{name}` | {} | {unit} | {meaning}{empty} |\n", kind.types().0));
        }
    }
    text
}

/// Heading in which file names are marked as code.
fn heading(name: &str) -> String {
    if name.contains('`') {
        return name.to_string();
    }
    name.split(", ").map(|file| format!("`{file}`")).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::super::files::*;
    use super::*;
    use std::path::Path;

    #[test]
    fn the_page_of_columns_is_that_of_the_declarations() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/columns.md");
        if std::env::var_os("UPDATE").is_some() {
            std::fs::write(&path, columns_markdown()).unwrap();
        }
        let page = std::fs::read_to_string(&path).unwrap_or_default();
        let remedy = "docs/columns.md is stale: UPDATE=1 cargo test -p trackfail-output columns";
        assert!(page == columns_markdown(), "{remedy}");
    }

    #[test]
    fn rows_have_the_declared_types() {
        fn check<'a, R: Rows<'a>>() {
            let frame = R::frame("", []).unwrap();
            let found = frame.columns().iter().map(|c| (c.name().as_str(), c.dtype().clone()));
            let declared = R::columns().into_iter().map(|c| (c.name, c.kind.types().1));
            assert!(found.eq(declared), "{}", R::NAME);
        }
        check::<Score<'_>>();
        check::<MeasureRow<'_>>();
        check::<Measured<'_>>();
        check::<Pair>();
        check::<Frame<'_>>();
        check::<Signal<'_>>();
        check::<Target<'_>>();
        check::<ConditionRow<'_>>();
        check::<CheckRow<'_>>();
        check::<Piece<'_>>();
        check::<Row>();
        check::<TableRow<'_>>();
        check::<Judgement<'_>>();
    }

    #[test]
    fn every_column_is_explained_and_there_once() {
        for file in files() {
            let names: std::collections::BTreeSet<&str> = file.columns.iter().map(|c| c.name).collect();
            assert_eq!(names.len(), file.columns.len(), "{}", file.name);
            let is_explained = |c: &Column| !c.meaning.is_empty() && !c.meaning.contains('|');
            assert!(file.columns.iter().all(is_explained), "{}", file.name);
        }
    }
}
