//! From a number of a table to the sequences it comes from, from results alone.
//!
//! Measures are computed from counts that are summed over sequences, so a sequence has no share of its own in
//! a ratio. What it contributes is told by the measure without it: `m - m(without it)`, which for a count is
//! the sequence's count.

use super::results::{Results, ResultsError};
use super::sequences::Tallies;
use super::trace;
use crate::score::measures::{Counts, Metric, Pooled, median_delay, normalised_mean_std};
use crate::score::{Protocol, TrackScore};
use crate::spec::table::Table;
use crate::table::layout::{self, Group, Layout, Spot};
use crate::table::measures::{self, Measure};
use crate::table::records::{CellScore, method_label};
use serde::Serialize;
use std::collections::BTreeMap;

/// A number of a table and what is behind it.
pub struct Explained {
    /// Which it is.
    pub spot: Spot,
    /// The number as the table has it.
    pub value: Option<f64>,
    /// What was counted on all sequences and runs.
    pub counts: Counts,
    /// How the number comes about, with the counts filled in.
    pub formula: String,
    /// How the counts come about.
    pub protocol: Option<&'static Protocol>,
    /// The sequences, those that move the number most first.
    pub parts: Vec<Part>,
    /// Cells behind the number without a result: sequence, run and reason.
    pub failed: Vec<(String, u32, String)>,
}

/// What a sequence has to do with a number.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// The sequence.
    pub sequence: String,
    /// Number of runs on it.
    pub runs: usize,
    /// What was counted on it.
    pub counts: Counts,
    /// The measure on this sequence alone.
    pub alone: Option<f64>,
    /// The measure on all the others.
    pub without: Option<f64>,
    /// The measure on all less that on the others.
    pub moves: Option<f64>,
}

/// What is behind a cell of a table, as the page tells it.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Origin {
    /// Which number it is: `f_score of DTEF on NCC is 0.242`.
    pub number: String,
    /// How it comes about, with the counts filled in.
    pub formula: String,
    /// The command that takes it apart.
    pub command: String,
    /// Index of its tracker among those shown sequence by sequence.
    pub tracker: Option<usize>,
    /// Index of its method with its grid point there.
    pub method: Option<usize>,
    /// Index of the attribute of the sequences it is about; it is about all of them when `None`.
    pub attribute: Option<usize>,
}

/// The origins of a table's cells: groups, rows, cells.
pub type Origins = Vec<Vec<Vec<Option<Origin>>>>;

/// What one sequence gives to a pooled number.
#[derive(Default)]
struct Given {
    runs: usize,
    counts: Counts,
    scores: Vec<Vec<f64>>,
    delays: Vec<i64>,
}

/// Explains one number; `scores` are those of [`Results::scores`].
///
/// # Errors
/// When the frames are needed and cannot be read.
pub fn explain(results: &Results, scores: &[CellScore], spot: &Spot) -> Result<Explained, ResultsError> {
    let label = method_label(&spot.method, &spot.params);
    let mut given: BTreeMap<String, Given> = BTreeMap::new();
    let mine =
        |s: &&CellScore| s.tracker == spot.tracker && s.method == spot.method && s.params == spot.params;
    let attributes = &results.manifest.suite.attributes;
    let concerned = |sequence: &str| {
        let own = attributes.get(sequence);
        spot.attribute.as_ref().is_none_or(|a| own.is_some_and(|own| own.contains(a)))
    };
    for score in scores.iter().filter(mine).filter(|s| concerned(&s.sequence)) {
        let part = given.entry(score.sequence.clone()).or_default();
        part.runs += 1;
        part.counts = [part.counts, score.counts].into_iter().sum();
    }
    let protocol = results.experiment.protocol_of(&spot.method);
    let of_frames = [Metric::ScoreMean, Metric::ScoreStd, Metric::ScoreMeanStd, Metric::DelayMedian];
    if of_frames.contains(&spot.metric) {
        for track in trace::read(results, &spot.tracker, &label, None)? {
            if let Some(part) = given.get_mut(&track.sequence) {
                part.delays.extend(protocol.map(|p| track.judge(p)).iter().flat_map(TrackScore::delays));
                part.scores.push(track.score);
            }
        }
    }
    let measure = results
        .measures
        .iter()
        .find(|m| m.tracker == spot.tracker && m.method == spot.method && m.params == spot.params);
    let all: Vec<&Given> = given.values().collect();
    let value = match spot.attribute {
        None => measure.and_then(|m| m.value(spot.metric)),
        Some(_) => pooled(&all, protocol, spot.metric),
    };
    let part = |(k, (sequence, part)): (usize, (&String, &Given))| {
        let others: Vec<&Given> = all.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, g)| *g).collect();
        let without = pooled(&others, protocol, spot.metric);
        Part {
            sequence: sequence.clone(),
            runs: part.runs,
            counts: part.counts,
            alone: pooled(&[part], protocol, spot.metric),
            without,
            moves: value.zip(without).map(|(all, others)| all - others),
        }
    };
    let mut parts: Vec<Part> = given.iter().enumerate().map(part).collect();
    let weight = |p: &Part| {
        let counted = p.counts.tp + p.counts.fp + p.counts.fn_;
        (p.moves.map_or(f64::INFINITY, f64::abs), counted)
    };
    // A sequence without which there is no number at all moves it most. The order of the names stays where
    // nothing else tells two apart.
    parts.sort_by(|a, b| {
        let (a, b) = (weight(a), weight(b));
        b.0.total_cmp(&a.0).then(b.1.cmp(&a.1))
    });
    let failed = results.manifest.cells_failed.iter();
    let failed = failed.filter(|c| c.tracker == spot.tracker && c.method == label && concerned(&c.sequence));
    let counts = all.iter().map(|g| g.counts).sum();
    Ok(Explained {
        spot: spot.clone(),
        value,
        counts,
        formula: formula(spot.metric, counts, protocol),
        protocol,
        parts,
        failed: failed.map(|c| (c.sequence.clone(), c.run, c.reason.clone())).collect(),
    })
}

