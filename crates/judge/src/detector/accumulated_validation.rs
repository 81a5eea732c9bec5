//! AVU, accumulated validation of uncertainty (SanMiguel and Cavallaro, "Temporal validation of particle
//! filters for video tracking", CVIU 131, 2015, sections 4.2 and 5).
//!
//! ```text
//! s[t] = sum_{r=1..L} c[t - L + r]                    Eq. 8, with w_r = 1
//! alarm at t when s[t] > beta                         P_2(S < beta) = 1 - alpha, Eq. 11
//! p_2  = density of the sum of L independent values with density p_1       Eq. 17
//! p_1  = mixture of K Gamma densities, learned from consistent frames      Eq. 12, 13, 24
//! ```
//!
//! `c` is the change signal c_t (`uncertainty-change`), without unit; `t` is a 0-based frame, and before
//! frame `L - 1` the sum is over the frames so far. `L` is `length`, `alpha` the accepted rate of false
//! alarms. The score is s_t, high is suspicious, the threshold is `beta`.
//!
//! Learning: c_t of all frames of the suite in role `train` with an error below `tau` ([`consistency`]),
//! a mixture for each order up to `max_components`, the order by dAIC or dBIC. One model serves all lengths
//! and rates. Instead of learning, `beta` can be given.
//!
//! Choices where the source is silent: alarm only above `beta` (the text says s_t > beta); orders 1 to 10.
//! The paper convolves a histogram of numbers drawn from p_1, which `sampled` does; the default convolves
//! p_1 itself. `normal` is the central limit theorem, and `empirical` the quantile of s_t of the training
//! tracks over windows whose frames are all consistent: the two that the paper compares it with.

use super::consistency::{self, ConsistencyModel, Fitting};
use super::prelude::*;
use crate::num::accumulation::{self, Accumulated, AccumulationError};
use crate::num::gamma_mixture::select::Criterion;
use serde_json::{Value, json};
use std::sync::Arc;

pub(crate) const ENTRY: Entry<dyn Detector> = Entry::of::<AccumulatedValidation>(
    "accumulated-validation",
    2,
    "alarm while the sum of the last c_t is beyond what a learned model of consistency allows (AVU)",
)
.example("{ length = 5, beta = 0.2 }");

/// Method by which the distribution of the sum is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Approximation {
    /// Convolution of the mixture with itself.
    Convolution,
    /// Convolution of a histogram of numbers drawn from the mixture, as the paper writes it.
    Sampled,
    /// Central limit theorem: normal distribution with L times the mean and variance of c_t.
    Normal,
    /// No model: the empirical quantile of s_t on the training tracks.
    Empirical,
}

#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Length of the sum in frames, L, 1 to 10000.
    #[default(20)]
    pub length: usize,
    /// Rate of false alarms of a consistent filter, above 0 and below 0.5.
    #[default(0.005)]
    pub alpha: f64,
    /// Threshold; if it is given, nothing is learned.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beta: Option<f64>,
    /// Role of the suite to learn from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub train: Option<String>,
    /// Error below which a frame is consistent, above 0 and at most 1.
    #[default(0.9)]
    pub tau: f64,
    /// Order of the mixture, 1 to 20; by default chosen by `criterion`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub components: Option<usize>,
    /// Largest order to try, 1 to 20.
    #[default(10)]
    pub max_components: usize,
    /// Criterion that chooses the order: `aic` (dAIC) or `bic` (dBIC).
    #[default(Criterion::Bic)]
    pub criterion: Criterion,
    /// Method by which the distribution of the sum is computed.
    #[default(Approximation::Convolution)]
    pub approximation: Approximation,
}

/// Number of values that `sampled` draws.
const DRAWN: usize = 1_000_000;

/// The AVU detector. It raises no alarms until it has a threshold.
#[derive(Debug, Clone)]
pub struct AccumulatedValidation {
    params: Params,
    beta: Option<f64>,
}

/// Ranges of the parameters that `arte-star` shares.
pub(super) const LENGTH: Range = Range::within("length", 1.0, 10_000.0);
pub(super) const ALPHA: Range = Range::of("alpha").above(0.0).below(0.5);
pub(super) const BETA: Range = Range::of("beta");
pub(super) const TAU: Range = Range::of("tau").above(0.0).at_most(1.0);

impl Plugin for AccumulatedValidation {
    type Params = Params;

    const RANGES: &'static [Range] = &[
        LENGTH,
        ALPHA,
        BETA,
        TAU,
        Range::within("components", 1.0, 20.0),
        Range::within("max_components", 1.0, 20.0),
    ];

    fn make(p: Params) -> Result<Self, ParamError> {
        let message = match (p.beta, &p.train) {
            (Some(_), None) | (None, Some(_)) => return Ok(Self { beta: p.beta, params: p }),
            (None, None) => "give `train` (role of the suite to learn from) or `beta` (the threshold)",
            (Some(_), Some(_)) => "give `train` or `beta`, not both",
        };
        Err(ParamError { message: message.to_string(), key: p.beta.map(|_| "beta"), span: None })
    }
}

