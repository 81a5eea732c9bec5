//! The table `differences`: how far each method is behind the best one, frame by frame, all trackers together.
//!
//! The numbers are those of `frame_pairs.csv`; see [`crate::results::frame_pairs`] for the statistics.

use super::layouts::{self, cell, group, of_suite};
use super::standings::{Estimate, Standing, Standings};
use crate::results::Results;
use crate::results::frame_measures::EVERY_TRACKER;
use crate::results::frame_pairs::{Difference, Pair};
use crate::table::layout::{Cell, Label, TableLayout};

/// The area under the ROC curve of a score that says nothing.
pub const CHANCE: f64 = 0.5;

/// The pair of a method and another one, whichever is first in the file.
pub fn pair_of(pairs: &[Pair], method: &str, other: &str) -> Option<Pair> {
    let found = pairs.iter().find(|p| p.method == method && p.other == other).cloned();
    found.or_else(|| pairs.iter().find(|p| p.method == other && p.other == method).map(Pair::turned))
}

/// The table, from the standings of [`super::standings::of_frames`] by the same pairs.
pub fn table(of: &Standings, results: &Results, pairs: &[Pair]) -> TableLayout {
    let ranked: Vec<&Standing> =
        of.fields.iter().flat_map(|field| of.best_first(field)).map(|(method, _)| method).collect();
    let style = of.measured.style;
    let text = |text: Option<String>| Cell { ours: text, ..Cell::default() };
    let signed = |Difference { value, bounds }: Difference| {
        Estimate { value, bounds }.cells(|v| style.format_signed(v))
    };
    let row = |(k, method): (usize, &&Standing)| {
        let name = &method.name;
        let known = results.experiment.methods.iter().find(|m| m.name == *name);
        let reads = known.and_then(|m| m.variants.first()).map(|variant| variant.needs().join(", "));
        let is_it = |[tracker, other, _]: &[String; 3]| tracker == EVERY_TRACKER && other == name;
        let measures = results.frame_measures.iter().find(|(key, _)| is_it(key));
        let found = measures.and_then(|(_, measures)| measures.get("found_at_5"));
        let best = ranked[..k].iter().find_map(|better| pair_of(pairs, name, &better.name));
        let plain = |value: Option<f64>| cell(value, |v| style.format(v));
        let mut cells = vec![
            text(Some(reads.unwrap_or_default())),
            plain(method.estimate.value),
            plain(found),
            text(best.as_ref().map(|pair| pair.other.clone())),
        ];
        let [auroc, found] = best.map_or_else(Default::default, |pair| [pair.auroc, pair.found_at_5]);
        cells.extend(signed(auroc).into_iter().chain(signed(found)));
        (name.clone(), cells)
    };
    let rows = ranked.iter().enumerate().map(row).collect();
    let caption = "AUROC and share of losses found at 5 false alarms per 1000 good frames, all trackers together, and differences \
                   from the best method run on the same tracks.";
    let mut columns = ["reads", "AUROC", "found at 5", "compared with"].map(Label::from).to_vec();
    for difference in ["AUROC difference", "found difference"] {
        let bound = |end: &str| Label::shown_as(format!("{difference}, {end}"), format!("95 % {end}"));
        columns.extend([difference.into(), bound("from"), bound("to")]);
    }
    let groups = vec![group("", String::new(), rows)];
    let table = layouts::table("differences", caption.to_string(), "method", &[], groups);
    of_suite(TableLayout { columns, ..table }, results, &layouts::suite(results))
}
