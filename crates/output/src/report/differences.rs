//! The table `differences`: how far each method is behind the best one, frame by frame, all trackers together.
//!
//! The numbers are those of `frame_pairs.csv`; see [`crate::results::frame_pairs`] for the statistics.

use super::colors;
use super::headline::{self, MAX_ROWS, by_chance, estimate, signed_bounds};
use super::layouts::{self, cell, group, of_suite};
use crate::figure::{Dot, Dots};
use crate::results::Results;
use crate::results::frame_measures::EVERY_TRACKER;
use crate::results::frame_pairs::{Difference, Pair};
use crate::table::layout::{Cell, Label, TableLayout, is_anchor};
use crate::table::number::Style;
use trackfail_methods::score::{FrameMeasures, Metric};

/// The area under the ROC curve of a score that says nothing.
pub const CHANCE: f64 = 0.5;

/// The metric that the methods are ordered by.
pub fn metric() -> Option<Metric> {
    Metric::from_name("auroc")
}

/// A method with its measures over all trackers.
struct Ranked<'a> {
    name: &'a str,
    measures: &'a FrameMeasures,
}

/// The methods without a grid that have an AUROC, the best first.
fn ranked(results: &Results) -> Vec<Ranked<'_>> {
    let methods = &results.experiment.methods;
    let single = |name: &str| methods.iter().any(|m| m.name == name && m.variants.len() == 1);
    let mine = results.frame_measures.iter().filter(|(key, measures)| {
        let [tracker, name, _] = key;
        tracker == EVERY_TRACKER
            && single(name)
            && !is_anchor(&results.experiment, name)
            && measures.get("auroc").is_some()
    });
    let mut ranked: Vec<Ranked<'_>> =
        mine.map(|([_, name, _], measures)| Ranked { name, measures }).collect();
    ranked.sort_by(|a, b| {
        b.measures.get("auroc").partial_cmp(&a.measures.get("auroc")).unwrap_or(std::cmp::Ordering::Equal)
    });
    ranked
}

/// Inputs of a method beside the tracker's boxes, in words.
fn needs(results: &Results, name: &str) -> String {
    let method = results.experiment.methods.iter().find(|m| m.name == name);
    method.and_then(|m| m.variants.first()).map_or_else(String::new, |variant| variant.needs().join(", "))
}

/// The pair of a method and another one, whichever is first in the file.
pub fn pair_of(pairs: &[Pair], method: &str, other: &str) -> Option<Pair> {
    let found = pairs.iter().find(|p| p.method == method && p.other == other).cloned();
    found.or_else(|| pairs.iter().find(|p| p.method == other && p.other == method).map(Pair::turned))
}

/// The best method in a sentence, with how sure that is; `None` for results without pairs.
pub fn verdict(results: &Results, pairs: &[Pair]) -> Option<String> {
    let ranked = ranked(results);
    let (first, second) = (ranked.first().filter(|_| !pairs.is_empty())?, ranked.get(1)?);
    let style = Style::DEFAULT;
    let shown = estimate(style, first.measures.get("auroc")?, bounds(first));
    let mut text = format!(
        "{} tells lost frames from good ones best: area under the ROC curve {shown} over all trackers together.",
        first.name
    );
    let lead = pair_of(pairs, first.name, second.name).map(|pair| pair.auroc);
    if let Some(Difference { value: Some(value), bounds: Some(bounds) }) = lead {
        let (value, chance) = (style.format_signed(value), by_chance(Some(bounds)));
        let bounds = signed_bounds(style, bounds);
        text.push_str(&format!(" It leads {} by {value} ({bounds}), {chance}.", second.name));
    }
    Some(text)
}

/// Bounds of the area under the ROC curve.
fn bounds(method: &Ranked<'_>) -> Option<(f64, f64)> {
    method.measures.get("auroc_low").zip(method.measures.get("auroc_high"))
}

/// The best methods with their intervals, as a figure with its caption; `None` for results without pairs.
pub fn dots(results: &Results, pairs: &[Pair]) -> Option<(Dots, String)> {
    let ranked = ranked(results);
    let shown = &ranked[..ranked.len().min(MAX_ROWS)];
    let dot = |m: &Ranked<'_>| m.measures.get("auroc").map(|value| Dot { value, bounds: bounds(m) });
    let values = shown.iter().map(|m| (dot(m), None)).collect();
    let panel = ("all trackers together".to_string(), values);
    let caption = format!(
        "Area under the ROC curve of lost frames against good ones, all trackers together, with 95 % bootstrap intervals over \
         sequences; the best {} of {} methods. {}",
        shown.len(),
        ranked.len(),
        layouts::suite(results)
    );
    let rows =
        shown.iter().map(|m| (m.name.to_string(), colors::color(&results.experiment, m.name))).collect();
    let dots = headline::dots("Area under the ROC curve", "larger", rows, vec![panel]);
    let dots = Dots { note: format!("{}; dashed: chance", dots.note), chance: Some(CHANCE), ..dots };
    (!pairs.is_empty() && shown.len() > 1).then_some((dots, caption))
}

/// The table; `None` for results without pairs.
pub fn table(results: &Results, pairs: &[Pair]) -> Option<TableLayout> {
    let ranked = ranked(results);
    let style = Style::of_metric(metric()?);
    let signed = |d: Difference| {
        let shown = |v: Option<f64>| cell(v, |v| style.format_signed(v));
        [shown(d.value), shown(d.bounds.map(|b| b.0)), shown(d.bounds.map(|b| b.1))]
    };
    let row = |(k, method): (usize, &Ranked<'_>)| {
        let best = ranked[..k].iter().find_map(|better| pair_of(pairs, method.name, better.name));
        let plain = |v: Option<f64>| cell(v, |v| style.format(v));
        let text = |text: Option<String>| Cell { ours: text, ..Cell::default() };
        let against = text(best.as_ref().map(|pair| pair.other.clone()));
        let (auroc, found) = best.map_or_else(Default::default, |pair| (pair.auroc, pair.found_at_5));
        let reads = text(Some(needs(results, method.name)));
        let mut cells = vec![
            reads,
            plain(method.measures.get("auroc")),
            plain(method.measures.get("found_at_5")),
            against,
        ];
        cells.extend(signed(auroc).into_iter().chain(signed(found)));
        (method.name.to_string(), cells)
    };
    let rows: Vec<(String, Vec<Cell>)> = ranked.iter().enumerate().map(row).collect();
    let caption = "AUROC is the area under the ROC curve, all trackers together; found at 5 the share of losses found within 15 \
                   frames at 5 false alarms per 1000 good frames. Differences are those from the best method by AUROC that was \
                   run on the same tracks, with 95 % bounds by bootstrap over the same sequences for both; a method without a \
                   better one has none. frame_pairs.csv has all other pairs.";
    let mut columns = ["reads", "AUROC", "found at 5", "compared with"].map(Label::from).to_vec();
    for difference in ["AUROC difference", "found difference"] {
        let bound = |end: &str| Label::shown_as(format!("{difference}, {end}"), format!("95 % {end}"));
        columns.extend([difference.into(), bound("from"), bound("to")]);
    }
    let groups = vec![group("", String::new(), rows)];
    let table = layouts::table("differences", caption.to_string(), "method", &[], groups);
    let table = TableLayout { columns, ..table };
    (!pairs.is_empty()).then(|| of_suite(table, results, &layouts::suite(results)))
}
