//! Output on stdout: the verdict for people, or all frames for programs.

use crate::cli::Failure;
use crate::cli::output::{self, Format};
use crate::report::verdict::{Stretch, of_target, possibly_lost, stretches, table, verdict};
use crate::results::detections::{self, JudgedMethod, JudgedTrack, TargetState};
use serde_json::{Value, json};

/// Prints the results of the methods.
pub fn print(format: Format, tracks: &[&JudgedTrack]) -> Result<(), Failure> {
    match format {
        Format::Table => output::write(&for_people(tracks)?),
        Format::Csv => {
            let bytes = detections::csv(tracks).map_err(Failure::io)?;
            output::write(&String::from_utf8_lossy(&bytes))
        }
        Format::Json => {
            let text = serde_json::to_string(&json(tracks)).map_err(Failure::io)?;
            output::write(&(text + "\n"))
        }
    }
}

/// Verdict of the first method on each target with the stretches behind it. If several methods ran, also one
/// line for each.
fn for_people(tracks: &[&JudgedTrack]) -> Result<String, Failure> {
    let mut text = String::new();
    for track in tracks {
        let Some(first) = track.methods.first() else { continue };
        text.push_str(&of_target(track, &verdict(track, first)));
        text.push('\n');
    }
    let mut rows = table(tracks);
    let headings = rows.remove(0);
    if !rows.is_empty() {
        let headings: Vec<&str> = headings.iter().map(String::as_str).collect();
        text.push('\n');
        text.push_str(&output::text(Format::Table, &headings, &rows)?);
    }
    if tracks.iter().any(|track| track.methods.len() > 1) {
        // Targets have names where there are several.
        let skipped = usize::from(tracks.len() < 2);
        let headings = &["target", "method", "losses", "frames lost", "first", "at the end"][skipped..];
        let rows = tracks.iter().flat_map(|track| track.methods.iter().map(move |m| row(track, m, skipped)));
        text.push('\n');
        text.push_str(&output::text(Format::Table, headings, &rows.collect::<Vec<_>>())?);
    }
    Ok(text)
}

/// Table row of a method, without the first `skipped` cells.
fn row(track: &JudgedTrack, method: &JudgedMethod, skipped: usize) -> Vec<String> {
    let losses = method.losses();
    let lost: usize = losses.iter().map(ExactSizeIterator::len).sum();
    let first = losses.first().map(|run| track.number(run.start).to_string());
    let cells = [
        track.target.map(|id| id.to_string()).unwrap_or_default(),
        method.name.clone(),
        losses.len().to_string(),
        format!("{lost} of {}", method.states.len()),
        first.unwrap_or_default(),
        method.states.last().map_or("", |state| state.word()).to_string(),
    ];
    cells[skipped..].to_vec()
}

/// All results as JSON, with the first and last frame of each stretch.
fn json(tracks: &[&JudgedTrack]) -> Value {
    let of_track = |track: &JudgedTrack| {
        let methods: Vec<Value> = track.methods.iter().map(|method| of_method(track, method)).collect();
        json!({ "target": track.target, "methods": methods })
    };
    json!({ "tracks": tracks.iter().map(|track| of_track(track)).collect::<Vec<_>>() })
}

fn of_method(track: &JudgedTrack, method: &JudgedMethod) -> Value {
    let span =
        |run: std::ops::Range<usize>| json!([track.number(run.start), track.number(run.end.max(1) - 1)]);
    let in_state = |wanted: TargetState| -> Vec<Value> {
        method.stretches().filter(|(state, _)| *state == wanted).map(|(_, run)| span(run)).collect()
    };
    let stretch = |stretch: Stretch| {
        json!({
            "from": track.number(stretch.frames.start),
            "to": track.number(stretch.frames.end - 1),
            "state": stretch.state.word(),
            "probability": stretch.probability,
            "why": stretch.why,
        })
    };
    let frame = |t: usize| {
        json!({
            "frame": track.number(t),
            "score": method.score.get(t).copied().flatten(),
            "label": u8::from(method.label.get(t) == Some(&true)),
            "change": method.changes.get(t),
            "state": method.states.get(t).map(|state| state.word()),
        })
    };
    json!({
        "method": method.name,
        "threshold": method.threshold,
        "verdict": verdict(track, method),
        "lost": in_state(TargetState::Lost),
        "absent": in_state(TargetState::Absent),
        "possibly_lost": possibly_lost(method).into_iter().map(span).collect::<Vec<_>>(),
        "stretches": stretches(method).into_iter().map(stretch).collect::<Vec<_>>(),
        "frames": (0..method.states.len()).map(frame).collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::Direction;
    use proptest::prelude::*;

    proptest! {
        // The law: the spans and stretches of the JSON are those of its frames, and no frame is in two of them.
        #[test]
        fn json_says_one_thing_of_a_frame(
            frames in prop::collection::vec((0_usize..3, 0.0_f64..1.0), 1..60),
        ) {
            let states: Vec<TargetState> = frames
                .iter()
                .map(|(state, _)| [TargetState::Tracking, TargetState::Lost, TargetState::Absent][*state])
                .collect();
            let method = JudgedMethod {
                name: "M".into(),
                threshold: Some(0.8),
                direction: Direction::LowerIsBetter,
                is_probability: true,
                score: frames.iter().map(|(_, p)| Some(*p)).collect(),
                alarm_score: None,
                label: states.iter().map(|state| *state == TargetState::Lost).collect(),
                changes: vec![0; states.len()],
                states,
            };
            let track = JudgedTrack { target: None, first: 1, methods: vec![method] };
            let json = of_method(&track, &track.methods[0]);
            let has = |key: &str, number: u64| {
                let spans = json[key].as_array().unwrap().iter();
                spans.filter(|s| (s[0].as_u64().unwrap()..=s[1].as_u64().unwrap()).contains(&number)).count()
            };
            for frame in json["frames"].as_array().unwrap() {
                let (number, state) = (frame["frame"].as_u64().unwrap(), frame["state"].as_str().unwrap());
                prop_assert_eq!(has("lost", number), usize::from(state == "lost"));
                prop_assert_eq!(has("absent", number), usize::from(state == "absent"));
                prop_assert!(has("possibly_lost", number) <= usize::from(state == "tracking"));
                let here = json["stretches"].as_array().unwrap().iter().filter(|s| {
                    (s["from"].as_u64().unwrap()..=s["to"].as_u64().unwrap()).contains(&number)
                });
                prop_assert!(here.clone().all(|stretch| stretch["state"] == state));
                prop_assert!(here.count() <= 1);
            }
        }
    }
}
