//! Standings of an experiment: methods by counts and by measures of frames, and trackers.

use super::{Estimate, Field, Measured, Pair, Standing, Standings, field, ordering_metric};
use crate::report::operating;
use crate::results::frame_measures::EVERY_TRACKER;
use crate::results::{Results, frame_pairs, grouped, method_label};
use crate::sampling::{Sampling, Units, by_sequence, counts_of_column, mean_of_sum, metric_of_sum};
use crate::table::build::suite;
use crate::table::layout::is_anchor;
use crate::table::suites::suites_note;
use trackfail_engine::execute::analyse::Analysed;
use trackfail_engine::spec::Experiment;
use trackfail_engine::spec::method::{Method, Variant};
use trackfail_methods::analysis::Grid;
use trackfail_methods::score::{FrameMeasures, Metric};

/// Metric of frames by which methods are ordered.
pub fn frames_metric() -> Option<Metric> {
    Metric::from_name("auroc")
}

/// Standings of the methods on each tracker, by protocol, from summed counts.
pub fn of_methods(results: &Results, units: &Units) -> Standings {
    let experiment = &results.experiment;
    let metric = ordering_metric(experiment);
    let mut fields = Vec::new();
    for tracker in experiment.trackers.iter().map(|t| t.label.as_str()) {
        let methods = experiment.methods.iter().filter(|m| m.runs_on(tracker));
        let by_protocol = grouped(methods, |m| m.protocol.name);
        for (protocol, methods) in &by_protocol {
            let chance = methods[0].protocol.chance;
            let mine: Vec<Standing> =
                methods.iter().flat_map(|m| at_points(experiment, m, tracker, units)).collect();
            let label = match by_protocol.len() {
                1 => tracker.to_string(),
                _ => format!("{tracker}, {protocol}"),
            };
            let of = |sum: &[i64; 4]| metric_of_sum(metric, Some(chance), sum);
            if !mine.is_empty() {
                let names = (label, tracker.to_string());
                fields.push(field(names, mine, of, metric.direction(), &units.sampling));
            }
        }
    }
    Standings { measured: Measured::metric(metric), fields }
}

/// Standings of a method at all grid points that have a result on a tracker.
fn at_points(experiment: &Experiment, method: &Method, tracker: &str, units: &Units) -> Vec<Standing> {
    let ranked = operating::ranked(experiment, method).map(Variant::params);
    let ranked = ranked.filter(|_| !is_anchor(experiment, &method.name));
    let standing = |variant: &Variant| {
        let params = variant.params();
        let (label, name) = (method_label(&method.name, &params), method.name.clone());
        let counts = units.of(tracker, &label)?.clone();
        Some(Standing { label, name, competes: ranked == Some(params), counts, ..Standing::default() })
    };
    method.variants.iter().filter_map(standing).collect()
}

/// First analysis with a table by sequence, for its first tracker, and that table.
pub fn first_by_sequence(results: &Results) -> Option<(&Analysed, &Grid)> {
    results.analyses.iter().find_map(|a| Some((a, by_sequence(a)?)))
}

/// Sentence that names the suite behind the numbers of trackers.
pub fn suite_of_trackers(results: &Results) -> String {
    let compared = first_by_sequence(results).filter(|(a, _)| !a.shares.is_empty());
    compared.map_or_else(|| suite(results), |(a, _)| format!("Suite {}.", suites_note(a)))
}

/// Standings of the trackers that the [first analysis](first_by_sequence) scored, for each column of its
/// table.
pub fn of_trackers(results: &Results, sampling: &Sampling) -> Vec<Standings> {
    let Some((first, table)) = first_by_sequence(results) else { return Vec::new() };
    let mine = results.analyses.iter().filter(|a| a.analysis == first.analysis);
    let of_column = |(k, column): (usize, &String)| {
        let standing = |a: &Analysed| {
            let (label, name) = (a.tracker.clone(), a.tracker.clone());
            let counts = counts_of_column(by_sequence(a)?, k);
            Some(Standing { label, name, competes: true, counts, ..Standing::default() })
        };
        let standings = mine.clone().filter_map(standing).collect();
        let measured = Measured::column(column);
        let none = (String::new(), String::new());
        let fields = vec![field(none, standings, mean_of_sum, measured.direction, sampling)];
        Standings { measured, fields }
    };
    table.columns.iter().enumerate().map(of_column).collect()
}

/// Standings of the methods without a grid by the area under the ROC curve, all trackers together; `None` for
/// results without pairs.
pub fn of_frames(results: &Results, pairs: &[frame_pairs::Pair]) -> Option<Standings> {
    let experiment = &results.experiment;
    let metric = frames_metric().filter(|_| !pairs.is_empty())?;
    let is_single = |name: &str| experiment.methods.iter().any(|m| m.name == name && m.variants.len() == 1);
    let mine = results.frame_measures.iter().filter(|([tracker, name, _], measures)| {
        tracker == EVERY_TRACKER && is_single(name) && measures.get(metric.name()).is_some()
    });
    let standing = |([_, name, _], measures): (&[String; 3], &FrameMeasures)| Standing {
        label: name.clone(),
        name: name.clone(),
        competes: !is_anchor(experiment, name),
        estimate: Estimate::of_frames(measures, metric.name()),
        ..Standing::default()
    };
    let standings: Vec<Standing> = mine.map(standing).collect();
    let pair = |pair: &frame_pairs::Pair| {
        let labels = [pair.method.clone(), pair.other.clone()];
        Pair { labels, difference: pair.auroc, p: None, corrected: None, sequences: 0 }
    };
    let pairs = pairs.iter().map(pair).collect();
    let (label, tracker) = ("all trackers together".to_string(), EVERY_TRACKER.to_string());
    let fields = vec![Field { label, tracker, standings, friedman: None, pairs }];
    Some(Standings { measured: Measured::metric(metric), fields })
}
