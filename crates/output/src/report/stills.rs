//! Video frames that figures show. Their pictures are kept beside the results.

use crate::results::{Results, ResultsError, TrackSeries};
use trackfail_engine::spec::figure::Figure;
use trackfail_methods::score::PROTOCOLS;

/// Frames of one sequence that a figure shows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StillRequest {
    /// Name of the figure.
    pub figure: String,
    /// Name of the sequence.
    pub sequence: String,
    /// Frame indices, 0-based, ascending.
    pub frames: Vec<usize>,
}

/// Frames before and after the first tracking error from which stills are picked.
const AROUND: usize = 30;

/// Tracker of a strip figure: the requested one, or the experiment's first.
pub fn tracker<'a>(results: &'a Results, wanted: Option<&'a str>) -> &'a str {
    wanted.or(results.experiment.trackers.first().map(|t| t.label.as_str())).unwrap_or_default()
}

/// Tracks of a strip figure: those of the requested sequences, or the one with most events (the first by name
/// among equals).
pub fn chosen<'a>(results: &Results, wanted: &[String], tracks: &[&'a TrackSeries]) -> Vec<&'a TrackSeries> {
    if wanted.is_empty() {
        // `max_by_key` takes the last of equal ones.
        let most = tracks.iter().rev().max_by_key(|track| events(results, track).len());
        return most.copied().into_iter().collect();
    }
    wanted.iter().filter_map(|name| tracks.iter().find(|t| t.sequence == *name).copied()).collect()
}

/// Frames in which the tracker failed, by the experiment's protocol.
pub fn events(results: &Results, track: &TrackSeries) -> Vec<usize> {
    // An experiment without detections has no protocol; the first one defines its failures.
    let protocol = results.experiment.protocol.unwrap_or(&PROTOCOLS[0]);
    track.judge(protocol, &[], &[]).events
}

/// Picks `count` frames around the first tracking error, or spread over a sequence without one.
fn pick(length: usize, first_event: Option<usize>, count: usize) -> Vec<usize> {
    let last = length.saturating_sub(1);
    let (from, to) = match first_event {
        Some(e) => (e.saturating_sub(AROUND), (e + AROUND).min(last)),
        None => (0, last),
    };
    let step = |i: usize| from + (to - from) * i / (count - 1).max(1);
    let mut frames: Vec<usize> = (0..count).map(step).collect();
    if let Some(e) = first_event
        && let Some(nearest) = frames.iter_mut().rev().min_by_key(|f| f.abs_diff(e))
    {
        *nearest = e;
    }
    frames.dedup();
    frames
}

/// Stills of one figure; `None` if it shows none or has no track.
pub fn request(results: &Results, figure: &Figure, tracks: &[TrackSeries]) -> Option<StillRequest> {
    let stills = Some(figure.params.stills).filter(|stills| *stills > 0)?;
    let label = tracker(results, figure.params.tracker.as_deref());
    let mine: Vec<&TrackSeries> = tracks.iter().filter(|t| t.tracker == label).collect();
    let track = *chosen(results, &figure.params.sequences, &mine).first()?;
    let frames = pick(track.error.len(), events(results, track).first().copied(), stills);
    Some(StillRequest { figure: figure.name.clone(), sequence: track.sequence.clone(), frames })
}

/// Stills of all figures of an experiment, from the tracks of [`Results::all_tracks`].
pub fn requested(results: &Results, tracks: &[TrackSeries]) -> Vec<StillRequest> {
    results.experiment.figures.iter().filter_map(|figure| request(results, figure, tracks)).collect()
}

/// Stills of all figures of an experiment.
///
/// # Errors
/// When the results cannot be read.
pub fn requests(results: &Results) -> Result<Vec<StillRequest>, ResultsError> {
    if results.experiment.figures.iter().all(|figure| figure.params.stills == 0) {
        return Ok(Vec::new());
    }
    Ok(requested(results, &results.all_tracks()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_surround_the_first_error() {
        assert_eq!(pick(200, Some(100), 5), [70, 85, 100, 115, 130]);
        assert_eq!(pick(200, Some(10), 3), [0, 10, 40]);
        assert_eq!(pick(101, None, 3), [0, 50, 100]);
        assert_eq!(pick(1, None, 4), [0]);
        assert_eq!(pick(50, None, 1), [0]);
    }
}
