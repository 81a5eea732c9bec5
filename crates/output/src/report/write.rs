//! Fills the page of a report from a results folder, and writes the report.

use super::claims::{self, Finding};
use super::colors;
use super::explain;
use super::figures::{self, Captioned};
use super::glance::{self, HEADLINE};
use super::page::{FigureView, Page, ReportError, markdown, render};
use super::paper::{self, Item};
use super::readings;
use super::sentences::say;
use super::sequences::{self, Sequences, json};
use super::site;
use super::sources;
use super::standings::{self, Uncertainty};
use super::stills;
use crate::figure::Files;
use crate::results::{Manifest, Results, to_json, unfinished};
use crate::sampling::Units;
use crate::table;
use crate::table::build::{of_suite, suite};
use crate::table::layout::TableLayout;
use crate::table::suites::targets_note;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use trackfail_core::image;
use trackfail_engine::store::staging::{self, Staging};
use trackfail_engine::store::{self, StoreError};

/// Name of the page. A report folder with this file is complete.
pub const INDEX: &str = "index.html";
/// Folders in a report folder that contain only parts of the report.
pub const OWNED: [&str; 4] = ["tables", "figures", "data", "stills"];
/// Name of the report as Markdown.
pub const MARKDOWN: &str = "report.md";
/// Name of the report's summary.
pub const SUMMARY: &str = "summary.json";

/// Contents of a report that was written.
pub struct WrittenReport {
    /// Claims with their outcomes.
    pub findings: Vec<Finding>,
    /// Table that answers the report's question: that of ranked methods, of differences or of readings, or
    /// else the first one.
    pub answer: Option<TableLayout>,
    /// Answer of the page in one sentence; may be empty.
    pub verdict: String,
    /// Tables and figures of the report.
    pub items: Vec<Item>,
}

/// Largest page with embedded series, in bytes. Larger ones have their series in files beside them.
const MAX_PAGE: usize = 5 << 20;

/// A report in a temporary folder beside its final place.
pub struct StagedReport {
    name: String,
    aside: Staging,
    written: WrittenReport,
}

impl StagedReport {
    /// Renders a report into a temporary folder, and its tables beside the results.
    ///
    /// # Errors
    /// See [`ReportError`].
    pub fn render(results: &Results, reports: &Path) -> Result<Self, ReportError> {
        staging::sweep(reports);
        let aside = Staging::new(reports)?;
        let written = write(results, aside.path())?;
        Ok(Self { name: results.experiment.name.clone(), aside, written })
    }

    /// Moves the report to its final place below `reports`. Returns the path of its page, and its contents.
    ///
    /// # Errors
    /// When the folder cannot be replaced.
    pub fn publish(self, reports: &Path) -> Result<(PathBuf, WrittenReport), ReportError> {
        let target = reports.join(&self.name);
        self.aside.publish(&target, INDEX, &OWNED)?;
        Ok((target.join(INDEX), self.written))
    }
}