impl AccumulatedValidation {
    /// The detector with the threshold from a learned model.
    ///
    /// # Errors
    /// When the model is not from this learner.
    pub(super) fn ready(&self, model: &Value) -> Result<Self, LearnError> {
        let model = Learned::deserialize(model).map_err(LearnError::Read)?;
        let beta = self.cut(&model)?;
        if !beta.is_finite() {
            let message = format!("its threshold is {beta}, not a number");
            return Err(LearnError::Read(serde::de::Error::custom(message)));
        }
        Ok(Self { params: self.params.clone(), beta: Some(beta) })
    }

    /// Threshold beta that follows from a model.
    fn cut(&self, model: &Learned) -> Result<f64, LearnError> {
        let Params { length, alpha, approximation, .. } = self.params;
        let m = &model.consistency;
        let convolved =
            |sum: Result<Accumulated, AccumulationError>| Ok(sum.and_then(|sum| sum.upper_quantile(alpha))?);
        match approximation {
            Approximation::Convolution => convolved(Accumulated::of_mixture(&m.mixture, length)),
            Approximation::Sampled => {
                let mut rng = crate::num::seed::rng(2015);
                let drawn: Vec<f64> = (0..DRAWN).map(|_| m.mixture.sample(&mut rng)).collect();
                convolved(Accumulated::from_samples(&drawn, length))
            }
            Approximation::Normal => Ok(accumulation::clt_quantile(m.mean, m.variance, length, alpha)),
            Approximation::Empirical => {
                let known = model.empirical.filter(|e| e.length == length && e.alpha == alpha);
                known.map(|e| e.beta).ok_or(LearnError::OtherModel)
            }
        }
    }
}

/// Model that AVU learns.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Learned {
    consistency: ConsistencyModel,
    #[serde(skip_serializing_if = "Option::is_none", default)]
    empirical: Option<EmpiricalCut>,
}

/// Quantile of s_t on the training tracks.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct EmpiricalCut {
    length: usize,
    alpha: f64,
    beta: f64,
}

impl Learner for AccumulatedValidation {
    fn role(&self) -> &str {
        self.params.train.as_deref().unwrap_or_default()
    }

    fn params(&self) -> Value {
        let p = &self.params;
        let mut params = json!({
            "tau": p.tau,
            "components": p.components,
            "max_components": p.max_components,
            "criterion": p.criterion,
        });
        if p.approximation == Approximation::Empirical {
            params["empirical"] = json!([p.length, p.alpha]);
        }
        params
    }

    fn learn(&self, examples: &[Example<'_>]) -> Result<Value, LearnError> {
        let p = &self.params;
        let Params { tau, components, max_components, criterion, .. } = *p;
        let how = Fitting { tau, components, max_components, criterion };
        let consistency = consistency::fit(examples, &how)?.model;
        let empirical = match p.approximation {
            Approximation::Empirical => {
                let sums = examples.iter().flat_map(|e| consistency::consistent_sums(e, p.tau, p.length));
                let mut sums: Vec<f64> = sums.collect();
                sums.sort_by(f64::total_cmp);
                let beta = accumulation::empirical_quantile(&sums, 1.0 - p.alpha);
                let beta = beta.ok_or(LearnError::NoWindow(p.length))?;
                Some(EmpiricalCut { length: p.length, alpha: p.alpha, beta })
            }
            _ => None,
        };
        serde_json::to_value(Learned { consistency, empirical }).map_err(LearnError::Write)
    }

    fn with_model(&self, model: &Value) -> Result<Arc<dyn Detector>, LearnError> {
        Ok(Arc::new(self.ready(model)?))
    }
}

impl Detector for AccumulatedValidation {
    fn facts(&self) -> Facts {
        Facts { threshold: self.beta, frames_to_recover: 1, ..Facts::default() }
    }

    fn learner(&self) -> Option<&dyn Learner> {
        self.params.beta.is_none().then_some(self as &dyn Learner)
    }

