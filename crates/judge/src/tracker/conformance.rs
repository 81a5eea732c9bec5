//! Properties of every tracker in the list, checked on short synthetic sequences.

use super::testing::{context, excerpt, track};
use super::*;
use crate::region::Rect;
use sha2::{Digest, Sha256};

fn finite(state: &TrackerState) -> bool {
    let corners = state.region.corners();
    let moments = state.posterior.iter().flat_map(|m| {
        let weights = [m.effective_samples, m.samples, m.entropy, m.likelihood];
        m.mean.iter().chain(&m.covariance).copied().chain(weights)
    });
    let map = state.response.iter().flat_map(|r| {
        let peaks = [r.peak, r.second_peak, r.lowest, r.mean, r.deviation];
        let sidelobes = [r.sidelobe_mean, r.sidelobe_deviation, r.narrow_sidelobe_mean];
        peaks.into_iter().chain(sidelobes).chain([r.narrow_sidelobe_deviation])
    });
    let moments = moments.chain(map);
    !corners.is_empty() && corners.iter().flat_map(|c| [c.0, c.1]).chain(moments).all(f64::is_finite)
}

#[test]
fn same_seed_same_track_also_after_a_restart() {
    let (q, frames) = excerpt(25);
    let region = q.truth[0].clone().unwrap();
    for e in TRACKERS {
        let config = e.build_from_text(e.example).unwrap();
        let first = track(&*config, &q, 7, &region, &frames);
        assert_eq!(track(&*config, &q, 7, &region, &frames), first, "{}: started again", e.kind);
        let again = e.build_from_text(e.example).unwrap();
        assert_eq!(track(&*again, &q, 7, &region, &frames), first, "{}: built again", e.kind);
    }
}

#[test]
fn trackers_that_use_no_seed_give_the_same_track_with_any() {
    let (q, frames) = excerpt(25);
    let region = q.truth[0].clone().unwrap();
    for e in TRACKERS {
        let config = e.build_from_text(e.example).unwrap();
        let tracks = [1, 2].map(|seed| track(&*config, &q, seed, &region, &frames));
        assert_eq!(config.facts().uses_seed, tracks[0] != tracks[1], "{}: `uses_seed` is not true", e.kind);
    }
}

/// Those that give a posterior can be started from it.
#[test]
fn a_fork_goes_on_as_its_tracker_does_and_with_another_seed_otherwise() {
    let (q, frames) = excerpt(25);
    let region = q.truth[0].clone().unwrap();
    for e in TRACKERS {
        let config = e.build_from_text(e.example).unwrap();
        let (mut tracker, first) = config.start(&context(&q, 7), &frames[0], &region).unwrap();
        let mut states = vec![first];
        states.extend(frames[1..12].iter().map(|f| tracker.update(f).unwrap()));
        let Some(mut same) = tracker.fork(None) else {
            assert!(states.iter().all(|s| s.posterior.is_none()), "{}: a posterior, but no fork", e.kind);
            continue;
        };
        let go_on = |tracker: &mut dyn Tracker| -> Vec<TrackerState> {
            frames[12..].iter().map(|f| tracker.update(f).unwrap()).collect()
        };
        let [mut one, mut again, mut other] = [3, 3, 4].map(|seed| tracker.fork(Some(seed)).unwrap());
        let reseeded = go_on(&mut *one);
        let rest = go_on(&mut *tracker);
        assert_eq!(go_on(&mut *same), rest, "{}: a fork", e.kind);
        assert_eq!(go_on(&mut *again), reseeded, "{}: two forks of a seed", e.kind);
        assert_eq!(
            go_on(&mut *other) != reseeded,
            config.facts().uses_seed,
            "{}: forks of two seeds",
            e.kind
        );
        assert_eq!(rest != reseeded, config.facts().uses_seed, "{}: a fork of another seed", e.kind);
        assert_eq!(
            [states, rest].concat(),
            track(&*config, &q, 7, &region, &frames),
            "{}: forked from",
            e.kind
        );
    }
}

#[test]
fn answers_have_what_the_configuration_says() {
    let (q, frames) = excerpt(4);
    let region = q.truth[0].clone().unwrap();
    for e in TRACKERS {
        let config = e.build_from_text(e.example).unwrap();
        for s in track(&*config, &q, 3, &region, &frames) {
            assert_eq!(s.posterior.is_some(), config.facts().gives_posterior, "{}", e.kind);
            assert_eq!(s.response.is_some(), config.facts().gives_response, "{}", e.kind);
            let even = s.posterior.is_none_or(|m| {
                let bound = m.entropy * m.samples.ln() + 1e-9;
                (1.0..=m.samples).contains(&m.effective_samples) && m.effective_samples.ln() <= bound
            });
            assert!(even, "{}: entropy and number of weights", e.kind);
        }
    }
}

#[test]
fn answers_are_finite_and_marked() {
    let (q, frames) = excerpt(25);
    let region = q.truth[0].clone().unwrap();
    for e in TRACKERS {
        let config = e.build_from_text(e.example).unwrap();
        let states = track(&*config, &q, 3, &region, &frames);
        assert_eq!((states[0].status, &states[0].region), (Status::Initialized, &region), "{}", e.kind);
        for (t, s) in states.iter().enumerate() {
            assert!(finite(s), "{} frame {t}: {s:?}", e.kind);
            assert!(t == 0 || s.status == Status::Tracked, "{} frame {t}", e.kind);
        }
    }
}

