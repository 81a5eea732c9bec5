use super::*;
use crate::signal::testing;
use crate::tracker::{self, TrackerState};

const ALL: &str = "{ v2 = [\"overlap\", \"score\"], v3 = [\"overlap\", \"score\"], both = [\"product\", \"least\", \
                   \"most\", \"overlap\", \"against\", \"apart\"], here = [\"score\", \"overlap\", \"disagreement\", \
                   \"apart\", \"distance\", \"middle\", \"inside\", \"outside\", \"elsewhere\"] }";

/// All values beside a tracker that follows a face for ten frames, and is `shift` pixels further on from then on.
fn beside(shift: f64) -> Vec<Vec<f64>> {
    beside_with(ALL, shift)
}

/// Values of a signal beside the same tracker.
fn beside_with(params: &str, shift: f64) -> Vec<Vec<f64>> {
    let (girl, frames) = tracker::testing::excerpt(20);
    let config = tracker::nanotrack::ENTRY.build_from_text("{}").unwrap();
    let states = tracker::testing::track(&*config, &girl, 1, girl.truth[0].as_ref().unwrap(), &frames);
    let signal = ENTRY.build_from_text(params).unwrap();
    let mut session = testing::start(&*signal);
    let of = |(t, (frame, state)): (usize, (&Frame, &TrackerState))| {
        let bounds = state.region.bounds().shifted(if t < 10 { 0.0 } else { shift }, 0.0);
        let state = TrackerState { region: Region::Rect(bounds), ..state.clone() };
        let first = session.push(&Observation::new(frame, &state));
        std::iter::once(first).chain(session.more().iter().copied()).collect()
    };
    frames.iter().zip(&states).enumerate().map(of).collect()
}

#[test]
fn values_of_both_watchdogs_are_made_of_theirs() {
    for values in beside(60.0) {
        let [i2, s2, i3, s3, product, least, most, overlap, against, apart] = values[..10] else { panic!() };
        let (r2, r3) = ((1.0 - i2) * s2, (1.0 - i3) * s3);
        assert_eq!([product, least, most], [r2 * r3, r2.min(r3), r2.max(r3)]);
        assert!((against - overlap * s2.min(s3) * (1.0 - i2.max(i3))).abs() < 1e-15);
        assert!((apart - (1.0 - overlap) * s2.min(s3)).abs() < 1e-15);
    }
}

/// On the target the second look is that of the watchdog, whose box the tracker has. Off it, its best place is another
/// one while the target is within its search region; beyond the frame, in one color, all places are alike.
#[test]
fn a_second_look_tells_the_target_from_its_surroundings() {
    let here = |values: &[f64]| <[f64; 9]>::try_from(&values[10..]).unwrap();
    for values in beside(0.0) {
        let [score, overlap, disagreement, apart, distance, middle, inside, outside, elsewhere] =
            here(&values);
        assert!(score > 0.9 && overlap > 0.7 && apart == 0.0 && distance < 0.2 && middle > 0.8, "{values:?}");
        assert!((disagreement - (1.0 - overlap) * score).abs() < 1e-15);
        assert!(inside > 2.0 && outside < 1.0 && elsewhere < -2.0, "{values:?}");
    }
    let (near, far) = (beside(60.0), beside(500.0));
    let [score, overlap, .., inside, outside, elsewhere] = here(&near[15]);
    assert!(score < 0.5 && overlap < 0.6 && inside < 0.0 && outside > 1.0 && elsewhere > 1.0, "{near:?}");
    let [.., inside, _, elsewhere] = here(&far[15]);
    assert!(inside < 2.0 && elsewhere.abs() < 0.5, "{far:?}");
}

// By a signal of v3 alone: its watchdog's values are those beside v2, and its second look is another network's.
#[test]
fn a_second_look_of_v3_needs_no_v2() {
    let alone = ALL.replace("v2 = [\"overlap\", \"score\"], ", "");
    let i = alone.find("both = ").unwrap();
    let alone = format!(
        "{}{}, look = \"v3\" }}",
        &alone[..i],
        alone[alone.find("here = ").unwrap()..].trim_end_matches(" }")
    );
    let (of_v3, of_both) = (beside_with(&alone, 60.0), beside(60.0));
    assert!(of_v3.iter().zip(&of_both).all(|(mine, all)| mine[..2] == all[2..4] && mine.len() == 11));
    let [score, .., elsewhere] = of_v3[15][2..] else { panic!() };
    assert!(score < 0.7 && elsewhere > 0.0 && of_v3[15][2..] != of_both[15][10..], "{of_v3:?}");
    assert!(of_v3[5][2] > 0.9 && of_v3[5][10] < -2.0, "{of_v3:?}");
}

#[test]
fn a_box_without_numbers_has_no_cells_and_is_apart_from_the_watchdogs() {
    let (girl, frames) = tracker::testing::excerpt(2);
    let signal = ENTRY.build_from_text("{ v2 = [\"overlap\"], here = [\"score\", \"inside\"] }").unwrap();
    let mut session = testing::start(&*signal);
    let state = |region: Region| TrackerState::tracked(region);
    session.push(&Observation::new(&frames[0], &state(girl.truth[0].clone().unwrap())));
    let overlap = session.push(&Observation::new(&frames[1], &state(Region::nowhere())));
    assert_eq!(overlap, 0.0);
    assert_eq!(session.more(), [0.0, -6.0]);
}

#[test]
fn values_are_named_once_and_the_first_one_gives_direction_and_bounds() {
    for (text, key) in [
        ("{ here = [] }", "here"),
        ("{ here = [\"score\", \"score\"] }", "here"),
        ("{ v3 = [\"score\", \"score\"] }", "v3"),
    ] {
        assert_eq!(ENTRY.build_from_text(text).err().and_then(|e| e.key), Some(key), "{text}");
    }
    let of = |text: &str| ENTRY.build_from_text(text).unwrap();
    assert_eq!((of(ALL).width(), of("{}").width()), (19, 1));
    assert_eq!(of("{ here = [\"inside\"] }").direction(), Direction::HigherIsBetter);
    assert_eq!(of("{ here = [\"elsewhere\"] }").bounds(), (-8.0, 8.0));
    let (least, most) = of("{ here = [\"outside\"] }").bounds();
    assert!(least == -6.0 && (most - 999_999.0_f64.ln()).abs() < 1e-9);
}
