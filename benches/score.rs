//! Success and precision of 540,000 boxes, in sequences of 1000 frames, by the rules of got10k-toolkit.
//!
//! `benches/peers/score_got10k.py` scores the same boxes with got10k itself; both use one thread.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use trackfail::region::Rect;
use trackfail::score::success::{Curves, RULES};

const FRAMES: u32 = 1000;
const SEQUENCES: u32 = 540;

/// Boxes of a sequence and their ground truth: near it, and off it in the last quarter.
fn sequence(s: u32) -> (Vec<Option<Rect>>, Vec<Option<Rect>>) {
    let truth = |t: u32| {
        Rect::new(f64::from((7 * t + s) % 500), f64::from((3 * t) % 300), 60.0, f64::from(40 + t % 9))
    };
    let tracked = |t: u32| {
        let off = if 4 * t > 3 * FRAMES { 45.0 } else { 0.0 };
        truth(t).shifted(off + f64::from((t * s) % 13), f64::from((t + s) % 7))
    };
    ((0..FRAMES).map(|t| Some(tracked(t))).collect(), (0..FRAMES).map(|t| Some(truth(t))).collect())
}

fn score(c: &mut Criterion) {
    let Some(rules) = RULES.iter().find(|r| r.name == "got10k/1") else { return };
    let all: Vec<_> = (0..SEQUENCES).map(sequence).collect();
    let mut group = c.benchmark_group("score");
    group.sample_size(20);
    group.bench_function(BenchmarkId::new("success", FRAMES * SEQUENCES), |b| {
        b.iter(|| {
            let curves: Vec<Curves> =
                black_box(&all).iter().map(|(boxes, truth)| rules.of_boxes(boxes, truth)).collect();
            Curves::mean(curves.iter().map(|curves| (1.0, curves))).map(|c| (c.auc(), c.precision_at_20()))
        });
    });
}

criterion_group!(benches, score);
criterion_main!(benches);