/// Writes a report from results alone: tables into the results folder; figures, stills, series, `index.html`,
/// `report.md` and `summary.json` into an empty folder.
///
/// # Errors
/// See [`ReportError`].
pub fn write(results: &Results, folder: &Path) -> Result<WrittenReport, ReportError> {
    let experiment = &results.experiment;
    let scores = results.scores()?;
    let units = Units::new(experiment, &scores);
    // All trackers together come first: that is what a leaderboard is asked for.
    let pairs = results.frame_pairs()?;
    let by_frames = standings::of_frames(results, &pairs);
    let of_frames = by_frames.as_ref().map(|of| standings::differences(of, results, &pairs));
    let mut layouts: Vec<TableLayout> = of_frames.into_iter().chain(standings::breakdown(results)).collect();
    let of_readings = results.readings()?;
    let mut of_experiment =
        [readings::tables(results, &of_readings), table::layouts(results, &scores, &units)];
    // Readings are the answer where most methods are readings, else they stand behind the tables that they are about.
    let readings_first = readings::are_the_answer(experiment);
    if !readings_first {
        of_experiment.reverse();
    }
    layouts.extend(of_experiment.into_iter().flatten());
    let Uncertainty { tables, ranks, note, first } = standings::uncertainty(results, &units);
    layouts.extend(tables);
    // A foreign results folder may contain links, which are followed only for reading. (Files are replaced by
    // renaming, which replaces the link itself.)
    let place = results.folder.join("tables");
    if place.is_symlink() {
        let message = "a link, through which no table is written; put a folder in its place";
        return Err(StoreError::new(&place, message).into());
    }
    let mut page = page_frame(results);
    page.claims = claims::test(results, &units);
    let facts = sources::facts(results, &page.claims);
    let by_frames = by_frames.as_ref();
    page.verdict = by_frames
        .and_then(standings::frames_verdict)
        .or_else(|| readings::verdict(&of_readings).filter(|_| readings_first))
        .or(first.as_ref().and_then(|(of, _)| standings::verdict(of)))
        .or_else(|| claims::verdict(&page.claims))
        .into_iter()
        .collect();
    // Beside the page too: it offers them, wherever the results are.
    table::write_tables([&results.folder, folder], experiment, &facts, &layouts)?;
    page.downloads = true;
    // Where no figure shows tracks, they are never in memory all at once.
    let shown = figures::show_tracks(&experiment.figures);
    let tracks = if shown { results.all_tracks()? } else { Vec::new() };
    let make = |figure| figures::make(results, &tracks, &units, figure);
    let made: Vec<_> = experiment.figures.par_iter().map(make).collect();
    let mut shown_figures: Vec<Captioned> = Vec::new();
    for (figure, made) in experiment.figures.iter().zip(made) {
        match made {
            Ok(made) => shown_figures.push(made),
            Err(ReportError::NoData(reason)) => {
                page.warnings.push(format!("Figure {} is not drawn: {reason}.", figure.name));
            }
            Err(e) => return Err(e),
        }
    }
    let of_readings = readings::figures(&of_readings, |method| colors::color(experiment, method));
    let is_about_readings = readings_first && !of_readings.is_empty();
    let of_frames = by_frames.and_then(|of| standings::dots(of, experiment, &suite(results)));
    let dots = || first.as_ref().and_then(|(of, suite)| standings::dots(of, experiment, suite));
    let headline = of_frames.or_else(dots).filter(|_| !is_about_readings);
    let headline = headline.map(|(dots, caption)| (HEADLINE.to_string(), dots, caption));
    let own = of_readings.into_iter().chain(headline);
    let own = own.map(|(name, dots, caption)| Captioned::new(name, dots.figure(), caption)).chain(ranks);
    for mut own in own {
        let is_taken = |name: &String| {
            experiment.figures.iter().any(|f| f.name == *name)
                || shown_figures.iter().any(|f| f.name == *name)
        };
        while is_taken(&own.name) {
            own.name.push('_');
        }
        shown_figures.push(own);
    }
    let kept: Vec<_> = shown_figures.par_iter().map(|figure| keep_figure(folder, figure)).collect();
    page.figures = kept.into_iter().collect::<Result<_, _>>()?;
    // Differences and readings have a verdict of their own, and their tables stand first.
    let counted = standings::ordering_metric(experiment);
    let metric = if pairs.is_empty() { Some(counted) } else { standings::frames_metric() };
    let best = first.as_ref().map_or_else(Vec::new, |(of, _)| standings::best_names(of));
    glance::figure_first(&mut page.figures, experiment, (metric, &best), is_about_readings);
    // The others are looked at more closely; a second picture of each would double what a page has to carry.
    page.figures.iter_mut().skip(1).for_each(|figure| figure.narrow.clear());
    page.summary.extend(note);
    let requests = stills::requested(results, &tracks);
    let mut sequences = sequences::collect(results, shown.then_some(tracks))?;
    for request in &requests {
        keep_stills(results, folder, request, &mut sequences)?;
    }
    page.sequences = sequences.tallies();
    explain::link(results, &mut layouts, &sequences.trackers, &page.sequences);
    page.links = !experiment.tables.is_empty();
    page.tables = layouts;
    let methods_first = pairs.is_empty() && !readings_first;
    let ranked = first.map(|(of, suite)| of_suite(standings::ranked(&of), results, &suite));
    let answer = ranked.as_ref().filter(|ranked| methods_first && !ranked.groups.is_empty());
    let answer = answer.or(page.tables.first()).cloned();
    if methods_first {
        glance::table_first(&mut page, experiment, counted, (ranked, &best));
    }
    let html = small_enough(&mut page, folder, &sequences, MAX_PAGE)?;
    store::write_derived(&folder.join(INDEX), html.as_bytes())?;
    store::write_derived(&folder.join(MARKDOWN), markdown(&page)?.as_bytes())?;
    let (summary, path) = (site::summary(results, &units, &page), folder.join(SUMMARY));
    store::write_derived(&path, &to_json(&path, &summary)?)?;
    let items = paper::items(&page);
    Ok(WrittenReport { answer, items, verdict: summary.verdict, findings: page.claims })
}

