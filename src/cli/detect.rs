//! `trackfail detect --frames DIR --boxes FILE [--method NAME]...`

use super::{Failure, output};
use crate::dataset::{DatasetError, Sequence, otb};
use crate::detector::Input;
use crate::num::seed;
use crate::signal::{Reads, Session};
use crate::spec::builtin;
use crate::spec::method::{DetectorChoice, Method, Variant};
use crate::table::frame;
use crate::tracker::State;
use crate::tracker::results::{self, Base};
use polars::prelude::Column;
use std::path::PathBuf;

/// Arguments of `detect`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Prints CSV: frame,method,score,label,change. label is 1 where the track is inconsistent \
(the tracker has failed), change is 1 where it becomes so and -1 where it recovers. Methods run with their published thresholds."
)]
pub struct Args {
    /// Folder of the video's frames (.jpg or .png, numbered)
    #[arg(long, value_name = "DIR")]
    frames: PathBuf,
    /// The tracker's boxes, a line `x,y,w,h` for each frame; a header line is allowed
    #[arg(long, value_name = "FILE")]
    boxes: PathBuf,
    /// Method (may be given several times; default: all)
    #[arg(long, value_name = "NAME")]
    method: Vec<String>,
    /// Number of the top left pixel in the boxes: 1 as in OTB, or 0
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(0..=1))]
    base: u8,
}

/// Runs the verb.
///
/// # Errors
/// See [`Failure`].
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut offered = methods_on_boxes()?;
    let names: Vec<String> = offered.iter().map(|m| m.name.clone()).collect();
    let mut methods = Vec::new();
    for name in if args.method.is_empty() { &names } else { &args.method } {
        if let Some(place) = offered.iter().position(|m| m.name == *name) {
            methods.push(offered.remove(place));
        } else if names.contains(name) {
            return Err(Failure::Usage(format!("method `{name}` is asked for twice")));
        } else if builtin::method_names().contains(&name.as_str()) {
            return Err(Failure::Usage(format!(
                "method `{name}` needs a tracker's posterior and a suite to learn from; of boxes alone can be \
                 judged with: {}",
                names.join(", ")
            )));
        } else {
            let known = names.iter().map(String::as_str);
            return Err(Failure::Usage(crate::plugin::unknown("method", name, known)));
        }
    }
    let data = |e: DatasetError| Failure::Data(e.to_string());
    let base = if args.base == 0 { Base::Zero } else { Base::One };
    let regions = results::read_boxes(&args.boxes, base).map_err(data)?;
    let options = otb::Options { truth: otb::Truth::Ignored, ..otb::Options::default() };
    let sequence = otb::load(&args.frames, &options).map_err(data)?;
    if regions.len() != sequence.len() {
        return Err(Failure::Data(format!(
            "{} has {} boxes, but {} has {} frames; there must be one box for each frame",
            args.boxes.display(),
            regions.len(),
            args.frames.display(),
            sequence.len()
        )));
    }
    let states: Vec<State> = regions.into_iter().map(State::tracked).collect();
    let signals = compute_signals(&sequence, &states, &methods)?;
    print(&sequence, &methods, &signals)
}

/// The published methods that need nothing but frames and boxes.
fn methods_on_boxes() -> Result<Vec<Method>, Failure> {
    let mut methods = Vec::new();
    for method in builtin::method_names().into_iter().filter_map(builtin::published_method) {
        let method = method.map_err(|e| Failure::Io(e.to_string()))?;
        let fits = |v: &Variant| {
            let looks = v.signal.as_ref().is_none_or(|s| s.signal.reads() == Reads::Pixels);
            looks && matches!(v.detector, DetectorChoice::Given(_))
        };
        if method.variants.iter().all(fits) {
            methods.push(method);
        }
    }
    Ok(methods)
}

/// One series for each method; each frame is decoded once for all of them.
fn compute_signals(
    sequence: &Sequence,
    states: &[State],
    methods: &[Method],
) -> Result<Vec<Vec<f64>>, Failure> {
    let session = |m: &Method| m.variants.first().and_then(|v| v.signal.as_ref()).map(|s| s.signal.start());
    let mut sessions: Vec<Option<Box<dyn Session>>> = methods.iter().map(session).collect();
    let mut signals = vec![Vec::with_capacity(sequence.len()); methods.len()];
    for (t, state) in states.iter().enumerate() {
        let frame = sequence.frame(t).map_err(|e| Failure::Data(e.to_string()))?;
        for (session, series) in sessions.iter_mut().zip(&mut signals) {
            series.push(session.as_mut().map_or(0.0, |s| s.push(&frame, state)));
        }
    }
    Ok(signals)
}

fn print(sequence: &Sequence, methods: &[Method], signals: &[Vec<f64>]) -> Result<(), Failure> {
    let (mut number, mut name, mut score) = (Vec::new(), Vec::new(), Vec::new());
    let (mut label, mut change) = (Vec::new(), Vec::new());
    // No ground truth is needed: only the oracle anchor looks at the error, and it is not offered here.
    let unknown = vec![f64::NAN; sequence.len()];
    for (method, signal) in methods.iter().zip(signals) {
        let Some(DetectorChoice::Given(fixed)) = method.variants.first().map(|v| &v.detector) else {
            continue;
        };
        let seed = seed::seed(0, &[&method.name]);
        let verdict = fixed.detector.detect(&Input { signal, error: &unknown, seed, reverse: None });
        number.extend((0..sequence.len()).map(|t| i64::from(sequence.number(t))));
        name.extend(std::iter::repeat_n(method.name.as_str(), sequence.len()));
        score.extend_from_slice(&verdict.score);
        label.extend(verdict.alarm.iter().map(|a| i32::from(*a)));
        change.extend_from_slice(&verdict.changes());
    }
    let table = frame::frame(vec![
        Column::new("frame".into(), number),
        Column::new("method".into(), name),
        Column::new("score".into(), score),
        Column::new("label".into(), label),
        Column::new("change".into(), change),
    ]);
    let bytes = table.and_then(|mut t| frame::to_csv(&mut t)).map_err(|e| Failure::Io(e.to_string()))?;
    output::write(&String::from_utf8_lossy(&bytes))
}
