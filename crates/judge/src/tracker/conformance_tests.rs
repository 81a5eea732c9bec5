//! Properties that all trackers of the list must have, tested on short synthetic sequences.

mod scenes_tests;

use super::testing::{Scene, context, excerpt, numbers, run, track};
use super::*;
use crate::plugin::{Configured, find};
use crate::region::{Areas, Rect};
use sha2::{Digest, Sha256};
use trackfail_dataset::format::otb;
use trackfail_testing::{assert_near, assert_says};

/// Options that change the course of a frame, beside those of the examples.
const VARIANTS: [(&str, &str); 13] = [
    ("color-particle-filter", "{ color_space = \"hsv\" }"),
    ("color-particle-filter", "{ resampling = \"multinomial\" }"),
    ("color-particle-filter", "{ kernel = \"points\" }"),
    ("color-particle-filter", "{ model_update = 0.2, initial_spread = 1, resample_below = 1 }"),
    ("color-particle-filter", "{ resample_below = 0, sigma_color = 0.01 }"),
    ("color-particle-filter", "{ bins = [1, 1, 1], particles = 2 }"),
    ("color-particle-filter", "{}"),
    ("fragments-particle-filter", "{}"),
    ("fragments-particle-filter", "{ particles = 3, reliability_rate = 1 }"),
    ("fragments-particle-filter", "{ sigma_likelihood = 0.01 }"),
    ("pixel-lut", "{}"),
    ("pixel-lut", "{ cells = 2 }"),
    ("pixel-lut", "{ search_radius = 1, memory = 2 }"),
];

/// A tracker of this kind.
fn build(kind: &str, params: &str) -> Configured<dyn TrackerConfig> {
    find(TRACKERS, kind).unwrap().build_from_text(params).unwrap()
}

fn finite(state: &TrackerState) -> bool {
    let corners = state.region.corners();
    let moments = state.posterior.iter().flat_map(|m| {
        let weights = [m.effective_samples, m.samples, m.entropy, m.likelihood];
        m.mean.iter().chain(&m.covariance).copied().chain(weights)
    });
    let moments = moments.chain(state.response.iter().flat_map(numbers));
    !corners.is_empty() && corners.iter().flat_map(|c| [c.0, c.1]).chain(moments).all(f64::is_finite)
}

#[test]
fn tracks_are_made_by_their_seed_alone_where_they_use_one() {
    let (q, region, frames) = excerpt(25);
    for e in TRACKERS {
        let by = |config: &dyn TrackerConfig, seed: u64| track(config, &q, seed, &region, &frames);
        let config = build(e.kind, e.example);
        let first = by(&*config, 7);
        assert_eq!(by(&*config, 7), first, "{}: started again", e.kind);
        assert_eq!(by(&*build(e.kind, e.example), 7), first, "{}: built again", e.kind);
        assert_eq!(config.facts().uses_seed, by(&*config, 8) != first, "{}: `uses_seed` is not true", e.kind);
    }
}

/// A fork continues like its tracker, or differently with another seed. All trackers with a posterior can be
/// forked.
#[test]
fn a_fork_goes_on_as_its_tracker_does_and_with_another_seed_otherwise() {
    let (q, region, frames) = excerpt(25);
    for e in TRACKERS {
        let config = build(e.kind, e.example);
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
        let uses_seed = config.facts().uses_seed;
        assert_eq!(go_on(&mut *other) != reseeded, uses_seed, "{}: forks of two seeds", e.kind);
        assert_eq!(rest != reseeded, uses_seed, "{}: a fork of another seed", e.kind);
        let whole = track(&*config, &q, 7, &region, &frames);
        assert_eq!([states, rest].concat(), whole, "{}: forked from", e.kind);
    }
}

