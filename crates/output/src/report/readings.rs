//! The tables and figures of readings: which choice the published numbers speak for, where a text leaves it open.
//!
//! The numbers are those of `readings.csv`; see [`crate::results::readings`] for the discrepancy.

use super::layouts::{self, cell, group, of_suite};
use crate::figure::{Color, Dot, DotPanel, Dots};
use crate::results::Results;
use crate::results::readings::{DISCREPANCY, Row};
use crate::table::layout::{Cell, TableLayout};
use crate::table::number::Style;
use std::collections::BTreeMap;
use trackfail_engine::spec::Experiment;
use trackfail_methods::score::Metric;

/// The readings of one method on one tracker, those with the smallest discrepancy first.
struct Group<'a> {
    of: (&'a str, &'a str),
    /// Names of the statistics, in their order.
    statistics: Vec<&'a str>,
    readings: Vec<Reading<'a>>,
}

impl Group<'_> {
    /// Whether there are published numbers that readings are compared with.
    fn is_judged(&self) -> bool {
        self.readings.iter().any(|r| r.discrepancy().is_some())
    }

    /// The published number of a statistic.
    fn published(&self, statistic: &str) -> Option<f64> {
        self.readings.iter().find_map(|r| r.rows.get(statistic)?.published)
    }
}

/// One reading with its rows by statistic.
struct Reading<'a> {
    tracker: &'a str,
    method: &'a str,
    rows: BTreeMap<&'a str, &'a Row>,
}

impl Reading<'_> {
    fn discrepancy(&self) -> Option<f64> {
        self.rows.get(DISCREPANCY)?.ours
    }

    /// Name among the readings of a method on a tracker.
    fn name(&self, of: (&str, &str)) -> String {
        match (self.tracker == of.0, self.method == of.1) {
            (true, true) => format!("{} (as it is)", self.method),
            (true, false) => self.method.to_string(),
            (false, true) => format!("on {}", self.tracker),
            (false, false) => format!("{} on {}", self.method, self.tracker),
        }
    }
}

/// The item of a list that fits, or a new one at its end.
fn entry<T>(list: &mut Vec<T>, is_it: impl Fn(&T) -> bool, new: T) -> &mut T {
    let place = list.iter().position(is_it).unwrap_or(list.len());
    if place == list.len() {
        list.push(new);
    }
    &mut list[place]
}

fn groups(rows: &[Row]) -> Vec<Group<'_>> {
    let mut groups: Vec<Group<'_>> = Vec::new();
    for row in rows {
        let of = (row.of_tracker.as_str(), row.of_method.as_str());
        let (tracker, method, statistic) =
            (row.tracker.as_str(), row.method.as_str(), row.statistic.as_str());
        let new = Group { of, statistics: Vec::new(), readings: Vec::new() };
        let group = entry(&mut groups, |g| g.of == of, new);
        if statistic != DISCREPANCY && !group.statistics.contains(&statistic) {
            group.statistics.push(statistic);
        }
        let new = Reading { tracker, method, rows: BTreeMap::new() };
        let is_it = |r: &Reading<'_>| (r.tracker, r.method) == (tracker, method);
        entry(&mut group.readings, is_it, new).rows.insert(statistic, row);
    }
    for group in &mut groups {
        let key = |r: &Reading<'_>| r.discrepancy().unwrap_or(f64::INFINITY);
        group.readings.sort_by(|a, b| key(a).total_cmp(&key(b)));
    }
    groups
}

/// Whether an experiment is about readings: most of its methods are.
pub fn are_the_answer(experiment: &Experiment) -> bool {
    2 * experiment.methods.iter().filter(|m| m.like.is_some()).count() > experiment.methods.len()
}

/// How many of the methods have a reading nearer to the published numbers than they are themselves, and the one that gains
/// most by it, in a sentence; `None` where most methods are no readings, or nothing that they are judged by is published.
pub fn verdict(results: &Results, rows: &[Row]) -> Option<String> {
    if are_the_answer(&results.experiment) { sentence(&groups(rows)) } else { None }
}

/// A method with its nearest reading, that one's discrepancy, and its own as it is.
fn nearest<'g>(g: &'g Group<'_>) -> Option<((&'g str, &'g str), String, f64, f64)> {
    let first = g.readings.first()?;
    let plain = g.readings.iter().find(|r| (r.tracker, r.method) == g.of)?;
    Some((g.of, first.name(g.of), first.discrepancy()?, plain.discrepancy()?))
}