/// What is behind every cell of the experiment's own tables, whose layouts come first among `layouts`;
/// `trackers` and `shown` are what the page has sequence by sequence.
/// `scores` are those of [`Results::scores`].
pub fn origins(
    results: &Results,
    scores: &[CellScore],
    layouts: &[Layout],
    trackers: &[String],
    shown: &Tallies,
) -> Vec<Origins> {
    let place = |of: &[String], name: &str| of.iter().position(|known| known == name);
    let parts = measures::by_attribute(scores, &results.manifest.suite.attributes);
    let all = [results.measures.as_slice(), &parts].concat();
    let mut counted: BTreeMap<_, &Measure> = BTreeMap::new();
    for m in &all {
        counted.entry((&m.tracker, &m.method, &m.params, &m.attribute)).or_insert(m);
    }
    let experiment = &results.experiment;
    let of_table = |(table, layout): (&Table, &Layout)| {
        // Tables of an analysis are made without events and detections.
        let spots = match table.shows {
            Some(_) => Vec::new(),
            None => layout::spots(experiment, table, &all),
        };
        let mut places: BTreeMap<(&str, &str), Vec<&Spot>> = BTreeMap::new();
        for spot in &spots {
            places.entry((&spot.row, &spot.column)).or_default().push(spot);
        }
        let name = format!("{}/{}", experiment.name, layout.name);
        let of_cell = |group: &Group, row: &str, column: &str, ours: Option<&str>| {
            let alike = places.get(&(row, column))?;
            let spot = *alike.iter().find(|s| group.has_ours && heads(&group.key, s))?;
            let measure = counted.get(&(&spot.tracker, &spot.method, &spot.params, &spot.attribute))?;
            let protocol = experiment.protocol_of(&spot.method);
            let method = method_label(&spot.method, &spot.params);
            let only = spot.attribute.as_ref().map_or_else(String::new, |a| format!(", only {a},"));
            Some(Origin {
                number: format!(
                    "{} of {method} on {}{only} is {}",
                    spot.metric.name(),
                    spot.tracker,
                    ours.unwrap_or("without a value")
                ),
                formula: formula(spot.metric, measure.pooled.counts, protocol),
                command: command(&name, spot, alike),
                tracker: place(trackers, &spot.tracker),
                method: place(&shown.methods, &method),
                attribute: spot.attribute.as_ref().and_then(|a| place(&shown.attributes, a)),
            })
        };
        let of_group = |group: &Group| {
            let of_row = |row: &layout::Row| {
                let cells = row.cells.iter().zip(&layout.columns);
                cells.map(|(cell, column)| of_cell(group, &row.label, column, cell.ours.as_deref())).collect()
            };
            group.rows.iter().map(of_row).collect()
        };
        layout.groups.iter().map(of_group).collect()
    };
    experiment.tables.iter().zip(layouts).map(of_table).collect()
}

