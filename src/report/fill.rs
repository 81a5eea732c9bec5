//! Fills the page from a results folder and writes the report.

use super::claims::{self, Finding, Tested};
use super::figures::{self, DrawError};
use super::results::{Results, ResultsError};
use super::uncertainty::{self, Uncertainty};
use super::{ClaimView, FailedCell, FigureView, Page, ReportError, Verdict, markdown, render};
use crate::engine::store::{self, StoreError};
use crate::figure::Ranks;
use crate::spec::claim;
use crate::spec::table::Figure;
use crate::table::folder::{self, FolderError};
use crate::table::layout;
use std::path::Path;

/// A report that could not be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The results cannot be read.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// A table cannot be written.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// A figure cannot be drawn.
    #[error(transparent)]
    Draw(#[from] DrawError),
    /// The page cannot be rendered.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// A file cannot be written.
    #[error(transparent)]
    Store(#[from] StoreError),
}

/// The page, which says that a report folder is whole.
pub const INDEX: &str = "index.html";
/// The folder in a report folder in which nothing else lies.
pub const OWNED: [&str; 1] = ["figures"];

/// A verdict in words.
pub fn verdict_words(verdict: &claim::Verdict) -> &'static str {
    view(verdict).words()
}

fn view(verdict: &claim::Verdict) -> Verdict {
    match verdict {
        claim::Verdict::Holds => Verdict::Holds,
        claim::Verdict::Fails => Verdict::DoesNotHold,
        claim::Verdict::Untestable(_) => Verdict::CannotBeTested,
    }
}

/// Writes tables into the results folder, and figures, `index.html` and `report.md` into an empty folder,
/// from results alone; what our numbers say of the claims.
///
/// # Errors
/// See [`WriteError`].
pub fn write(results: &Results, folder: &Path) -> Result<Vec<Finding>, WriteError> {
    let mut layouts = results.layouts()?;
    let Uncertainty { tables, ranks, note } = uncertainty::measure(results)?;
    layouts.extend(tables);
    stays_here(&results.folder.join("tables"))?;
    folder::write_tables(&results.folder, &results.experiment, &layouts)?;
    let mut page = frame(results);
    let drawn: Vec<_> = results.experiment.figures.iter().map(|f| figures::draw(results, f)).collect();
    for (figure, drawn) in results.experiment.figures.iter().zip(drawn) {
        match drawn? {
            Ok(drawn) => {
                let file = |ending: &str| format!("figures/{}.{ending}", figure.name);
                store::write(&folder.join(file("svg")), drawn.svg.as_bytes())?;
                store::write(&folder.join(file("png")), &drawn.png)?;
                page.figures.push(FigureView {
                    name: drawn.name,
                    caption: drawn.caption,
                    svg: drawn.svg,
                    file: file("svg"),
                });
            }
            Err(reason) => page.warnings.push(not_drawn(figure, &reason)),
        }
    }
    if let Some((ranks, caption)) = ranks {
        page.figures.push(draw_ranks(results, folder, &ranks, caption)?);
    }
    page.summary.extend(note);
    let findings = claims::test(results);
    page.claims = findings.iter().map(claim_view).collect();
    page.tables = layouts;
    store::write(&folder.join(INDEX), render(&page)?.as_bytes())?;
    store::write(&folder.join("report.md"), markdown(&page)?.as_bytes())?;
    Ok(findings)
}

/// Draws mean ranks beside the experiment's own figures.
fn draw_ranks(
    results: &Results,
    folder: &Path,
    ranks: &Ranks,
    caption: String,
) -> Result<FigureView, WriteError> {
    let mut name = "ranks".to_string();
    while results.experiment.figures.iter().any(|f| f.name == name) {
        name.push('_');
    }
    let fail = |error| DrawError::Figure { name: name.clone(), error };
    let (svg, png) = (ranks.to_svg().map_err(fail)?, ranks.to_png().map_err(fail)?);
    let file = |ending: &str| format!("figures/{name}.{ending}");
    store::write(&folder.join(file("svg")), svg.as_bytes())?;
    store::write(&folder.join(file("png")), &png)?;
    Ok(FigureView { file: file("svg"), name, caption, svg })
}

/// Results of others are read, links and all; but nothing is written where a link of theirs leads. (Files
/// are replaced by renaming, which replaces a link itself.)
fn stays_here(folder: &Path) -> Result<(), StoreError> {
    if folder.is_symlink() {
        let message = "a link, through which no table is written; put a folder in its place";
        return Err(StoreError::new(folder, message));
    }
    Ok(())
}

fn not_drawn(figure: &Figure, reason: &str) -> String {
    format!("Figure {} is not drawn: {reason}.", figure.name)
}

