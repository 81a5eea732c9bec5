//! Fit of a mixture of Gammas, choice of its order on two million samples, and quantile of a sum.
//!
//! `benches/peers/gamma_mixture.py` fits the same samples in NumPy; the bench `fit` uses one thread like it.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use trackfail::num::accumulation::Accumulated;
use trackfail::num::gamma_mixture::{Binned, Component, FitOptions, Mixture, fit, fit_all, select};

/// Number `i` of SplitMix64 from state 0, in (0, 1).
fn uniform(i: u64) -> f64 {
    let mut z = (i + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (((z ^ (z >> 31)) >> 11) as f64 + 0.5) / 2.0_f64.powi(53)
}

/// Six in ten from Gamma(1, 0.1), three from Gamma(2, 0.4), one from Gamma(4, 0.5): sums of exponentials.
fn samples(n: u64) -> Vec<f64> {
    let sample = |i: u64| {
        let (terms, scale) = match uniform(5 * i) {
            u if u < 0.6 => (1, 0.1),
            u if u < 0.9 => (2, 0.4),
            _ => (4, 0.5),
        };
        (1..=terms).map(|j| -scale * uniform(5 * i + j).ln()).sum()
    };
    (0..n).map(sample).collect()
}

fn gamma_mixture(c: &mut Criterion) {
    let mut group = c.benchmark_group("gamma_mixture");
    group.sample_size(10);
    let x = samples(100_000);
    if let Ok(one) = rayon::ThreadPoolBuilder::new().num_threads(1).build() {
        let options = FitOptions { restarts: 0, ..FitOptions::default() };
        group.bench_with_input(BenchmarkId::new("fit-3", x.len()), &x, |b, x| {
            b.iter(|| {
                one.install(|| Binned::new(black_box(x).iter().copied()).map(|x| fit(&x, 3, &options)))
            });
        });
    }
    let x = samples(2_000_000);
    group.bench_with_input(BenchmarkId::new("bin", x.len()), &x, |b, x| {
        b.iter(|| Binned::new(black_box(x).iter().copied()));
    });
    group.bench_with_input(BenchmarkId::new("select-1-10", x.len()), &x, |b, x| {
        b.iter(|| {
            let binned = Binned::new(black_box(x).iter().copied()).ok()?;
            let fits = fit_all(&binned, 10, &FitOptions::default()).ok()?;
            let terms = select::terms(&fits, binned.count());
            select::choose(&terms, select::Criterion::Aic, select::MAX_PENALTY_WEIGHT).order
        });
    });
    group.finish();

    let mut group = c.benchmark_group("accumulation");
    group.sample_size(10);
    let component = |weight, shape, scale| Component { weight, shape, scale };
    let parts = vec![
        component(0.45, 0.6, 0.15),
        component(0.3, 1.8, 0.25),
        component(0.2, 5.0, 0.3),
        component(0.05, 3.0, 2.0),
    ];
    if let Ok(mixture) = Mixture::new(parts) {
        for length in [5, 20, 60] {
            group.bench_with_input(BenchmarkId::new("beta", length), &length, |b, &length| {
                b.iter(|| {
                    Accumulated::of_mixture(black_box(&mixture), length)
                        .and_then(|sum| sum.upper_quantile(0.005))
                });
            });
        }
    }
}

criterion_group!(benches, gamma_mixture);
criterion_main!(benches);
