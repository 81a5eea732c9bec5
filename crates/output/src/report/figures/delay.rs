//! `delay`: how soon after an event it is found, as the share of events that a detection matched by then.

use super::bands;
use super::drawer::{DrawError, Drawer, Drawing, Scope};
use super::lines::{Line, arrange, drawing};
use crate::figure::{CurveAxis, Curves, Range};
use crate::results::TrackSeries;
use crate::sampling::Sampling;
use trackfail_methods::score::TrackScore;
use trackfail_methods::score::khalid2016::TOLERANCE;

/// The entry of this kind.
pub const DRAWER: Drawer = Drawer { word: "delay", shows_tracks: true, draw };

fn draw(scope: &Scope<'_>) -> Result<Drawing, DrawError> {
    let curves = delays(scope);
    Ok(drawing(curves, "no method has an event to find".to_string()))
}

/// For every delay d in frames, from the tolerance before an event to the tolerance after it, the share of all
/// events whose matched detection came at most d frames after them; it ends at the recall of events. None
/// without an event.
fn found_by(scores: &[TrackScore]) -> Option<Vec<(f64, f64)>> {
    let events: usize = scores.iter().map(|s| s.events.len()).sum();
    let delays: Vec<i64> = scores.iter().flat_map(TrackScore::delays).collect();
    let tolerance = TOLERANCE as i64;
    let share = |d: i64| delays.iter().filter(|delay| **delay <= d).count() as f64 / events as f64;
    (events > 0).then(|| (-tolerance..=tolerance).map(|d| (d as f64, share(d))).collect())
}

/// Bounds of each of these shares by bootstrap over the tracks, which are of a sequence each.
fn bounds(scores: &[TrackScore], sampling: &Sampling) -> Vec<(f64, f64)> {
    let tolerance = TOLERANCE as i64;
    let at = |d: i64| {
        let unit = |s: &TrackScore| {
            let found = s.delays().filter(|delay| *delay <= d).count();
            [found as i64, s.events.len() as i64]
        };
        bands::ratio(&scores.iter().map(unit).collect::<Vec<_>>(), sampling)
    };
    (-tolerance..=tolerance).map(at).collect()
}

/// One curve for each method without a grid, on every tracker that it runs on; first runs.
fn delays(scope: &Scope<'_>) -> Curves {
    let (results, mut lines) = (scope.results, Vec::new());
    let sampling = Sampling::new(&results.experiment);
    for tracker in &results.experiment.trackers {
        for method in &scope.params().methods {
            let Some(protocol) = results.experiment.protocol_of(method) else { continue };
            let score = |track: &TrackSeries| {
                let series = track.method(method)?;
                Some(track.judge(protocol, &series.alarm, &series.changes))
            };
            let tracks = scope.tracks.iter().filter(|track| track.tracker == tracker.label);
            let scores: Vec<TrackScore> = tracks.filter_map(score).collect();
            let Some(points) = found_by(&scores) else { continue };
            lines.push(Line {
                method: method.clone(),
                tracker: tracker.label.clone(),
                points,
                band: bounds(&scores, &sampling),
                ..Line::default()
            });
        }
    }
    let label = "Share of events found";
    let names = ("Frames after the event", label);
    let curves = arrange(&results.experiment, &scope.note, names, lines);
    Curves { y: CurveAxis { range: Range::Fixed(0.0, 1.0), ..CurveAxis::new(label) }, ..curves }
}

#[cfg(test)]
mod tests {
    use super::*;

    // By hand: four events on two tracks, found 2 frames early, at once and 5 frames late; one is missed.
    #[test]
    fn shares_add_up_to_the_recall() {
        let score = |events: &[usize], detections: &[usize], matches: &[(usize, usize)]| TrackScore {
            events: events.into(),
            detections: detections.into(),
            matches: matches.into(),
            ..TrackScore::default()
        };
        let tracks = [
            score(&[20, 40, 80], &[3, 18, 85], &[(0, 1), (2, 2)]),
            score(&[30], &[30], &[(0, 0)]),
            score(&[], &[7], &[]),
        ];
        let points = found_by(&tracks).unwrap();
        let at = |d: f64| points.iter().find(|p| p.0 == d).map(|p| p.1);
        assert_eq!((points.len(), at(-5.0), at(-3.0)), (11, Some(0.0), Some(0.0)));
        assert_eq!((at(-2.0), at(-1.0), at(0.0), at(4.0)), (Some(0.25), Some(0.25), Some(0.5), Some(0.5)));
        assert_eq!(at(5.0), Some(0.75));
        assert_eq!(found_by(&tracks[2..]), None);
    }
}
