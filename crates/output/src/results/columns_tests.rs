//! The columns of all files, beside their types in frames and the page that explains them.

use super::files::*;
use super::rows::{Column, Kind, Rows};
use polars::prelude::DataFrame;
use std::collections::BTreeSet;
use std::path::Path;
use trackfail_methods::score::frames::list::FRAME_METRICS;

/// Name, columns and empty frame of each file, in the order of the page.
fn files() -> Vec<(&'static str, Vec<Column>, DataFrame)> {
    fn of<'a, R: Rows<'a>>() -> (&'static str, Vec<Column>, DataFrame) {
        (R::NAME, R::columns(), R::frame("", []).unwrap())
    }
    vec![
        of::<Score<'_>>(),
        of::<MeasureRow<'_>>(),
        of::<Measured<'_>>(),
        of::<Pair>(),
        of::<Frame<'_>>(),
        of::<Signal<'_>>(),
        of::<Target<'_>>(),
        of::<ConditionRow<'_>>(),
        of::<CheckRow<'_>>(),
        of::<Piece>(),
        of::<Row>(),
        of::<TableRow<'_>>(),
        of::<Judgement<'_>>(),
    ]
}

#[test]
fn rows_have_the_declared_types() {
    for (name, columns, frame) in files() {
        let found = frame.columns().iter().map(|c| (c.name().as_str(), c.dtype().clone()));
        assert!(found.eq(columns.iter().map(|c| (c.name, c.kind.in_polars()))), "{name}");
        let names: BTreeSet<&str> = columns.iter().map(|c| c.name).collect();
        assert_eq!(names.len(), columns.len(), "{name}");
    }
}

#[test]
fn the_page_explains_every_column() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/columns.md");
    let page = std::fs::read_to_string(page).unwrap();
    let mut files = files();
    // For a file of one target, detections have no column of its number.
    let (_, mut judged, frame) = files[12].clone();
    judged.pop();
    files.insert(12, ("stdout of `trackfail detect`", judged, frame));
    let sections: Vec<(&str, &str)> =
        page.split("\n## ").skip(1).map(|section| section.split_once("\n\n").unwrap()).collect();
    let headings: Vec<String> = sections.iter().map(|(heading, _)| heading.replace('`', "")).collect();
    assert_eq!(headings, files.iter().map(|(name, ..)| name.replace('`', "")).collect::<Vec<_>>());
    for ((heading, text), (_, columns, _)) in sections.into_iter().zip(files) {
        let rows = text.lines().filter_map(|line| line.strip_prefix("| `")?.strip_suffix(" |"));
        let rows: Vec<[&str; 4]> =
            rows.map(|row| row.split(" | ").collect::<Vec<_>>().try_into().unwrap()).collect();
        let declared = columns.iter().map(|column| {
            let kind = match column.kind {
                Kind::Text => "text",
                Kind::Integer => "integer, 64 bits",
                Kind::Small => "integer, 32 bits",
                Kind::Real => "float, 64 bits",
            };
            (format!("{}`", column.name), kind)
        });
        let explained: Vec<_> = rows.iter().map(|[name, kind, ..]| (name.to_string(), *kind)).collect();
        assert_eq!(explained, declared.collect::<Vec<_>>(), "{heading}");
        for ([name, .., meaning], column) in rows.iter().zip(&columns) {
            assert!(meaning.len() > 3 && !meaning.contains('|'), "{heading}: {name}");
            assert!(!column.is_optional || meaning.contains("; empty where "), "{heading}: {name}");
        }
    }
    for measure in FRAME_METRICS {
        let (name, unit) = (measure.metric.name(), measure.metric.unit);
        let row = format!("\n| `{name}` | float, 64 bits | {unit} | {}", measure.meaning);
        assert!(page.contains(&row), "{row}");
    }
}