/// Whether a group of this name has the spot: it names some of its tracker, method and grid point, in this order,
/// and maybe axes that the method does not have.
fn heads(key: &str, spot: &Spot) -> bool {
    let axes: Vec<(String, f64)> = measures::parse_point(&spot.params);
    let mut parts = vec![spot.tracker.clone(), spot.method.clone()];
    parts.extend(axes.iter().map(|(axis, value)| format!("{axis} = {value}")));
    let foreign = |part: &str| {
        part.split_once(" = ").is_some_and(|(axis, _)| axes.iter().all(|(known, _)| known != axis))
    };
    fn is_made_of(key: &str, parts: &[String], foreign: &dyn Fn(&str) -> bool) -> bool {
        let rest = |taken: usize| match key.get(taken..) {
            Some("") => Some(""),
            rest => rest?.strip_prefix(", "),
        };
        key.is_empty()
            || parts.iter().enumerate().any(|(k, part)| {
                key.starts_with(part.as_str())
                    && rest(part.len()).is_some_and(|rest| is_made_of(rest, &parts[k + 1..], foreign))
            })
            || {
                let first = key.split(", ").next().unwrap_or_default();
                foreign(first) && rest(first.len()).is_some_and(|rest| is_made_of(rest, parts, foreign))
            }
    }
    is_made_of(key, &parts, &foreign)
}

/// The command line that explains a cell; `alike` are all of the table in the same row and column.
fn command(table: &str, spot: &Spot, alike: &[&Spot]) -> String {
    let label = |s: &Spot| method_label(&s.method, &s.params);
    let mut words = vec!["trackfail".to_string(), "explain".to_string(), quoted(table)];
    words.extend([quoted(&spot.row), quoted(&spot.column)]);
    if alike.iter().any(|s| s.tracker != spot.tracker) {
        words.extend(["--tracker".to_string(), quoted(&spot.tracker)]);
    }
    if alike.iter().any(|s| label(s) != label(spot)) {
        words.extend(["--method".to_string(), quoted(&label(spot))]);
    }
    words.join(" ")
}

/// A word as a shell reads it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_./@%+=:,-".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_string();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

/// How counts come about, in a line.
pub fn counted_by(protocol: &Protocol) -> String {
    format!("counted by {}: {}", protocol.name, protocol.summary)
}

/// A metric of some sequences together.
fn pooled(given: &[&Given], protocol: Option<&Protocol>, metric: Metric) -> Option<f64> {
    if given.is_empty() || !by_sequence(metric) {
        return None;
    }
    let counts = given.iter().map(|g| g.counts).sum();
    let score = normalised_mean_std(given.iter().flat_map(|g| &g.scores));
    let delay = median_delay(given.iter().flat_map(|g| g.delays.iter().copied()).collect());
    Pooled { counts, score, delay, chance: protocol.map(|p| p.chance), ..Pooled::default() }.value(metric)
}

/// Whether results have what a metric is made of sequence by sequence.
fn by_sequence(metric: Metric) -> bool {
    !matches!(metric, Metric::ReverseRuns | Metric::ReverseFrames)
}

