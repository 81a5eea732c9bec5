//! `conformal-forecast`: the forecast error of `arma-forecast` with a threshold that the track sets itself, by
//! adaptive conformal inference (Gibbs and Candes, "Adaptive conformal inference under distribution shift", NeurIPS
//! 2021).
//!
//! ```text
//! alarm at t when |z[t]| > Q[t](1 - a[t])          a[t+1] = a[t] + gamma (rate - alarm[t]),  a = rate at first
//! Q[t](p) = smallest earlier |z| that a share p or more of the earlier |z| do not exceed
//! ```
//!
//! `z[t] = y[t] - y^[t]` is the forecast error in the signal's unit, as in [`arma_forecast`]; `t` is a
//! 0-based frame; `a`, `rate` (the source's alpha) and `gamma` have no unit, `alarm[t]` is 1 or 0. The
//! earlier `|z|` are those of all frames with a forecast, alarms included (the last 100,000). `Q(p)` is minus
//! infinity for p <= 0 and infinity for p > 1. The score is `|z|`, high is suspicious; the threshold moves,
//! so figures draw none. Until there are `warm_up` earlier scores, there is no alarm and `a` is not changed.
//!
//! Guarantee, for any series whatever: of T frames after the warm-up, the share of alarms is at most
//! `rate + (rate + gamma) / (gamma T)` and at least `rate - (1 - rate + gamma) / (gamma T)`. It is about the number of
//! alarms and says nothing about which frames they are: a track that is always on target has as many, and a constant
//! signal alarms whenever `a` has grown to 1.
//!
//! Choices: `gamma = 0.02`, as tracks are shorter than the source's series, for which it takes 0.005; a warm-up of 50
//! scores, where the 0.95 quantile is the third largest; `rate = 0.05`, since the errors of one block of forecasts tend
//! to exceed together and count as one detection. The parameters of the forecast are those of the paper, as in
//! `arma-forecast`.

use super::arma_forecast;
use super::forecasting::{self, Forecaster, Scheme};
use super::prelude::*;
use crate::num::accumulation::empirical_quantile;
use crate::num::arma::{self, Presample};
use std::collections::VecDeque;

pub(crate) const ENTRY: Entry<dyn Detector> = Entry::of::<Params>(
    "conformal-forecast",
    1,
    "forecasts the signal with an ARMA model; alarm when the error is large for this track, at a given rate",
)
.example("{ rate = 0.05 }")
.more(&["{ warm_up = 5, rate = 0.2, gamma = 0.3, window = 8, horizon = 2 }"]);

/// Most scores from which a threshold is computed. Longer tracks forget the oldest scores.
const MOST: usize = 100_000;

#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Share of frames that should be alarms in the long run, 0.0001 to 0.5.
    pub rate: f64,
    /// Step size of the adaptation, 0.0001 to 1.
    pub gamma: f64,
    /// Number of scores before the first frame that can be an alarm, 1 to 100000.
    pub warm_up: usize,
    /// Autoregressive and moving average order, each 0 to 5.
    pub order: [usize; 2],
    /// Number of frames to which a model is fitted, at least `2 p + q + 3`.
    pub window: usize,
    /// Number of frames that a forecast looks ahead, at least 1.
    pub horizon: usize,
    /// Assignment of forecast origins to frames.
    pub scheme: Scheme,
    /// Values assumed before the window.
    pub start: Presample,
}

impl Default for Params {
    fn default() -> Self {
        let arma_forecast::Params { order, window, horizon, scheme, start, .. } =
            arma_forecast::Params::default();
        Self { rate: 0.05, gamma: 0.02, warm_up: 50, order, window, horizon, scheme, start }
    }
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[
        Range::within("rate", 0.0001, 0.5),
        Range::within("gamma", 0.0001, 1.0),
        Range::within("warm_up", 1.0, 100_000.0),
        Range::within("order", 0.0, arma::MAX_ORDER as f64),
        forecasting::WINDOW,
        forecasting::HORIZON,
    ];

    fn check(&self) -> Result<(), ParamError> {
        self.forecast().check()
    }
}

impl Params {
    /// The forecast, whose own threshold is not read.
    fn forecast(&self) -> arma_forecast::Params {
        let Params { order, window, horizon, scheme, start, .. } = *self;
        arma_forecast::Params { order, window, horizon, scheme, start, ..arma_forecast::Params::default() }
    }

    fn threshold(&self) -> AdaptiveThreshold {
        let Params { rate, gamma, warm_up, .. } = *self;
        AdaptiveThreshold { rate, gamma, warm_up, level: rate, most: MOST, ..AdaptiveThreshold::default() }
    }
}

