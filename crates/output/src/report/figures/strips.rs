//! `strips`: series over the frames of sequences, below video frames.

use super::drawer::{DrawError, Drawer, Drawing, Scope};
use super::panels::panel;
use crate::figure::{BoxStyle, LOST, Panel, Still, Strip};
use crate::report::stills;
use crate::results::{Results, ResultsError, TrackSeries};
use trackfail_core::region::Region;
use trackfail_engine::spec::figure::{self, Figure};
use trackfail_methods::signal::distribution_field::{self, Displacement};

/// The entry of this kind.
pub const DRAWER: Drawer = Drawer { word: "strips", shows_tracks: true, draw };

fn draw(scope: &Scope<'_>) -> Result<Drawing, DrawError> {
    let (results, params) = (scope.results, scope.params());
    let tracker = stills::tracker(results, params.tracker.as_deref());
    let tracks: Vec<&TrackSeries> = scope.tracks.iter().filter(|t| t.tracker == tracker).collect();
    let shown = stills::chosen(results, &params.sequences, &tracks);
    if shown.is_empty() {
        return Ok(Drawing::NoData(format!("none of its sequences is there with tracker {tracker}")));
    }
    let is_absent = |name: &&String| !shown.iter().any(|t| t.sequence == **name);
    let absent: Vec<&str> = params.sequences.iter().filter(is_absent).map(String::as_str).collect();
    let shown = results.with_signals(tracker, &shown)?;
    let mut strip = strip(results, &scope.note, tracker, &shown, &params.panels);
    strip.stills = load_stills(results, scope.figure, &tracks)?;
    let remark = match absent.as_slice() {
        [] => String::new(),
        names => format!(" Not here: {}.", names.join(", ")),
    };
    Ok(Drawing::Plot { plot: Box::new(strip), remark })
}

fn strip(
    results: &Results,
    note: &str,
    tracker: &str,
    shown: &[TrackSeries],
    panels: &[Vec<figure::Panel>],
) -> Strip {
    let single = shown.len() == 1;
    let mut strip = Strip {
        title: String::new(),
        note: format!("{tracker}, {note}"),
        stills: Vec::new(),
        headings: Vec::new(),
        rows: Vec::new(),
        shaded: LOST,
    };
    if single {
        strip.title = shown[0].sequence.clone();
        let mut letter = 'a';
        for row in panels {
            let mut drawn: Vec<Panel> = row.iter().map(|p| panel(results, tracker, &shown[0], p)).collect();
            for p in &mut drawn {
                p.caption = format!("({letter})");
                letter = char::from_u32(letter as u32 + 1).unwrap_or('z');
            }
            strip.rows.push(drawn);
        }
    } else {
        // A column a sequence, all panels below each other.
        strip.headings = shown.iter().map(|t| t.sequence.clone()).collect();
        for kind in panels.iter().flatten() {
            strip.rows.push(shown.iter().map(|t| panel(results, tracker, t, kind)).collect());
        }
    }
    strip
}

fn load_stills(
    results: &Results,
    figure: &Figure,
    tracks: &[&TrackSeries],
) -> Result<Vec<Still>, ResultsError> {
    let Some(request) = stills::request(results, figure, tracks) else { return Ok(Vec::new()) };
    let Some(track) = tracks.iter().find(|t| t.sequence == request.sequence) else { return Ok(Vec::new()) };
    let truth = results.truth()?;
    let truth = truth.get(&track.sequence);
    // The region around the target that a distribution field is compared with.
    let signals =
        results.experiment.methods.iter().flat_map(|m| &m.variants).filter_map(|v| v.signal.as_ref());
    let has_background = signals.into_iter().any(|s| s.kind == distribution_field::ENTRY.kind);
    let mut all = Vec::new();
    for t in request.frames {
        // Results of a run that could not decode the frame again have no still; the rest is shown.
        let Ok(pixels) = results.still(&request.figure, t) else { continue };
        let number = track.numbers[t];
        let (past, current) = (&track.rects[..t], &track.rects[t]);
        let history = distribution_field::Params::default().history;
        let background = distribution_field::background_region(past, current, history, Displacement::Past);
        let mut boxes = vec![(Region::Rect(track.rects[t]), BoxStyle::State)];
        if has_background {
            boxes.insert(0, (Region::Rect(background), BoxStyle::Background));
        }
        if let Some(region) = truth.and_then(|truth| truth.get(&number)) {
            boxes.push((region.clone(), BoxStyle::Truth));
        }
        let caption = if track.error[t] >= 1.0 { "lost".to_string() } else { String::new() };
        all.push(Still { number: u32::try_from(number).unwrap_or(0), pixels, boxes, caption });
    }
    Ok(all)
}