fn sentence(groups: &[Group<'_>]) -> Option<String> {
    let judged: Vec<_> = groups.iter().filter_map(nearest).collect();
    let nearer: Vec<_> =
        judged.iter().filter(|(_, _, near, plain)| D.round(*near) < D.round(*plain)).collect();
    let methods = if judged.len() == 1 { "method" } else { "methods" };
    let Some((of, name, near, plain)) = nearer.iter().max_by(|a, b| (a.3 - a.2).total_cmp(&(b.3 - b.2)))
    else {
        let text = format!(
            "No reading is nearer to the published numbers than the {} {methods} as they are.",
            judged.len()
        );
        return (!judged.is_empty()).then_some(text);
    };
    Some(format!(
        "Another reading of the text is nearer to the published numbers for {} of {} {methods}, most of all for {} on {}: \
         {} standard errors off instead of {}, with \u{201c}{name}\u{201d}.",
        nearer.len(),
        judged.len(),
        of.1,
        of.0,
        D.format(*near),
        D.format(*plain),
    ))
}

fn heading(statistic: &str) -> String {
    match statistic {
        "score_mean" => "Mean score".to_string(),
        "score_std" => "Deviation of scores".to_string(),
        other => Metric::from_name(other).map_or_else(|| other.to_string(), |m| m.title()),
    }
}

const D: Style = Style { decimals: 2, bare: false };

/// Three significant digits for what is given per 1000 frames, three decimals for shares.
fn style(statistic: &str) -> Style {
    if statistic.ends_with("_per_1000") { Style { decimals: 1, bare: false } } else { Style::DEFAULT }
}

/// The tables; none for results without readings.
pub fn tables(results: &Results, rows: &[Row]) -> Vec<TableLayout> {
    let groups = groups(rows);
    if groups.is_empty() {
        return Vec::new();
    }
    let mut statistics: Vec<&str> = Vec::new();
    for &name in groups.iter().flat_map(|g| &g.statistics) {
        entry(&mut statistics, |known| *known == name, name);
    }
    let headings: Vec<String> = statistics.iter().map(|s| heading(s)).collect();
    let columns: Vec<&str> =
        ["discrepancy", "nearest in"].into_iter().chain(headings.iter().map(String::as_str)).collect();
    let of = |g: &Group<'_>| {
        let numbers = |of: &dyn Fn(&str) -> Option<f64>| -> Vec<Cell> {
            statistics.iter().map(|s| cell(of(s), |v| style(s).format(v))).collect()
        };
        let first = [vec![Cell::default(); 2], numbers(&|s| g.published(s))].concat();
        let line = |reading: &Reading<'_>| {
            let share = reading.rows.get(DISCREPANCY).and_then(|row| row.first);
            let nearest = cell(share, |v| format!("{:.0} %", 100.0 * v));
            let head = vec![cell(reading.discrepancy(), |v| D.format(v)), nearest];
            (reading.name(g.of), [head, numbers(&|s| reading.rows.get(s)?.ours)].concat())
        };
        let first = std::iter::once(("published".to_string(), first));
        let lines = first.chain(g.readings.iter().map(line)).collect();
        group(&format!("{} {}", g.of.0, g.of.1), format!("{} on {}", g.of.1, g.of.0), lines)
    };
    let judged = "Which reading of the text the published numbers speak for: the smallest discrepancy first. The discrepancy is \
                  the root mean square of the differences to the published numbers, each in units of its standard error over \
                  sequences, the same for all readings of a method on a tracker: about 1 where another choice of sequences would \
                  explain them. `nearest in` is the share of the samples in which a reading has \
                  the smallest one. F is not among the statistics, and nothing was chosen by it.";
    let listed = "The readings of each method, in the order of the experiment. Nothing is published that they could be \
                  compared with by a discrepancy.";
    let caption = if groups.iter().any(Group::is_judged) { judged } else { listed };
    let table =
        layouts::table("readings", caption.to_string(), "reading", &columns, groups.iter().map(of).collect());
    vec![of_suite(table, results, &layouts::suite(results))]
}