fn claim_view(finding: &Finding) -> ClaimView {
    let count = |verdict| finding.tested.iter().filter(|t| view(&t.verdict) == verdict).count();
    let (holds, fails) = (count(Verdict::Holds), count(Verdict::DoesNotHold));
    let verdict = match (holds, fails) {
        (_, 1..) => Verdict::DoesNotHold,
        (n, 0) if n == finding.tested.len() => Verdict::Holds,
        _ => Verdict::CannotBeTested,
    };
    let headline = if finding.tested.len() > 1 {
        format!("holds for {holds} of {} trackers", finding.tested.len())
    } else {
        verdict.words().to_string()
    };
    let detail = |Tested { tracker, verdict, numbers }: &Tested| {
        let shown = match verdict {
            claim::Verdict::Untestable(reason) => reason.clone(),
            _ => {
                let numbers = numbers.iter().map(|(name, value)| match value {
                    Some(v) => format!("{name} = {v:.4}"),
                    None => format!("{name} has no value"),
                });
                numbers.collect::<Vec<_>>().join(", ")
            }
        };
        let who = if tracker.is_empty() { String::new() } else { format!("{tracker}: ") };
        format!("{who}{}: {shown}", view(verdict).words())
    };
    ClaimView {
        text: finding.text.clone(),
        verdict,
        headline,
        predicate: finding.predicate.clone(),
        details: finding.tested.iter().map(detail).collect(),
    }
}

/// The page without tables, figures and claims.
fn frame(results: &Results) -> Page {
    let (experiment, manifest) = (&results.experiment, &results.manifest);
    let suite = &manifest.suite;
    let mut data_note = format!(
        "suite {}, {} ({} frames)",
        suite.name,
        folder::data_note(experiment, manifest),
        suite.present.iter().map(|(_, frames)| frames).sum::<usize>()
    );
    if !suite.missing.is_empty() {
        data_note.push_str(&format!("; missing: {}", suite.missing.join(", ")));
    }
    let mut warnings = Vec::new();
    if !suite.missing.is_empty() {
        warnings.push(format!(
            "Only {} of the suite are here; every number below rests on these.",
            layout::data_note(suite.present.len(), suite.wanted)
        ));
    }
    if !manifest.differing.is_empty() {
        let names = manifest.differing.join(", ");
        warnings.push(format!("Not the data that datasets.lock pins: {names}."));
    }
    for method in &manifest.methods {
        if let Some((parameter, trained_on)) = &method.trained
            && *trained_on == suite.name
        {
            let warning = format!("{}: `{parameter}` was tuned on the test suite itself.", method.name);
            if !warnings.contains(&warning) {
                warnings.push(warning);
            }
        }
    }
    for (rule, count) in &manifest.rules {
        warnings.push(format!("{rule}: {count} times."));
    }
    let failed = manifest.cells_failed.iter().map(|c| FailedCell {
        cell: format!("{}, {}, run {}, {}", c.sequence, c.tracker, c.run, c.method),
        reason: c.reason.clone(),
    });
    Page {
        title: experiment.title.clone(),
        experiment: experiment.name.clone(),
        paper: experiment.paper.clone().unwrap_or_default(),
        object: experiment.object.clone().unwrap_or_default(),
        data_note,
        warnings,
        summary: experiment.note.iter().cloned().collect(),
        failed: failed.collect(),
        provenance: provenance(results),
        ..Page::default()
    }
}

/// The experiment's protocol, and those of methods that have one of their own.
fn protocols(results: &Results) -> String {
    let mut text = results.manifest.protocol.clone();
    let own = results.experiment.methods.iter().filter(|m| m.protocol.name != results.manifest.protocol);
    for method in own {
        text.push_str(&format!("; {} for {}", method.protocol.name, method.name));
    }
    text
}

fn provenance(results: &Results) -> Vec<(String, String)> {
    let manifest = &results.manifest;
    let mut all = vec![
        ("experiment file, SHA-256".to_string(), manifest.spec_digest.clone()),
        ("protocol".to_string(), protocols(results)),
        ("seed".to_string(), manifest.seed.to_string()),
        ("trackfail".to_string(), manifest.version.clone()),
    ];
    for t in &manifest.trackers {
        let runs = format!("runs {}, {} to learn from", t.runs, t.training_runs);
        let value = format!("{} version {}, {}, {runs}", t.kind, t.version, t.params);
        all.push((format!("tracker {}", t.label), value));
    }
    // Every combination of a grid would fill pages; its first stands for the parameters they share.
    let mut named: Vec<&str> = Vec::new();
    for m in &manifest.methods {
        if named.contains(&m.name.as_str()) {
            continue;
        }
        named.push(&m.name);
        let part = |(kind, version, params): &(String, u32, serde_json::Value)| {
            format!("{kind} version {version} {params}")
        };
        let mut value = m.signal.as_ref().map_or(String::new(), |s| format!("signal {}; ", part(s)));
        value.push_str(&format!("detector {}", part(&m.detector)));
        if !m.params.is_empty() {
            value.push_str(&format!(" (first of the grid: {})", m.params));
        }
        if let Some((key, suite)) = &m.trained {
            let values: Vec<String> =
                m.thresholds.iter().map(|(tracker, v)| format!("{v} for {tracker}")).collect();
            value.push_str(&format!("; `{key}` trained on {suite}: {}", values.join(", ")));
        }
        all.push((format!("method {}", m.name), value));
    }
    for (name, text) in &manifest.models {
        all.push((format!("learned by {name}"), text.clone()));
    }
    for (suite, sequences) in &manifest.digests {
        for (name, digest) in sequences {
            all.push((format!("{suite}/{name}"), digest.clone()));
        }
    }
    all
}
