//! `fused`: a learned detector over several signals, each compared with its own past on the track.
//!
//! ```text
//! f[j,t]   features of the inputs, see fused/features.rs
//! s[t]     b + sum_j w[j] d[j,t],  d the standardized features                  see fused/model.rs
//! p[t]     1 / (1 + exp(-(a s[t] + c)))                                         the score
//! n[t]     1 while each deep watchdog among the inputs has touched the box within the last `window` frames, else .001
//! alarm    from the frame with n[t] p[t] >= threshold(budget) until `confirm` frames in a row have p[t] below it
//! ```
//!
//! `p` is the probability that the box does not overlap the target in the 0-based frame `t`; high values
//! speak for a failure. `budget` is the number of good frames in 1000 that the user accepts at or above the
//! threshold. The model has a threshold for each budget, determined on videos outside of its training.
//! Features are relative to the past of the same track, so the scale of a signal does not matter. A missing
//! value (NaN) counts as nothing; the values before it go on counting.
//!
//! Learning (`train`): an L2 logistic model of the frames of other tracks, see fused/learn.rs; or one of the models that
//! come with the program (`model`), which were learned by `benchmark/deep-models` and are described in `docs/fused.md`.
//!
//! Source: none; logistic fusion of weak signals is common practice (stacking). Choices: features, inputs and `lambda` were
//! chosen by scores on folds of the sources of videos that are learned from, see docs/fused.md.

mod features;
mod inputs;
mod learn;
mod logistic;
mod model;

pub use inputs::{FusedInput, INPUTS};
pub use model::{FusedModel, FusedStream};

use super::prelude::*;
use super::stream::{Judgement, step_by_step};
use serde_json::Value;
use std::sync::Arc;

/// The fused detector in the list.
pub const ENTRY: Entry<dyn Detector> = Entry::of::<Fused>(
    "fused",
    4,
    "learned probability of a loss from several signals, with an alarm by a budget of false alarms",
)
.example("{ inputs = [\"displacement\", \"acceleration\", \"scale\", \"aspect\"], model = \"boxes\" }");

/// Names and texts of the models that come with the program. Results depend on them: if they change, the
/// version of [`ENTRY`] is raised.
static MODELS: &[(&str, &str)] = &[
    ("boxes", include_str!("../../models/fused/boxes.json")),
    ("deep", include_str!("../../models/fused/deep.json")),
    ("deep-full", include_str!("../../models/fused/deep-full.json")),
    ("deep-v3", include_str!("../../models/fused/deep-v3.json")),
    ("deep-and-companions", include_str!("../../models/fused/deep-and-companions.json")),
    ("companions", include_str!("../../models/fused/companions.json")),
];

/// Parameters of the detector.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Names of the inputs in the order of the signals: `displacement`, `companions`, `v2-overlap` ...
    pub inputs: Vec<String>,
    /// Name of a model that comes with the program.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<String>,
    /// Role of the suite to learn from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub train: Option<String>,
    /// Most false alarms per 1000 good frames, 0.000001 to 1000.
    #[serde(default = "budget")]
    pub budget: f64,
    /// Number of frames in a row below the threshold that confirm a recovery, 1 to 1000.
    #[serde(default = "confirm")]
    pub confirm: usize,
    /// Weight of the penalty on squared weights when learning, relative to that of the examples, 0.000001 to
    /// 100.
    #[serde(default = "lambda")]
    pub lambda: f64,
    /// Distance in frames between training examples, except at the beginning of a loss, where all frames are
    /// used; 1 to 100.
    #[serde(default = "stride")]
    pub stride: usize,
    /// Number of frames during which a disagreement with a watchdog is news, 0 to 10000.
    #[serde(default = "window")]
    pub window: u32,
}

fn budget() -> f64 {
    10.0
}

fn confirm() -> usize {
    super::RECOVERY_FRAMES
}

fn lambda() -> f64 {
    0.1
}

fn stride() -> usize {
    20
}

fn window() -> u32 {
    20
}

/// The fused detector. It raises no alarms until it has a model.
#[derive(Debug, Clone)]
pub struct Fused {
    params: Params,
    inputs: Vec<&'static FusedInput>,
    model: Option<Arc<FusedModel>>,
}

impl Plugin for Fused {
    type Params = Params;

