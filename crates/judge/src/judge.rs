//! Judges whole tracks: all tracks of a video in one pass over its frames.

use crate::detector::Input;
use crate::image::Frame;
use crate::judged::JudgedMethod;
use crate::method::{Method, SignalChoice};
use crate::num::seed;
use crate::reader::{Reader, Seen, SignalFault, columns};
use crate::region::Region;
use crate::sequence::{Numbering, SequenceInfo};
use crate::signal::Reads;
use crate::tracker::RunContext;
use rayon::prelude::*;
use std::error::Error;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

/// Error of the code that provides the frames.
pub type FrameError = Box<dyn Error + Send + Sync>;

/// Function that returns frame `t` (0-based).
pub type FrameOf<'a> = &'a (dyn Fn(usize) -> Result<Arc<Frame>, FrameError> + Sync);

/// Output of a tracker on one target, in each frame of the video.
#[derive(Debug, Clone, Copy, Default)]
pub struct Track<'a> {
    /// Regions in 0-based pixels; `None` where the tracker reports the target as absent.
    pub regions: &'a [Option<Region>],
    /// Confidence of the tracker in its own scale, high if it is sure; empty if it gives none.
    pub confidence: &'a [Option<f64>],
    /// Regions of other trackers on the same target, one list for each.
    pub companions: &'a [&'a [Option<Region>]],
}

/// Reason why tracks cannot be judged.
#[derive(Debug, thiserror::Error)]
pub enum JudgeError {
    /// A frame cannot be provided.
    #[error("{source}")]
    Frame {
        /// Index of the frame, from 0.
        t: usize,
        /// Error of the code that provides the frames.
        source: FrameError,
    },
    /// A signal has no value.
    #[error("{source} in frame {t} (from 0)")]
    Signal {
        /// Index of the track.
        track: usize,
        /// Index of the frame, from 0.
        t: usize,
        /// Reason why the signal has no value.
        source: SignalFault,
    },
    /// A detector returns no labels.
    #[error("{reason}")]
    Detector {
        /// Index of the track.
        track: usize,
        /// Reason given by the detector.
        reason: String,
    },
    /// A track has a different number of frames than the first one.
    #[error("track {track} has {got} frames, the first one {expected}")]
    Frames {
        /// Index of the track.
        track: usize,
        /// Number of frames of the first track.
        expected: usize,
        /// Number of frames of this track.
        got: usize,
    },
    /// The caller requested a stop.
    #[error("interrupted")]
    Interrupted,
}

/// Judges all tracks by all methods. Returns a list for each track, in the order of the methods.
///
/// `frames` returns the frames of the video and is called once for each, in order; methods that read pixels
/// need it. `stop` is called before each frame; true ends the call.
///
/// # Errors
/// A frame that cannot be provided, a signal without a value, a detector without labels, and an interruption.
pub fn judge(
    methods: &[Method],
    tracks: &[Track<'_>],
    frames: Option<FrameOf<'_>>,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<Vec<JudgedMethod>>, JudgeError> {
    let count = tracks.first().map_or(0, |track| track.regions.len());
    if let Some((track, other)) = tracks.iter().enumerate().find(|(_, t)| t.regions.len() != count) {
        return Err(JudgeError::Frames { track, expected: count, got: other.regions.len() });
    }
    let (signals, of_method) = distinct(methods);
    let mut lanes: Vec<Lane<'_>> = tracks.iter().map(|track| Lane::new(*track, signals.len())).collect();
    read(&mut lanes, &signals, frames, stop)?;
    let one = |(k, lane): (usize, Lane<'_>)| {
        methods.iter().zip(&of_method).map(|(method, mine)| lane.judged(k, method, mine)).collect()
    };
    lanes.into_par_iter().enumerate().map(one).collect()
}

/// Distinct signals of the methods, and for each method the indices of its signals.
fn distinct(methods: &[Method]) -> (Vec<&SignalChoice>, Vec<Vec<usize>>) {
    let mut signals: Vec<(&SignalChoice, String)> = Vec::new();
    let mut of_method = Vec::new();
    for method in methods {
        let mut mine = Vec::new();
        for choice in &method.signals {
            let params = choice.signal.params().to_string();
            let known = signals.iter().position(|(other, text)| other.kind == choice.kind && *text == params);
            mine.push(known.unwrap_or_else(|| {
                signals.push((choice, params));
                signals.len() - 1
            }));
        }
        of_method.push(mine);
    }
    (signals.into_iter().map(|(choice, _)| choice).collect(), of_method)
}

/// A track with the values of its signals.
struct Lane<'a> {
    track: Track<'a>,
    /// Frames from the first to the last region.
    range: Range<usize>,
    /// Reader of the signals, only while the track lasts. A file may have thousands of tracks, few of them at
    /// once.
    reader: Option<Reader>,
    /// Values of each signal, one frame after the other.
    series: Vec<Vec<f64>>,
}

impl<'a> Lane<'a> {
    fn new(track: Track<'a>, signals: usize) -> Self {
        let is_there = |region: &Option<Region>| region.is_some();
        let start = track.regions.iter().position(is_there).unwrap_or(0);
        let end = track.regions.iter().rposition(is_there).map_or(0, |last| last + 1);
        Self { track, range: start..end, reader: None, series: vec![Vec::new(); signals] }
    }

