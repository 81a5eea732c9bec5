//! A monitor, frame by frame.

use crate::frame::{Taken, order};
use crate::region::{origin, region};
use crate::{finite, refused, threads};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};
use trackfail_judge::image::{Frame, PixelFormat};
use trackfail_judge::method::Inputs;
use trackfail_judge::monitor::{Answer, Monitor as Judging, Options, Update};
use trackfail_judge::region::Region;

/// Index, probability, state, reasons and note.
type Told = (u64, Option<f64>, &'static str, Vec<String>, Option<String>);

/// A track being monitored.
#[pyclass(frozen, module = "trackfail._trackfail")]
pub struct Monitor {
    colors: Option<PixelFormat>,
    /// `None` once it is closed.
    watched: Mutex<Option<Watched>>,
}

/// An open monitor.
struct Watched {
    judging: Judging,
    /// The frame that was judged last, for a restart in it.
    last: Option<Arc<Frame>>,
}

/// Frame, box, confidence and boxes of companions.
type Known = (Option<Arc<Frame>>, Option<Region>, Option<f64>, Vec<Region>);

#[pymethods]
impl Monitor {
    #[new]
    fn new(
        inputs: Option<Vec<String>>,
        method: Option<String>,
        budget: Option<f64>,
        base: i64,
        colors: Option<&str>,
    ) -> PyResult<Self> {
        let inputs = inputs.map(|words| named(&words)).transpose()?;
        let options = Options { method, budget, inputs, base: Some(origin(base)?) };
        Self::of(Judging::new(&options).map_err(refused)?, colors)
    }

    #[staticmethod]
    fn load(state: &[u8], colors: Option<&str>) -> PyResult<Self> {
        Self::of(Judging::resume(&Options::default(), state).map_err(refused)?, colors)
    }

    fn save<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let saved = self.look(|watched| watched.judging.save())?;
        saved.map(|state| PyBytes::new(py, &state)).map_err(refused)
    }

    /// Judges the next frame. A frame that is refused counts.
    fn update(
        &self,
        py: Python<'_>,
        frame: Option<&Bound<'_, PyAny>>,
        numbers: Option<&Bound<'_, PyAny>>,
        confidence: Option<&Bound<'_, PyAny>>,
        companions: Option<&Bound<'_, PyAny>>,
        restart: bool,
    ) -> PyResult<Told> {
        let mut open = self.lock()?;
        let Some(watched) = open.as_mut() else { return Err(closed()) };
        let given = watched.known(self.colors, frame, numbers, confidence, companions);
        let (frame, region, confidence, companions) = given.inspect_err(|_| watched.judging.skip())?;
        let frame = if restart { frame.or_else(|| watched.last.clone()) } else { frame };
        let update = Update {
            frame: frame.as_deref(),
            region: region.as_ref(),
            confidence,
            companions: &companions,
            restart,
        };
        let judging = &mut watched.judging;
        match threads::work(py, || judging.update(&update)) {
            Ok(answer) => {
                let told = answer.map(told).map_err(refused)?;
                watched.last = frame;
                Ok(told)
            }
            // Nobody knows what state it is in.
            Err(fault) => {
                *open = None;
                Err(fault)
            }
        }
    }

    fn close(&self) -> PyResult<()> {
        *self.lock()? = None;
        Ok(())
    }

    #[getter]
    fn closed(&self) -> PyResult<bool> {
        Ok(self.lock()?.is_none())
    }

    #[getter]
    fn index(&self) -> PyResult<u64> {
        self.look(|watched| watched.judging.index())
    }

    #[getter]
    fn method(&self) -> PyResult<Option<String>> {
        self.look(|watched| watched.judging.method().map(str::to_string))
    }
}

impl Monitor {
    fn of(judging: Judging, colors: Option<&str>) -> PyResult<Self> {
        let watched = Mutex::new(Some(Watched { judging, last: None }));
        Ok(Self { colors: order(colors)?, watched })
    }

    /// The open monitor, or `None` once it is closed.
    ///
    /// # Errors
    /// Another thread that is judging with it.
    fn lock(&self) -> PyResult<MutexGuard<'_, Option<Watched>>> {
        match self.watched.try_lock() {
            Ok(guard) => Ok(guard),
            Err(TryLockError::Poisoned(guard)) => Ok(guard.into_inner()),
            Err(TryLockError::WouldBlock) => Err(PyRuntimeError::new_err(
                "the monitor is judging a frame in another thread; each thread needs a monitor of its own",
            )),
        }
    }

    fn look<T>(&self, of: impl FnOnce(&Watched) -> T) -> PyResult<T> {
        self.lock()?.as_ref().map(of).ok_or_else(closed)
    }
}

impl Watched {
    /// Input that Python gives for a frame; pixels that nothing looks at are checked, but not read.
    fn known(
        &mut self,
        colors: Option<PixelFormat>,
        frame: Option<&Bound<'_, PyAny>>,
        numbers: Option<&Bound<'_, PyAny>>,
        confidence: Option<&Bound<'_, PyAny>>,
        companions: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Known> {
        let base = f64::from(self.judging.base());
        let region_of = |given: &Bound<'_, PyAny>| region(given, "box", base);
        let own = numbers.map(region_of).transpose()?.flatten();
        let confidence: Option<f64> = confidence.map(|given| given.extract()).transpose()?;
        let confidence = finite(confidence, "confidence")?;
        let mut others = Vec::new();
        if let Some(companions) = companions {
            for given in companions.try_iter()? {
                others.push(region(&given?, "companions", base)?.unwrap_or_else(Region::nowhere));
            }
        }
        let taken = frame.map(|given| Ok::<_, PyErr>((given.py(), Taken::of(given, colors)?))).transpose()?;
        let frame = match taken {
            Some((py, taken)) if self.judging.reads_frames() => Some(taken.frame(py)?),
            taken => {
                if let Some(size) = taken.and_then(|(_, taken)| taken.size()) {
                    self.judging.check_size(size).map_err(refused)?;
                }
                None
            }
        };
        Ok((frame, own, confidence, others))
    }
}

fn closed() -> PyErr {
    refused("the monitor is closed")
}

fn told(answer: Answer) -> Told {
    let Answer { index, probability, state, reasons, note } = answer;
    (index, probability, state.word(), reasons, note)
}

/// Inputs by their words.
fn named(words: &[String]) -> PyResult<Inputs> {
    let mut inputs = Inputs::default();
    for word in words {
        match word.as_str() {
            "boxes" => {}
            "frames" => inputs.frames = true,
            "companions" => inputs.companions = true,
            "confidence" => inputs.confidence = true,
            other => {
                let known = "boxes, frames, companions, confidence";
                return Err(refused(format!("inputs: unknown input `{other}`; there are {known}")));
            }
        }
    }
    Ok(inputs)
}
