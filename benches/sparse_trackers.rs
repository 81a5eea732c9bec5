//! Time per frame of the trackers with 600 affine candidates on a target of 64 x 64 pixels, one thread.
//!
//! Each tracker first follows 40 frames, so that its model is complete, and is then timed on the same frames again and
//! again: a textured target that moves, a third of it hidden now and then, under noise of up to 12 pixel values.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use trackfail::image::Frame;
use trackfail::plugin::Entry;
use trackfail::region::Rect;
use trackfail::tracker::{TrackerConfig, adaptive_local_sparse, ivt, sparse_prototypes};
use trackfail_benches::started;

/// Frame `t` of a closed path, 320 x 240.
fn frame(t: usize) -> Frame {
    let turn = std::f64::consts::TAU * t as f64 / 40.0;
    let (left, top) = (128.0 + 20.0 * turn.cos(), 88.0 + 12.0 * turn.sin());
    Frame::from_fn(320, 240, |x, y| {
        let (u, v) = (x as f64 - left, y as f64 - top);
        let smooth = if (0.0..64.0).contains(&u) && (0.0..64.0).contains(&v) {
            if t % 20 >= 16 && v > 43.0 {
                230.0
            } else {
                120.0 + 50.0 * (0.2 * u).sin() * (0.3 * v).cos() + u / 2.0
            }
        } else {
            90.0 + 30.0 * (0.03 * x as f64).sin() + 20.0 * (0.05 * y as f64).cos()
        };
        let texture = ((x * 7919 + y * 104_729 + t * 1299) * 2_654_435_761 % 4_294_967_296) >> 16;
        [(smooth + (texture % 25) as f64 - 12.0).clamp(0.0, 255.0) as u8; 3]
    })
}

fn candidates(criterion: &mut Criterion) {
    let frames: Vec<Frame> = (0..40).map(frame).collect();
    let entries: [&Entry<dyn TrackerConfig>; 3] =
        [&sparse_prototypes::ENTRY, &ivt::ENTRY, &adaptive_local_sparse::ENTRY];
    for entry in entries {
        let mut tracker = started(entry, "{}", &frames[0], Rect::new(148.0, 88.0, 64.0, 64.0));
        for frame in &frames {
            tracker.update(frame).expect("it goes on");
        }
        let mut next = frames.iter().cycle();
        let mut group = criterion.benchmark_group(entry.kind);
        group.sample_size(10).bench_with_input(BenchmarkId::from_parameter(600), &600, |bencher, _| {
            bencher.iter(|| next.next().map(|frame| tracker.update(black_box(frame)).expect("it goes on")))
        });
    }
}

criterion_group!(benches, candidates);
criterion_main!(benches);
