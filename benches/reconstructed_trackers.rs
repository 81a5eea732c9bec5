//! Time per frame of the two reconstructed trackers, one thread: `fragments-particle-filter` with 400 particles on a
//! target of 40 x 80 pixels, and `pixel-lut` with all windows within 30 pixels of a target of 64 x 64, learning included.
//!
//! `benches/peers/reconstructed_trackers.py` does the most expensive part of the latter in NumPy.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use trackfail::dataset::synthetic;
use trackfail::image::Frame;
use trackfail::region::{Rect, Region};
use trackfail::tracker::{RunContext, fragments_particle_filter, pixel_lut};

/// Gradients with texture of +-12 values, as photographs have, and a target that differs; 320 x 240.
fn frame() -> Frame {
    Frame::from_fn(320, 240, |x, y| {
        let (u, v) = ((x as f64 + 0.5 - 160.0) / 32.0, (y as f64 + 0.5 - 120.0) / 32.0);
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

fn reconstructions(criterion: &mut Criterion) {
    let frame = frame();
    let sequence = synthetic::suite("synthetic-otb").expect("it is built in").swap_remove(0);
    let tall = Region::Rect(Rect::new(140.0, 80.0, 40.0, 80.0));
    let square = Region::Rect(Rect::new(128.0, 88.0, 64.0, 64.0));
    let cases = [
        ("fragments-particle-filter", &fragments_particle_filter::ENTRY, "{}", &tall, 400),
        ("pixel-lut", &pixel_lut::ENTRY, "{}", &square, 64),
        ("pixel-lut-24-cells", &pixel_lut::ENTRY, "{ cells = 24 }", &square, 64),
    ];
    for (name, entry, params, region, size) in cases {
        let setup = entry.build_from_text(params).expect("the parameters are valid");
        let context = RunContext { sequence: &sequence, start_frame: 0, run: 0, seed: 1, data_roots: &[] };
        let (mut tracker, _) = setup.start(&context, &frame, region).expect("it starts");
        let mut group = criterion.benchmark_group(name);
        group.bench_with_input(BenchmarkId::from_parameter(size), &size, |bencher, _| {
            bencher.iter(|| tracker.update(black_box(&frame)).expect("it goes on"))
        });
        group.finish();
    }
}

criterion_group!(benches, reconstructions);
criterion_main!(benches);
