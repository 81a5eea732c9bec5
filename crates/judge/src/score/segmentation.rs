//! Protocol `sanmiguel2015-segmentation/1`: how well a detector divides a track into stretches that can and
//! cannot be trusted (SanMiguel and Cavallaro, CVIU 131, 2015, Section 7, "temporal segmentation").
//!
//! * Every annotated frame counts. It is positive when the track is successful in it, e_t < 1 (Eq. 18), and
//!   the detector calls it positive when it raises no alarm.
//! * TP: successful without alarm; FP: lost without alarm; FN: successful with alarm; TN: lost with alarm. Recall
//!   is the paper's TPR, FPR its FPR.
//! * For figures and lists, events are the changes of e_t = 1, detections those of the label, in both
//!   directions, and they match as in `sanmiguel2015/1`; the counts do not use them.
//!
//! The paper does not say which class is the positive one. That it is success follows from its text: a change that
//! is noticed late costs false positives there, and fewer false alarms give true positives (section 7.3, 7.4),
//! both of which hold for that choice only. With the other one, TPR and FPR are 1 - FPR and 1 - TPR of
//! this one, and accuracy and informedness are the same.

use super::chance::Chance;
use super::counts::Place;
use super::protocol::{Protocol, TrackScore};
use super::restarts::Restarts;
use super::sanmiguel2015::SIGNED;

/// Protocol `sanmiguel2015-segmentation/1`.
pub const PROTOCOL: Protocol = Protocol {
    name: "sanmiguel2015-segmentation/1",
    summary: "frames said to be successfully tracked against those with e_t < 1",
    positives: "successful frames",
    frame: Some(frame),
    restarts: Restarts::PartOfTrack,
    chance: Chance::within(0),
    score,
};

fn frame(error: f64, alarm: bool) -> Option<Place> {
    (!error.is_nan()).then(|| Place::of(error < 1.0, !alarm))
}

fn score(error: &[f64], alarm: &[bool], changes: &[i32]) -> TrackScore {
    let counts = error.iter().zip(alarm).filter_map(|(e, alarm)| frame(*e, *alarm)).collect();
    TrackScore { counts, ..(SIGNED.score)(error, alarm, changes) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::changes;
    use crate::score::testing::{counts, track};
    use proptest::prelude::*;

    // By hand: frames 0-3 and 8-9 are successful, 4-7 lost, 5 is not annotated; the alarm is on in 5-8.
    #[test]
    fn counts_a_hand_worked_track() {
        let n = f64::NAN;
        let error = [0.1, 0.2, 0.99, 0.4, 1.0, n, 1.0, 1.0, 0.3, 0.0];
        let alarm: Vec<bool> = (0..10).map(|t| (5..9).contains(&t)).collect();
        let s = (PROTOCOL.score)(&error, &alarm, &changes(&alarm));
        assert_eq!(s.counts, counts(5, 1, 1, 2));
        assert_eq!((s.counts.recall(), s.counts.fpr()), (Some(5.0 / 6.0), Some(1.0 / 3.0)));
        assert_eq!((s.counts.accuracy(), s.counts.informedness()), (Some(7.0 / 9.0), Some(0.5)));
        assert_eq!((s.events, s.detections, s.matches), (vec![4, 8], vec![5, 9], vec![(0, 0), (1, 1)]));
    }

    proptest! {
        #[test]
        fn turning_both_around_swaps_the_classes((error, alarm, _) in track()) {
            let turned: Vec<f64> = error.iter().map(|e| if *e == 1.0 { 0.2 } else { e * 5.0 }).collect();
            let silent: Vec<bool> = alarm.iter().map(|a| !a).collect();
            let of = |error: &[f64], alarm: &[bool]| (PROTOCOL.score)(error, alarm, &changes(alarm)).counts;
            let other = of(&turned, &silent);
            prop_assert_eq!(of(&error, &alarm), counts(other.tn, other.fn_, other.fp, other.tp));
        }
    }
}
