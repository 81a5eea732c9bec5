//! Standings frame by frame, all trackers together: the distance of each method to the best, and the value of
//! each on each family of trackers and each source of videos.
//!
//! The numbers are those of `frame_measures.csv` and `frame_pairs.csv`; see [`crate::results::frame_measures`] for the pools,
//! [`crate::results::frame_pairs`] for the statistics.

use super::{Estimate, Standing, Standings};
use crate::report::sentences::say;
use crate::results::Results;
use crate::results::frame_measures::EVERY_TRACKER;
use crate::results::frame_pairs::Pair;
use crate::table::build::{group, number, of_suite, suite, table};
use crate::table::layout::{Cell, Label, TableLayout, is_anchor};
use crate::table::number::Style;
use serde_json::json;
use trackfail_methods::score::FrameMeasures;

/// Area under the ROC curve of a score without information.
pub const CHANCE: f64 = 0.5;

/// Columns of the table `breakdown`, with the measure in each.
const MEASURES: [(&str, &str); 10] = [
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

/// Pair of a method and another one, in either order of the file.
pub fn pair_of(pairs: &[Pair], method: &str, other: &str) -> Option<Pair> {
    let found = pairs.iter().find(|p| p.method == method && p.other == other).cloned();
    found.or_else(|| pairs.iter().find(|p| p.method == other && p.other == method).map(Pair::turned))
}

/// Measures of a method on all trackers together.
pub fn of_every_tracker<'r>(results: &'r Results, method: &str) -> Option<&'r FrameMeasures> {
    let mut all = results.frame_measures.iter();
    let found = all.find(|([tracker, name, _], _)| tracker == EVERY_TRACKER && name == method);
    found.map(|(_, measures)| measures)
}

/// Table `differences`: the standings of [`super::of_frames`] with the same pairs.
pub fn differences(of: &Standings, results: &Results, pairs: &[Pair]) -> TableLayout {
    let ranked: Vec<&Standing> =
        of.fields.iter().flat_map(|field| of.best_first(field)).map(|(method, _)| method).collect();
    let style = of.measured.style;
    let text = |text: Option<String>| Cell { ours: text, ..Cell::default() };
    let signed = |difference: Estimate| difference.cells(|v| style.format_signed(v));
    let row = |(k, method): (usize, &&Standing)| {
        let name = &method.name;
        let variant = results.experiment.methods.iter().find(|m| m.name == *name)?.variants.first()?;
        let found = of_every_tracker(results, name).and_then(|measures| measures.get("found_at_5"));
        let best = ranked[..k].iter().find_map(|better| pair_of(pairs, name, &better.name));
        let mut cells = vec![
            text(Some(variant.needs().join(", "))),
            number(method.estimate.value, style),
            number(found, style),
            text(best.as_ref().map(|pair| pair.other.clone())),
        ];
        let [auroc, found] = best.map_or_else(Default::default, |pair| [pair.auroc, pair.found_at_5]);
        cells.extend(signed(auroc).into_iter().chain(signed(found)));
        Some((name.clone(), cells))
    };
    let rows = ranked.iter().enumerate().filter_map(row);
    let mut columns = ["reads", "AUROC", "found at 5", "compared with"].map(Label::from).to_vec();
    for difference in ["AUROC difference", "found difference"] {
        let bound =
            |end: &str| Label { shown: format!("95 % {end}"), ..format!("{difference}, {end}").into() };
        columns.extend([difference.into(), bound("from"), bound("to")]);
    }
    let groups = vec![group("", String::new(), rows)];
    let caption = say("differences", json!({}));
    of_suite(table("differences", caption, "method", columns, groups), results, &suite(results))
}

/// Table `breakdown`; `None` for results with tracks of only one family and one source.
pub fn breakdown(results: &Results) -> Option<TableLayout> {
    let rows_of = |method: &str| -> Vec<(String, Vec<Cell>)> {
        let row = |([tracker, name, _], measures): (&[String; 3], &FrameMeasures)| {
            let pool = pool(tracker).filter(|_| name == method)?;
            measures.get("losses").filter(|losses| *losses > 0.0)?;
            let style = |name: &str| if name == "losses" { Style::COUNT } else { Style::DEFAULT };
            let cells = MEASURES.map(|(_, name)| number(measures.get(name), style(name)));
            Some((pool.to_string(), Vec::from(cells)))
        };
        results.frame_measures.iter().filter_map(row).collect()
    };
    let methods = results.experiment.methods.iter();
    let shown = methods.filter(|m| m.variants.len() == 1 && !is_anchor(&results.experiment, &m.name));
    let rows = shown.map(|m| (&m.name, rows_of(&m.name))).filter(|(_, rows)| rows.len() > 1);
    let groups: Vec<_> = rows.map(|(name, rows)| group(name, name.clone(), rows)).collect();
    let caption = say("breakdown", json!({}));
    let columns = MEASURES.map(|(name, _)| name);
    (!groups.is_empty())
        .then(|| of_suite(table("breakdown", caption, "tracks", columns, groups), results, &suite(results)))
}

/// Description of a pool of trackers; `None` for a single tracker.
fn pool(tracker: &str) -> Option<&str> {
    let (first, pool) = tracker.split_once(' ').unwrap_or((tracker, "all"));
    (first == EVERY_TRACKER).then_some(pool)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::frame_measures::MEASURES as COLUMNS;

    #[test]
    fn columns_are_measures_and_pools_are_words() {
        for (_, name) in MEASURES {
            assert!(COLUMNS.iter().any(|column| column.name == name), "{name}");
        }
        let words = ["*", "* on otb", "* deep on otb", "KCF"].map(pool);
        assert_eq!(words, [Some("all"), Some("on otb"), Some("deep on otb"), None]);
    }
}
