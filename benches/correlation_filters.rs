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
use trackfail::dataset::synthetic;
use trackfail::image::Frame;
use trackfail::region::{Rect, Region};
use trackfail::tracker::{RunContext, dsst, kcf, nanotrack, samf};

/// Gradients with texture of +-12 values, as photographs have, moved to the right by `shift`.
fn frame(shift: usize) -> Frame {
    Frame::from_fn(640, 480, |x, y| {
        let x = x + 12 - shift;
        std::array::from_fn(|c| {
            let smooth = 110.0
                + 50.0 * (0.03 * x as f64 + c as f64).sin()
                + 30.0 * (0.05 * y as f64 + 2.0 * c as f64).cos();
            let texture = ((x * 7919 + y * 104_729 + c * 1299) * 2_654_435_761 % 4_294_967_296) >> 16;
            (smooth + (texture % 25) as f64 - 12.0).clamp(0.0, 255.0) as u8
        })
    })
}

fn filters(criterion: &mut Criterion) {
    let frames = [3, 6, 9, 12, 9, 6, 3, 0].map(frame);
    let sequence = synthetic::suite("synthetic-otb").expect("it is built in").swap_remove(0);
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
        let setup = entry.build_from_text(params).expect("the parameters are valid");
        let context = RunContext { sequence: &sequence, start_frame: 0, run: 0, seed: 1, data_roots: &[] };
        let region = Region::Rect(Rect::new(288.0, 208.0, 64.0, 64.0));
        let (mut tracker, _) = setup.start(&context, &frames[7], &region).expect("it starts");
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
        group.finish();
    }
}

criterion_group!(benches, filters);
criterion_main!(benches);
