//! Restarts of a reset protocol: parts of one track, or beginnings of new ones.
//!
//! Under a reset protocol, a tracker fails in a frame f, is silent for the four frames that the protocol
//! skips, and restarts on the ground truth in f + 5 (see [`crate::tracker::protocol`]). Its box jumps there.
//! A detector that continues over the jump would find it within the five frames in which a detection still
//! counts, and would get credit for a restart that the protocol made. With [`Restarts::NewTrack`] all signals
//! and detectors begin again in the frame of the restart, and each piece is scored separately:
//!
//! ```text
//! frame   ... f-1   f    f+1 ... f+4   f+5      f+6 ...
//! status      .   Failed   Skipped   Initialized  .
//! piece       0     0      none          1        1
//! ```
//!
//! Skipped frames do not count, nor does the frame of a restart: neither an alarm in it nor a run of alarms
//! that begins in it is a detection. For measures of frames each piece is a track without these frames. Frames that a protocol leaves out at the start of a track are left out
//! at the start of each piece. A track without restarts is one piece, scored as in other protocols.

use crate::tracker::Status;
use std::borrow::Cow;
use std::ops::Range;

/// Treatment of restarts by a protocol.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Restarts {
    /// Signals and detectors continue; all frames are one track.
    #[default]
    PartOfTrack,
    /// Signals and detectors begin again, and each piece is scored as a track.
    NewTrack,
}

impl Restarts {
    /// Pieces of a track with these statuses; none if restarts are part of the track.
    pub fn pieces(self, status: &[Status]) -> Vec<Range<usize>> {
        if self == Self::NewTrack { pieces(status) } else { Vec::new() }
    }

    /// Pieces that are scored separately: all, or none if restarts are part of the track.
    pub fn apart(self, pieces: &[Range<usize>]) -> &[Range<usize>] {
        if self == Self::NewTrack { pieces } else { &[] }
    }
}

/// Pieces of a track, in order. A piece begins with a start of the tracker and ends with the last frame that
/// is not skipped. Frames before the first start belong to the first piece.
pub fn pieces(status: &[Status]) -> Vec<Range<usize>> {
    let mut pieces: Vec<Range<usize>> = Vec::new();
    let mut started = false;
    for (t, status) in status.iter().enumerate() {
        match (status, pieces.last_mut()) {
            (Status::Skipped, Some(_)) => {}
            (Status::Initialized, Some(piece)) if !started => piece.end = t + 1,
            (Status::Initialized, _) | (_, None) => pieces.push(t..t + 1),
            (_, Some(piece)) => piece.end = t + 1,
        }
        started |= *status == Status::Initialized;
    }
    pieces
}

/// The pieces without the frames of restarts, in order.
fn without_restarts(pieces: &[Range<usize>]) -> impl Iterator<Item = Range<usize>> + '_ {
    pieces.iter().enumerate().map(|(k, piece)| piece.start + usize::from(k > 0)..piece.end)
}

/// Values in the frames that count, in order: those of the pieces without the frames of restarts; all values
/// for a track without pieces.
pub fn counted<'v>(pieces: &[Range<usize>], values: &'v [f64]) -> Cow<'v, [f64]> {
    if pieces.is_empty() {
        return values.into();
    }
    without_restarts(pieces).flatten().filter_map(|t| values.get(t).copied()).collect()
}

/// The pieces, or the whole track where there are none, without the frames before the first whose error is known, in
/// which the tracker has not started.
pub(super) fn started(pieces: &[Range<usize>], error: &[f64]) -> Vec<Range<usize>> {
    let first = error.iter().position(|error| !error.is_nan()).unwrap_or(error.len());
    let whole = pieces.is_empty().then_some(0..error.len());
    pieces.iter().cloned().chain(whole).map(|piece| piece.start.max(first)..piece.end).collect()
}

/// Ranges of frames that count, from the tracker's start on, each a track of its own for measures of frames.
pub fn parts(pieces: &[Range<usize>], error: &[f64]) -> Vec<Range<usize>> {
    let on_track = |part: Range<usize>| part.start.min(error.len())..part.end.min(error.len());
    without_restarts(&started(pieces, error)).map(on_track).filter(|part| !part.is_empty()).collect()
}

/// Alarms without the runs that begin in the frame of a restart.
pub fn counted_alarms<'a>(pieces: &[Range<usize>], alarm: &'a [bool]) -> Cow<'a, [bool]> {
    let mut alarm = Cow::Borrowed(alarm);
    for piece in pieces.iter().skip(1) {
        let end = piece.end.min(alarm.len());
        let run = piece.start.min(end)..end;
        if alarm[run.clone()].first() == Some(&true) {
            alarm.to_mut()[run].iter_mut().take_while(|alarm| **alarm).for_each(|alarm| *alarm = false);
        }
    }
    alarm
}

#[cfg(test)]
mod tests {
    use super::super::testing::{counts, error, set, status};
    use super::super::{PROTOCOLS, khalid2016};
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn pieces_by_hand() {
        let pieces = |letters: &str| -> Vec<(usize, usize)> {
            pieces(&status(letters)).into_iter().map(|piece| (piece.start, piece.end)).collect()
        };
        // Two failures in a row, the track ends among skipped frames.
        assert_eq!(pieces("itfssssifss"), [(0, 3), (7, 9)]);
        let of = ["itttfssssittt", "wwitt", "wwi", "tttt", ""].map(pieces);
        assert_eq!(of, [vec![(0, 5), (9, 13)], vec![(0, 5)], vec![(0, 3)], vec![(0, 4)], vec![]]);
        let of = [Restarts::NewTrack, Restarts::PartOfTrack].map(|r| r.pieces(&status("itfssi")));
        assert_eq!(of, [vec![0..3, 5..6], vec![]]);
    }

