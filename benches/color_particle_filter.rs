//! Time per frame of the color particle filter: 400 particles on an ellipse of 40 x 80 pixels, one thread.
//!
//! `benches/peers/color_particle_filter.py` does the same in NumPy. The axes have no noise here, so that
//! every frame takes the same time.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use trackfail::dataset::synthetic;
use trackfail::image::Frame;
use trackfail::region::{Rect, Region};
use trackfail::tracker::RunContext;
use trackfail::tracker::color_particle_filter::ENTRY;

/// Gradients with texture of +-12 values, as photographs have, and a target that differs; 320 x 240.
fn frame() -> Frame {
    Frame::from_fn(320, 240, |x, y| {
        let (u, v) = ((x as f64 + 0.5 - 160.0) / 20.0, (y as f64 + 0.5 - 120.0) / 40.0);
        let target = if u * u + v * v < 1.0 { 60.0 } else { 0.0 };
        std::array::from_fn(|c| {
            let smooth = 110.0
                + 50.0 * (0.03 * x as f64 + c as f64).sin()
                + 30.0 * (0.05 * y as f64 + 2.0 * c as f64).cos();
            let texture = ((x * 7919 + y * 104_729 + c * 1299) * 2_654_435_761 % 4_294_967_296) >> 16;
            (smooth + (texture % 25) as f64 - 12.0 + target * (1.0 - c as f64)).clamp(0.0, 255.0) as u8
        })
    })
}

fn particles(criterion: &mut Criterion) {
    let textured = frame();
    let plain = Frame::new(320, 240, vec![90; 3 * 320 * 240]);
    let sequence = synthetic::suite("synthetic-otb").expect("it is built in").swap_remove(0);
    let cases = [
        ("color-particle-filter", "{ sigma_axes = 0, color_space = \"rgb\" }", &textured),
        ("color-particle-filter-hsv", "{ sigma_axes = 0, color_space = \"hsv\" }", &textured),
        // All pixels in one bin: every addition waits for the one before.
        ("color-particle-filter-one-color", "{ sigma_axes = 0, color_space = \"rgb\" }", &plain),
    ];
    for (name, params, frame) in cases {
        let setup = ENTRY.build_from_text(params).expect("the parameters are valid");
        let context = RunContext { sequence: &sequence, start_frame: 0, run: 0, seed: 1, data_roots: &[] };
        let region = Region::Rect(Rect::new(140.0, 80.0, 40.0, 80.0));
        let (mut tracker, _) = setup.start(&context, frame, &region).expect("it starts");
        let mut group = criterion.benchmark_group(name);
        group.bench_with_input(BenchmarkId::from_parameter(400), &400, |bencher, _| {
            bencher.iter(|| tracker.update(black_box(frame)).expect("it goes on"))
        });
        group.finish();
    }
}

criterion_group!(benches, particles);
criterion_main!(benches);
