//! A bank of Kalman filters, each matched to one hypothesis of when the signal's level has jumped: the
//! rival M-model in SanMiguel and Cavallaro (CVIU 131, 2015), read as adaptive forgetting by multiple
//! models (Andersson, Int. J. Control 42(5), 1985; Gustafsson, "Adaptive Filtering and Change
//! Detection", 2000).
//!
//! ```text
//! y[t] = x[t] + e[t],  e ~ N(0, R2)        x[t+1] = x[t] + g[t] v[t],  v ~ N(0, R1),  P(g = 1) = q
//! split   the most probable filter: a copy with P + R1 and weight q w; the filter keeps (1 - q) w
//! update  all filters: d = y - x, S = P + R2, w *= N(d; 0, S), x += P d / S, P *= R2 / S
//! prune   the least probable filter that has lived long enough, when there are more than M
//! adapt   R2 = f R2 + (1 - f) d^2 of the most probable filter
//! ```
//!
//! `y` and the level `x` are in the signal's unit; `P`, `R1` and `R2` in its square; `w` is a filter's
//! probability up to a common factor; `t` is a 0-based frame. The first frame splits nothing.
//!
//! A change is reported in the frame in which the last jump of the most probable filter is one that has not
//! been reported yet: +1 when that filter's level is above the one it was split from, -1 below. Jumps
//! closer than `merge` frames to a reported one are that one. Two changes of one sign may follow each
//! other. The label is inconsistent after a change +1 and consistent after a change -1. The score is the
//! level of the most probable filter; there is no threshold.
//!
//! Paper to code: the paper describes the idea only. q is `jump_probability`, M `models`, R1
//! `jump_variance`, P of the first frame `start_variance`, f `forgetting`; the minimum life of a branch is
//! `life`. Their defaults are those documented for the `segment` function of MATLAB's System
//! Identification Toolbox. Choices: `d` in the adaption is the error of the forecast, before the update;
//! R2 is at least `least_noise`; the level starts at the first sample. Offline, R2 starts as the variance
//! of the first `start_window` samples. As a label may not depend on later frames, while there are fewer
//! samples the bank is run anew from the first frame on in every frame, with the variance of the samples so
//! far; from then on it is the offline bank.
//!
//! The number of changes depends on R2: on noise from a Gamma distribution of shape 0.7 and scale 1, whose
//! level never changes, about 13 in 1000 frames with R2 estimated, and 280 with R2 fixed at 0.05 and no jumps
//! merged.
//!
//! Frames at the start in which the signal is exactly 0 are left out: c_t has no reference there yet.
//! Samples beyond 1e100 are cut to it, so that squares stay finite.

use super::consistency;
use super::prelude::*;

pub(crate) const ENTRY: Entry<dyn Detector> = Entry::of::<Params>(
    "matched-kalman-bank",
    1,
    "Kalman filters matched to hypotheses of jumps; a change where the most probable one has a new jump",
)
.example("{ jump_probability = 0.01, models = 5 }")
.more(&[
    "{ noise_variance = 0.01, life = 0, models = 2, start_level = 1.0 }",
    "{ life = 3, models = 7, forgetting = 0.5, start_window = 9, merge = 4 }",
]);

#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Probability q of a jump in a frame, 1e-9 to 0.5.
    #[default(0.01)]
    pub jump_probability: f64,
    /// Number M of filters that are kept, at least `life` + 2, at most 1000.
    #[default(5)]
    pub models: usize,
    /// Least number of frames that a new filter is kept, 0 to 998.
    #[default(1)]
    pub life: usize,
    /// Variance P of the level before the first frame, 1e-12 to 1e12.
    #[default(10.0)]
    pub start_variance: f64,
    /// Variance R1 of a jump, 1e-12 to 1e12.
    #[default(1.0)]
    pub jump_variance: f64,
    /// Fixed noise variance R2, 1e-12 to 1e12; by default estimated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise_variance: Option<f64>,
    /// Forgetting of the estimated noise variance, 0 to 1.
    #[default(0.97)]
    pub forgetting: f64,
    /// Least estimated noise variance, 1e-12 to 1e12.
    #[default(1e-8)]
    pub least_noise: f64,
    /// Number of samples for the first estimate of the noise variance, 2 to 1000.
    #[default(25)]
    pub start_window: usize,
    /// Number of frames below which two jumps count as one, at least 1.
    #[default(2)]
    pub merge: usize,
    /// Level before the first frame, between -1e100 and 1e100; by default the first sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start_level: Option<f64>,
}

/// Largest magnitude of a sample. Larger ones are clipped.
const MAX_MAGNITUDE: f64 = 1e100;

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[
        Range::within("jump_probability", 1e-9, 0.5),
        Range::within("life", 0.0, 998.0),
        Range::within("models", 2.0, 1000.0),
        Range::within("start_variance", 1e-12, 1e12),
        Range::within("jump_variance", 1e-12, 1e12),
        Range::within("noise_variance", 1e-12, 1e12),
        Range::within("least_noise", 1e-12, 1e12),
        Range::within("forgetting", 0.0, 1.0),
        Range::within("start_window", 2.0, 1000.0),
        Range::of("merge").at_least(1.0),
        Range::within("start_level", -MAX_MAGNITUDE, MAX_MAGNITUDE),
    ];

    fn check(&self) -> Result<(), ParamError> {
        // Fewer, and the filters that may be cut would be too few to leave the most probable one alone.
        let fewest = self.life + 2;
        let rule = format!("from {fewest} (`life` + 2) to 1000");
        ParamError::unless(self.models >= fewest, "models", &rule, self.models)
    }
}

