//! The table `breakdown`: what each method is worth on each family of trackers and each source of videos.
//!
//! The numbers are those of the pools of `frame_measures.csv`, see [`crate::results::frame_measures`].

use super::layouts::{self, cell, group, of_suite};
use crate::results::Results;
use crate::results::frame_measures::EVERY_TRACKER;
use crate::table::layout::{Cell, TableLayout, is_anchor};
use crate::table::number::Style;
use trackfail_methods::score::FrameMeasures;

/// Column, and the measure in it.
const COLUMNS: [(&str, &str); 10] = [
    ("losses", "losses"),
    ("AUROC", "auroc"),
    ("AUROC from", "auroc_low"),
    ("AUROC to", "auroc_high"),
    ("found at 5", "found_at_5"),
    ("found from", "found_at_5_low"),
    ("found to", "found_at_5_high"),
    ("found at 2", "found_at_2"),
    ("within 15", "auroc_within_15"),
    ("ECE", "ece"),
];

/// The table; `None` for results whose tracks are of one family and one source.
pub fn table(results: &Results) -> Option<TableLayout> {
    let rows_of = |method: &str| -> Vec<(String, Vec<Cell>)> {
        let mine = results.frame_measures.iter().filter(|([tracker, name, _], measures)| {
            let has_loss = measures.get("losses").is_some_and(|losses| losses > 0.0);
            name == method && tracker.split(' ').next() == Some(EVERY_TRACKER) && has_loss
        });
        mine.map(|([tracker, ..], measures)| (pool(tracker).to_string(), cells(measures))).collect()
    };
    let methods = results.experiment.methods.iter();
    let shown = methods.filter(|m| m.variants.len() == 1 && !is_anchor(&results.experiment, &m.name));
    let groups: Vec<_> = shown
        .map(|m| (m.name.as_str(), rows_of(&m.name)))
        .filter(|(_, rows)| rows.len() > 1)
        .map(|(name, rows)| group(name, name.to_string(), rows))
        .collect();
    let caption = "Measures by family of trackers and source of videos, with 95 % intervals; found at 5, at 2: losses found at \
                   so many false alarms per 1000 good frames; within 15: AUROC of a loss within the next 15 frames.";
    let columns = COLUMNS.map(|(name, _)| name);
    let is_empty = groups.is_empty();
    let table = layouts::table("breakdown", caption.to_string(), "tracks", &columns, groups);
    (!is_empty).then(|| of_suite(table, results, &layouts::suite(results)))
}

/// A pool in words.
fn pool(tracker: &str) -> &str {
    match tracker.strip_prefix(EVERY_TRACKER).map(str::trim_start) {
        None | Some("") => "all",
        Some(pool) => pool,
    }
}

fn cells(measures: &FrameMeasures) -> Vec<Cell> {
    let style = |name: &str| if name == "losses" { Style::COUNT } else { Style::DEFAULT };
    COLUMNS.map(|(_, name)| cell(measures.get(name), |v| style(name).format(v))).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::frame_measures::FILE;

    #[test]
    fn columns_are_measures_and_pools_are_words() {
        for (_, name) in COLUMNS {
            assert!(FILE.columns.iter().any(|column| column.name == name), "{name}");
        }
        assert_eq!(["*", "* on otb", "* deep on otb"].map(pool), ["all", "on otb", "deep on otb"]);
    }
}
