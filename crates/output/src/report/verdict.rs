//! Verdict of a method on a user's track, in sentences.

use crate::detector::RECOVERY_FRAMES;
use crate::num::fixed;
use crate::results::detections::{JudgedMethod, JudgedTrack, TargetState, badness};
use crate::table::number::Style;
use std::ops::Range;

/// Losses and absences that a sentence lists; of more, it gives the number.
const MAX_LISTED: usize = 8;

/// False-alarm-prone stretches whose frames a sentence lists.
const MAX_PRONE: usize = 3;

/// Share of its threshold from which a probability is near it.
const NEAR: f64 = 0.75;

/// `lost from frame 52 (fused: .97 > .80); recovered at 61; lost from 104 to the end; 2 false-alarm-prone stretches
/// (52 to 60, 81)`.
///
/// A loss that is followed by `tracking` ends with `recovered` only where the method gives a reason to say so, else with
/// `alarm over`.
pub fn verdict(track: &JudgedTrack, method: &JudgedMethod) -> String {
    let frames = method.states.len();
    let mut parts = Vec::new();
    let mut more = 0;
    let mut is_first = true;
    for (state, run) in method.stretches().filter(|(state, _)| *state != TargetState::Tracking) {
        if parts.len() >= MAX_LISTED {
            more += usize::from(state == TargetState::Lost);
            continue;
        }
        let to_the_end = if run.end == frames { " to the end" } else { "" };
        if state == TargetState::Absent {
            let from = track.number(run.start);
            parts.push(match run.len() {
                1 => format!("absent at {from}"),
                _ if run.end == frames => format!("absent from {from}{to_the_end}"),
                _ => format!("absent from {from} to {}", track.number(run.end - 1)),
            });
            continue;
        }
        let (word, why) = match is_first {
            true => ("frame ", format!(" ({})", evidence(method, run.start, true))),
            false => ("", String::new()),
        };
        is_first = false;
        let ending = match method.states.get(run.end) {
            Some(TargetState::Tracking) => format!("; {}", ending(track, method, &run)),
            _ => String::new(),
        };
        parts.push(format!("lost from {word}{}{to_the_end}{why}{ending}", track.number(run.start)));
    }
    if more > 0 {
        parts.push(format!("and lost {more} more times"));
    }
    if is_first {
        let worst = worst(method).map_or_else(|| method.name.clone(), |t| evidence(method, t, false));
        let seen = method.states.iter().filter(|state| **state != TargetState::Absent).count();
        let s = if seen == 1 { "" } else { "s" };
        parts.insert(0, format!("tracking, no loss found in {seen} frame{s} ({worst})"));
    }
    parts.extend(prone_stretches(track, method));
    parts.join("; ")
}

/// `2 false-alarm-prone stretches (52 to 60, 91)`, with the frames of the first few.
fn prone_stretches(track: &JudgedTrack, method: &JudgedMethod) -> Option<String> {
    let found = false_alarm_prone(method);
    let frames = |run: &Range<usize>| match run.len() {
        1 => track.number(run.start).to_string(),
        _ => format!("{} to {}", track.number(run.start), track.number(run.end - 1)),
    };
    let mut listed: Vec<String> = found.iter().take(MAX_PRONE).map(frames).collect();
    if found.len() > MAX_PRONE {
        listed.push("...".to_string());
    }
    let es = if found.len() == 1 { "" } else { "es" };
    (!found.is_empty())
        .then(|| format!("{} false-alarm-prone stretch{es} ({})", found.len(), listed.join(", ")))
}

/// The end of a loss that is followed by `tracking`.
///
/// `recovered at 61`: the method's probability of a loss has been below one half for some frames, or a method without a
/// probability has alarmed up to the frame before. Otherwise `alarm over at 61`: no alarm has come for some frames, which need
/// not mean that the tracker is on the target again.
fn ending(track: &JudgedTrack, method: &JudgedMethod, lost: &Range<usize>) -> String {
    let alarms_as_long = method.label.get(lost.end - 1).copied().unwrap_or_default();
    let words = if method.is_probability || alarms_as_long { "recovered" } else { "alarm over" };
    format!("{words} at {}", track.number(lost.end))
}

