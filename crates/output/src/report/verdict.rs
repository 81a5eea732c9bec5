//! Verdict of a method on a user's track: an answer in at most two sentences, and the stretches of frames
//! behind it.

use super::sentences::say;
use crate::results::detections::{JudgedMethod, JudgedTrack, TargetState};
use crate::table::number::Style;
use serde_json::json;
use std::ops::Range;
use trackfail_core::num::fixed;
use trackfail_methods::detector::RECOVERY_FRAMES;

/// Share of the threshold from which on a probability makes a loss possible, though there is no alarm.
const NEAR: f64 = 0.75;

/// Probability below which a frame counts as surely tracked.
const SURE: f64 = 0.1;

/// Consecutive frames in one state, or in which a loss is possible.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretch {
    /// Frames of the stretch, 0-based.
    pub frames: Range<usize>,
    /// State of the target in these frames.
    pub state: TargetState,
    /// Highest probability of a loss in these frames; `None` for methods without probabilities.
    pub probability: Option<f64>,
    /// Reason for the state, in words.
    pub why: String,
}

/// A loss, including frames without a box within it and after it.
struct Loss {
    frames: Range<usize>,
    /// True if the method has evidence that the tracker is on its target again, false if merely no alarm has
    /// come for some frames; `None` if the track ends during the loss.
    is_found: Option<bool>,
}

/// Answer with its time and what to do: `Lost since frame 181; not surely found again. Start the tracker
/// again at frame 181, or do not use its boxes from there on.`
pub fn verdict(track: &JudgedTrack, method: &JudgedMethod) -> String {
    let (losses, possible) = (losses(method), possibly_lost(method));
    let ends = |run: &Range<usize>| [run.start, run.end - 1].map(|t| track.number(t));
    let is_found = losses.last().and_then(|last| last.is_found);
    let after = losses.last().map_or(0, |last| last.frames.end);
    let absent = method.states.iter().filter(|state| **state == TargetState::Absent).count();
    let about = json!({
        "losses": losses.iter().map(|loss| ends(&loss.frames)).collect::<Vec<_>>(),
        "is_found": is_found == Some(true),
        "is_unsure": is_found == Some(false),
        "possible": possible.iter().map(ends).collect::<Vec<_>>(),
        "doubt": possible.iter().find(|run| run.start >= after).map(|run| track.number(run.start)),
        "absent": absent,
        "seen": method.states.len() - absent,
    });
    say("user verdict", about).trim().to_string()
}

/// All losses. A loss that is interrupted by an absence counts as one.
fn losses(method: &JudgedMethod) -> Vec<Loss> {
    let mut found: Vec<Loss> = Vec::new();
    for (state, frames) in method.stretches() {
        let open = found.last_mut().filter(|loss| loss.is_found.is_none());
        match (state, open) {
            (TargetState::Lost, Some(loss)) => loss.frames.end = frames.end,
            (TargetState::Lost, None) => found.push(Loss { frames, is_found: None }),
            (TargetState::Tracking, Some(loss)) => loss.is_found = Some(is_found(method, loss.frames.end)),
            _ => {}
        }
    }
    found
}

/// True if the target is found again after a loss whose last frame is `t - 1`.
///
/// With probabilities, the target is found again if ten tracked frames in a row have a probability below a
/// tenth before the state changes. Without probabilities, it is found again if the method's alarm lasted
/// until frame `t - 1`. Otherwise the alarms have merely stopped, which does not prove that the tracker is on
/// its target.
fn is_found(method: &JudgedMethod, t: usize) -> bool {
    if method.is_probability {
        let after = method.states.iter().zip(&method.score).skip(t);
        let tracking = after.take_while(|(state, _)| **state == TargetState::Tracking);
        let sure: Vec<bool> = tracking.map(|(_, score)| score.is_some_and(|p| p < SURE)).collect();
        sure.windows(RECOVERY_FRAMES).any(|frames| !frames.contains(&false))
    } else {
        t.checked_sub(1).and_then(|last| method.label.get(last)) == Some(&true)
    }
}