    fn detect(&self, input: &Input<'_>) -> DetectorOutput {
        let score = accumulation::sums(input.signal, self.params.length);
        let alarm = score.iter().map(|s| self.beta.is_some_and(|beta| *s > beta)).collect();
        DetectorOutput { score, alarm, ..DetectorOutput::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::testing::{self, alone};
    use crate::plugin::Configured;
    use rand::RngExt;

    fn built(text: &str) -> Configured<dyn Detector> {
        testing::built(&ENTRY, text)
    }

    fn alarms(detector: &dyn Detector, signal: &[f64]) -> Vec<bool> {
        detector.detect(&alone(signal)).alarm
    }

    // By hand: s = 1, 3, 5, 7 for L = 2; only values above beta are alarms.
    #[test]
    fn the_sum_of_the_last_values_is_compared() {
        let detector = built("{ length = 2, beta = 5.0 }");
        let output = detector.detect(&alone(&[1.0, 2.0, 3.0, 4.0]));
        assert_eq!(output.score, [1.0, 3.0, 5.0, 7.0]);
        assert_eq!(output.alarm, [false, false, false, true]);
        assert_eq!(detector.facts().threshold, Some(5.0));
    }

    /// Exponential c_t with mean 0.2 in consistent frames and mean 2 in the others.
    fn drawn() -> (Vec<f64>, Vec<f64>) {
        let mut rng = crate::num::seed::rng(3);
        let error: Vec<f64> = (0..20_000).map(|t| if t % 400 < 40 { 1.0 } else { 0.4 }).collect();
        let draw = |e: &f64| -rng.random_range(1e-9_f64..1.0).ln() * if *e < 1.0 { 0.2 } else { 2.0 };
        (error.iter().map(draw).collect(), error)
    }

    fn learned(more: &str) -> (Value, Arc<dyn Detector>) {
        let (signal, error) = drawn();
        let detector = built(&format!("{{ train = \"train\", components = 1, {more} }}"));
        let learner = detector.learner().unwrap();
        let model = learner.learn(&[Example::new(&signal, &error)]).unwrap();
        let ready = learner.with_model(&model).unwrap();
        (model, ready)
    }

    // The sum of L exponentials of mean 0.2 is Gamma(L, 0.2).
    // scipy.stats.gamma.ppf(0.995, [1, 5, 20], scale=0.2) = [1.05966347, 2.51881796, 6.67659618]; 0.95 and 5: 1.83070381
    #[test]
    fn a_model_of_exponential_values_has_the_cut_values_of_gamma() {
        for (length, alpha, beta) in
            [(1, 0.005, 1.05966347), (5, 0.005, 2.51881796), (20, 0.005, 6.67659618), (5, 0.05, 1.83070381)]
        {
            for approximation in ["convolution", "sampled", "empirical"] {
                let params =
                    format!("length = {length}, alpha = {alpha}, approximation = \"{approximation}\"");
                let got = learned(&params).1.facts().threshold.unwrap();
                // 18,000 samples, and a tenth as many independent windows of 20.
                assert!((got / beta - 1.0).abs() < 0.06, "{approximation} {length}: {got}, not {beta}");
            }
        }
        // 20 * 0.2 + 2.5758293 * 0.2 * sqrt(20) = 6.3039
        let got = learned("length = 20, approximation = \"normal\"").1.facts().threshold.unwrap();
        assert!((got / 6.3039 - 1.0).abs() < 0.02, "{got}");
    }

    #[test]
    fn lost_frames_alarm_and_consistent_ones_seldom_do() {
        let (signal, error) = drawn();
        let (model, ready) = learned("length = 5");
        let alarm = alarms(&*ready, &signal);
        let share = |frames: std::ops::Range<usize>| {
            let chosen: Vec<usize> = (0..error.len()).filter(|t| frames.contains(&(t % 400))).collect();
            chosen.iter().filter(|t| alarm[**t]).count() as f64 / chosen.len() as f64
        };
        // Lost in frames 0..40 of every 400; the window has forgotten that 5 frames later.
        assert!(share(4..40) > 0.9 && share(45..400) < 0.01, "{} {}", share(4..40), share(45..400));
        // The model survives being written and read to the last bit.
        assert_eq!(serde_json::from_str::<Value>(&model.to_string()).unwrap(), model);
    }

    #[test]
    fn a_constant_signal_never_alarms_once_it_is_consistent() {
        let (signal, error) = (vec![0.25; 200], vec![0.1; 200]);
        let detector = built("{ length = 10, train = \"t\" }");
        let learner = detector.learner().unwrap();
        // Equal samples have no mixture: an error, and no threshold.
        assert!(learner.learn(&[Example::new(&signal, &error)]).is_err());
        assert!(!alarms(&*detector, &signal).contains(&true));
        assert!(!alarms(&*learned("length = 10").1, &[0.0; 300]).contains(&true));
    }

    #[test]
    fn models_are_checked() {
        let (model, _) = learned("length = 5, approximation = \"empirical\"");
        for other in ["length = 6", "length = 5, alpha = 0.01"] {
            let other = built(&format!("{{ {other}, train = \"t\", approximation = \"empirical\" }}"));
            assert!(matches!(other.learner().unwrap().with_model(&model), Err(LearnError::OtherModel)));
            assert!(other.learner().unwrap().with_model(&json!({"beta": 1})).is_err());
        }
        // The root of a negative variance is no threshold; compared with it, no frame would ever alarm.
        let (mut model, _) = learned("approximation = \"normal\"");
        model["consistency"]["variance"] = json!(-1.0);
        let normal = built("{ train = \"t\", approximation = \"normal\" }");
        let refused = normal.learner().unwrap().with_model(&model).err().unwrap();
        assert!(refused.to_string().contains("threshold is NaN"), "{refused}");
        assert!(built("{ beta = 1.0 }").learner().is_none());
        let empirical = built("{ train = \"t\", approximation = \"empirical\" }");
        let told = [empirical, normal].map(|d| d.learner().unwrap().params()["empirical"].clone());
        assert_eq!(told, [json!([20, 0.005]), Value::Null]);
        assert!(!built("{ train = \"t\" }").learner().unwrap().pools_trackers());
    }
}
