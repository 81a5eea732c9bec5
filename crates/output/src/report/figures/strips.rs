//! `strips`: series over the frames of sequences, below video frames.

mod panels;

use super::Scope;
use crate::figure::{BoxStyle, Color, Entry, Figure, Form, Mark, Marker, Panel, Still, Symbol, box_legend};
use crate::report::page::ReportError;
use crate::report::stills;
use crate::results::{ResultsError, TrackSeries};
use panels::{LOSS, RECOVERY, panel};
use trackfail_core::region::Region;
use trackfail_engine::spec::figure as spec;
use trackfail_methods::signal::distribution_field::{self, Displacement};

/// Draws the figure. With stills and one row of panels the layout is that of Fig. 3 of Khalid, Cavallaro and
/// Rinner (BMVC 2016); with one column per sequence, of their Fig. 4; with two panels per row, of their Fig.
/// 5.
pub(super) fn draw(scope: &Scope<'_>) -> Result<(Figure, String), ReportError> {
    let (results, params) = (scope.results, &scope.figure.params);
    let tracker = stills::tracker(results, params.tracker.as_deref());
    let tracks: Vec<&TrackSeries> = scope.tracks.iter().filter(|t| t.tracker == tracker).collect();
    let shown = stills::chosen(results, &params.sequences, &tracks);
    if shown.is_empty() {
        return Err(ReportError::NoData(format!("none of its sequences is there with tracker {tracker}")));
    }
    let is_absent = |name: &&String| !shown.iter().any(|t| t.sequence == **name);
    let absent: Vec<&str> = params.sequences.iter().filter(is_absent).map(String::as_str).collect();
    let shown = results.with_signals(&shown)?;
    let mut figure = Figure {
        note: format!("{tracker}, {}", scope.note),
        stills: load_stills(scope, &tracks)?,
        form: Form::Strip,
        ..Figure::default()
    };
    if let [track] = shown.as_slice() {
        figure.title = track.sequence.clone();
        let mut letters = 'a'..='z';
        for row in &params.panels {
            let mut titled = |kind: &spec::Panel| {
                let title = format!("({})", letters.next().unwrap_or('z'));
                Panel { title, ..panel(results, track, kind) }
            };
            figure.rows.push(row.iter().map(&mut titled).collect());
        }
    } else {
        // A column a sequence, all panels below each other.
        for (k, kind) in params.panels.iter().flatten().enumerate() {
            let titled = |track: &TrackSeries| {
                let title = if k == 0 { track.sequence.clone() } else { String::new() };
                Panel { title, ..panel(results, track, kind) }
            };
            figure.rows.push(shown.iter().map(titled).collect());
        }
    }
    figure.legend = key(&figure);
    let absent = if absent.is_empty() { String::new() } else { format!(" Not here: {}.", absent.join(", ")) };
    Ok((figure, absent))
}

/// Legend of the marks that have the same meaning in all panels.
fn key(figure: &Figure) -> Vec<Entry> {
    let marks = || figure.rows.iter().flatten().flat_map(|panel| &panel.marks);
    let mut legend = box_legend(&figure.stills);
    if marks().any(|mark| matches!(mark, Mark::Shade(_))) {
        legend.push(Entry::new(Symbol::Shade, "target lost (Oₜ = 1)"));
    }
    for (style, name) in [(LOSS, "loss"), (RECOVERY, "recovery")] {
        if marks().any(|mark| matches!(mark, Mark::Upright(_, drawn) if *drawn == style)) {
            legend.push(Entry::new(Symbol::Upright(style), name));
        }
    }
    let alarm = |mark: &Mark| match mark {
        Mark::Top(_, marker, color) => Some((*marker, *color)),
        _ => None,
    };
    let alarms: Vec<(Marker, Color)> = marks().filter_map(alarm).collect();
    // Triangles of several methods have the colors of their lines.
    let only = alarms.first().map(|first| first.1).filter(|color| alarms.iter().all(|a| a.1 == *color));
    for (marker, name) in [(Marker::AlarmBegins, "alarm begins"), (Marker::AlarmEnds, "alarm ends")] {
        if alarms.iter().any(|a| a.0 == marker) {
            legend.push(Entry::new(Symbol::Mark(only.unwrap_or(Color::GRAY), marker), name));
        }
    }
    legend
}

fn load_stills(scope: &Scope<'_>, tracks: &[&TrackSeries]) -> Result<Vec<Still>, ResultsError> {
    let results = scope.results;
    let Some(request) = stills::request(results, scope.figure, scope.tracks) else { return Ok(Vec::new()) };
    let Some(track) = tracks.iter().find(|t| t.sequence == request.sequence) else { return Ok(Vec::new()) };
    let truth = results.truth()?;
    let truth = truth.get(&track.sequence);
    // The region around the target that a distribution field is compared with.
    let signals =
        results.experiment.methods.iter().flat_map(|m| &m.variants).filter_map(|v| v.signals.first());
    let has_background = signals.into_iter().any(|s| s.kind == distribution_field::ENTRY.kind);
    let mut all = Vec::new();
    for t in request.frames {
        // Results of a run that could not decode the frame again have no still; the rest is shown.
        let Ok(pixels) = results.still(&request.figure, t) else { continue };
        let number = track.numbers[t];
        let (past, current) = (&track.rects[..t], &track.rects[t]);
        let history = distribution_field::Params::default().history;
        let background = distribution_field::background_region(past, current, history, Displacement::Past);
        let mut boxes = vec![(Region::Rect(track.rects[t]), BoxStyle::STATE)];
        if has_background {
            boxes.insert(0, (Region::Rect(background), BoxStyle::BACKGROUND));
        }
        if let Some(region) = truth.and_then(|truth| truth.get(&number)) {
            boxes.push((region.clone(), BoxStyle::TRUTH));
        }
        let caption = if track.error[t] >= 1.0 { "lost".to_string() } else { String::new() };
        all.push(Still { number: u32::try_from(number).unwrap_or(0), pixels, boxes, caption });
    }
    Ok(all)
}
