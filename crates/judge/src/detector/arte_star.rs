//! ARTE*, [ARTE](super::arte) with the change detection of AVU instead of its own thresholds (SanMiguel and
//! Cavallaro, "Temporal validation of particle filters for video tracking", CVIU 131, 2015, section 6).
//!
//! ```text
//! s[t] = sum_{r=1..L} c[t - L + r],   inconsistent when s[t] > beta_1              Eq. 8, 11
//! large increase in t:   s[t] becomes inconsistent
//! large decrease in t:   s[t] becomes consistent
//! small decrease in t:   c[t - 1] > beta_2  and  c[t] <= beta_2,   beta_2 = beta_1 / 2
//! ```
//!
//! `c` is the change signal c_t (`uncertainty-change`) of the full state, without unit and not smoothed; `t`
//! is a 0-based frame, and a track counts as consistent before its first. `s`, `beta_1` and how it is learned
//! are those of [`super::accumulated_validation`], Eq. 12 to 24; beta_1 can be given as `beta`. The
//! effect of the events is in [`super::track_quality::machine`], the recovery check in
//! [`super::track_quality`]; the alarm holds while the track is unsuccessful. The score is s_t,
//! high is suspicious, the threshold is beta_1. Frame t is labeled from frames up to t alone.
//!
//! Source: the text of section 6 says which labels replace which thresholds; its Table 2 was not legible.
//! Reconstruction:
//!
//! * beta_2 is half of beta_1 as it is written (`half`), although c_t is one value and beta_1 a bound on L of
//!   them, so that nearly every c_t is below it for a large L. `half-of-one` is half of the bound on one value;
//! * LOCKING-IN ends after `locking_in_limit` frames, by default as many as the long window of ARTE.
//!
//! As increases are onsets here and s_t is inconsistent all the time while the tracker is SCANNING or
//! LOCKING-IN, no large increase ever happens in these two conditions.

use super::accumulated_validation::{self as avu, AccumulatedValidation};
use super::prelude::*;
use super::track_quality::machine::Events;
use super::track_quality::{self, Rules};
use serde_json::Value;
use std::sync::Arc;

/// ARTE* in the list of detectors. Its labels change with those of AVU.
pub(crate) const ENTRY: Entry<dyn Detector> = Entry::of::<ArteStar>(
    "arte-star",
    1,
    "alarm from where the sum of c_t passes its cut value until a run backwards confirms a recovery (ARTE*)",
)
.example("{ length = 5, beta = 0.2 }")
.more(&["{ length = 2, beta = 0.1, accept_below = 1.0, reverse_limit = 0, locking_in_limit = 1 }"]);

/// Rule for the threshold on a single c_t, beta_2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Second {
    /// Half of beta_1.
    Half,
    /// Half of the beta_1 for a sum of one value; only with a learned model.
    HalfOfOne,
}

/// Parameters; the first five are those of `accumulated-validation`.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Length of the sum in frames, L, 1 to 10000.
    pub length: usize,
    /// Rate of false alarms of a consistent filter, above 0 and below 0.5.
    pub alpha: f64,
    /// Threshold beta_1; if it is given, nothing is learned.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beta: Option<f64>,
    /// Role of the suite to learn from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub train: Option<String>,
    /// Error below which a frame is consistent, above 0 and at most 1.
    pub tau: f64,
    /// Rule for the threshold on a single c_t.
    pub beta_2: Second,
    /// Error below which a recovery check is accepted, tau_4, above 0 and at most 1.
    pub accept_below: f64,
    /// Most frames of a run backwards, 0 to 100000.
    pub reverse_limit: usize,
    /// Number of frames after which LOCKING-IN ends, 1 to 100000.
    pub locking_in_limit: usize,
    /// Number of frames from the reference of a check to the frame in which the track was lost, 1 to 100000.
    pub reference_lag: usize,
}