/// A sentence about a target, with its number if it has one: `target 3: lost from ...`.
pub fn of_target(track: &JudgedTrack, sentence: &str) -> String {
    track.target.map_or_else(|| sentence.to_string(), |id| format!("target {id}: {sentence}"))
}

/// The method with the score of a frame beside its threshold, `fused: .97 > .80`, where that is a reason for what is said.
fn evidence(method: &JudgedMethod, t: usize, is_loss: bool) -> String {
    let name = &method.name;
    let reason = comparison(method, t).filter(|_| method.is_beyond(t) == Some(is_loss));
    reason.map_or_else(|| name.clone(), |comparison| format!("{name}: {comparison}"))
}

/// The score of a frame beside the threshold: `.97 > .80`; `None` where there is no score or no threshold.
pub fn comparison(method: &JudgedMethod, t: usize) -> Option<String> {
    let score = method.score.get(t).copied().flatten().filter(|score| score.is_finite())?;
    let threshold = method.threshold?;
    // As many digits as tell the two apart.
    let texts = |decimals| {
        let shown = |value: f64| match (Style { decimals, bare: true }).format(value) {
            text if text.len() <= 17 => text,
            _ => fixed(value, decimals),
        };
        (shown(score), shown(threshold))
    };
    let tell_apart =
        |(score, threshold): &(String, String)| score != threshold && threshold.parse() != Ok(0.0);
    let (shown, level) = (2..6).map(texts).find(tell_apart).unwrap_or_else(|| texts(6));
    let sign = match score.total_cmp(&threshold) {
        std::cmp::Ordering::Less => "<",
        std::cmp::Ordering::Equal => "=",
        std::cmp::Ordering::Greater => ">",
    };
    Some(format!("{shown} {sign} {level}"))
}

/// The frame with a box whose score speaks most for a loss.
fn worst(method: &JudgedMethod) -> Option<usize> {
    let scores = method.score.iter().enumerate().filter_map(|(t, score)| Some((t, (*score)?)));
    let with_box = scores.filter(|(t, _)| method.states.get(*t) != Some(&TargetState::Absent));
    let bad = |score: f64| badness(method.direction, score);
    // The earliest of equal ones.
    with_box.rev().max_by(|a, b| bad(a.1).total_cmp(&bad(b.1))).map(|(t, _)| t)
}

/// Stretches in which a method that gives a probability came near a false alarm, or may have raised one.
///
/// A frame belongs to one if its probability is at least three quarters of the threshold without an alarm, or if it is in
/// a loss that was over within ten frames. Frames with fewer than ten others between them are one stretch. The rise
/// before a longer loss and the fall after it are none, nor are frames in which the target is absent.
pub fn false_alarm_prone(method: &JudgedMethod) -> Vec<Range<usize>> {
    let Some(threshold) = method.threshold.filter(|_| method.is_probability) else { return Vec::new() };
    let is_near = |t: usize| method.score.get(t).copied().flatten().is_some_and(|p| p >= NEAR * threshold);
    let frames = method.states.len();
    let mut found: Vec<Range<usize>> = Vec::new();
    for (state, run) in method.stretches() {
        match state {
            TargetState::Tracking => {
                let mut near: Vec<usize> = run.clone().filter(|t| is_near(*t)).collect();
                // A rise that ends in a loss, or a fall that follows one, belongs to that loss.
                let is_loss =
                    |t: Option<usize>| t.and_then(|t| method.states.get(t)) == Some(&TargetState::Lost);
                if is_loss(run.start.checked_sub(1)) {
                    let fall =
                        near.iter().zip(run.start..).take_while(|(t, expected)| *t == expected).count();
                    near.drain(..fall);
                }
                if is_loss(Some(run.end)) {
                    let mut expected = run.end;
                    while near.last().is_some_and(|t| t + 1 == expected) {
                        expected -= 1;
                        near.pop();
                    }
                }
                near.into_iter().for_each(|t| extend(&mut found, t..t + 1));
            }
            TargetState::Lost if run.len() < RECOVERY_FRAMES && run.end < frames => extend(&mut found, run),
            TargetState::Lost | TargetState::Absent => {}
        }
    }
    found
}