/// Stretches in which the target is lost, absent or possibly lost, in order.
pub fn stretches(method: &JudgedMethod) -> Vec<Stretch> {
    let stretch = |(state, frames): (TargetState, Range<usize>)| {
        let scores = frames.clone().filter_map(|t| method.score.get(t).copied().flatten());
        // What is said where the tracker has no box is said of another place.
        let has_probability = method.is_probability && state != TargetState::Absent;
        let probability = scores.filter(|p| has_probability && p.is_finite()).max_by(f64::total_cmp);
        let why = match state {
            TargetState::Absent => "no box".to_string(),
            TargetState::Lost => why_lost(method, &frames),
            TargetState::Tracking => "possibly lost: near an alarm".to_string(),
        };
        Stretch { frames, state, probability, why }
    };
    let others = method.stretches().filter(|(state, _)| *state != TargetState::Tracking);
    let possible = possibly_lost(method).into_iter().map(|frames| (TargetState::Tracking, frames));
    let mut found: Vec<Stretch> = others.chain(possible).map(stretch).collect();
    found.sort_by_key(|stretch| stretch.frames.start);
    found
}

/// Most rows of [`table`].
const MAX_ROWS: usize = 20;

/// Stretches behind the verdicts of the first method on each track: headings, then a row for each of the
/// first stretches, and the number of the others. Only headings if there are no stretches.
pub fn table(tracks: &[&JudgedTrack]) -> Vec<Vec<String>> {
    let mut rows = vec![["target", "from", "to", "state", "probability", "why"].map(str::to_string)];
    for track in tracks {
        for stretch in track.methods.first().map(stretches).unwrap_or_default() {
            let [from, to] =
                [stretch.frames.start, stretch.frames.end - 1].map(|t| track.number(t).to_string());
            let shown = |p| Style { decimals: 2, bare: true }.format(p);
            let probability = stretch.probability.map(shown).unwrap_or_default();
            let target = track.target.map(|id| id.to_string()).unwrap_or_default();
            rows.push([target, from, to, stretch.state.word().to_string(), probability, stretch.why]);
        }
    }
    let more = rows.len().saturating_sub(1 + MAX_ROWS);
    if more > 0 {
        rows.truncate(1 + MAX_ROWS);
        let mut last = [const { String::new() }; 6];
        last[5] = format!("and {more} more stretch{}", if more == 1 { "" } else { "es" });
        rows.push(last);
    }
    let without = usize::from(tracks.iter().all(|track| track.target.is_none()));
    rows.into_iter().map(|row| row.into_iter().skip(without).collect()).collect()
}

/// Reason for a loss, like `alarm: .97 > .80`, and how the loss ends.
fn why_lost(method: &JudgedMethod, frames: &Range<usize>) -> String {
    let state = |t: Option<usize>| method.states.get(t?);
    let is_after_absence = state(frames.start.checked_sub(1)) == Some(&TargetState::Absent);
    let is_beyond = method.is_beyond(frames.start) == Some(true);
    let is_over = state(Some(frames.end)) == Some(&TargetState::Tracking);
    let about = json!({
        "was_lost": is_after_absence && method.label.get(frames.start) != Some(&true),
        "comparison": comparison(method, frames.start).filter(|_| is_beyond),
        "is_found": is_over.then(|| is_found(method, frames.end)),
    });
    say("why lost", about)
}

/// Sentence about a target, with its number if it has one: `Target 3: Lost since ...`.
pub fn of_target(track: &JudgedTrack, sentence: &str) -> String {
    track.target.map_or_else(|| sentence.to_string(), |id| format!("Target {id}: {sentence}"))
}

/// Score of a frame beside the threshold: `.97 > .80`; `None` without a score or a threshold.
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

