//! The documentation of the columns, from their declarations.

use super::column::{Column, TableFile};
use super::{
    checks, conditions, detections, frame_measures, frame_pairs, frames, measures, pieces, readings, scores,
    signals, tables, truth,
};

/// Every file with columns, in the order of the documentation.
const FILES: [&TableFile; 14] = [
    &scores::FILE,
    &measures::FILE,
    &frame_measures::FILE,
    &frame_pairs::FILE,
    &frames::FILE,
    &signals::FILE,
    &truth::FILE,
    &conditions::FILE,
    &checks::FILE,
    &pieces::FILE,
    &readings::FILE,
    &tables::FILE,
    &detections::FILE,
    &detections::FILE_OF_TARGETS,
];

const HEAD: &str = "\
# Columns of the result files

A run writes these files into `results/<experiment>/`. Floats are written so that reading them gives the same bits;
a missing value is an empty field in CSV and null in Parquet, never 0. Places are in pixels: the upper left corner of
the upper left pixel is 0,0, x grows to the right and y downwards.

This page is made from the declarations in `crates/output/src/results/` by a test, which says how to write it anew.
";

/// The page with a table of columns for every file, as Markdown.
pub fn columns_markdown() -> String {
    let mut text = HEAD.to_string();
    for file in FILES {
        text.push_str(&format!("\n## {}\n\n{}\n\n", heading(file.name), file.about));
        text.push_str("| column | type | unit | meaning |\n|---|---|---|---|\n");
        for Column { name, kind, unit, meaning, empty, .. } in file.columns {
            let empty = if empty.is_empty() { String::new() } else { format!("; empty where {empty}") };
            text.push_str(&format!("| `{name}` | {} | {unit} | {meaning}{empty} |\n", kind.words()));
        }
    }
    text
}

/// File names as code; words around them as they are.
fn heading(name: &str) -> String {
    if name.contains('`') {
        return name.to_string();
    }
    name.split(", ").map(|file| format!("`{file}`")).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn the_page_of_columns_is_that_of_the_declarations() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/columns.md");
        if std::env::var_os("UPDATE").is_some() {
            std::fs::write(&path, columns_markdown()).unwrap();
        }
        let page = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            page == columns_markdown(),
            "docs/columns.md is stale: UPDATE=1 cargo test -p trackfail-output columns"
        );
    }

    #[test]
    fn every_column_is_explained_and_there_once() {
        for file in FILES {
            let names: std::collections::BTreeSet<&str> = file.columns.iter().map(|c| c.name).collect();
            assert_eq!(names.len(), file.columns.len(), "{}", file.name);
            assert!(
                file.columns.iter().all(|c| !c.meaning.is_empty() && !c.meaning.contains('|')),
                "{}",
                file.name
            );
        }
    }
}
