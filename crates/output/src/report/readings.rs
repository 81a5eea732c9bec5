//! Tables and figures of readings: the choices that fit published numbers best, where a paper's text is
//! ambiguous.
//!
//! The numbers are those of `readings.csv`; see [`crate::results::readings`] for the discrepancy.

use super::figures::lines::distinct;
use super::sentences::say;
use crate::figure::{Color, Dot, DotPanel, Dots};
use crate::results::readings::{DISCREPANCY, Row};
use crate::results::{Results, grouped};
use crate::table::build::{cell, group, number, of_suite, suite, table};
use crate::table::layout::{Cell, TableLayout};
use crate::table::number::Style;
use serde_json::json;
use trackfail_engine::spec::Experiment;
use trackfail_methods::score::Metric;

/// Labels of a tracker and a method.
type Names<'a> = (&'a str, &'a str);

/// Readings of one method on one tracker, the smallest discrepancy first.
struct Group<'a> {
    of: Names<'a>,
    /// Names of the statistics, in order.
    statistics: Vec<&'a str>,
    readings: Vec<Reading<'a>>,
}

impl<'a> Group<'a> {
    fn new(of: Names<'a>, rows: &[&'a Row]) -> Self {
        let by_reading = grouped(rows.iter().copied(), |row| (row.tracker.as_str(), row.method.as_str()));
        let reading = |(own, rows)| Reading { name: name(own, of), is_plain: own == of, rows };
        let mut readings: Vec<Reading<'a>> = by_reading.into_iter().map(reading).collect();
        let key = |r: &Reading<'_>| r.discrepancy().unwrap_or(f64::INFINITY);
        readings.sort_by(|a, b| key(a).total_cmp(&key(b)));
        let statistics = rows.iter().map(|row| row.statistic.as_str()).filter(|name| *name != DISCREPANCY);
        Self { of, statistics: distinct(statistics), readings }
    }

    /// True if there are published numbers to compare the readings with.
    fn is_judged(&self) -> bool {
        self.readings.iter().any(|r| r.discrepancy().is_some())
    }

    /// Published number of a statistic.
    fn published(&self, statistic: &str) -> Option<f64> {
        self.readings.iter().find_map(|r| r.row(statistic)?.published)
    }
}

/// One reading, with one row per statistic.
struct Reading<'a> {
    name: String,
    /// True for the method on the tracker without changes.
    is_plain: bool,
    rows: Vec<&'a Row>,
}

impl<'a> Reading<'a> {
    fn row(&self, statistic: &str) -> Option<&'a Row> {
        self.rows.iter().copied().find(|row| row.statistic == statistic)
    }

    fn discrepancy(&self) -> Option<f64> {
        self.row(DISCREPANCY)?.ours
    }
}

/// Name of a reading, as a difference from the method and tracker that it is a reading of.
fn name((tracker, method): Names<'_>, of: Names<'_>) -> String {
    match (tracker == of.0, method == of.1) {
        (true, true) => format!("{method} (as it is)"),
        (true, false) => method.to_string(),
        (false, true) => format!("on {tracker}"),
        (false, false) => format!("{method} on {tracker}"),
    }
}

fn groups(rows: &[Row]) -> Vec<Group<'_>> {
    let groups = grouped(rows, |row| (row.of_tracker.as_str(), row.of_method.as_str()));
    groups.iter().map(|(of, mine)| Group::new(*of, mine)).collect()
}

/// True if an experiment is about readings, that is, if most of its methods are readings.
pub fn are_the_answer(experiment: &Experiment) -> bool {
    2 * experiment.methods.iter().filter(|m| m.like.is_some()).count() > experiment.methods.len()
}

/// One sentence: how many methods have a reading that is nearer to the published numbers, and which method
/// gains most. `None` without published numbers.
pub fn verdict(rows: &[Row]) -> Option<String> {
    let groups = groups(rows);
    // A method with its nearest reading, that one's discrepancy, and its own as it is.
    let judged = groups.iter().filter_map(|g| {
        let (first, plain) = (g.readings.first()?, g.readings.iter().find(|r| r.is_plain)?);
        Some((g.of, &first.name, first.discrepancy()?, plain.discrepancy()?))
    });
    let judged: Vec<_> = judged.collect();
    let nearer = || judged.iter().filter(|(.., near, plain)| D.round(*near) < D.round(*plain));
    let most = nearer().max_by(|a, b| (a.3 - a.2).total_cmp(&(b.3 - b.2)));
    let most = most.map(|((tracker, method), name, near, plain)| {
        let (near, plain) = (D.format(*near), D.format(*plain));
        json!({ "method": method, "tracker": tracker, "name": name, "near": near, "plain": plain })
    });
    let about = json!({ "all": judged.len(), "nearer": nearer().count(), "most": most });
    (!judged.is_empty()).then(|| say("readings verdict", about))
}

fn heading(statistic: &str) -> String {
    match statistic {
        "score_mean" => "Mean score".to_string(),
        "score_std" => "Deviation of scores".to_string(),
        other => Metric::from_name(other).map_or_else(|| other.to_string(), |m| m.title()),
    }
}

