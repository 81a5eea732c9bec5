//! Time per frame of the color particle filter: 400 particles on an ellipse of 40 x 80 pixels, one thread.
//!
//! `benches/peers/color_particle_filter.py` does the same in NumPy. The axes have no noise here, so that
//! every frame takes the same time.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use trackfail::image::Frame;
use trackfail::region::Rect;
use trackfail::tracker::color_particle_filter::ENTRY;
use trackfail_benches::{frame_with_target, started};

fn particles(criterion: &mut Criterion) {
    let textured = frame_with_target([20.0, 40.0]);
    let plain = Frame::new(320, 240, vec![90; 3 * 320 * 240]);
    let cases = [
        ("color-particle-filter", "{ sigma_axes = 0, color_space = \"rgb\" }", &textured),
        ("color-particle-filter-hsv", "{ sigma_axes = 0, color_space = \"hsv\" }", &textured),
        // All pixels in one bin: every addition waits for the one before.
        ("color-particle-filter-one-color", "{ sigma_axes = 0, color_space = \"rgb\" }", &plain),
    ];
    for (name, params, frame) in cases {
        let mut tracker = started(&ENTRY, params, frame, Rect::new(140.0, 80.0, 40.0, 80.0));
        let mut group = criterion.benchmark_group(name);
        group.bench_with_input(BenchmarkId::from_parameter(400), &400, |bencher, _| {
            bencher.iter(|| tracker.update(black_box(frame)).expect("it goes on"))
        });
        group.finish();
    }
}

criterion_group!(benches, particles);
criterion_main!(benches);
