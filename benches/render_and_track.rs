//! Frames per second of rendering a synthetic sequence, and of tracking it by cross-correlation.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use trackfail::dataset::{Frames, Sequence, synthetic};
use trackfail::image::Frame;
use trackfail::tracker::{RunContext, ncc};

fn sequence(suite: &str, name: &str) -> Sequence {
    let mut all = synthetic::suite(suite).expect("a built-in suite");
    let k = all.iter().position(|q| q.name == name).expect("a built-in sequence");
    all.swap_remove(k)
}

fn frames(q: &Sequence, n: usize) -> Vec<Frame> {
    match &q.frames {
        Frames::Rendered(r, _) => (0..n).map(|t| r(t)).collect(),
        _ => unreachable!("synthetic sequences are rendered"),
    }
}

fn render(c: &mut Criterion) {
    c.bench_function("list all suites", |b| {
        b.iter(|| synthetic::SUITES.iter().map(|s| s.sequences().len()).sum::<usize>());
    });
    let mut group = c.benchmark_group("render");
    group.sample_size(10).throughput(Throughput::Elements(50));
    // 320x240 without and with motion blur.
    for name in ["Crowd", "Pan"] {
        let q = sequence("synthetic-otb", name);
        frames(&q, 1);
        group.bench_function(name, |b| b.iter(|| black_box(frames(&q, 50))));
    }
    // 320x240 with few and with many others, and 360x288.
    for name in ["car-bridge", "car-queue", "face-pair", "person-crossing", "person-group"] {
        let q = sequence("synthetic-d1", name);
        frames(&q, 1);
        group.bench_function(name, |b| b.iter(|| black_box(frames(&q, 50))));
    }
}

fn track(c: &mut Criterion) {
    let mut group = c.benchmark_group("ncc");
    group.sample_size(10).throughput(Throughput::Elements(49));
    let setup = ncc::ENTRY.build_from_text("{}").expect("default parameters");
    // Targets of 25x74, 80x38 and 88x110 pixels.
    for name in ["Crowd", "Parking", "Magazine"] {
        let q = sequence("synthetic-otb", name);
        let pixels = frames(&q, 50);
        let first = q.truth[0].clone().expect("synthetic truth is complete");
        let context = RunContext { sequence: &q, start_frame: 0, run: 0, seed: 0, data_roots: &[] };
        group.bench_function(name, |b| {
            b.iter(|| {
                let started = setup.start(&context, &pixels[0], &first);
                let (mut t, _) = started.expect("ncc starts everywhere");
                for f in &pixels[1..] {
                    black_box(t.update(f).expect("ncc goes on"));
                }
            });
        });
    }
}

criterion_group!(benches, render, track);
criterion_main!(benches);