/// On many frames, and on a single one, which is enough.
#[test]
fn answers_are_finite_and_marked_and_have_what_the_configuration_says() {
    let excerpts = [excerpt(1), excerpt(25)];
    for (e, (q, region, frames)) in TRACKERS.iter().flat_map(|e| excerpts.iter().map(move |of| (e, of))) {
        let config = build(e.kind, e.example);
        let facts = config.facts();
        let states = track(&*config, q, 3, region, frames);
        assert_eq!(states.len(), frames.len(), "{}", e.kind);
        assert_eq!((states[0].status, &states[0].region), (Status::Initialized, region), "{}", e.kind);
        for (t, s) in states.iter().enumerate() {
            assert!(finite(s), "{} frame {t}: {s:?}", e.kind);
            assert!(t == 0 || s.status == Status::Tracked, "{} frame {t}", e.kind);
            let has = (s.posterior.is_some(), s.response.is_some());
            assert_eq!(has, (facts.gives_posterior, facts.gives_response), "{} frame {t}", e.kind);
            let even = s.posterior.as_ref().is_none_or(|m| {
                let bound = m.entropy * m.samples.ln() + 1e-9;
                (1.0 - 1e-9..=m.samples + 1e-9).contains(&m.effective_samples)
                    && m.effective_samples.ln() <= bound
            });
            assert!(even, "{} frame {t}: entropy and number of weights", e.kind);
        }
    }
}