/// Stretches without an alarm in which the probability of a loss is at least three quarters of the threshold.
///
/// Frames with fewer than ten others between them form one stretch. The rise before a loss and the fall after
/// it are left out, as are frames without a box.
pub fn possibly_lost(method: &JudgedMethod) -> Vec<Range<usize>> {
    let Some(threshold) = method.threshold.filter(|_| method.is_probability) else { return Vec::new() };
    let is_near = |t: usize| method.score.get(t).copied().flatten().is_some_and(|p| p >= NEAR * threshold);
    let is_loss = |t: Option<usize>| t.and_then(|t| method.states.get(t)) == Some(&TargetState::Lost);
    let mut found: Vec<Range<usize>> = Vec::new();
    for (_, Range { mut start, mut end }) in
        method.stretches().filter(|(state, _)| *state == TargetState::Tracking)
    {
        if is_loss(start.checked_sub(1)) {
            start = (start..end).find(|t| !is_near(*t)).unwrap_or(end);
        }
        if is_loss(Some(end)) {
            end = (start..end).rfind(|t| !is_near(*t)).map_or(start, |t| t + 1);
        }
        let near: Vec<usize> = (start..end).filter(|t| is_near(*t)).collect();
        let runs = near.chunk_by(|a, b| *b <= a + RECOVERY_FRAMES);
        found.extend(runs.map(|run| run[0]..run[run.len() - 1] + 1));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::judged_method;
    use trackfail_core::direction::Direction;

    /// Method on frames 1, 2, ...: `.` tracking, `L` lost, `A` absent, with a score for each.
    fn judged(states: &str, score: &[f64], threshold: Option<f64>) -> JudgedTrack {
        let state = |c| match c {
            'L' => TargetState::Lost,
            'A' => TargetState::Absent,
            _ => TargetState::Tracking,
        };
        let (states, score) = (states.chars().map(state).collect(), score.iter().map(|s| Some(*s)).collect());
        let method = judged_method("M", states, score, threshold);
        JudgedTrack { target: None, first: 1, methods: vec![method] }
    }

    fn said(states: &str, score: &[f64], threshold: Option<f64>) -> String {
        let track = judged(states, score, threshold);
        verdict(&track, &track.methods[0])
    }

    /// The rows of the table, cells joined by `|`.
    fn rows(track: &JudgedTrack) -> Vec<String> {
        table(&[track]).iter().skip(1).map(|row| row.join("|")).collect()
    }

    #[test]
    fn sentences_by_hand() {
        let score = |states: &str| -> Vec<f64> {
            states.chars().map(|c| if c == 'L' { 0.97 } else { 0.05 }).collect()
        };
        let again = |frame| {
            format!(" Start the tracker again at frame {frame}, or do not use its boxes from there on.")
        };
        let good = ".".repeat(10);
        for (states, sentence) in [
            ("..LLL", "Lost since frame 3.".to_string() + &again(3)),
            ("..LLL+", "Lost from frame 3 to 5; found again. Do not use its boxes there.".into()),
            ("..L+", "Lost in frame 3; found again. Do not use its boxes there.".into()),
            (".LL.L", "Lost since frame 2, 2 times in all; lost at the end.".to_string() + &again(5)),
            (
                ".L.L.L+",
                "Lost since frame 2, 3 times in all; found again. Do not use its boxes in the frames below."
                    .into(),
            ),
            // Fewer than ten frames as good as before are no reason.
            ("..LLL.........", "Lost since frame 3; not surely found again.".to_string() + &again(3)),
            // An absence is part of the loss that it interrupts.
            (".LAAL+", "Lost from frame 2 to 5; found again. Do not use its boxes there.".into()),
            (".LAA", "Lost since frame 2.".to_string() + &again(2)),
            ("...", "No loss found in 3 frames.".into()),
            (".A", "No loss found in 1 frame; one frame has no box.".into()),
            ("A.A", "No loss found in 1 frame; 2 frames have no box.".into()),
        ] {
            let states = states.replace('+', &good);
            assert_eq!(said(&states, &score(&states), Some(0.8)), sentence, "{states}");
        }
        // Nor are ten that are not as good.
        let states = format!("..LLL{good}");
        let mut doubtful = score(&states);
        doubtful[9] = 0.2;
        let unsure = |frame| format!("Lost since frame {frame}; not surely found again.{}", again(frame));
        assert_eq!(said(&states, &doubtful, Some(0.8)), unsure(3));
        // A later stretch near an alarm is no loss, but a reason for doubt.
        let states = format!(".LLL{good}..");
        let mut doubt = score(&states);
        doubt[14..].fill(0.7);
        let doubt = said(&states, &doubt, Some(0.8));
        let begins = "Lost from frame 2 to 4; found again, but possibly lost from 15 on. ";
        assert!(doubt.starts_with(begins), "{doubt}");
        // Without a probability, an alarm that is over need not mean that the target is found.
        let mut track = judged(".LLL.", &[0.0, 9.0, 0.0, 0.0, 0.0], Some(1.0));
        track.methods[0].is_probability = false;
        let found = "Lost from frame 2 to 4; found again. Do not use its boxes there.";
        assert_eq!(verdict(&track, &track.methods[0]), found);
        track.methods[0].label[2..].fill(false);
        assert_eq!(verdict(&track, &track.methods[0]), unsure(2));
    }

    #[test]
    fn a_loss_is_possible_near_an_alarm() {
        let mut score = [0.1; 30];
        for (near, threshold, sentence) in [
            (2..4, 0.83, "Possibly lost from frame 3 to 4; there was no alarm. Look at these frames."),
            (2..3, 0.83, "Possibly lost in frame 3; there was no alarm. Look at these frames."),
            (2..3, 0.99, "No loss found in 30 frames."),
        ] {
            score.fill(0.1);
            score[near].fill(0.74);
            assert_eq!(said(&".".repeat(30), &score, Some(threshold)), sentence);
        }
        let track = judged(&".".repeat(30), &score, Some(0.83));
        assert_eq!(rows(&track), ["3|3|tracking|.74|possibly lost: near an alarm"]);
        score[20] = 0.74;
        let several = said(&".".repeat(30), &score, Some(0.83));
        assert!(several.starts_with("Possibly lost in frame 3 and in 1 more stretch; there"), "{several}");
    }

    #[test]
    fn rows_by_hand() {
        let score = [0.1, 0.97, 0.9, 0.3, 0.2, 0.1, 0.99, 0.98];
        let all = rows(&judged(".LLL..AL", &score, Some(0.8)));
        assert_eq!(all[0], "2|4|lost|.97|alarm: .97 > .80; then not surely found again");
        assert_eq!(all[1..], ["7|7|absent||no box", "8|8|lost|.98|alarm: .98 > .80"]);
        // A score on the other side of the threshold is no reason.
        assert_eq!(rows(&judged("..LL", &[0.1, 0.1, 0.09, 0.1], Some(0.83)))[0], "3|4|lost|.10|alarm");
        // Low scores speak for a loss.
        let mut track = judged(".L", &[0.7, 0.2], Some(0.5));
        track.methods[0].direction = Direction::HigherIsBetter;
        track.methods[0].is_probability = false;
        assert_eq!(rows(&track), ["2|2|lost||alarm: .20 < .50"]);
        // A loss that goes on after an absence without an alarm of its own.
        let mut track = judged(".LAL", &[0.1, 0.9, 0.9, 0.6], Some(0.8));
        track.methods[0].label[3] = false;
        assert_eq!(rows(&track)[2], "4|4|lost|.60|lost before, too");
        track.target = Some(7);
        assert_eq!(rows(&track)[1], "7|3|3|absent||no box");
        let often = "L.".repeat(30);
        let all = rows(&judged(&often, &[0.9; 60], Some(0.8)));
        assert_eq!((all.len(), all[20].as_str()), (21, "||||and 10 more stretches"));
        assert!(rows(&judged("...", &[0.1; 3], Some(0.8))).is_empty());
    }

    #[test]
    fn scores_have_as_many_digits_as_tell_them_apart() {
        let of = |score, threshold| {
            let track = judged(".", &[score], Some(threshold));
            comparison(&track.methods[0], 0).unwrap()
        };
        assert_eq!(
            [of(0.97, 0.8), of(0.8042, 0.8), of(0.0051, 0.004)],
            [".97 > .80", ".804 > .800", ".005 > .004"]
        );
        assert_eq!([of(2.5, 2.3), of(-0.25, 0.5)], ["2.50 > 2.30", "-.25 < .50"]);
        assert_eq!([of(0.8, 0.8), of(1e300, 2.0)], [".800000 = .800000", "1.00e300 > 2.00"]);
    }

    #[test]
    fn stretches_of_possible_losses_by_hand() {
        let found = |states: &str, score: &[f64]| -> Vec<(usize, usize)> {
            let track = judged(states, score, Some(0.8));
            possibly_lost(&track.methods[0]).into_iter().map(|run| (run.start, run.end)).collect()
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
        // Scores that are no probabilities are not judged.
        let mut track = judged(&states, &[0.7; 60], Some(0.8));
        track.methods[0].is_probability = false;
        assert!(possibly_lost(&track.methods[0]).is_empty());
    }
}
