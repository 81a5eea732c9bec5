//! Judgements of whole tracks.

use crate::frame::{Taken, order};
use crate::region::{origin, track};
use crate::{finite, refused, threads};
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use std::sync::atomic::Ordering;
use std::sync::{Arc, OnceLock};
use trackfail_judge::direction::Direction;
use trackfail_judge::image::Frame;
use trackfail_judge::judge::{FrameError, FrameOf, JudgeError};
use trackfail_judge::judged::JudgedMethod;
use trackfail_judge::method::{self, Inputs, Method};
use trackfail_judge::monitor::MonitorError;
use trackfail_judge::region::Region;
use trackfail_judge::signal::Reads;
use trackfail_judge::{Track, judge as judge_tracks};

/// Method, threshold, whether high scores are good, whether they are probabilities; scores and, if these are not what is
/// compared with the threshold, those that are (NaN where there is none), labels, changes and states of all frames.
type Judged<'py> = (
    String,
    Option<f64>,
    bool,
    bool,
    Bound<'py, PyArray1<f64>>,
    Option<Bound<'py, PyArray1<f64>>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray1<i32>>,
    Vec<&'static str>,
);

/// Judges tracks of one video by a method.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn judge<'py>(
    py: Python<'py>,
    tracks: Vec<Bound<'py, PyAny>>,
    frame_of: Option<Py<PyAny>>,
    colors: Option<&str>,
    confidence: Option<Vec<Option<f64>>>,
    companions: Vec<Bound<'py, PyAny>>,
    method: Option<&str>,
    budget: Option<f64>,
    base: i64,
) -> PyResult<Vec<Judged<'py>>> {
    let (colors, base) = (order(colors)?, f64::from(origin(base)?));
    let inputs = Inputs {
        frames: frame_of.is_some(),
        companions: !companions.is_empty(),
        confidence: confidence.is_some(),
    };
    let method = chosen(method, inputs, budget)?;
    let all = |given: &[Bound<'py, PyAny>], what: &str| -> PyResult<Vec<Vec<Option<Region>>>> {
        given.iter().map(|given| track(given, what, base)).collect()
    };
    let (regions, others) = (all(&tracks, "boxes")?, all(&companions, "companions")?);
    let frames = regions.first().map_or(0, Vec::len);
    for (what, count) in others
        .iter()
        .map(|other| ("a companion", other.len()))
        .chain(confidence.iter().map(|confidence| ("confidence", confidence.len())))
    {
        if count != frames {
            return Err(refused(format!("{what} has {count} frames, the track {frames}")));
        }
    }
    let others: Vec<&[Option<Region>]> = others.iter().map(Vec::as_slice).collect();
    let certain = |(t, given): (usize, Option<f64>)| finite(given, format_args!("confidence, frame {t}"));
    let confidence = confidence.unwrap_or_default().into_iter().enumerate().map(certain);
    let confidence = confidence.collect::<PyResult<Vec<Option<f64>>>>()?;
    let given: Vec<Track<'_>> = regions
        .iter()
        .map(|regions| Track { regions, confidence: &confidence, companions: &others })
        .collect();
    let judged = threads::work_until_stopped(py, |stop| {
        let size = OnceLock::new();
        let frame = |t: usize| -> Result<Arc<Frame>, FrameError> {
            let of = |py: Python<'_>| -> PyResult<Arc<Frame>> {
                let given = frame_of.as_ref().map(|of| of.call1(py, (t,))).transpose()?;
                let given = given.ok_or_else(|| refused("there are no frames"))?;
                Taken::of(given.bind(py), colors)?.frame(py)
            };
            let frame = Python::attach(of)?;
            let got = (frame.width(), frame.height());
            let expected = *size.get_or_init(|| got);
            if got == expected { Ok(frame) } else { Err(MonitorError::FrameSize { expected, got }.into()) }
        };
        let frames = frame_of.is_some().then_some(&frame as FrameOf<'_>);
        judge_tracks(std::slice::from_ref(&method), &given, frames, &|| stop.load(Ordering::Relaxed))
    })?;
    let judged = judged.map_err(exception)?;
    Ok(judged.into_iter().flatten().map(|judged| columns(py, judged)).collect())
}

/// The method of a name, or the one that is recommended for the inputs, if they are enough for it.
fn chosen(name: Option<&str>, inputs: Inputs, budget: Option<f64>) -> PyResult<Method> {
    let method =
        Method::named(name.unwrap_or(method::recommended(inputs, budget)), budget).map_err(refused)?;
    let missing = method.reads().find(|reads| !inputs.has(*reads));
    let detector = &method.detector.detector;
    let is_able = detector.learner().is_none() && !detector.facts().needs_reverse;
    let need = match missing {
        None if is_able => return Ok(method),
        Some(Reads::Pixels) => "needs frames",
        Some(Reads::Companions) => "needs other trackers' boxes; give companions",
        Some(Reads::Confidence) => "needs the tracker's confidence; give confidence",
        _ => "needs more of a tracker than boxes",
    };
    Err(refused(format!("method `{}` {need}", method.name)))
}

/// The exception of an error; one that the frames have raised is raised again.
fn exception(error: JudgeError) -> PyErr {
    match error {
        JudgeError::Frame { t, source } => match source.downcast::<PyErr>() {
            Ok(raised) => *raised,
            Err(source) => refused(format!("frame {t} (from 0): {source}")),
        },
        JudgeError::Signal { t, source, .. } => {
            refused(source.in_frame(u32::try_from(t).unwrap_or(u32::MAX)))
        }
        error => refused(error),
    }
}

fn columns(py: Python<'_>, judged: JudgedMethod) -> Judged<'_> {
    let column = |scores: Vec<Option<f64>>| {
        let scores: Vec<f64> = scores.into_iter().map(|score| score.unwrap_or(f64::NAN)).collect();
        scores.into_pyarray(py)
    };
    (
        judged.name,
        judged.threshold,
        judged.direction == Direction::HigherIsBetter,
        judged.is_probability,
        column(judged.score),
        judged.alarm_score.map(column),
        judged.label.into_pyarray(py),
        judged.changes.into_pyarray(py),
        judged.states.iter().map(|state| state.word()).collect(),
    )
}

/// Names of the methods.
#[pyfunction]
pub fn methods() -> Vec<&'static str> {
    method::names()
}

/// Name of the method that is recommended for inputs beside boxes.
#[pyfunction]
pub fn recommended(frames: bool, companions: bool, confidence: bool, budget: Option<f64>) -> &'static str {
    method::recommended(Inputs { frames, companions, confidence }, budget)
}