/// The figures: name, figure and caption, one for each method on a tracker, in the color of the method.
pub fn figures(rows: &[Row], color: impl Fn(&str) -> Color) -> Vec<(String, Dots, String)> {
    let figure = |g: &Group<'_>| {
        let panel = |statistic: &&str| {
            let dot = |r: &Reading<'_>| {
                let row = r.rows.get(statistic)?;
                Some(Dot { value: row.ours?, bounds: row.bounds })
            };
            DotPanel {
                label: heading(statistic).trim_end_matches(" frames").replace("false positive rate", "FPR"),
                mark: g.published(statistic),
                values: g.readings.iter().map(dot).collect(),
                ..DotPanel::default()
            }
        };
        // F is not what readings are judged by; it is drawn where nothing else is published.
        let counted: Vec<&str> = g.statistics.iter().copied().filter(|s| !s.starts_with("f_")).collect();
        let shown = if counted.is_empty() { &g.statistics } else { &counted };
        let dots = Dots {
            title: format!("{} on {}", g.of.1, g.of.0),
            note: "Dots with 95 % intervals over sequences are ours, the line is the published number"
                .to_string(),
            rows: g.readings.iter().map(|r| r.name(g.of)).collect(),
            panels: shown.iter().map(panel).collect(),
            shared_axis: false,
            colors: vec![color(g.of.1); g.readings.len()],
            chance: None,
        };
        let order = match g.is_judged() {
            true => ", the one with the smallest discrepancy to the published numbers at the top",
            false => " in the order of the experiment: nothing that could be compared with them is published",
        };
        let caption = format!("Readings of {} on {}{order}.", g.of.1, g.of.0);
        (file_name(g.of), dots, caption)
    };
    groups(rows).iter().map(figure).collect()
}

/// Name of a group's figure: letters, digits and hyphens.
fn file_name(of: (&str, &str)) -> String {
    let text = format!("readings {} {}", of.1, of.0).to_lowercase();
    let words = text.split(|c: char| !c.is_ascii_lowercase() && !c.is_ascii_digit());
    words.filter(|word| !word.is_empty()).collect::<Vec<_>>().join("-")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(method: &str, statistic: &str, ours: f64) -> Row {
        Row {
            tracker: "SP".into(),
            method: method.into(),
            of_tracker: "SP".into(),
            of_method: "CovF".into(),
            statistic: statistic.into(),
            published: (statistic != DISCREPANCY).then_some(0.7),
            ours: Some(ours),
            ..Row::default()
        }
    }

    #[test]
    fn the_verdict_is_a_sentence() {
        let rows = [
            row("CovF", DISCREPANCY, 4.0),
            row("CovF sum", DISCREPANCY, 1.0),
            Row { of_method: "RAW".into(), ..row("RAW", DISCREPANCY, 0.5) },
        ];
        let expected = "Another reading of the text is nearer to the published numbers for 1 of 2 methods, most of all for \
                        CovF on SP: 1.00 standard errors off instead of 4.00, with \u{201c}CovF sum\u{201d}.";
        assert_eq!(sentence(&groups(&rows)).as_deref(), Some(expected));
        assert_eq!(sentence(&groups(&[row("CovF", "recall", 0.3)])), None);
    }

    #[test]
    fn without_published_numbers_no_reading_is_the_nearest() {
        let (_, _, caption) = figures(&[row("CovF", "recall", 0.3)], |_| Color::Blue).remove(0);
        assert!(
            caption.contains("in the order of the experiment") && !caption.contains("smallest"),
            "{caption}"
        );
    }

    #[test]
    fn the_nearest_reading_is_at_the_top() {
        let rows = [
            row("CovF", "recall", 0.3),
            row("CovF", DISCREPANCY, 4.0),
            row("CovF sum", "recall", 0.6),
            row("CovF sum", DISCREPANCY, 1.0),
        ];
        let (name, dots, _) = figures(&rows, |_| Color::Green).remove(0);
        assert_eq!(name, "readings-covf-sp");
        assert_eq!(dots.rows, ["CovF sum", "CovF (as it is)"]);
        assert_eq!((dots.panels.len(), dots.colors.as_slice()), (1, &[Color::Green; 2][..]));
        let dot = Dot { value: 0.6, bounds: None };
        assert_eq!((dots.panels[0].mark, dots.panels[0].values[0]), (Some(0.7), Some(dot)));
        assert!(figures(&[], |_| Color::Blue).is_empty());
    }
}