/// How a metric comes about, with the counts filled in.
fn formula(metric: Metric, counts: Counts, protocol: Option<&Protocol>) -> String {
    let Counts { tp, fp, fn_, tn } = counts;
    match metric {
        Metric::Precision => format!("TP / (TP + FP) = {tp} / ({tp} + {fp})"),
        Metric::Recall => format!("TP / (TP + FN) = {tp} / ({tp} + {fn_})"),
        Metric::FScore => format!("2 TP / (2 TP + FP + FN) = {} / ({} + {fp} + {fn_})", 2 * tp, 2 * tp),
        Metric::Fpr => format!("FP / (FP + TN) = {fp} / ({fp} + {tn})"),
        Metric::Accuracy => {
            format!("(TP + TN) / (TP + FP + FN + TN) = ({tp} + {tn}) / ({tp} + {fp} + {fn_} + {tn})")
        }
        Metric::Informedness => {
            format!("TP / (TP + FN) - FP / (FP + TN) = {tp} / ({tp} + {fn_}) - {fp} / ({fp} + {tn})")
        }
        Metric::FByChance => format!(
            "2 TP0 / (2 TP + FP + FN); TP0 = {:.2}, the true positives expected of {} detections at random",
            protocol.map_or(f64::NAN, |p| p.chance.true_positives(&counts)),
            tp + fp
        ),
        Metric::FOverChance => {
            let by_chance = protocol.map_or(f64::NAN, |p| p.chance.true_positives(&counts));
            let both = 2 * tp + fp + fn_;
            format!(
                "(F - F0) / (1 - F0); F = {} / {both}; F0 = 2 * {by_chance:.2} / {both}, with the true positives \
                 expected of {} detections at random",
                2 * tp,
                tp + fp
            )
        }
        Metric::MissRate => format!("FN / (TP + FN) = {fn_} / ({tp} + {fn_})"),
        Metric::FalseAlarms => {
            format!("1000 FP / (TP + FP + FN + TN) = 1000 * {fp} / ({tp} + {fp} + {fn_} + {tn})")
        }
        Metric::DelayMedian => {
            format!("median over the {tp} matched detections of their frame less that of the event")
        }
        Metric::Events => format!("TP + FN = {tp} + {fn_}"),
        Metric::Detections => format!("TP + FP = {tp} + {fp}"),
        Metric::Tp | Metric::Fp | Metric::Fn | Metric::Tn => "sum over sequences and runs".to_string(),
        Metric::ScoreMean | Metric::ScoreStd | Metric::ScoreMeanStd => {
            "mean and standard deviation of the scores of all frames, each run's brought to 0..1 by its own \
             minimum and maximum; runs of constant score are left out"
                .to_string()
        }
        Metric::ReverseRuns | Metric::ReverseFrames => {
            "sum over sequences and runs; counted while the tracker was run backwards, see checks.csv"
                .to_string()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::Direction;

    // By hand: F of (2, 1, 0) and (0, 1, 2) together is 4 / (4 + 2 + 2); F of the first alone 4 / 5.
    #[test]
    fn pools_counts_and_never_ratios() {
        let given = |tp, fp, fn_| Given { counts: Counts { tp, fp, fn_, tn: 9 }, ..Given::default() };
        let (a, b) = (given(2, 1, 0), given(0, 1, 2));
        assert_eq!(pooled(&[&a, &b], None, Metric::FScore), Some(0.5));
        assert_eq!(pooled(&[&a], None, Metric::FScore), Some(0.8));
        assert_eq!(pooled(&[], None, Metric::FScore), None);
        assert_eq!(pooled(&[&a], None, Metric::ReverseRuns), None);
    }

    fn spot(tracker: &str, method: &str, params: &str) -> Spot {
        let [row, column, tracker, method, params] =
            ["f_score", "M", tracker, method, params].map(String::from);
        Spot { row, column, tracker, method, params, attribute: None, metric: Metric::FScore }
    }

    #[test]
    fn a_group_is_known_by_its_name() {
        let s = spot("A, B", "M", "horizon=5;window=20");
        for key in ["", "A, B", "M", "A, B, M", "A, B, horizon = 5", "window = 20", "A, B, length = 3"] {
            assert!(heads(key, &s), "{key}");
        }
        for key in ["A", "A, BM", "M, A, B", "A, B, horizon = 50", "A, B, length", "A, B, M, M"] {
            assert!(!heads(key, &s), "{key}");
        }
    }

    #[test]
    fn commands_name_what_they_must_and_can_be_typed() {
        let (a, b, c) = (spot("A", "M", "x=1"), spot("B's", "M", "x=1"), spot("B's", "M", "x=2"));
        assert_eq!(command("q/t", &a, &[&a]), "trackfail explain q/t f_score M");
        assert_eq!(command("q/t", &a, &[&a, &b]), "trackfail explain q/t f_score M --tracker A");
        assert_eq!(
            command("q t", &c, &[&a, &b, &c]),
            r"trackfail explain 'q t' f_score M --tracker 'B'\''s' --method 'M[x=2]'"
        );
        assert_eq!(quoted(""), "''");
    }

    #[test]
    fn every_formula_gives_the_number() {
        let counts = Counts { tp: 3, fp: 4, fn_: 5, tn: 60 };
        let pooled = Pooled { counts, ..Pooled::default() };
        assert_eq!(formula(Metric::FScore, counts, None), "2 TP / (2 TP + FP + FN) = 6 / (6 + 4 + 5)");
        assert_eq!(pooled.value(Metric::FScore), Some(6.0 / 15.0));
        assert_eq!(formula(Metric::Fpr, counts, None), "FP / (FP + TN) = 4 / (4 + 60)");
        assert_eq!(pooled.value(Metric::Fpr), Some(4.0 / 64.0));
        // Every metric with a direction says how it is made.
        let metrics = Metric::names().filter_map(Metric::from_name);
        assert!(
            metrics
                .filter(|m| m.direction() != Direction::Neither)
                .all(|m| !formula(m, counts, None).is_empty())
        );
    }
}