    /// Computes the signals in frame `t`.
    fn read(
        &mut self,
        t: usize,
        frame: Option<&Frame>,
        signals: &[&SignalChoice],
    ) -> Result<(), SignalFault> {
        if t == self.range.start {
            let sequence = Unannotated(self.range.len());
            let context =
                RunContext { sequence: &sequence, start_frame: 0, run: 0, seed: 0, data_roots: &[] };
            self.reader = Some(Reader::start(signals.iter().copied(), &context).map_err(SignalFault::Broke)?);
        }
        let nowhere = Region::nowhere();
        let of = |companion: &&'a [Option<Region>]| companion.get(t).and_then(Option::as_ref);
        let companions: Vec<&Region> =
            self.track.companions.iter().map(|companion| of(companion).unwrap_or(&nowhere)).collect();
        let region = self.track.regions[t].as_ref();
        let confidence = self.track.confidence.get(t).copied().flatten();
        let seen = Seen { frame, region, confidence, companions: &companions };
        let values = self.reader.as_mut().and_then(|reader| reader.push(&seen));
        for (series, value) in self.series.iter_mut().zip(values.into_iter().flatten()) {
            series.extend(value?);
        }
        if t + 1 == self.range.end {
            self.reader = None;
        }
        Ok(())
    }

    /// Judges the track by a method whose signals have these indices; `track` is the index of the track.
    fn judged(&self, track: usize, method: &Method, signals: &[usize]) -> Result<JudgedMethod, JudgeError> {
        let widths = method.signals.iter().map(|choice| choice.signal.width());
        let columns = columns(signals.iter().map(|k| self.series[*k].as_slice()).zip(widths));
        let mine: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        // Detectors need no ground truth; only the oracle reads it, and it has no signal.
        let unknown = vec![f64::NAN; self.range.len()];
        let (signal, more) =
            mine.split_first().map_or((&unknown[..], &[][..]), |(first, more)| (*first, more));
        let seed = seed::seed(0, &[&method.name]);
        let detector = &*method.detector.detector;
        let mut output = detector.detect(&Input { signal, more, error: &unknown, seed, reverse: None });
        match output.failure.take() {
            Some(reason) => Err(JudgeError::Detector { track, reason }),
            None => {
                let present: Vec<bool> = self.track.regions.iter().map(Option::is_some).collect();
                Ok(JudgedMethod::new(&method.name, detector, &output, self.range.start, &present))
            }
        }
    }
}

/// Passes all frames to the tracks. The next frame is decoded on another thread.
fn read(
    lanes: &mut [Lane<'_>],
    signals: &[&SignalChoice],
    frames: Option<FrameOf<'_>>,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<(), JudgeError> {
    let count = lanes.iter().map(|lane| lane.range.end).max().unwrap_or(0);
    let reads = signals.iter().any(|choice| choice.signal.reads() == Reads::Pixels);
    let frame_of = frames.filter(|_| reads);
    let decode = |t: usize, lanes: &[Range<usize>]| {
        let frame_of = frame_of.filter(|_| t < count && lanes.iter().any(|range| range.contains(&t)))?;
        Some(frame_of(t))
    };
    let ranges: Vec<Range<usize>> = lanes.iter().map(|lane| lane.range.clone()).collect();
    let mut next = decode(0, &ranges);
    for t in 0..count {
        if stop() {
            return Err(JudgeError::Interrupted);
        }
        let frame = next.take().transpose().map_err(|source| JudgeError::Frame { t, source })?;
        let work = || {
            let read = |(k, lane): (usize, &mut Lane<'_>)| match lane.range.contains(&t) {
                true => lane.read(t, frame.as_deref(), signals).err().map(|source| (k, source)),
                false => None,
            };
            lanes.par_iter_mut().enumerate().filter_map(read).min_by_key(|(k, _)| *k)
        };
        let (fault, ahead) = rayon::join(work, || decode(t + 1, &ranges));
        if let Some((track, source)) = fault {
            return Err(JudgeError::Signal { track, t, source });
        }
        next = ahead;
    }
    Ok(())
}

/// A sequence of which only the number of frames is known.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Unannotated(pub usize);

impl SequenceInfo for Unannotated {
    fn name(&self) -> &str {
        "track"
    }

    fn numbering(&self) -> Numbering {
        Numbering { first: 0, official: (0, self.0.saturating_sub(1) as u32) }
    }

    fn truth(&self) -> &[Option<Region>] {
        &[]
    }

    fn attributes(&self) -> &[String] {
        &[]
    }

    fn size(&self) -> Result<(usize, usize), Box<dyn Error + Send + Sync>> {
        Err("the size of the frames is not known".into())
    }

    fn files(&self) -> Result<Vec<PathBuf>, Box<dyn Error + Send + Sync>> {
        Ok(Vec::new())
    }

    fn shared(&self) -> Arc<dyn SequenceInfo> {
        Arc::new(*self)
    }

    fn frames(&self) -> usize {
        self.0
    }
}