    const RANGES: &'static [Range] = &[
        Range::within("budget", 1e-6, 1000.0),
        Range::within("lambda", 1e-6, 100.0),
        Range::within("confirm", 1.0, 1000.0),
        Range::within("stride", 1.0, 100.0),
        Range::within("window", 0.0, 10_000.0),
    ];

    fn make(params: Params) -> Result<Self, ParamError> {
        let count = params.inputs.len();
        ParamError::unless((1..=64).contains(&count), "inputs", "from 1 to 64 names", count)?;
        let find = |name: &String| {
            let message = || crate::plugin::unknown("input", name, INPUTS.iter().map(|input| input.name));
            let refuse = || ParamError { message: message(), key: Some("inputs"), span: None };
            inputs::find(name).ok_or_else(refuse)
        };
        let inputs = params.inputs.iter().map(find).collect::<Result<_, _>>()?;
        let unready = Self { params, inputs, model: None };
        match (unready.params.model.clone(), &unready.params.train) {
            (None, Some(_)) => Ok(unready),
            (Some(name), None) => unready.built_in(&name),
            _ => {
                let message = "give either `model` (one that comes with the program) or `train` (role of the suite to \
                               learn from)";
                Err(ParamError { message: message.to_string(), key: None, span: None })
            }
        }
    }
}

impl Fused {
    /// The detector with a model that comes with the program.
    fn built_in(self, name: &str) -> Result<Self, ParamError> {
        let refuse = |message: String| ParamError { message, key: Some("model"), span: None };
        let found = MODELS.iter().find(|(known, _)| *known == name);
        let (_, text) = found.ok_or_else(|| {
            refuse(crate::plugin::unknown("model", name, MODELS.iter().map(|(known, _)| *known)))
        })?;
        let file: ModelFile = serde_json::from_str(text).map_err(|e| refuse(format!("model {name}: {e}")))?;
        self.ready(file.model).map_err(|e| refuse(format!("model {name}: {e}")))
    }

    /// The detector with a model.
    fn ready(&self, model: FusedModel) -> Result<Self, LearnError> {
        if !model.fits(&self.inputs) {
            return Err(LearnError::OtherModel);
        }
        Ok(Self { model: Some(Arc::new(model)), ..self.clone() })
    }

    /// Stream before the first frame of a track; `None` without a model.
    fn start(&self) -> Option<FusedStream> {
        Some(FusedStream::new(self.clone(), self.model.clone()?))
    }
}

/// A model of the program, with the sequences that it was learned from.
#[derive(Deserialize)]
struct ModelFile {
    sequences: Vec<String>,
    model: FusedModel,
}

/// Names of the sequences that a model of the program was learned from; `None` for an unknown model.
pub fn learned_from(model: &str) -> Option<Vec<String>> {
    let (_, text) = MODELS.iter().find(|(known, _)| *known == model)?;
    Some(serde_json::from_str::<ModelFile>(text).ok()?.sequences)
}

impl Learner for Fused {
    fn role(&self) -> &str {
        self.params.train.as_deref().unwrap_or_default()
    }

    fn pools_trackers(&self) -> bool {
        true
    }

    fn params(&self) -> Value {
        let Params { inputs, lambda, stride, window, .. } = &self.params;
        serde_json::json!({ "inputs": inputs, "lambda": lambda, "stride": stride, "window": window })
    }

    fn learn(&self, examples: &[Example<'_>]) -> Result<Value, LearnError> {
        serde_json::to_value(learn::learn(self, examples)?).map_err(LearnError::Write)
    }

    fn with_model(&self, model: &Value) -> Result<Arc<dyn Detector>, LearnError> {
        Ok(Arc::new(self.ready(FusedModel::deserialize(model).map_err(LearnError::Read)?)?))
    }
}

impl Detector for Fused {
    fn facts(&self) -> Facts {
        let (signals, budget) = (self.inputs.len(), self.params.budget);
        let threshold = self.model.as_ref().map(|model| model.threshold(budget));
        Facts { signals, threshold, gives_probability: true, frames_to_recover: 1, ..Facts::default() }
    }

    fn learner(&self) -> Option<&dyn Learner> {
        self.model.is_none().then_some(self as &dyn Learner)
    }

    fn stream(&self) -> Option<Box<dyn Stream>> {
        Some(Box::new(self.start()?))
    }

    fn detect(&self, input: &Input<'_>) -> DetectorOutput {
        let tells_news = self.inputs.iter().any(|input| input.is_watchdog_overlap);
        let mut stream = self.start();
        step_by_step(input, |values| {
            let Some(stream) = &mut stream else { return Step::new(0.0, false) };
            let (Judgement { probability, alarm, compared, .. }, _) = stream.step(values);
            Step { alarm_score: tells_news.then_some(compared), ..Step::new(probability, alarm) }
        })
    }
}

#[cfg(test)]
mod tests;
