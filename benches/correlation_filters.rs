//! Time per frame of the trackers with correlation filters and of NanoTrack, one thread: a target of 64 x 64 pixels that moves back and
//! forth by three pixels per frame, in frames of 640 x 480 pixels.
//!
//! `dsst` takes 3.9 ms (5.0 before spectra stayed four columns side by side), `samf` 4.0 (6.0 before pixels were
//! interpolated in vectors). `dsst` transforms 2 x 28 planes of 128 x 128 values, each of about
//! `2.5 n log2 n` = 0.57 million operations, 32 million a frame. The butterflies take 28 % of the time, 1.1 ms, or
//! 30 operations a nanosecond: additions for the most part, of which a core has 24 at 3 GHz with two adders of four
//! numbers and 48 with multiplications beside them. So butterflies are near what vectors of four can do. Another 39 %
//! goes to what is around them, values that come and go and products of spectra, 16 % to gradients, 6 % to resampling.
//! `samf`: transforms 15 %, what is around them and cells 32 %, gradients 28 %, resampling 14 %.
//!
//! `benches/peers/opencv_trackers.py` times OpenCV's trackers on the same frames, `benches/peers/nanotrack.py` the networks
//! of NanoTrack by onnxruntime.

use criterion::{BatchSize, BenchmarkId, Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use trackfail::region::Rect;
use trackfail::tracker::{dsst, kcf, nanotrack, samf};
use trackfail_benches::{started, textured};

fn filters(criterion: &mut Criterion) {
    // To the right by so many pixels.
    let frame = |moved: usize| textured((640, 480), [110.0, 50.0, 30.0], 12 - moved, |_, _, _| 0.0);
    let frames = [3, 6, 9, 12, 9, 6, 3, 0].map(frame);
    let cases = [
        ("kcf", &kcf::ENTRY, "{}"),
        ("kcf-grey", &kcf::ENTRY, "{ features = \"grey\" }"),
        ("kcf-vot", &kcf::ENTRY, "{ preset = \"vot\" }"),
        ("dsst", &dsst::ENTRY, "{}"),
        ("samf", &samf::ENTRY, "{}"),
        ("nanotrack", &nanotrack::ENTRY, "{}"),
        ("nanotrack-v3", &nanotrack::ENTRY, "{ version = \"v3\" }"),
    ];
    for (name, entry, params) in cases {
        let mut tracker = started(entry, params, &frames[7], Rect::new(288.0, 208.0, 64.0, 64.0));
        let mut group = criterion.benchmark_group(name);
        let mut turn = frames.iter().cycle();
        group.bench_with_input(BenchmarkId::from_parameter(64), &64, |bencher, _| {
            // Copies, with which no tracker finds what it has seen in an earlier turn.
            let mut next = || turn.next().cloned().expect("there are frames");
            bencher.iter_batched(
                &mut next,
                |frame| tracker.update(black_box(&frame)).expect("it goes on"),
                BatchSize::PerIteration,
            )
        });
    }
}

criterion_group!(benches, filters);
criterion_main!(benches);
