//! Time per frame of trackers on a frame that stays the same, one thread.
//!
//! `color-particle-filter` has 400 particles on an ellipse of 40 x 80 pixels, and no noise of the axes, so that every
//! frame takes the same time; `benches/peers/color_particle_filter.py` does the same in NumPy.
//! `fragments-particle-filter` has 400 particles on a target of 40 x 80 pixels, and `pixel-lut` all windows within 30
//! pixels of a target of 64 x 64, learning included; `benches/peers/reconstructed_trackers.py` does the most expensive part
//! of the latter in NumPy.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use trackfail::image::Frame;
use trackfail::region::Rect;
use trackfail::tracker::{color_particle_filter, fragments_particle_filter, pixel_lut};
use trackfail_benches::{frame_with_target, started};

fn trackers(criterion: &mut Criterion) {
    let [ellipse, circle] = [[20.0, 40.0], [32.0, 32.0]].map(frame_with_target);
    // All pixels in one bin: every addition waits for the one before.
    let plain = Frame::new(320, 240, vec![90; 3 * 320 * 240]);
    let (rgb, hsv) =
        ("{ sigma_axes = 0, color_space = \"rgb\" }", "{ sigma_axes = 0, color_space = \"hsv\" }");
    let (tall, square) = (Rect::new(140.0, 80.0, 40.0, 80.0), Rect::new(128.0, 88.0, 64.0, 64.0));
    let cases = [
        ("color-particle-filter", &color_particle_filter::ENTRY, rgb, &ellipse, tall, 400),
        ("color-particle-filter-hsv", &color_particle_filter::ENTRY, hsv, &ellipse, tall, 400),
        ("color-particle-filter-one-color", &color_particle_filter::ENTRY, rgb, &plain, tall, 400),
        ("fragments-particle-filter", &fragments_particle_filter::ENTRY, "{}", &circle, tall, 400),
        ("pixel-lut", &pixel_lut::ENTRY, "{}", &circle, square, 64),
        ("pixel-lut-24-cells", &pixel_lut::ENTRY, "{ cells = 24 }", &circle, square, 64),
    ];
    for (name, entry, params, frame, target, size) in cases {
        let mut tracker = started(entry, params, frame, target);
        let mut group = criterion.benchmark_group(name);
        group.bench_with_input(BenchmarkId::from_parameter(size), &size, |bencher, _| {
            bencher.iter(|| tracker.update(black_box(frame)).expect("it goes on"))
        });
    }
}

criterion_group!(benches, trackers);
criterion_main!(benches);
