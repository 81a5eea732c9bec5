//! One pass over one sequence: each frame is decoded once and given to every tracker and, with the
//! tracker's answer, to every signal.

use super::supervise::{Watchdog, supervised};
use crate::dataset::Sequence;
use crate::dataset::frame_cache::FrameCache;
use crate::error::CellError;
use crate::limits::{Interrupted, RunLimits};
use crate::region::Region;
use crate::signal::Reads;
use crate::spec::method::SignalChoice;
use crate::tracker::{self, RunContext, StartedTracker, TrackerConfig, TrackerState};
use crate::{image::Frame, signal};
use std::path::PathBuf;
use std::sync::Arc;

/// What one job of a pass is to make.
#[derive(Clone)]
pub struct Task {
    /// The tracker.
    pub setup: Arc<dyn TrackerConfig>,
    /// Repetition, from 0.
    pub run: u32,
    /// Seed of the tracker.
    pub seed: u64,
    /// The states, where they are known and only signals are wanted.
    pub states: Option<Arc<Vec<TrackerState>>>,
    /// Signals that are wanted, as indices into [`Pass::signals`].
    pub signals: Vec<usize>,
}

/// A pass to be made.
pub struct Pass {
    /// The sequence.
    pub sequence: Arc<Sequence>,
    /// Where its frames are had from.
    pub frames: Arc<FrameCache>,
    /// All signals that may be asked for.
    pub signals: Arc<Vec<SignalChoice>>,
    /// Folder of result files, if the user gave one.
    pub data_root: Option<PathBuf>,
    /// What to make.
    pub tasks: Vec<Task>,
    /// Called once a frame, for progress.
    pub on_frame: Arc<dyn Fn() + Send + Sync>,
}

/// What a task has made.
#[derive(Debug, Clone, PartialEq)]
pub struct PassOutput {
    /// One state a frame.
    pub states: Arc<Vec<TrackerState>>,
    /// One series for each of the task's signals, in its order.
    pub signals: Vec<Vec<f64>>,
}

/// Makes a pass, a result for each task in order; see [`supervised`] for tasks that panic or hang.
///
/// # Errors
/// [`Interrupted`].
pub fn pass(pass: Pass, limits: &RunLimits) -> Result<Vec<Result<PassOutput, CellError>>, Interrupted> {
    // One job more: whoever decodes the frames.
    let jobs = pass.tasks.len() + 1;
    supervised(jobs, limits, move |watch, out| pass.go(watch, out))
}

/// A task at work.
struct Running {
    tracker: Option<Box<dyn tracker::Tracker>>,
    sessions: Vec<Box<dyn signal::Session>>,
    states: Vec<TrackerState>,
    signals: Vec<Vec<f64>>,
}

impl Pass {
    fn go(
        &self,
        watch: &Watchdog,
        left_out: &[Option<String>],
    ) -> Result<Vec<Result<PassOutput, CellError>>, Interrupted> {
        let name = &self.sequence.name;
        let in_words = |reason: String| CellError::Failed(format!("{name}: {reason}"));
        let mut running: Vec<Result<Running, CellError>> = Vec::with_capacity(self.tasks.len());
        let decoder = self.tasks.len();
        for (k, task) in self.tasks.iter().enumerate() {
            let out = [left_out.get(k), left_out.get(decoder)].into_iter().flatten().flatten().next();
            running.push(match out {
                Some(reason) => Err(in_words(reason.clone())),
                _ => watch.step(k, || self.open(task)).map_err(in_words),
            });
        }
        for t in 0..self.sequence.len() {
            watch.check_interrupted()?;
            if running.iter().all(Result::is_err) {
                break;
            }
            let looked_at = running.iter().zip(&self.tasks).any(|(r, task)| r.is_ok() && self.looks(task));
            let frame = if looked_at {
                match watch.step(decoder, || self.frames.frame(&self.sequence, t)) {
                    Ok(frame) => frame.map_err(|e| CellError::Failed(e.to_string())),
                    Err(reason) => Err(in_words(reason)),
                }
            } else {
                Ok(Arc::new(Frame::from_fn(1, 1, |_, _| [0; 3])))
            };
            for (k, (task, entry)) in self.tasks.iter().zip(&mut running).enumerate() {
                let Ok(active) = entry else { continue };
                let done = match &frame {
                    Ok(frame) => {
                        watch.step(k, || self.step(task, active, t, frame)).map_err(in_words).flatten()
                    }
                    Err(e) => Err(e.clone()),
                };
                if let Err(e) = done {
                    *entry = Err(e);
                }
            }
            (self.on_frame)();
        }
        let made = |(running, task): (Result<Running, CellError>, &Task)| {
            running.map(|r| PassOutput {
                states: task.states.clone().unwrap_or_else(|| Arc::new(r.states)),
                signals: r.signals,
            })
        };
        Ok(running.into_iter().zip(&self.tasks).map(made).collect())
    }

