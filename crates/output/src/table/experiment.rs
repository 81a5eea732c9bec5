//! Tables of an experiment, from its results.

use super::layout::{self, TableLayout};
use super::macros::Fact;
use super::suites::targets_note;
use super::{latex, leaderboard, macros, render};
use crate::results::manifest::{self, Manifest, TrackerRecord};
use crate::results::{CellScore, FailedCell, Measure, Results, ResultsError, TABLES, grouped, measures};
use crate::sampling::Units;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use trackfail_engine::spec::method::Method;
use trackfail_engine::spec::table::{Side, Table};
use trackfail_engine::spec::{Experiment, Tracker};
use trackfail_engine::store;

/// Most methods that a note names singly.
const MAX_NAMED: usize = 3;

/// Data behind all tables and figures: `12 of 21 targets, 10 runs`. If fewer runs were made than the
/// experiment requests, both numbers are given.
pub fn data_note(experiment: &Experiment, manifest: &Manifest) -> String {
    let mut note = targets_note(manifest.suite.present.len(), manifest.suite.wanted);
    note.push_str(&declared_note(experiment, manifest));
    // The order of trackers may be another one than in the run.
    let record = |t: &Tracker| manifest.trackers.iter().find(|record| record.label == t.label);
    let trackers = || experiment.trackers.iter().filter_map(|t| Some((t, record(t)?)));
    let mut add = |what: &str, done: fn(&TrackerRecord) -> u32, asked: fn(&Tracker) -> u32| {
        let counted: Vec<_> =
            trackers().map(|(t, record)| (t.label.as_str(), done(record), asked(t))).collect();
        note.push_str(&runs_note(&counted, what));
    };
    add("", |r| r.runs, |t| t.runs);
    let learns = experiment.methods.iter().flat_map(|m| &m.variants).any(|v| v.detector.role().is_some());
    if learns || experiment.analyses.iter().any(|a| a.signal.is_some()) {
        add(" to learn from", |r| r.training_runs, |t| t.training_runs);
    }
    let on_others = |m: &&Method| m.variants.iter().any(|v| v.detector.trains_on_others());
    let on_others: Vec<&str> = experiment.methods.iter().filter(on_others).map(|m| m.name.as_str()).collect();
    if !on_others.is_empty() {
        let names = match on_others.as_slice() {
            few if few.len() <= MAX_NAMED => few.join(", "),
            many => format!("{} methods", many.len()),
        };
        note.push_str(&format!("; {names}: learned from other videos and other trackers, see manifest.json"));
    }
    note
}

/// Text like ` (98 of them with a track of MDNet)`, for trackers that are declared to have no track of some
/// present targets.
fn declared_note(experiment: &Experiment, manifest: &Manifest) -> String {
    let here = &manifest.suite.present;
    let declared = experiment.trackers.iter().filter_map(|t| {
        let without =
            t.absent.iter().filter(|absence| here.iter().any(|(name, _)| *name == absence.sequence)).count();
        (without > 0).then(|| format!("{} of them with a track of {}", here.len() - without, t.label))
    });
    let declared: Vec<String> = declared.collect();
    if declared.is_empty() { String::new() } else { format!(" ({})", declared.join(", ")) }
}

/// Text like `, 10 runs`: the number of runs of each tracker, and the requested number if it differs.
/// Trackers with the same number are named together, or not at all if all trackers have it.
fn runs_note(trackers: &[(&str, u32, u32)], what: &str) -> String {
    let several = trackers.iter().filter(|(_, done, asked)| *done > 1 || *asked > 1);
    let note = |(runs, alike): ((u32, u32), Vec<&(&str, _, _)>)| {
        let (done, asked) = runs;
        let of = if done == asked { String::new() } else { format!(" of {asked}") };
        let words = format!("{}{of}{what}", manifest::runs(done));
        match alike.len() {
            1 if trackers.len() == 1 => format!(", {words}"),
            n if n == trackers.len() => format!(", {words} per tracker"),
            _ => {
                let labels: Vec<&str> = alike.iter().map(|(label, ..)| *label).collect();
                format!(", {}: {words}", labels.join(", "))
            }
        }
    };
    grouped(several, |(_, done, asked)| (*done, *asked)).into_iter().map(note).collect()
}