/// Adds a run of frames to the last stretch, or a new one if it is further away.
fn extend(found: &mut Vec<Range<usize>>, run: Range<usize>) {
    match found.last_mut() {
        Some(last) if run.start < last.end + RECOVERY_FRAMES => last.end = run.end,
        _ => found.push(run),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::Direction;

    /// A method over frames from 1 on: `.` tracking, `L` lost, `A` absent, with a score for each.
    fn judged(states: &str, score: &[f64], threshold: Option<f64>) -> JudgedTrack {
        let state = |c| match c {
            'L' => TargetState::Lost,
            'A' => TargetState::Absent,
            _ => TargetState::Tracking,
        };
        let states: Vec<TargetState> = states.chars().map(state).collect();
        let method = JudgedMethod {
            name: "M".into(),
            threshold,
            direction: Direction::LowerIsBetter,
            is_probability: true,
            score: score.iter().map(|s| Some(*s)).collect(),
            label: states.iter().map(|s| *s == TargetState::Lost).collect(),
            changes: vec![0; states.len()],
            states,
        };
        JudgedTrack { target: None, first: 1, methods: vec![method] }
    }

    fn said(states: &str, score: &[f64], threshold: Option<f64>) -> String {
        let track = judged(states, score, threshold);
        verdict(&track, &track.methods[0])
    }

    #[test]
    fn sentences_by_hand() {
        let mut states = ".".repeat(120);
        states.replace_range(51..60, &"L".repeat(9));
        states.replace_range(103..120, &"L".repeat(17));
        let score = |states: &str| -> Vec<f64> {
            states.chars().map(|c| if c == 'L' { 0.97 } else { 0.1 }).collect()
        };
        assert_eq!(
            said(&states, &score(&states), Some(0.8)),
            "lost from frame 52 (M: .97 > .80); recovered at 61; lost from 104 to the end; 1 false-alarm-prone stretch (52 to 60)"
        );
        let whole = "L".repeat(20);
        assert_eq!(said(&whole, &score(&whole), Some(0.8)), "lost from frame 1 to the end (M: .97 > .80)");
        assert_eq!(said(&whole, &score(&whole), None), "lost from frame 1 to the end (M)");
        assert_eq!(
            said("A..AAL.A", &score("A..AAL.A"), None),
            "absent at 1; absent from 4 to 5; lost from frame 6 (M); recovered at 7; absent at 8"
        );
        assert_eq!(
            said("A.A", &[0.9, 0.3, 0.9], None),
            "tracking, no loss found in 1 frame (M); absent at 1; absent at 3"
        );
        assert_eq!(
            said("...", &[0.1, 0.3, 0.2], Some(0.8)),
            "tracking, no loss found in 3 frames (M: .30 < .80)"
        );
        // By hand: the last alarm is in frame 3, and frames 4 to 6 are below the threshold.
        let after = |p| said("..LLL...", &[0.1, 0.1, 0.97, p, 0.3, 0.2, 0.1, 0.1], Some(0.8));
        assert_eq!(
            after(0.49),
            "lost from frame 3 (M: .97 > .80); recovered at 6; 1 false-alarm-prone stretch (3 to 5)"
        );
        assert_eq!(
            after(0.77),
            "lost from frame 3 (M: .97 > .80); recovered at 6; 1 false-alarm-prone stretch (3 to 5)"
        );
        // Without a probability: alarms up to the frame before, or a single one that is over for some frames.
        let mut track = judged(".LLL.", &[0.0, 9.0, 0.0, 0.0, 0.0], Some(1.0));
        track.methods[0].is_probability = false;
        assert_eq!(verdict(&track, &track.methods[0]), "lost from frame 2 (M: 9.00 > 1.00); recovered at 5");
        track.methods[0].label[2..].fill(false);
        assert_eq!(verdict(&track, &track.methods[0]), "lost from frame 2 (M: 9.00 > 1.00); alarm over at 5");
        let often = "L.".repeat(20);
        let listed = said(&often, &score(&often), None);
        assert!(listed.ends_with("lost from 15; recovered at 16; and lost 12 more times"), "{listed}");
    }

    #[test]
    fn scores_have_as_many_digits_as_tell_them_apart() {
        let of = |score, threshold| {
            let track = judged(".", &[score], Some(threshold));
            comparison(&track.methods[0], 0).unwrap()
        };
        assert_eq!(of(0.97, 0.8), ".97 > .80");
        assert_eq!(of(0.8042, 0.8), ".804 > .800");
        assert_eq!(of(0.0051, 0.004), ".005 > .004");
        assert_eq!(of(2.5, 2.3), "2.50 > 2.30");
        assert_eq!(of(-0.25, 0.5), "-.25 < .50");
        assert_eq!(of(0.8, 0.8), ".800000 = .800000");
        assert_eq!(of(1e300, 2.0), "1.00e300 > 2.00");
    }

    #[test]
    fn a_score_on_the_other_side_of_the_threshold_is_no_reason() {
        assert_eq!(said("..LL", &[0.1, 0.1, 0.09, 0.1], Some(0.83)), "lost from frame 3 to the end (M)");
        // What is said of an absence is no score of the track, however high.
        assert_eq!(
            said("..A.", &[0.1, 0.3, 0.97, 0.2], Some(0.83)),
            "tracking, no loss found in 3 frames (M: .30 < .83); absent at 3"
        );
        // Low scores speak for a loss: .20 < .50 is a reason for one, and .70 > .50 for none.
        let mut track = judged(".L", &[0.7, 0.2], Some(0.5));
        track.methods[0].direction = Direction::HigherIsBetter;
        track.methods[0].is_probability = false;
        assert_eq!(verdict(&track, &track.methods[0]), "lost from frame 2 to the end (M: .20 < .50)");
        track.methods[0].states.fill(TargetState::Tracking);
        assert_eq!(verdict(&track, &track.methods[0]), "tracking, no loss found in 2 frames (M)");
        track.methods[0].score[1] = Some(0.7);
        assert_eq!(verdict(&track, &track.methods[0]), "tracking, no loss found in 2 frames (M: .70 > .50)");
    }

    #[test]
    fn stretches_near_a_false_alarm_by_hand() {
        let found = |states: &str, score: &[f64]| -> Vec<(usize, usize)> {
            let track = judged(states, score, Some(0.8));
            false_alarm_prone(&track.methods[0]).into_iter().map(|run| (run.start, run.end)).collect()
        };
        let mut score = vec![0.1; 60];
        score[5] = 0.61;
        score[14] = 0.7;
        score[40] = 0.61;
        // Eight frames between two are few; .59 is not near .80.
        score[55] = 0.59;
        assert_eq!(found(&".".repeat(60), &score), [(5, 15), (40, 41)]);
        // The rise before a loss and the fall after it belong to it.
        let mut states = ".".repeat(60);
        states.replace_range(20..40, &"L".repeat(20));
        let mut score = vec![0.1; 60];
        score[18..41].fill(0.7);
        assert!(found(&states, &score).is_empty());
        score[10] = 0.7;
        assert_eq!(found(&states, &score), [(10, 11)]);
        // A loss over within ten frames is one; at the end of the track nobody knows.
        let mut states = ".".repeat(60);
        states.replace_range(20..29, &"L".repeat(9));
        states.replace_range(55..60, &"L".repeat(5));
        assert_eq!(found(&states, &[0.1; 60]), [(20, 29)]);
        // Scores that are no probabilities are not judged.
        let mut track = judged(&states, &[0.7; 60], Some(0.8));
        track.methods[0].is_probability = false;
        assert!(false_alarm_prone(&track.methods[0]).is_empty());
    }
}