const D: Style = Style { decimals: 2, bare: false };

/// Print style: three significant digits for numbers per 1000 frames, three decimals for shares.
fn style(statistic: &str) -> Style {
    if statistic.ends_with("_per_1000") { Style { decimals: 1, bare: false } } else { Style::DEFAULT }
}

/// Tables of readings; empty for results without readings.
pub fn tables(results: &Results, rows: &[Row]) -> Vec<TableLayout> {
    let groups = groups(rows);
    if groups.is_empty() {
        return Vec::new();
    }
    let statistics = distinct(groups.iter().flat_map(|g| g.statistics.iter().copied()));
    let first = ["discrepancy", "nearest in"].map(String::from);
    let columns = first.into_iter().chain(statistics.iter().map(|s| heading(s)));
    let of = |g: &Group<'_>| {
        let line = |head: [Cell; 2], of: &dyn Fn(&str) -> Option<f64>| -> Vec<Cell> {
            head.into_iter().chain(statistics.iter().map(|s| number(of(s), style(s)))).collect()
        };
        let published = line(Default::default(), &|s| g.published(s));
        let reading = |r: &Reading<'_>| {
            let nearest =
                cell(r.row(DISCREPANCY).and_then(|row| row.first), |v| format!("{:.0} %", 100.0 * v));
            let head = [number(r.discrepancy(), D), nearest];
            (r.name.clone(), line(head, &|s| r.row(s)?.ours))
        };
        let rows = [("published".to_string(), published)].into_iter().chain(g.readings.iter().map(reading));
        group(&format!("{} {}", g.of.0, g.of.1), format!("{} on {}", g.of.1, g.of.0), rows)
    };
    let caption = say("readings", json!({ "is_judged": groups.iter().any(Group::is_judged) }));
    let table = table("readings", caption, "reading", columns, groups.iter().map(of).collect());
    vec![of_suite(table, results, &suite(results))]
}

/// Figures with name and caption, one for each method on a tracker, in the color of the method.
pub fn figures(rows: &[Row], color: impl Fn(&str) -> Color) -> Vec<(String, Dots, String)> {
    let figure = |g: &Group<'_>| {
        let (tracker, method) = g.of;
        let panel = |statistic: &&str| {
            let dot = |r: &Reading<'_>| {
                let row = r.row(statistic)?;
                Some(Dot { value: row.ours?, bounds: row.bounds.map(<(f64, f64)>::from) })
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
            title: format!("{method} on {tracker}"),
            note: "Dots with 95 % intervals over sequences are ours, the line is the published number"
                .to_string(),
            rows: g.readings.iter().map(|r| r.name.clone()).collect(),
            panels: shown.iter().map(panel).collect(),
            colors: vec![color(method); g.readings.len()],
            ..Dots::default()
        };
        let about = json!({ "tracker": tracker, "method": method, "is_judged": g.is_judged() });
        (file_name(g.of), dots, say("readings of", about))
    };
    groups(rows).iter().map(figure).collect()
}

/// Name of a group's figure, of letters, digits and hyphens.
fn file_name(of: Names<'_>) -> String {
    let text = format!("readings {} {}", of.1, of.0).to_lowercase();
    let words = text.split(|c: char| !c.is_ascii_lowercase() && !c.is_ascii_digit());
    words.filter(|word| !word.is_empty()).collect::<Vec<_>>().join("-")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(method: &str, statistic: &str, ours: f64) -> Row {
        let published = (statistic != DISCREPANCY).then_some(0.7);
        let [tracker, method, of_tracker, of_method, statistic] =
            ["SP", method, "SP", "CovF", statistic].map(String::from);
        let ours = Some(ours);
        Row { tracker, method, of_tracker, of_method, statistic, published, ours, ..Row::default() }
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
        assert_eq!(verdict(&rows).as_deref(), Some(expected));
        assert_eq!(verdict(&[row("CovF", "recall", 0.3)]), None);
    }

    #[test]
    fn the_nearest_reading_is_at_the_top_where_any_is() {
        let rows = [
            row("CovF", "recall", 0.3),
            row("CovF", DISCREPANCY, 4.0),
            row("CovF sum", "recall", 0.6),
            row("CovF sum", DISCREPANCY, 1.0),
        ];
        let (name, dots, caption) = figures(&rows, |_| Color::GREEN).remove(0);
        assert_eq!(name, "readings-covf-sp");
        assert_eq!(dots.rows, ["CovF sum", "CovF (as it is)"]);
        assert_eq!((dots.panels.len(), dots.colors.as_slice()), (1, &[Color::GREEN; 2][..]));
        let dot = Dot { value: 0.6, bounds: None };
        assert_eq!((dots.panels[0].mark, dots.panels[0].values[0]), (Some(0.7), Some(dot)));
        assert!(caption.ends_with("smallest discrepancy to the published numbers at the top."), "{caption}");
        let (_, _, caption) = figures(&rows[..1], |_| Color::BLUE).remove(0);
        assert!(caption.starts_with("Readings of CovF on SP in the order of the experiment:"), "{caption}");
        assert!(figures(&[], |_| Color::BLUE).is_empty());
    }
}