/// Pooled numbers for an experiment's tables: over all sequences and, for tables by attribute, over those
/// with each attribute. `scores` come from [`Results::scores`].
pub fn pooled<'t>(
    results: &Results,
    scores: &[CellScore],
    tables: impl IntoIterator<Item = &'t Table>,
) -> Vec<Measure> {
    let Results { experiment, manifest, .. } = results;
    let mut pooled = results.measures.clone();
    if tables.into_iter().any(by_attribute) {
        let without: Vec<FailedCell> = results.cells_failed().cloned().collect();
        let mut parts = measures::by_attribute(scores, &without, &manifest.suite.attributes);
        parts.iter_mut().for_each(|part| part.pooled.chance = experiment.chance_of(&part.method));
        pooled.append(&mut parts);
    }
    pooled
}

fn by_attribute(table: &Table) -> bool {
    [&table.rows, &table.columns].contains(&&Side::Attribute)
}

/// Tables of the experiment; `scores` come from [`Results::scores`], `units` has the same by sequence.
pub fn layouts(results: &Results, scores: &[CellScore], units: &Units) -> Vec<TableLayout> {
    let Results { experiment, measures, analyses, manifest, .. } = results;
    let note = data_note(experiment, manifest);
    let pooled = pooled(results, scores, &experiment.tables);
    let layout = |t: &Table| match &t.shows {
        Some(shows) => layout::analysed(experiment, t, shows, analyses, &note),
        None if t.ranked.is_some() => leaderboard::leaderboard(experiment, t, measures, units, &note),
        None => {
            let mut layout = layout::layout(experiment, t, &pooled, &note);
            if by_attribute(t) {
                layout.caption.push_str(&attributes_note(&manifest.suite.attributes));
            }
            layout
        }
    };
    experiment.tables.iter().map(layout).collect()
}

/// Sentence on the number of targets with each attribute.
fn attributes_note(attributes: &BTreeMap<String, Vec<String>>) -> String {
    let different: BTreeSet<&String> = attributes.values().flatten().collect();
    let targets = |attribute: &String| attributes.values().filter(|list| list.contains(attribute)).count();
    let words = different.into_iter().map(|attribute| format!("{attribute} {}", targets(attribute)));
    let words: Vec<String> = words.collect();
    if words.is_empty() {
        return " No attributes are known here.".to_string();
    }
    format!(" Targets: {}.", words.join(", "))
}

/// Writes the tables into the folder `tables` of both folders, each as CSV, Parquet, Markdown and LaTeX, and
/// `macros.tex` with all numbers.
///
/// # Errors
/// When a file cannot be written.
pub fn write_tables(
    folders: [&Path; 2],
    experiment: &Experiment,
    facts: &[Fact],
    layouts: &[TableLayout],
) -> Result<(), ResultsError> {
    let mut files: Vec<(String, Vec<u8>)> = Vec::new();
    for layout in layouts {
        let mut add = |ending: &str, bytes| files.push((format!("{}.{ending}", layout.name), bytes));
        add("csv", render::csv(layout)?);
        add("md", render::markdown(layout).into_bytes());
        add("parquet", render::parquet(layout)?);
        add("tex", latex::latex(&experiment.name, layout).into_bytes());
        add("body.tex", latex::body(layout).into_bytes());
        if let Some(counts) = latex::counts(&experiment.name, layout) {
            add("counts.tex", counts.into_bytes());
        }
    }
    if !layouts.is_empty() {
        let commands = macros::macros(&experiment.name, facts, layouts);
        files.push((macros::FILE.to_string(), commands.into_bytes()));
    }
    for folder in folders {
        for (name, bytes) in &files {
            store::write_derived(&folder.join(TABLES).join(name), bytes)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::runs_note;

    #[test]
    fn trackers_with_as_many_runs_are_named_together() {
        let note = |trackers: &[(&str, u32, u32)]| runs_note(trackers, "");
        assert_eq!(note(&[("PF", 1, 1)]), "");
        assert_eq!(note(&[("PF", 10, 10)]), ", 10 runs");
        assert_eq!(note(&[("PF", 1, 10)]), ", 1 run of 10");
        assert_eq!(note(&[("PF", 10, 10), ("FT", 10, 10)]), ", 10 runs per tracker");
        let mixed = note(&[("PF", 3, 3), ("KCF", 1, 1), ("FT", 3, 3), ("ST", 2, 3)]);
        assert_eq!(mixed, ", PF, FT: 3 runs, ST: 2 runs of 3");
        assert_eq!(runs_note(&[("PF", 9, 9)], " to learn from"), ", 9 runs to learn from");
    }
}