impl Default for Params {
    fn default() -> Self {
        let avu::Params { length, alpha, beta, train, tau, .. } = avu::Params::default();
        Self {
            length,
            alpha,
            beta,
            train,
            tau,
            beta_2: Second::Half,
            accept_below: 0.8,
            reverse_limit: 200,
            locking_in_limit: 25,
            reference_lag: 1,
        }
    }
}

/// The ARTE* detector. It raises no alarms until it has thresholds.
#[derive(Debug, Clone)]
pub struct ArteStar {
    params: Params,
    rules: Rules,
    validation: AccumulatedValidation,
    beta_2: Option<f64>,
}

impl Plugin for ArteStar {
    type Params = Params;

    const RANGES: &'static [Range] = &[
        avu::LENGTH,
        avu::ALPHA,
        avu::BETA,
        avu::TAU,
        track_quality::ACCEPT_BELOW,
        track_quality::REVERSE_LIMIT,
        track_quality::LOCKING_IN_LIMIT,
        track_quality::REFERENCE_LAG,
    ];

    fn make(p: Params) -> Result<Self, ParamError> {
        let Params { accept_below, reverse_limit, locking_in_limit, reference_lag, .. } = p;
        let rules = Rules { accept_below, reverse_limit, locking_in_limit, reference_lag };
        let validation = AccumulatedValidation::new(validation_params(&p, p.length))?;
        if p.beta.is_some() && p.beta_2 == Second::HalfOfOne {
            let message =
                "`beta_2` = \"half-of-one\" comes from a learned model; give `train` instead of `beta`";
            return Err(ParamError { message: message.to_string(), key: Some("beta_2"), span: None });
        }
        let beta_2 = p.beta.map(|beta| beta / 2.0);
        Ok(Self { params: p, rules, validation, beta_2 })
    }
}

impl ArteStar {
    /// Score and events in each frame, from the changes `c`.
    fn events(&self, input: &Input<'_>) -> (Vec<f64>, Vec<Events>) {
        let DetectorOutput { score, alarm: inconsistent, .. } = self.validation.detect(input);
        let large = |t: usize| inconsistent[t];
        let small = |t: usize| self.beta_2.is_some_and(|beta_2| input.signal[t] > beta_2);
        let frame = |t: usize| {
            let (was_large, was_small) = t.checked_sub(1).map_or((false, false), |t| (large(t), small(t)));
            [!was_large && large(t), was_large && !large(t), was_small && !small(t)]
        };
        let events = (0..score.len()).map(frame).collect();
        (score, events)
    }
}

/// Parameters of AVU, taken from those of ARTE*.
fn validation_params(p: &Params, length: usize) -> avu::Params {
    let Params { alpha, beta, tau, .. } = *p;
    avu::Params { length, alpha, beta, train: p.train.clone(), tau, ..avu::Params::default() }
}

impl Learner for ArteStar {
    fn role(&self) -> &str {
        self.validation.role()
    }

    fn params(&self) -> Value {
        Learner::params(&self.validation)
    }

    fn learn(&self, examples: &[Example<'_>]) -> Result<Value, LearnError> {
        self.validation.learn(examples)
    }

    fn with_model(&self, model: &Value) -> Result<Arc<dyn Detector>, LearnError> {
        let validation = self.validation.ready(model)?;
        let whole = match self.params.beta_2 {
            Second::Half => validation.facts().threshold,
            Second::HalfOfOne => {
                let one = AccumulatedValidation::new(validation_params(&self.params, 1))?;
                one.ready(model)?.facts().threshold
            }
        };
        Ok(Arc::new(Self { validation, beta_2: whole.map(|beta| beta / 2.0), ..self.clone() }))
    }
}

impl Detector for ArteStar {
    fn facts(&self) -> Facts {
        Facts { needs_reverse: true, ..self.validation.facts() }
    }

    fn learner(&self) -> Option<&dyn Learner> {
        self.params.beta.is_none().then_some(self as &dyn Learner)
    }

    fn detect(&self, input: &Input<'_>) -> DetectorOutput {
        self.rules.follow(input, self.events(input))
    }
}

#[cfg(test)]
mod tests;
