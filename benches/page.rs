//! The page of made-up results: 100 sequences of 300 frames, 10 methods, 2 trackers. Times of packing the series, of
//! counting, and of rendering with the series inside the page and beside it.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use trackfail::region::{Rect, Region};
use trackfail::report::sequences::json::{Said, beside, embedded};
use trackfail::report::sequences::{Method, Sequence, Sequences, Track};
use trackfail::report::{Page, render};
use trackfail::results::{MethodSeries, TrackSeries};
use trackfail::score::{TrackScore, protocol};

const SEQUENCES: usize = 100;
const METHODS: usize = 10;
const TRACKERS: usize = 2;
const FRAMES: usize = 300;

/// Whole numbers without an order to be seen, the same every time.
fn noise(seed: usize) -> impl FnMut() -> f64 {
    let mut state = seed as u64 * 0x9e37_79b9_7f4a_7c15 + 1;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Values and score of one method on a track.
type Judged = (MethodSeries, TrackScore);

/// Each track with the values of its methods.
fn tracks() -> Vec<(TrackSeries, Vec<Judged>)> {
    let protocol = protocol("khalid2016/1").expect("a protocol");
    let track = |k: usize| {
        let mut number = noise(k);
        let error = (0..FRAMES).map(|t| if t % 60 > 45 { 1.0 } else { number() }).collect();
        let rects = (0..FRAMES).map(|t| Rect::new(t as f64 + number(), 99.0, 40.0, 30.0)).collect();
        let track = TrackSeries { rects, error, ..TrackSeries::default() };
        let said = |m: usize| {
            let mut number = noise(k * METHODS + m);
            let score: Vec<f64> = (0..FRAMES).map(|_| number()).collect();
            let alarm = score.iter().map(|v| *v > 0.95).collect();
            let series = MethodSeries { score, alarm, changes: vec![0; FRAMES], ..MethodSeries::default() };
            let judged = track.judge(protocol, &series.alarm, &series.changes);
            (series, judged)
        };
        let said = (0..METHODS).map(said).collect();
        (track, said)
    };
    (0..SEQUENCES * TRACKERS).map(track).collect()
}

fn packed(tracks: &[(TrackSeries, Vec<Judged>)]) -> Sequences {
    let sequence = |s: usize| Sequence {
        name: format!("Sequence {s:03}"),
        first: 1,
        size: Some((640, 480)),
        attributes: ["occlusion", "scale-change", "motion-blur"].map(String::from)[..s % 4].to_vec(),
        truth: (0..FRAMES).map(|t| Some(Region::Rect(Rect::new(t as f64, 99.0, 40.0, 30.0)))).collect(),
        ..Sequence::default()
    };
    let track = |(k, (track, said)): (usize, &(TrackSeries, Vec<Judged>))| {
        let pack = |(series, judged): &Judged| Said::new(track, series, judged, Some(0.95));
        let said = said.iter().map(pack).enumerate().collect();
        Track::new([k / TRACKERS, k % TRACKERS], track, &[], said)
    };
    let method = |m: usize| Method {
        name: format!("Method {m}"),
        thresholds: vec![Some(0.95); TRACKERS],
        counted: String::new(),
    };
    Sequences {
        trackers: (0..TRACKERS).map(|t| format!("Tracker {t}")).collect(),
        methods: (0..METHODS).map(method).collect(),
        sequences: (0..SEQUENCES).map(sequence).collect(),
        tracks: tracks.iter().enumerate().map(track).collect(),
        ..Sequences::default()
    }
}

fn page(criterion: &mut Criterion) {
    let tracks = tracks();
    let mut group = criterion.benchmark_group("page");
    group.sample_size(10);
    group.bench_function("series-in-it", |b| {
        b.iter(|| {
            let all = packed(black_box(&tracks));
            let series = embedded(&all, usize::MAX).expect("room");
            render(&Page { sequences: all.tallies(), series, ..Page::default() }).expect("a page")
        });
    });
    group.bench_function("series-beside-it", |b| {
        b.iter(|| {
            let all = packed(black_box(&tracks));
            let mut bytes = 0;
            let split = beside::<()>(&all, |_, text| {
                bytes += text.len();
                Ok(())
            });
            let (series, _) = split.expect("packed");
            let page = Page { sequences: all.tallies(), series, beside: true, ..Page::default() };
            (render(&page).expect("a page"), bytes)
        });
    });
}

criterion_group!(benches, page);
criterion_main!(benches);