    // Worked by hand on 40 frames with a failure in 15 and a restart in 20. The alarm of 13 finds it. Those of 17 (skipped)
    // and of 20 to 21 (the restart's own) count for nothing, that of 30 is false.
    // True negatives: frames 10 to 15 of the first piece without the detection, and 30 to 39 of the second without its own.
    #[test]
    fn a_restart_pays_nobody() {
        let status = status("ittttttttttttttfssssittttttttttttttttttt");
        assert_eq!(status.len(), 40);
        let (error, alarm) = (error(40, &[[15, 20]]), set(40, &[[13, 14], [17, 18], [20, 22], [30, 31]]));
        let pieces = pieces(&status);
        let s = khalid2016::NEW_TRACK.judge(&error, &alarm, &[0; 40], &pieces);
        assert_eq!((s.events.as_slice(), s.detections.as_slice()), (&[15][..], &[13, 30][..]));
        assert_eq!(s.matches, [(0, 0)]);
        assert_eq!(s.counts, counts(1, 1, 0, 5 + 9));
        let numbers: Vec<f64> = (0..40).map(f64::from).collect();
        let those_that_count: Vec<f64> = (0..16).chain(21..40).map(f64::from).collect();
        assert_eq!(counted(&pieces, &numbers), those_that_count);
        assert_eq!((parts(&pieces, &error), &*counted(&[], &numbers)), (vec![0..16, 21..40], &*numbers));
        assert_eq!(counted_alarms(&pieces, &alarm).into_owned(), set(40, &[[13, 14], [17, 18], [30, 31]]));
        // Before its start, in frame 3, a tracker is not judged.
        let late = [&[f64::NAN; 3][..], &error].concat();
        let (early, moved) = ([&[true, false, true][..], &alarm].concat(), khalid2016::PROTOCOL);
        let whole = moved.judge(&error, &alarm, &[], &[]);
        let found = moved.judge(&late, &early, &[], &[]);
        assert_eq!(found.counts, whole.counts);
        assert!(found.delays().eq(whole.delays()));
        assert_eq!((found.events, parts(&[], &late).first()), (vec![18], Some(&(3..43))));
        // As one track the restart alone finds the failure, whatever pieces there are.
        let jump = set(40, &[[20, 21]]);
        let as_one = khalid2016::PROTOCOL.judge(&error, &jump, &[], &pieces);
        assert_eq!((as_one.counts.tp, as_one), (1, khalid2016::PROTOCOL.judge(&error, &jump, &[], &[])));
        let anew = khalid2016::NEW_TRACK.judge(&error, &jump, &[0; 40], &pieces);
        assert_eq!(anew.counts, counts(0, 0, 1, 5 + 10));
    }

    proptest! {
        #[test]
        fn a_track_without_restarts_is_scored_as_ever(
            error in proptest::collection::vec(prop_oneof![Just(1.0), Just(0.4)], 1..80),
            seed in any::<u64>(),
        ) {
            let alarm: Vec<bool> = (0..error.len()).map(|t| (seed >> (t % 61)) & 3 == 0).collect();
            let changes = crate::detector::changes(&alarm);
            let mut status = vec![Status::Tracked; error.len()];
            status[0] = Status::Initialized;
            for protocol in PROTOCOLS {
                let whole = (protocol.score)(&error, &alarm, &changes);
                prop_assert_eq!(protocol.judge(&error, &alarm, &changes, &pieces(&status)), whole);
            }
        }

        // Labels of skipped frames and boxes that stand still there say nothing.
        #[test]
        fn what_is_between_pieces_changes_nothing(letters in "i[tf]{0,12}(fssssi[t]{0,12}){0,4}", seed in any::<u64>()) {
            let status = status(&letters);
            let pieces = pieces(&status);
            let bit = |t: usize| (seed >> (t % 61)) & 1 == 1;
            let error: Vec<f64> = (0..status.len()).map(|t| if bit(t + 7) { 1.0 } else { 0.4 }).collect();
            let alarm: Vec<bool> = (0..status.len()).map(bit).collect();
            let is_skipped = |t: usize| status[t] == Status::Skipped;
            let other_error: Vec<f64> =
                (0..status.len()).map(|t| if is_skipped(t) != bit(t + 7) { 1.0 } else { 0.4 }).collect();
            let other_alarm: Vec<bool> = (0..status.len()).map(|t| alarm[t] ^ is_skipped(t)).collect();
            let of = |error: &[f64], alarm: &[bool]| khalid2016::NEW_TRACK.judge(error, alarm, &[], &pieces);
            prop_assert_eq!(of(&error, &alarm), of(&other_error, &other_alarm));
            let in_parts: Vec<f64> = parts(&pieces, &error).into_iter().flat_map(|part| error[part].to_vec()).collect();
            prop_assert_eq!(counted(&pieces, &error).into_owned(), in_parts);
        }

        // Results from elsewhere may have pieces that their frames do not.
        #[test]
        fn any_pieces_are_scored(ends in proptest::collection::vec((0..30_usize, 0..30_usize), 0..5), frames in 0..20_usize) {
            let pieces: Vec<Range<usize>> = ends.into_iter().map(|(from, to)| from..to).collect();
            let (error, alarm) = (vec![0.4; frames], vec![true; frames / 2]);
            for protocol in PROTOCOLS {
                protocol.judge(&error, &alarm, &[], &pieces);
            }
            prop_assert!(counted(&pieces, &error).iter().all(|e| *e == 0.4));
            prop_assert!(parts(&pieces, &error).iter().all(|part| part.end <= frames));
            prop_assert_eq!(counted_alarms(&pieces, &alarm).len(), alarm.len());
        }
    }
}
