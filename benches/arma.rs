//! Fits and forecasts of ARMA(1, 1), and the detector on a long track.
//!
//! `benches/peers/arma_statsmodels.py` does the same with statsmodels, on the same window.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use trackfail::detector::{Detector, Input, arma_forecast};
use trackfail::num::arma::{Presample, fit};

const WINDOW: [f64; 20] = [
    0.52, 0.47, 0.55, 0.61, 0.58, 0.66, 0.60, 0.49, 0.44, 0.40, 0.43, 0.38, 0.45, 0.51, 0.47, 0.54, 0.57,
    0.50, 0.46, 0.49,
];

fn arma(c: &mut Criterion) {
    let mut group = c.benchmark_group("arma");
    group.sample_size(50);
    for (name, start) in [("fit-backcast", Presample::Backcast), ("fit-drop-first", Presample::DropFirst)] {
        group.bench_with_input(BenchmarkId::new(name, WINDOW.len()), &WINDOW, |b, window| {
            b.iter(|| fit(black_box(window), [1, 1], start).map(|model| model.forecast(5)));
        });
    }
    let signal: Vec<f64> = (0..500_u32).map(|t| 0.04 + f64::from(t * 7919 % 101) / 5e4).collect();
    let detector = arma_forecast::Params::default();
    group.bench_with_input(BenchmarkId::new("detector", signal.len()), &signal, |b, signal| {
        let input = Input { signal, error: &[], seed: 0, reverse: None, more: &[] };
        b.iter(|| detector.detect(black_box(&input)));
    });
}

criterion_group!(benches, arma);
criterion_main!(benches);
