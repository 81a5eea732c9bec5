//! Time of a line of `trackfail monitor`, from its bytes to the answer: frames of 640 x 480 pixels, a target of 64 x 64.
//!
//! `jpeg` reads and decodes a file, `raw` reads the pixels from a file, `base64` has them in the line, `boxes` has no frames. Each method that the program recommends for
//! some inputs, and those that are named, has a group. The pipes' share is not in it, see `docs/performance.md`.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use trackfail::cli::monitor::Lines;
use trackfail::image::Frame;
use trackfail::method::{Inputs, recommended};
use trackfail::monitor::Options;
use trackfail_benches::frame;

/// The lines of two frames in turn, with the `frame` that is given.
fn lines(frames: [String; 2]) -> [Vec<u8>; 2] {
    let mut x = [300.0, 302.0].into_iter();
    frames.map(|frame| {
        let x = x.next().unwrap_or_default();
        let line = format!("{{{frame}\"box\": [{x}, 200, 64, 64], \"confidence\": 0.9, \"companions\": [[301, 201, 64, 64]]}}");
        line.into_bytes()
    })
}

fn monitor(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a folder for two frames");
    let frames = [frame(640, 480, 0), frame(640, 480, 2)];
    let save = |frame: &Frame, name: &str| {
        let path = folder.path().join(name);
        let picture = image::RgbImage::from_raw(640, 480, frame.bytes().to_vec()).expect("its size");
        picture.save(&path).expect("a file that can be written");
        format!("\"frame\": \"{}\", ", path.display())
    };
    let raw = |bytes: String| {
        format!("\"frame\": {{\"raw\": {{\"width\": 640, \"height\": 480, \"format\": \"rgb\", {bytes}}}}}, ")
    };
    let put = |frame: &Frame, name: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, frame.bytes()).expect("a file that can be written");
        raw(format!("\"path\": \"{}\"", path.display()))
    };
    let encode = |frame: &Frame| {
        use base64::Engine as _;
        raw(format!("\"data\": \"{}\"", base64::engine::general_purpose::STANDARD.encode(frame.bytes())))
    };
    let forms = [
        ("jpeg", lines([save(&frames[0], "0.jpg"), save(&frames[1], "1.jpg")])),
        ("raw", lines([put(&frames[0], "0.rgb"), put(&frames[1], "1.rgb")])),
        ("base64", lines([encode(&frames[0]), encode(&frames[1])])),
        ("boxes", lines([String::new(), String::new()])),
    ];
    let mut methods = vec!["Watchdog", "First colors", "Forward-backward", "Template"];
    for bits in 0..8 {
        let [frames, companions, confidence] = [1, 2, 4].map(|bit| bits & bit > 0);
        methods.push(recommended(Inputs { frames, companions, confidence }, None));
    }
    methods.sort_unstable();
    methods.dedup();
    for method in methods {
        let mut group = criterion.benchmark_group(format!("monitor/{method}"));
        for (form, lines) in &forms {
            let options = Options { method: Some(method.into()), ..Options::default() };
            let (mut stream, mut t) = (Lines::new(options).expect("a method that can monitor"), 0);
            group.bench_function(*form, |bencher| {
                bencher.iter(|| {
                    t += 1;
                    let answer = stream.answer(black_box(&lines[t % 2]));
                    assert!(!answer.contains("error"), "{answer}");
                    answer
                });
            });
        }
    }
}

criterion_group!(benches, monitor);
criterion_main!(benches);
