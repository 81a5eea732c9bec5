//! Methods on one tracker, or trackers, that can be compared.

use super::Measured;
use crate::report::headline::spoken;
use crate::report::operating;
use crate::results::{CellScore, Results, method_label};
use crate::sampling::{counts_of_column, counts_of_sequences, sum_of};
use crate::table::layout;
use std::collections::BTreeMap;
use trackfail_engine::execute::analyse::Analysed;
use trackfail_engine::spec::method::Variant;
use trackfail_methods::analysis::Grid;
use trackfail_methods::score::Protocol;
use trackfail_methods::score::chance::Chance;

/// A method on one tracker, or a tracker.
pub(super) struct Competitor {
    pub label: String,
    /// The method without its grid point, or the tracker.
    pub name: String,
    /// Whether it is ranked and tested.
    pub competes: bool,
    /// Sequence -> counts of all runs.
    pub counts: BTreeMap<String, [i64; 4]>,
}

impl Competitor {
    /// Its name with the point of its grid, as sentences and figures have it.
    pub fn spoken(&self) -> String {
        spoken(&self.name, &self.label)
    }

    /// The summed counts of all sequences.
    pub fn total(&self) -> [i64; 4] {
        sum_of(&self.counts)
    }
}

/// Methods or trackers that can be compared.
pub(super) struct Field {
    /// Tracker, and protocol where the tracker's methods have several.
    pub label: String,
    /// The tracker; empty where trackers compete.
    pub tracker: String,
    /// How detections at random match by the protocol.
    pub chance: Chance,
    pub competitors: Vec<Competitor>,
}

impl Field {
    /// Those that compete with a result on every sequence that any of the field has one on: only they can be the best.
    pub fn whole(&self) -> impl Iterator<Item = &Competitor> {
        let most = self.competitors.iter().map(|c| c.counts.len()).max();
        self.competitors.iter().filter(move |c| c.competes && Some(c.counts.len()) == most)
    }
}

/// The methods on each tracker, by protocol.
pub(super) fn fields(results: &Results, scores: &[CellScore]) -> Vec<Field> {
    let experiment = &results.experiment;
    let mut counts = counts_of_sequences(scores);
    let mut fields = Vec::new();
    for tracker in &experiment.trackers {
        let methods = || experiment.methods.iter().filter(|m| m.runs_on(&tracker.label));
        let mut protocols: Vec<&Protocol> = Vec::new();
        for method in methods() {
            if protocols.iter().all(|p| p.name != method.protocol.name) {
                protocols.push(method.protocol);
            }
        }
        for protocol in &protocols {
            let mut competitors = Vec::new();
            for method in methods().filter(|m| m.protocol.name == protocol.name) {
                let ranked = operating::ranked(experiment, method)
                    .filter(|_| !layout::is_anchor(experiment, &method.name))
                    .map(Variant::params);
                for variant in &method.variants {
                    let competes = ranked.as_ref() == Some(&variant.params());
                    let label = method_label(&method.name, &variant.params());
                    let Some(counts) = counts.remove(&(tracker.label.clone(), label.clone())) else {
                        continue;
                    };
                    competitors.push(Competitor { label, name: method.name.clone(), competes, counts });
                }
            }
            let several = protocols.len() > 1;
            let label =
                if several { format!("{}, {}", tracker.label, protocol.name) } else { tracker.label.clone() };
            if !competitors.is_empty() {
                let (tracker, chance) = (tracker.label.clone(), protocol.chance);
                fields.push(Field { label, tracker, chance, competitors });
            }
        }
    }
    fields
}

fn by_sequence(analysed: &Analysed) -> Option<&Grid> {
    analysed.findings.tables.iter().find(|t| t.name == "sequences")
}

/// The first analysis with a table `sequences`, of its first tracker.
pub(super) fn first_by_sequence(results: &Results) -> Option<&Analysed> {
    results.analyses.iter().find(|a| by_sequence(a).is_some())
}

/// The trackers that the [first analysis](first_by_sequence) scored, for each column of its table.
pub(super) fn tracker_fields(results: &Results) -> Vec<(Measured, Field)> {
    let Some(first) = first_by_sequence(results) else { return Vec::new() };
    let mine = results.analyses.iter().filter(|a| a.analysis == first.analysis);
    let tables: Vec<(&str, &Grid)> =
        mine.filter_map(|a| Some((a.tracker.as_str(), by_sequence(a)?))).collect();
    let field = |(k, column): (usize, &String)| {
        let competitor = |(tracker, table): &(&str, &Grid)| {
            let counts = counts_of_column(table, k);
            Competitor { label: (*tracker).to_string(), name: (*tracker).to_string(), competes: true, counts }
        };
        let competitors = tables.iter().map(competitor).collect();
        (
            Measured::Mean(column.clone()),
            Field { label: String::new(), tracker: String::new(), chance: Chance::within(0), competitors },
        )
    };
    tables[0].1.columns.iter().enumerate().map(field).collect()
}
