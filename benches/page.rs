//! The page of made-up results: 100 sequences of 300 frames, 10 methods, 2 trackers. Times of counting, of packing the
//! series, and of rendering with the series inside the page and beside it.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use trackfail::region::{Rect, Region};
use trackfail::report::sequences::json::{beside, embedded};
use trackfail::report::sequences::{JudgedSeries, Method, Sequence, Sequences, Track};
use trackfail::report::{Page, render};
use trackfail::score::protocol;

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

fn result() -> Sequences {
    let protocol = protocol("khalid2016/1").expect("a protocol");
    let sequence = |s: usize| Sequence {
        name: format!("Sequence {s:03}"),
        first: 1,
        size: Some((640, 480)),
        attributes: ["occlusion", "scale-change", "motion-blur"].map(String::from)[..s % 4].to_vec(),
        truth: (0..FRAMES).map(|t| Some(Region::Rect(Rect::new(t as f64, 99.0, 40.0, 30.0)))).collect(),
        stills: Default::default(),
        pictures: Default::default(),
    };
    let track = |k: usize| {
        let mut number = noise(k);
        let error: Vec<f64> = (0..FRAMES).map(|t| if t % 60 > 45 { 1.0 } else { number() }).collect();
        let rects = (0..FRAMES).map(|t| Rect::new(t as f64 + number(), 99.0, 40.0, 30.0)).collect();
        let said = |m: usize| {
            let mut number = noise(k * METHODS + m);
            let score: Vec<f64> = (0..FRAMES).map(|_| number()).collect();
            let alarm: Vec<bool> = score.iter().map(|v| *v > 0.95).collect();
            let changes = vec![0; FRAMES];
            let judged = protocol.judge(&error, &alarm, &changes, &[]);
            JudgedSeries { score, alarm, changes, judged, ..JudgedSeries::default() }
        };
        let methods = (0..METHODS).map(|m| (m, said(m))).collect();
        Track { sequence: k / TRACKERS, tracker: k % TRACKERS, rects, error, methods, ..Track::default() }
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
        tracks: (0..SEQUENCES * TRACKERS).map(track).collect(),
        note: String::new(),
        unannotated: false,
    }
}

fn page(criterion: &mut Criterion) {
    let all = result();
    let mut group = criterion.benchmark_group("page");
    group.sample_size(10);
    group.bench_function("series-in-it", |b| {
        b.iter(|| {
            let all = black_box(&all).packed();
            let series = embedded(&all, usize::MAX).expect("room");
            render(&Page { sequences: all.tallies(), series, ..Page::default() }).expect("a page")
        });
    });
    group.bench_function("series-beside-it", |b| {
        b.iter(|| {
            let all = black_box(&all).packed();
            let mut bytes = 0;
            let packed = beside::<()>(&all, |_, text| {
                bytes += text.len();
                Ok(())
            });
            let (series, _) = packed.expect("packed");
            let page = Page { sequences: all.tallies(), series, beside: true, ..Page::default() };
            (render(&page).expect("a page"), bytes)
        });
    });
    group.finish();
}

criterion_group!(benches, page);
criterion_main!(benches);
