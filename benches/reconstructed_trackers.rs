//! Time per frame of the two reconstructed trackers, one thread: `fragments-particle-filter` with 400 particles on a
//! target of 40 x 80 pixels, and `pixel-lut` with all windows within 30 pixels of a target of 64 x 64, learning included.
//!
//! `benches/peers/reconstructed_trackers.py` does the most expensive part of the latter in NumPy.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use trackfail::region::Rect;
use trackfail::tracker::{fragments_particle_filter, pixel_lut};
use trackfail_benches::{frame_with_target, started};

fn reconstructions(criterion: &mut Criterion) {
    let frame = frame_with_target([32.0, 32.0]);
    let (tall, square) = (Rect::new(140.0, 80.0, 40.0, 80.0), Rect::new(128.0, 88.0, 64.0, 64.0));
    let cases = [
        ("fragments-particle-filter", &fragments_particle_filter::ENTRY, "{}", tall, 400),
        ("pixel-lut", &pixel_lut::ENTRY, "{}", square, 64),
        ("pixel-lut-24-cells", &pixel_lut::ENTRY, "{ cells = 24 }", square, 64),
    ];
    for (name, entry, params, target, size) in cases {
        let mut tracker = started(entry, params, &frame, target);
        let mut group = criterion.benchmark_group(name);
        group.bench_with_input(BenchmarkId::from_parameter(size), &size, |bencher, _| {
            bencher.iter(|| tracker.update(black_box(&frame)).expect("it goes on"))
        });
        group.finish();
    }
}

criterion_group!(benches, reconstructions);
criterion_main!(benches);
