//! Time per frame of each signal at three target sizes, on a textured frame.
//!
//! `benches/peers/compare.py` sets these times beside the same computations in Python; both use the
//! frame that is made here.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use trackfail::image::Frame;
use trackfail::region::{Rect, Region};
use trackfail::signal::SIGNALS;
use trackfail::tracker::{Moments, TrackerState};

/// Smooth gradients with texture of +-12 values, as photographs have; 384 x 384 pixels.
fn frame() -> Frame {
    Frame::from_fn(384, 384, |x, y| {
        std::array::from_fn(|c| {
            let smooth = 128.0
                + 70.0 * (0.03 * x as f64 + c as f64).sin()
                + 40.0 * (0.05 * y as f64 + 2.0 * c as f64).cos();
            let texture = ((x * 7919 + y * 104_729 + c * 1299) * 2_654_435_761 % 4_294_967_296) >> 16;
            (smooth + (texture % 25) as f64 - 12.0) as u8
        })
    })
}

fn signals(criterion: &mut Criterion) {
    let frame = frame();
    for entry in SIGNALS {
        let mut group = criterion.benchmark_group(entry.kind);
        for size in [32, 64, 128] {
            let signal = entry.build_from_text("{}").expect("defaults are valid");
            let mut session = signal.start();
            let at = |x: f64| {
                TrackerState::tracked(Region::Rect(Rect::new(x, 100.0, f64::from(size), f64::from(size))))
            };
            let posterior = |mut state: TrackerState, spread: f64| {
                let covariance =
                    (0..25).map(|k| if k % 6 == 0 { spread + f64::from(k) } else { 0.1 }).collect();
                let mean = vec![100.0, 100.0, 20.0, 40.0, 0.0];
                state.posterior =
                    Some(Moments { mean, covariance, effective_samples: 300.0, ..Moments::default() });
                state
            };
            let states = [posterior(at(100.0), 4.0), posterior(at(103.0), 5.0)];
            let mut t = 0;
            group.bench_with_input(BenchmarkId::from_parameter(size), &size, |bencher, _| {
                bencher.iter(|| {
                    t += 1;
                    session.push(black_box(&frame), black_box(&states[t % 2]))
                });
            });
        }
        group.finish();
    }
}

criterion_group!(benches, signals);
criterion_main!(benches);