/// Writes a figure as SVG, PNG and PDF, also at the width of a column if it is wider. Returns the figure for
/// the page.
fn keep_figure(folder: &Path, figure: &Captioned) -> Result<FigureView, ReportError> {
    let Files { svg, narrow, narrow_pdf, png, pdf } = figure.draw()?;
    let (name, caption) = (figure.name.clone(), figure.caption.clone());
    let path = |ending: &str| format!("figures/{name}.{ending}");
    let mut files: Vec<(&'static str, &[u8])> = vec![("svg", svg.as_bytes()), ("pdf", &pdf), ("png", &png)];
    if !narrow.is_empty() && narrow != svg {
        files.extend([("column.svg", narrow.as_bytes()), ("column.pdf", narrow_pdf.as_slice())]);
    }
    for (ending, bytes) in &files {
        store::write_derived(&folder.join(path(ending)), bytes)?;
    }
    let endings = files.iter().map(|(ending, _)| *ending).collect();
    let (file, is_wide) = (path("svg"), narrow != svg);
    Ok(FigureView { file, endings, is_wide, name, caption, svg, narrow })
}

/// Copies the stills of a figure for the frame viewer.
fn keep_stills(
    results: &Results,
    folder: &Path,
    request: &stills::StillRequest,
    sequences: &mut Sequences,
) -> Result<(), ReportError> {
    let mut all = sequences.sequences.iter_mut().enumerate();
    let Some((s, sequence)) = all.find(|(_, s)| s.name == request.sequence) else { return Ok(()) };
    for &t in &request.frames {
        // A run that could not decode the frame again has written no still.
        if !sequence.stills.contains(&t)
            && let Ok(pixels) = results.still(&request.figure, t)
        {
            let path = folder.join(format!("stills/{s:03}-{t:06}.png"));
            let png = image::encode_png(&pixels).map_err(|e| StoreError::new(&path, e))?;
            store::write_derived(&path, &png)?;
            sequence.stills.insert(t);
        }
    }
    Ok(())
}

/// Renders the page with at most about `most` bytes. If the page is too large, three things are tried in
/// turn: series go into files beside it, figures are loaded from their files, and the origins of the numbers
/// are left out.
pub(super) fn small_enough(
    page: &mut Page,
    folder: &Path,
    sequences: &Sequences,
    most: usize,
) -> Result<String, ReportError> {
    let drawn: usize = page.figures.iter().map(|f| f.svg.len() + f.narrow.len()).sum();
    page.beside = sequences.sequences.iter().any(|s| !s.stills.is_empty());
    if let Some(series) = json::embedded(sequences, most.saturating_sub(drawn)) {
        page.series = series;
        let html = render(page)?;
        if html.len() <= most {
            return Ok(html);
        }
    }
    page.beside = true;
    if !page.sequences.rows.is_empty() {
        let keep = |name: &str, text: &str| store::write_derived(&folder.join(name), text.as_bytes());
        let (index, files) = json::beside(sequences, keep)?;
        page.series = index;
        page.sequences.note.push_str(&say("series", serde_json::json!({ "files": files })));
    }
    page.figures_beside = page.series.len() + drawn > most;
    let mut html = render(page)?;
    let smaller: [fn(&mut Page); 2] = [|page| page.figures_beside = true, |page| page.links = false];
    for make in smaller {
        if html.len() > most {
            make(page);
            html = render(page)?;
        }
    }
    Ok(html)
}

/// Page without tables, figures and claims.
fn page_frame(results: &Results) -> Page {
    let (experiment, manifest) = (&results.experiment, &results.manifest);
    let suite = &manifest.suite;
    let frames: usize = suite.present.iter().map(|(_, frames)| frames).sum();
    let data = table::data_note(experiment, manifest);
    let data = serde_json::json!({
        "suite": suite.name, "data": data, "frames": frames, "missing": suite.missing
    });
    let failed = |group: unfinished::Unfinished| {
        let why = if group.missing { "not there" } else { "failed" };
        (group.cells, format!("{why}: {}", group.reason))
    };
    Page {
        title: experiment.title.clone(),
        home: format!("{}index.html", "../".repeat(experiment.name.split('/').count())),
        experiment: experiment.name.clone(),
        paper: experiment.paper.clone().unwrap_or_default(),
        object: experiment.object.clone().unwrap_or_default(),
        data_note: say("data", data),
        warnings: warnings(manifest),
        summary: experiment.note.iter().chain(results.beside.iter().map(|b| &b.note)).cloned().collect(),
        failed: unfinished::groups(&manifest.cells_failed).into_iter().map(failed).collect(),
        provenance: sources::provenance(results),
        // The experiment's file, protocol, seed and version, what stands beside it, and the suites.
        provenance_head: 4 + usize::from(results.beside.is_some()) + manifest.digests.len(),
        ..Page::default()
    }
}

/// Warnings that readers need before they trust a number.
fn warnings(manifest: &Manifest) -> Vec<String> {
    let suite = &manifest.suite;
    let mut warnings = Vec::new();
    if !suite.missing.is_empty() {
        warnings.push(format!(
            "Only {} of the suite are here; every number below rests on these.",
            targets_note(suite.present.len(), suite.wanted)
        ));
    }
    if !manifest.differing.is_empty() {
        let names = manifest.differing.join(", ");
        warnings.push(format!("Not the data that datasets.lock pins: {names}."));
    }
    let on_test = manifest.methods.iter().filter_map(|method| {
        let (parameter, _) = method.trained.as_ref().filter(|(_, on)| *on == suite.name)?;
        Some(format!("{}: parameter {parameter} was tuned on the test suite itself.", method.name))
    });
    warnings.extend(on_test);
    // The points of a grid are of one method, and stand together.
    warnings.dedup();
    warnings.extend(sources::learned_on_test(manifest));
    warnings.extend(unfinished::not_run(&manifest.not_run).into_iter().map(|line| line + "."));
    warnings.extend(manifest.rules.iter().map(|(rule, count)| format!("{rule}: {count} times.")));
    warnings
}