impl Causal for Params {
    type Memory = (Forecaster, AdaptiveThreshold);

    fn begin(&self) -> Self::Memory {
        (Forecaster::default(), self.threshold())
    }

    fn step(&self, (forecaster, threshold): &mut Self::Memory, values: &[f64]) -> Step {
        let forecast = self.forecast().push(forecaster, values[0]);
        let score = forecasting::error(values[0], forecast);
        let alarm = !forecast.is_nan() && threshold.is_alarm(score);
        Step { forecast: Some(forecast), ..Step::new(score, alarm) }
    }

    fn is_memory(&self, (_, threshold): &Self::Memory) -> bool {
        let mut earlier: Vec<f64> = threshold.came.iter().copied().collect();
        earlier.sort_by(f64::total_cmp);
        // All but the scores and the level is as it was in the beginning.
        let AdaptiveThreshold { level, ref came, .. } = *threshold;
        let rebuilt = AdaptiveThreshold { level, earlier, came: came.clone(), ..self.threshold() };
        level.is_finite() && came.len() <= MOST && *threshold == rebuilt
    }
}

/// Moving threshold of a series of scores.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct AdaptiveThreshold {
    rate: f64,
    gamma: f64,
    warm_up: usize,
    /// Current level a\[t\].
    level: f64,
    /// Most scores that are remembered.
    most: usize,
    /// Remembered scores, ascending; `came` has them in order of arrival.
    earlier: Vec<f64>,
    came: VecDeque<f64>,
}