impl Params {
    /// State of the bank after these samples, of which there is at least one.
    fn run(&self, samples: &[f64]) -> Bank<'_> {
        let noise = self.noise_variance.unwrap_or_else(|| variance(samples).max(self.least_noise));
        let level = self.start_level.unwrap_or_else(|| samples.first().copied().unwrap_or_default());
        let filter = Filter { level, variance: self.start_variance, log_weight: 0.0, error: 0.0, jump: None };
        let mut bank = Bank { params: self, filters: vec![filter], best: filter, noise, next: 0 };
        samples.iter().for_each(|y| bank.step(*y));
        bank
    }

    fn follow(&self, signal: &[f64]) -> DetectorOutput {
        let Params { noise_variance, start_window, merge, .. } = *self;
        let samples: Vec<f64> = signal.iter().map(|y| y.clamp(-MAX_MAGNITUDE, MAX_MAGNITUDE)).collect();
        let starting = if noise_variance.is_some() { 1 } else { start_window };
        let mut bank = self.run(&[]);
        let mut reported: Vec<usize> = Vec::new();
        let mut inconsistent = false;
        let mut output = DetectorOutput::default();
        let mut changes = Vec::with_capacity(samples.len());
        for (t, y) in samples.iter().enumerate() {
            if t < starting {
                bank = self.run(&samples[..=t]);
            } else {
                bank.step(*y);
            }
            let best = bank.best;
            let mut change = 0;
            if let Some(jump) = best.jump
                && reported.iter().all(|r| r.abs_diff(jump.frame) >= merge)
                && best.level != jump.from
            {
                reported.push(jump.frame);
                inconsistent = best.level > jump.from;
                change = if inconsistent { 1 } else { -1 };
            }
            changes.push(change);
            output.alarm.push(inconsistent);
            output.score.push(best.level);
        }
        DetectorOutput { changes: Some(changes), ..output }
    }
}

/// Unbiased variance; 0 for fewer than two samples.
fn variance(samples: &[f64]) -> f64 {
    let n = samples.len() as f64;
    let mean = samples.iter().sum::<f64>() / n;
    samples.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0)
}

/// Last jump of a filter's level: the frame, and the level before it.
#[derive(Debug, Clone, Copy)]
struct Jump {
    frame: usize,
    from: f64,
}

/// A hypothesis of the frames in which the level jumped.
#[derive(Debug, Clone, Copy)]
struct Filter {
    level: f64,
    variance: f64,
    log_weight: f64,
    /// Error of the filter's last forecast.
    error: f64,
    jump: Option<Jump>,
}

/// Bank of filters, older ones first.
struct Bank<'a> {
    params: &'a Params,
    filters: Vec<Filter>,
    /// Most probable filter; of equal ones, the oldest.
    best: Filter,
    noise: f64,
    next: usize,
}

impl Bank<'_> {
    fn step(&mut self, y: f64) {
        let t = self.next;
        self.next += 1;
        if t > 0 {
            self.split(t);
        }
        for f in &mut self.filters {
            let spread = f.variance + self.noise;
            f.error = y - f.level;
            f.log_weight -= (f.error * f.error / spread + spread.ln()) / 2.0;
            f.level += f.variance / spread * f.error;
            f.variance *= self.noise / spread;
        }
        if self.filters.len() > self.params.models {
            self.prune(t);
        }
        let best = self.most_probable();
        self.best = self.filters[best];
        // Only ratios of weights matter.
        for f in &mut self.filters {
            f.log_weight -= self.best.log_weight;
        }
        if self.params.noise_variance.is_none() {
            let Params { forgetting, least_noise, .. } = *self.params;
            let adapted = forgetting * self.noise + (1.0 - forgetting) * self.best.error.powi(2);
            self.noise = adapted.max(least_noise);
        }
    }

    fn most_probable(&self) -> usize {
        let weight = |k: usize| self.filters[k].log_weight;
        (1..self.filters.len()).fold(0, |best, k| if weight(k) > weight(best) { k } else { best })
    }

    fn split(&mut self, t: usize) {
        let best = self.most_probable();
        let q = self.params.jump_probability;
        let stays = &mut self.filters[best];
        let mut jumps = *stays;
        jumps.variance += self.params.jump_variance;
        jumps.log_weight += q.ln();
        jumps.jump = Some(Jump { frame: t, from: stays.level });
        stays.log_weight += (-q).ln_1p();
        self.filters.push(jumps);
    }

    /// Removes the least probable filter that has lived long enough; of equal ones, the youngest.
    fn prune(&mut self, t: usize) {
        let old = |f: &Filter| f.jump.is_none_or(|jump| t - jump.frame >= self.params.life);
        let may_go = self.filters.iter().enumerate().filter(|(_, f)| old(f));
        let worst = may_go.min_by(|(i, a), (j, b)| a.log_weight.total_cmp(&b.log_weight).then(j.cmp(i)));
        if let Some((worst, _)) = worst {
            self.filters.remove(worst);
        }
    }
}

impl Detector for Params {
    fn facts(&self) -> Facts {
        Facts { frames_to_recover: 1, ..Facts::default() }
    }

    fn detect(&self, input: &Input<'_>) -> DetectorOutput {
        consistency::on_defined_frames(input.signal, |signal| self.follow(signal))
    }
}

#[cfg(test)]
mod tests;