    /// Whether a task looks at pixels; signals of the posterior on a kept track do not.
    fn looks(&self, task: &Task) -> bool {
        let pixels = |k: &usize| self.signals.get(*k).is_some_and(|s| s.signal.reads() == Reads::Pixels);
        task.states.is_none() || task.signals.iter().any(pixels)
    }

    fn open(&self, task: &Task) -> Running {
        let wanted = || task.signals.iter().filter_map(|k| self.signals.get(*k));
        Running {
            tracker: None,
            sessions: wanted().map(|s| s.signal.start()).collect(),
            states: Vec::new(),
            signals: vec![Vec::with_capacity(self.sequence.len()); task.signals.len()],
        }
    }

    fn start(&self, task: &Task, frame: &Frame) -> Result<StartedTracker, CellError> {
        let context = RunContext {
            sequence: &self.sequence,
            start_frame: 0,
            run: task.run,
            seed: task.seed,
            data_root: self.data_root.as_deref(),
        };
        Ok(task.setup.start(&context, frame, self.first_region()?)?)
    }

    fn step(&self, task: &Task, running: &mut Running, t: usize, frame: &Frame) -> Result<(), CellError> {
        let fresh;
        let state = match (&mut running.tracker, &task.states) {
            (_, Some(states)) => states.get(t).ok_or_else(|| {
                CellError::Failed(format!("{}: the kept track has no frame {t}", self.sequence.name))
            })?,
            (Some(tracker), None) => {
                fresh = tracker.update(frame)?;
                &fresh
            }
            (empty @ None, None) => {
                let (tracker, state) = self.start(task, frame)?;
                *empty = Some(tracker);
                fresh = state;
                &fresh
            }
        };
        for ((session, series), k) in running.sessions.iter_mut().zip(&mut running.signals).zip(&task.signals)
        {
            if let Some(choice) = self.signals.get(*k)
                && choice.signal.reads() == Reads::Posterior
                && state.posterior.is_none()
            {
                let (name, kind) = (&self.sequence.name, choice.kind);
                let message = format!("{name}: signal {kind} needs a tracker that gives its posterior");
                return Err(CellError::Failed(message));
            }
            let value = session.push(frame, state);
            if !value.is_finite() {
                let kind = self.signals.get(*k).map_or("?", |s| s.kind);
                let (name, number) = (&self.sequence.name, self.sequence.number(t));
                return Err(CellError::Failed(format!("{name}: signal {kind} is {value} in frame {number}")));
            }
            series.push(value);
        }
        if running.tracker.is_some() {
            let state = state.clone();
            running.states.push(state);
        }
        Ok(())
    }