#[test]
fn one_frame_is_enough() {
    let (q, frames) = excerpt(1);
    for e in TRACKERS {
        let config = e.build_from_text(e.example).unwrap();
        let states = track(&*config, &q, 1, q.truth[0].as_ref().unwrap(), &frames);
        assert!(states.len() == 1 && finite(&states[0]), "{}", e.kind);
    }
}

/// A tracker may refuse such a start, but must not break down, and what it answers must be a region.
#[test]
fn survives_tiny_huge_and_distant_boxes() {
    let (mut q, frames) = excerpt(5);
    let (w, h) = (frames[0].width() as f64, frames[0].height() as f64);
    let mut regions: Vec<Region> = [
        (10.0, 10.0, 1.0, 1.0),
        (10.3, 10.7, 0.25, 0.5),
        (20.0, 20.0, 2.0, 1.0),
        (20.0, 20.0, 3.0, 40.0),
        (-5.0, -5.0, 12.0, 12.0),
        (w - 3.0, h - 3.0, 12.0, 20.0),
        (-80.0, 20.0, 20.0, 20.0),
        (w + 30.0, h + 30.0, 20.0, 20.0),
        (0.0, 0.0, w, h),
        (-w, -h, 3.0 * w, 3.0 * h),
    ]
    .map(|(x, y, w, h)| Region::Rect(Rect::new(x, y, w, h)))
    .into();
    regions.push(Region::Polygon(vec![(30.0, 20.0), (60.0, 40.0), (50.0, 55.0), (20.0, 35.0)]));
    for e in TRACKERS {
        let config = e.build_from_text(e.example).unwrap();
        for region in &regions {
            q.truth.fill(Some(region.clone()));
            if let Ok((mut tracker, first)) = config.start(&context(&q, 1), &frames[0], region) {
                assert!(finite(&first), "{} {region:?}", e.kind);
                for f in &frames[1..] {
                    if let Ok(s) = tracker.update(f) {
                        assert!(finite(&s), "{} {region:?}: {s:?}", e.kind);
                    }
                }
            }
        }
    }
}

#[test]
fn frames_without_contrast_are_survived() {
    let (q, _) = excerpt(4);
    for level in [0, 255] {
        let frames = vec![Frame::new(64, 48, vec![level; 3 * 64 * 48]); 4];
        let region = Region::Rect(Rect::new(20.0, 10.0, 16.0, 20.0));
        for e in TRACKERS {
            let config = e.build_from_text(e.example).unwrap();
            let states = track(&*config, &q, 1, &region, &frames);
            assert!(states.iter().all(finite), "{} on gray level {level}", e.kind);
        }
    }
}

#[test]
fn ranges_are_what_is_accepted() {
    crate::range_tests::check(TRACKERS);
    trackfail_testing::check_pins("range tracker", crate::range_tests::pins(TRACKERS));
}

#[test]
fn unknown_parameters_are_refused() {
    for e in TRACKERS {
        let inner = e.example.trim().trim_start_matches('{').trim_end_matches('}').trim();
        let comma = if inner.is_empty() { "" } else { "," };
        let text = format!("{{ {inner}{comma} no-such-parameter = 1 }}");
        let refused = e.build_from_text(&text).err().unwrap_or_else(|| panic!("{}: {text}", e.kind));
        assert!(refused.message.contains("no-such-parameter"), "{}: {}", e.kind, refused.message);
    }
}

#[test]
fn parameters_survive_being_shown_and_read() {
    for e in TRACKERS {
        let shown = e.build_from_text(e.example).unwrap().params();
        let table: toml::Value = serde_json::from_value(without_nulls(shown.clone())).unwrap();
        let text = toml::Value::try_from(&table).unwrap().to_string();
        let again = e.build_from_text(&text).unwrap();
        assert_eq!(again.params(), shown, "{}", e.kind);
    }
}

/// TOML has no null: an option that is not set is left out.
fn without_nulls(v: serde_json::Value) -> serde_json::Value {
    match v {
        serde_json::Value::Object(m) => {
            m.into_iter().filter(|(_, v)| !v.is_null()).map(|(k, v)| (k, without_nulls(v))).collect()
        }
        other => other,
    }
}

#[test]
fn the_list_is_in_order() {
    let kinds: Vec<_> = TRACKERS.iter().map(|e| e.kind).collect();
    let mut unique = kinds.clone();
    unique.sort_unstable();
    unique.dedup();
    assert_eq!(unique.len(), kinds.len(), "a kind twice: {kinds:?}");
    for e in TRACKERS {
        assert!(e.version >= 1 && !e.summary.is_empty(), "{}", e.kind);
        assert!((e.schema)().as_value().is_object(), "{}", e.kind);
    }
}

#[test]
fn output_is_that_of_the_version() {
    let (q, frames) = excerpt(25);
    let region = q.truth[0].clone().unwrap();
    let pin = |e: &Entry<dyn TrackerConfig>| {
        let config = e.build_from_text(e.example).unwrap();
        let mut hash = Sha256::new();
        // To a hundredth of a pixel: the exponentials of one system's library may differ in their last bits from those of
        // another.
        for s in track(&*config, &q, 2016, &region, &frames) {
            for (x, y) in s.region.corners() {
                hash.update(((x * 100.0).round() as i64).to_le_bytes());
                hash.update(((y * 100.0).round() as i64).to_le_bytes());
            }
        }
        let digest: String = hash.finalize().iter().take(8).map(|b| format!("{b:02x}")).collect();
        format!("{} {} {digest}", e.kind, e.version)
    };
    trackfail_testing::check_pins("output tracker", TRACKERS.iter().map(pin));
}
