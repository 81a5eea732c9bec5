//! Time per frame of each signal at three target sizes, on two textured frames in turn.
//!
//! `benches/peers/compare.py` sets these times beside the same computations in Python; both use the
//! frames that are made here.
//!
//! The roofline of `distribution-field` (y_t), for one core. A chunk is eight layers in `f32`, 32 bytes. On this
//! frame, for a pixel and channel:
//!
//! | step | chunks | each | loads | operations |
//! |---|--:|---|--:|--:|
//! | across and over layers: 4 columns (1 of the target, 1.5 of each pair of windows) of 2.0 of 4 chunks | 8.2 | 9 taps | 74 | 74 |
//! | differences of four pairs | 12 | 1 | 24 | 12 |
//! | down, where both fields of a pair are | 8.2 | 7 sums, 8 multiplications, value, sum | 45 | 139 |
//! | down, where one is | 2.7 | 22 rows for 8 | 8 | 8 |
//!
//! Dense, four differences of four chunks would be 16 chunks down instead of 11, and five windows of four chunks
//! 20 across instead of 8. What moves stays in the first two caches: 160 bytes a row of three strips. The time is
//! that of the operations: a core with two loads and three 32-byte operations a cycle (Zen 4 at 3.7 GHz; two
//! additions and two multiplications, together at most three) needs 37 + 6 + 46 + 3 = 92 cycles; at 64 x 64 px in
//! three channels 0.31 ms, at 32 px 0.08 ms, at 128 px 1.2 ms.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use trackfail::dataset::synthetic;
use trackfail::region::{Rect, Region};
use trackfail::signal::{Observation, SIGNALS};
use trackfail::tracker::{Moments, Response, RunContext, TrackerState};
use trackfail_benches::frame;

fn signals(criterion: &mut Criterion) {
    let frames = [frame(384, 384, 0), frame(384, 384, 2)];
    let sequence = synthetic::suite("synthetic-otb").expect("it is built in").swap_remove(0);
    let context = RunContext { sequence: &sequence, start_frame: 0, run: 0, seed: 1, data_roots: &[] };
    for entry in SIGNALS {
        let mut group = criterion.benchmark_group(entry.kind);
        for size in [32, 64, 128] {
            let signal = entry.build_from_text("{}").expect("defaults are valid");
            let mut session = signal.start(&context).expect("it reads no files");
            let at = |x: f64| {
                TrackerState::tracked(Region::Rect(Rect::new(x, 100.0, f64::from(size), f64::from(size))))
            };
            let posterior = |mut state: TrackerState, spread: f64| {
                let covariance =
                    (0..25).map(|k| if k % 6 == 0 { spread + f64::from(k) } else { 0.1 }).collect();
                let mean = vec![100.0, 100.0, 20.0, 40.0, 0.0];
                let (effective_samples, samples, entropy) = (300.0, 400.0, 0.9);
                let weights = Moments { effective_samples, samples, entropy, ..Moments::default() };
                state.posterior = Some(Moments { mean, covariance, ..weights });
                let (peak, second_peak, mean) = (0.7, 0.2, 0.1);
                let map = Response { peak, second_peak, mean, ..Response::default() };
                state.response = Some(Response { deviation: 0.15, sidelobe_deviation: 0.05, ..map });
                state
            };
            let states = [posterior(at(100.0), 4.0), posterior(at(103.0), 5.0)];
            let mut t = 0;
            group.bench_with_input(BenchmarkId::from_parameter(size), &size, |bencher, _| {
                bencher.iter(|| {
                    t += 1;
                    session.push(&Observation::new(black_box(&frames[t % 2]), black_box(&states[t % 2])))
                });
            });
        }
    }
}

criterion_group!(benches, signals);
criterion_main!(benches);