    fn first_region(&self) -> Result<&Region, CellError> {
        let none = || {
            let name = &self.sequence.name;
            CellError::Failed(format!("{name}: the first frame has no ground truth to start from"))
        };
        self.sequence.truth.first().and_then(Option::as_ref).ok_or_else(none)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::{Frames, Numbering, Render};
    use crate::region::Rect;
    use crate::signal::SIGNALS;
    use crate::tracker::{Tracker, TrackerError};
    use std::time::Duration;

    /// Grey frames, as many as its number says before it panics.
    struct Grey(usize);
    impl Render for Grey {
        fn render(&self, t: usize) -> Frame {
            assert!(t < self.0, "no frame {t}");
            Frame::from_fn(32, 24, |x, y| [(x * 7) as u8, (y * 9) as u8, t as u8])
        }
    }

    fn sequence(good: usize) -> Arc<Sequence> {
        Arc::new(Sequence {
            name: "grey".into(),
            numbering: Numbering { first: 1, official: (1, 6) },
            truth: vec![Some(Region::Rect(Rect::new(4.0, 4.0, 12.0, 10.0))); 6],
            attributes: vec![],
            frame_attributes: vec![],
            digest: Default::default(),
            frames: Frames::Rendered(Arc::new(Grey(good)), 6),
        })
    }

    /// Stays where it is, and in frame 3 does what it does.
    #[derive(Clone, Copy, PartialEq)]
    enum Bad {
        Never,
        Panics,
        Hangs,
        Errs,
    }

    impl TrackerConfig for Bad {
        fn params(&self) -> serde_json::Value {
            serde_json::Value::Null
        }

        fn start(
            &self,
            _: &RunContext<'_>,
            _: &Frame,
            region: &Region,
        ) -> Result<StartedTracker, TrackerError> {
            Ok((Box::new(BadTracker(*self, 0)), TrackerState::initialized(region.clone())))
        }
    }

    /// The tracker, and the frames it has seen.
    struct BadTracker(Bad, u32);

    impl Tracker for BadTracker {
        fn update(&mut self, _: &Frame) -> Result<TrackerState, TrackerError> {
            self.1 += 1;
            match self.0 {
                Bad::Panics if self.1 == 3 => panic!("out of wits"),
                Bad::Hangs if self.1 == 3 => loop {
                    std::thread::park();
                },
                Bad::Errs if self.1 == 3 => Err(TrackerError::Broken("lost its file".into())),
                _ => Ok(TrackerState::tracked(Region::Rect(Rect::new(4.0, 4.0, 12.0, 10.0)))),
            }
        }
    }

    fn make(
        setups: &[Bad],
        states: Option<&Arc<Vec<TrackerState>>>,
        limits: &RunLimits,
    ) -> Vec<Result<PassOutput, CellError>> {
        make_on(sequence(6), setups, states, limits)
    }

    fn make_on(
        sequence: Arc<Sequence>,
        setups: &[Bad],
        states: Option<&Arc<Vec<TrackerState>>>,
        limits: &RunLimits,
    ) -> Vec<Result<PassOutput, CellError>> {
        let entry = SIGNALS.iter().find(|e| e.kind == "rgb-histogram").unwrap();
        let signal = SignalChoice {
            kind: entry.kind,
            version: entry.version,
            signal: Arc::from(entry.build_from_text(entry.example).unwrap()),
        };
        let task = |bad: &Bad| Task {
            setup: Arc::new(*bad),
            run: 0,
            seed: 1,
            states: states.cloned(),
            signals: vec![0],
        };
        let one = Pass {
            sequence,
            frames: Arc::new(FrameCache::new(0)),
            signals: Arc::new(vec![signal]),
            data_root: None,
            tasks: setups.iter().map(task).collect(),
            on_frame: Arc::new(|| {}),
        };
        pass(one, limits).unwrap()
    }

    #[test]
    fn bad_trackers_fail_alone() {
        let alone = make(&[Bad::Never], None, &RunLimits::default()).remove(0).unwrap();
        assert_eq!((alone.states.len(), alone.signals[0].len()), (6, 6));
        let limits = RunLimits { timeout: Some(Duration::from_secs(2)), ..RunLimits::default() };
        let made = make(&[Bad::Panics, Bad::Never, Bad::Hangs, Bad::Errs, Bad::Never], None, &limits);
        let reason = |k: usize| made[k].as_ref().unwrap_err().to_string();
        assert!(
            reason(0).starts_with("grey: panicked at crates/engine") && reason(0).ends_with("out of wits"),
            "{}",
            reason(0)
        );
        assert_eq!(reason(2), "grey: took longer than 2 s (--timeout)");
        assert_eq!(reason(3), "lost its file");
        assert_eq!((made[1].as_ref(), made[4].as_ref()), (Ok(&alone), Ok(&alone)));
    }

    #[test]
    fn frames_that_cannot_be_decoded_fail_all_trackers_of_the_sequence() {
        let made = make_on(sequence(4), &[Bad::Never, Bad::Never], None, &RunLimits::default());
        for made in made {
            let reason = made.unwrap_err().to_string();
            assert!(
                reason.starts_with("grey: panicked at crates/engine") && reason.ends_with("no frame 4"),
                "{reason}"
            );
        }
    }

    #[test]
    fn signals_on_a_kept_track_are_those_on_a_live_one() {
        let live = make(&[Bad::Never], None, &RunLimits::default()).remove(0).unwrap();
        // The tracker itself, which would panic, is not asked.
        let kept = make(&[Bad::Panics], Some(&live.states), &RunLimits::default()).remove(0).unwrap();
        assert_eq!(kept, live);
    }
}