impl AdaptiveThreshold {
    /// Adds the next score. Returns true if it is an alarm.
    fn is_alarm(&mut self, score: f64) -> bool {
        let mut alarm = false;
        if self.earlier.len() >= self.warm_up {
            let p = 1.0 - self.level;
            let exceeds = |quantile| score > quantile;
            alarm = p <= 0.0 || empirical_quantile(&self.earlier, p).is_some_and(exceeds);
            self.level += self.gamma * (self.rate - f64::from(u8::from(alarm)));
        }
        if self.came.len() == self.most
            && let Some(oldest) = self.came.pop_front()
        {
            self.earlier.remove(self.earlier.partition_point(|z| *z < oldest));
        }
        let place = self.earlier.partition_point(|z| *z <= score);
        self.earlier.insert(place, score);
        self.came.push_back(score);
        alarm
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detector::testing::detect;
    use proptest::prelude::*;

    fn threshold(rate: f64, gamma: f64, warm_up: usize) -> AdaptiveThreshold {
        Params { rate, gamma, warm_up, ..Params::default() }.threshold()
    }

    fn alarms(mut threshold: AdaptiveThreshold, scores: &[f64]) -> Vec<bool> {
        scores.iter().map(|z| threshold.is_alarm(*z)).collect()
    }

    // By hand: of 5, 5, 1, 1, 1 a share of 3/4 does not exceed 5, of the last three of them it does not exceed 1.
    #[test]
    fn the_oldest_scores_are_forgotten() {
        let scores = [5.0, 5.0, 1.0, 1.0, 1.0, 2.0];
        let last_is_alarm =
            |most| alarms(AdaptiveThreshold { most, ..threshold(0.25, 0.0001, 3) }, &scores)[5];
        assert_eq!([3, 5].map(last_is_alarm), [true, false]);
    }

    // By hand, rate 1/4 and gamma 1/2 after four scores 1, 2, 3, 4. a = 1/4: Q(3/4) = 3, exceeded by 3.5.
    // a = -1/8: no alarm, whatever the score. a = 0: Q(1) = 9, not exceeded by 9. a = 1/8: Q(7/8) of
    // 1 2 3 3.5 4 9 9 is 9, and 10 exceeds it. a = -1/4, -1/8 and 0: no alarm at the scores 0, and so on.
    #[test]
    fn the_threshold_by_hand() {
        let scores = [1.0, 2.0, 3.0, 4.0, 3.5, 9.0, 9.0, 10.0, 11.0, 0.0, 0.0, 11.5];
        let mut adaptive = threshold(0.25, 0.5, 4);
        let steps = scores.map(|z| (adaptive.level, adaptive.is_alarm(z)));
        assert_eq!((0..12).filter(|t| steps[*t].1).collect::<Vec<_>>(), [4, 7, 11]);
        let levels = steps.map(|step| step.0);
        assert_eq!(levels[4..], [0.25, -0.125, 0.0, 0.125, -0.25, -0.125, 0.0, 0.125]);
    }

    #[test]
    fn a_state_that_no_track_leads_to_is_refused() {
        let detector = Params::default();
        let takes = |change: fn(&mut AdaptiveThreshold)| {
            let mut threshold = detector.threshold();
            for score in [3.0, 1.0, 2.0] {
                threshold.is_alarm(score);
            }
            change(&mut threshold);
            let memory = ((Forecaster::default(), threshold), crate::detector::labels::LossState::default());
            detector.stream().unwrap().restore(&crate::saved::to_bytes(&memory).unwrap())
        };
        assert!(takes(|_| {}) && takes(|t| t.level = -0.25));
        let bad: [fn(&mut AdaptiveThreshold); 5] = [
            |t| t.earlier.clear(),
            |t| t.earlier.swap(0, 1),
            |t| (t.most, t.warm_up) = (1, 0),
            |t| t.level = f64::NAN,
            |t| (t.came, t.earlier) = (vec![0.0; MOST + 1].into(), vec![0.0; MOST + 1]),
        ];
        assert_eq!(bad.map(takes), [false; 5]);
    }

    /// Checks the bounds for all numbers of frames after the warm-up.
    fn check_share(rate: f64, gamma: f64, warm_up: usize, scores: &[f64]) {
        let alarm = alarms(threshold(rate, gamma, warm_up), scores);
        let mut count = 0.0;
        for (t, alarm) in alarm.iter().enumerate() {
            assert!(!alarm || t >= warm_up);
            count += f64::from(u8::from(*alarm));
            let frames = (t + 1).saturating_sub(warm_up) as f64;
            // Rounding of a[t], of less than 1e-16 a frame.
            let slack = 1e-15 * frames / gamma + 1e-9;
            let bounds = [(rate + gamma) / gamma, (1.0 - rate + gamma) / gamma].map(|bound| bound + slack);
            let over = count - rate * frames;
            assert!(over <= bounds[0] && -over <= bounds[1], "{rate} {gamma} {t}: {count}");
        }
    }

    // Each score larger than all before, the worst for too many alarms; each smaller and all the same, the worst for
    // too few; then waves, bursts and jumps.
    #[test]
    fn the_rate_is_kept_on_series_made_to_break_it() {
        let n = 6000;
        let series: [fn(usize) -> f64; 6] = [
            |t| t as f64,
            |t| 1.0 / (1.0 + t as f64),
            |_| 0.25,
            |t| (t as f64 * 0.01).sin().abs() * t as f64,
            |t| if t / 100 % 2 == 0 { 0.0 } else { t as f64 },
            |t| if t < 3000 { 1e6 - t as f64 } else { 1e9 + t as f64 },
        ];
        for series in series {
            let scores: Vec<f64> = (0..n).map(series).collect();
            for (rate, gamma, warm_up) in [(0.05, 0.02, 50), (0.01, 0.005, 1), (0.3, 0.05, 50), (0.5, 1.0, 7)]
            {
                check_share(rate, gamma, warm_up, &scores);
            }
        }
    }

    // Frames 20 to 69 are the warm-up of 50 scores. An almost regular signal jumps in frame 100.
    #[test]
    fn scores_and_forecasts_are_those_of_the_arma_forecast_and_a_jump_is_an_alarm() {
        let signal: Vec<f64> =
            (0..150).map(|t| f64::from(t * 37 % 64) / 640.0 + if t < 100 { 0.0 } else { 5.0 }).collect();
        let conformal = detect(&ENTRY, "{}", &signal);
        let fixed = detect(&arma_forecast::ENTRY, "{}", &signal);
        assert!(conformal.alarm[..70].iter().all(|a| !a) && conformal.alarm[100]);
        let shown = |output: DetectorOutput| -> (Vec<f64>, Vec<u64>) {
            (output.score, output.forecast.unwrap().into_iter().map(f64::to_bits).collect())
        };
        assert_eq!(shown(conformal), shown(fixed));
    }

    // By hand: with a = 1 the threshold Q(0) is below every score.
    #[test]
    fn at_level_1_every_score_is_an_alarm() {
        let adaptive = AdaptiveThreshold { level: 1.0, ..threshold(0.25, 0.5, 1) };
        assert_eq!(alarms(adaptive, &[5.0, 1.0]), [false, true]);
    }

    proptest! {
        #[test]
        fn the_rate_is_kept_on_any_series(
            scores in prop::collection::vec(prop_oneof![0.0_f64..1.0, Just(0.5), 0.0_f64..1e9], 0..400),
            rate in 0.001_f64..0.5,
            gamma in 0.001_f64..1.0,
            warm_up in 1..30_usize,
        ) {
            check_share(rate, gamma, warm_up, &scores);
        }
    }
}