/// A tracker may refuse such a start, but must not panic, and its answers must be regions.
#[test]
fn survives_tiny_huge_and_distant_boxes() {
    let (mut q, _, frames) = excerpt(5);
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
        let config = build(e.kind, e.example);
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

/// Trackers that do not refuse the oddest starts, also on frames of a few pixels and of changing sizes. Shares of weights and
/// likelihoods stay what they are.
#[test]
fn variants_survive_the_oddest_starts() {
    let scene = Scene { step: (1, 1), ..Scene::SLOPES };
    let frames = scene.frames(6);
    let pixels = |w: usize, h: usize, level: u8| Frame::new(w, h, vec![level; 3 * w * h]);
    let tiny = [pixels(1, 1, 9), pixels(2, 1, 7), pixels(1, 3, 5), frames[0].clone()];
    for (x, y, w, h) in [
        (40.0, 30.0, 1.0, 1.0),
        (40.0, 30.0, 0.2, 50.0),
        (-50.0, -50.0, 400.0, 300.0),
        (-500.0, 20.0, 10.0, 10.0),
        (119.5, 89.5, 40.0, 40.0),
        (1e15, -1e15, 10.0, 10.0),
        (0.0, 0.0, 1e15, 1e-9),
    ] {
        let region = Region::Rect(Rect::new(x, y, w, h));
        for (kind, params) in VARIANTS {
            for frames in [&frames[..], &frames[..1], &tiny[..]] {
                for s in run(kind, params, 11, &region, frames) {
                    let sides = s.region.rect();
                    let is_sound = s.posterior.as_ref().map_or(sides.w > 0.0 && sides.h > 0.0, |m| {
                        (1.0..=m.samples + 1e-9).contains(&m.effective_samples)
                            && (0.0..=1.0 + 1e-9).contains(&m.likelihood)
                    });
                    assert!(finite(&s) && is_sound, "{kind} {params} {region:?}: {s:?}");
                }
            }
        }
    }
}

#[test]
fn a_start_without_numbers_is_refused() {
    let (q, _, frames) = excerpt(1);
    let nan = Region::Rect(Rect::new(f64::NAN, 0.0, 1.0, 1.0));
    let kinds_without = ["ncc", "still", "scripted"];
    for e in TRACKERS.iter().filter(|e| !kinds_without.contains(&e.kind)) {
        let started = build(e.kind, e.example).start(&context(&q, 1), &frames[0], &nan);
        assert_says(started.err().unwrap(), format!("{}: the first region is no region", e.kind));
    }
}

/// All particles are at the annotation, with equal weights, and fit it as well as can be.
#[test]
fn particles_start_at_the_annotation() {
    let sigma = "{ noise = [4, 4, 0.01, 0, 0.005, 0] }";
    for (kind, params, mean, samples, likelihood) in [
        ("color-particle-filter", "{}", &[50.0, 40.0, 20.0, 20.0, 0.0][..], 400.0, 1.0),
        ("fragments-particle-filter", "{}", &[50.0, 40.0], 400.0, 1.0),
        ("ivt", sigma, &[50.0, 40.0, 1.25, 1.0], 600.0, 1.0),
        ("sparse-prototypes", sigma, &[50.0, 40.0, 1.25, 1.0], 600.0, 1.0),
        ("adaptive-local-sparse", sigma, &[50.0, 40.0, 1.25, 1.0], 600.0, 9.0),
    ] {
        let states = Scene::WAVES.run(kind, params, 3, &Scene::WAVES.frames(1));
        let start = states[0].posterior.as_ref().unwrap();
        assert_eq!((&start.mean[..], start.samples), (mean, samples), "{kind} {params}");
        assert!(start.covariance.len() == mean.len().pow(2) && start.covariance.iter().all(|v| *v == 0.0));
        assert_near([start.effective_samples, start.likelihood], [samples, likelihood], 1e-9, kind);
    }
}

#[test]
fn frames_without_contrast_are_survived() {
    let (q, ..) = excerpt(4);
    for level in [0, 255] {
        let frames = vec![Frame::new(64, 48, vec![level; 3 * 64 * 48]); 4];
        let region = Region::Rect(Rect::new(20.0, 10.0, 16.0, 20.0));
        for e in TRACKERS {
            let states = track(&*build(e.kind, e.example), &q, 1, &region, &frames);
            assert!(states.iter().all(finite), "{} on gray level {level}", e.kind);
            let stays = ["ncc", "still"].contains(&e.kind);
            assert!(!stays || states.iter().all(|s| s.region == region), "{}: no place is better", e.kind);
        }
    }
}

#[trackfail_testing::needs(real_data)]
#[test]
fn real_targets_are_followed() {
    for (name, most, kind, params, least) in [
        ("FaceOcc1", 60, "sparse-prototypes", "{}", 0.75),
        ("Couple", usize::MAX, "nanotrack", "{ version = \"v2\" }", 0.68),
        ("Couple", usize::MAX, "nanotrack", "{ version = \"v3\" }", 0.63),
    ] {
        let q =
            otb::load(&trackfail_testing::real_data().join("otb").join(name), &Default::default()).unwrap();
        let frames: Vec<Frame> = (0..q.truth.len().min(most)).map(|t| q.frame(t).unwrap()).collect();
        let states = track(&*build(kind, params), &q, 1, q.truth[0].as_ref().unwrap(), &frames);
        let pairs = states.iter().zip(q.truth.iter().flatten());
        let overlaps = pairs.map(|(s, truth)| Areas::Exact.overlap(&s.region, truth, None));
        let mean = overlaps.sum::<f64>() / frames.len() as f64;
        assert!(mean > least, "{kind} {params} on {name}: {mean}");
    }
}

#[test]
fn parameters_that_do_not_go_together_are_refused() {
    let scales = |n: usize| format!("{{ scales = {:?} }}", vec![1.0; n]);
    let (most, too_many) = (scales(99), scales(100));
    let still = "{ noise = [0, 0, 0, 0, 0, 0] }";
    for (kind, params, key) in [
        ("sparse-prototypes", still, Some("noise")),
        ("sparse-prototypes", "{ noise = [4, nan, 0, 0, 0, 0] }", Some("noise")),
        ("sparse-prototypes", "{ low = 0.7 }", Some("high")),
        ("ivt", still, Some("noise")),
        ("adaptive-local-sparse", still, Some("noise")),
        ("dsst", "{ scales = 32 }", Some("scales")),
        ("kcf", "{ template = 15 }", Some("template")),
        ("kcf", "{ template = 1 }", Some("template")),
        ("kcf", "{ template = 0 }", None),
        ("kcf", "{ template = 16 }", None),
        ("samf", "{ scales = [] }", Some("scales")),
        ("samf", "{ scales = [1.0, 0.1] }", Some("scales")),
        ("samf", &*most, None),
        ("samf", &*too_many, Some("scales")),
    ] {
        let refused = find(TRACKERS, kind).unwrap().build_from_text(params).err();
        assert_eq!(refused.map(|e| e.key), key.map(Some), "{kind} {params}");
    }
}

#[test]
fn the_list_and_its_ranges_are_lawful() {
    crate::range_tests::check(TRACKERS);
    trackfail_testing::check_pins("range tracker", crate::range_tests::pins(TRACKERS));
}

#[test]
fn output_is_that_of_the_version() {
    let (q, region, frames) = excerpt(25);
    let pin = |e: &Entry<dyn TrackerConfig>| {
        let config = build(e.kind, e.example);
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
