//! `confidence`: the tracker's own confidence, as it gives it or relative to how it began.
//!
//! ```text
//! raw    y[t] = c[t]
//! ratio  y[t] = c[t] / mean of c[1], ..., c[min(t, early)]        y[0] = 1
//! ```
//!
//! `c` is the tracker's confidence in its own unit; a ratio has no unit. For trackers with a posterior and
//! without confidence, it is the likelihood of the estimate (choice): the peak of the response map for kcf,
//! dsst and samf, the likelihood of the estimate for particle filters. `t` is a 0-based frame. High values
//! are good. A value depends on frames up to its own: the mean of a ratio changes until frame `early`, then
//! it is fixed.
//!
//! Frames without a value (a tracker need not give one in every frame) repeat the last value of the signal, and the mean
//! leaves them out. In the first frame the target is given, and what tools write there is a placeholder: nothing
//! (pysot), 1 (pytracking), 10000 (SiamFC). A ratio leaves it out. Otherwise the signal has the placeholder itself, or 1
//! where there is none; `first = 10.0` replaces it.
//!
//! Choices: `early` 19, frames 2 to 20 as people count them; ratios are cut at 1000 and -1000. A ratio needs a tracker
//! whose early confidence is positive on average; where it is not, the signal fails and says so. Sources: the files that
//! `replay` reads, or what a tracker gives live.

use crate::num::readable;
use crate::signal::prelude::*;

/// The confidence in the list of signals.
pub const ENTRY: Entry<dyn Signal> =
    Entry::of::<Params>("confidence", 2, "the tracker's own confidence, raw or relative to its early mean")
        .example("{ scale = \"raw\", early = 19 }");

/// Largest absolute value of a ratio.
const MAX_RATIO: f64 = 1000.0;

/// Scale of the signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Scale {
    /// Scale of the tracker.
    Raw,
    /// Relative to the mean of the early frames.
    Ratio,
}

/// Parameters of the signal.
#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Scale of the values.
    #[default(Scale::Raw)]
    pub scale: Scale,
    /// Index of the last frame in the mean of a ratio, at least 1.
    #[default(19)]
    pub early: usize,
    /// Value in the first frame, except for ratios; by default that of the tracker, or 1 if it gives none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first: Option<f64>,
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[Range::of("early").at_least(1.0), Range::of("first")];

    fn check(&self) -> Result<(), ParamError> {
        let Some(first) = self.first else { return Ok(()) };
        let rule = "left out of a ratio, which begins with 1";
        ParamError::unless(self.scale != Scale::Ratio, "first", rule, first)
    }
}

/// Course of a track up to a frame.
#[derive(SmartDefault, Serialize, Deserialize)]
pub struct Course {
    /// Index of the next frame.
    frame: usize,
    /// Last value of the signal.
    #[default(1.0)]
    last: f64,
    /// Sum and number of the values in the mean of a ratio.
    sum: f64,
    count: usize,
}

/// True if numbers can be relative to this mean.
fn is_positive(mean: f64) -> bool {
    mean > 0.0 && mean.is_finite()
}

impl Causal for Params {
    type Memory = Course;

    fn facts(&self) -> Facts {
        let bounds = match self.scale {
            Scale::Raw => (f64::NEG_INFINITY, f64::INFINITY),
            Scale::Ratio => (-MAX_RATIO, MAX_RATIO),
        };
        let facts = Facts::of(Direction::HigherIsBetter, bounds);
        Facts { reads: Reads::Confidence, symbol: "cₜ", ..facts }
    }

    fn push(&self, course: &mut Course, observation: &Observation<'_>) -> f64 {
        let t = course.frame;
        course.frame = t.saturating_add(1);
        let given = observation.state.confidence_or_likelihood().filter(|c| c.is_finite());
        let value = match (self.scale, given) {
            (Scale::Ratio, _) if t == 0 => 1.0,
            (Scale::Raw, _) if t == 0 => self.first.or(given).unwrap_or(course.last),
            (_, None) => course.last,
            (Scale::Raw, Some(given)) => given,
            (Scale::Ratio, Some(given)) => {
                if t <= self.early || course.count == 0 {
                    course.sum += given;
                    course.count = course.count.saturating_add(1);
                }
                let mean = course.sum / course.count as f64;
                if !is_positive(mean) {
                    return f64::NAN;
                }
                (given / mean).clamp(-MAX_RATIO, MAX_RATIO)
            }
        };
        course.last = value;
        value
    }

    fn fault(&self, course: &Course) -> Option<String> {
        let (t, mean) = (course.frame.saturating_sub(1), course.sum / course.count as f64);
        let why = "a ratio needs a positive, finite one, `scale = \"raw\"` takes any";
        let is_bad = course.count > 0 && !is_positive(mean);
        is_bad.then(|| {
            let what = format!("the mean of the early confidence is {}", readable(mean));
            format!("confidence: frame of index {t}: {what}; {why}")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::testing;
    use crate::tracker::TrackerState;
    use trackfail_testing::assert_says;

    fn run(params: &str, values: &[Option<f64>]) -> Result<Vec<f64>, String> {
        let mut session = testing::start(&*testing::build("confidence", params));
        let frame = Frame::new(1, 1, vec![0; 3]);
        let push = |confidence: &Option<f64>| {
            let region = Region::Rect(Rect::new(1.0, 1.0, 2.0, 2.0));
            let state = TrackerState { confidence: *confidence, ..TrackerState::tracked(region) };
            let found = session.push(&Observation::new(&frame, &state));
            found.map(|values| values[0]).map_err(|e| e.to_string())
        };
        values.iter().map(push).collect()
    }

    #[test]
    fn values_by_hand() {
        let given = [None, Some(0.8), None, Some(0.4), Some(0.6)];
        let grown = [Some(9.0), Some(4.0), None, Some(2.0), Some(6.0)];
        // With its placeholder in the first frame.
        let siamfc = [Some(10_000.0), Some(8.0), Some(4.0)];
        for (params, given, want) in [
            ("{}", &given[..], &[1.0, 0.8, 0.8, 0.4, 0.6][..]),
            ("{ first = 0.25 }", &given, &[0.25, 0.8, 0.8, 0.4, 0.6]),
            // The means are 4, and from the fourth frame on 3.
            ("{ scale = \"ratio\", early = 3 }", &grown, &[1.0, 1.0, 1.0, 2.0 / 3.0, 2.0]),
            ("{}", &siamfc, &[10_000.0, 8.0, 4.0]),
            ("{ first = 10.0 }", &siamfc, &[10.0, 8.0, 4.0]),
            ("{ scale = \"ratio\" }", &siamfc, &[1.0, 1.0, 4.0 / 6.0]),
            // A first value after the early frames is all there is to compare with.
            ("{ scale = \"ratio\", early = 1 }", &[None, None, Some(2.0), Some(1.0)], &[1.0, 1.0, 1.0, 0.5]),
            (
                "{ scale = \"ratio\", early = 1 }",
                &[None, Some(1.0), Some(1e6), Some(-1e6)],
                &[1.0, 1.0, 1000.0, -1000.0],
            ),
            ("{}", &[Some(-0.5)], &[-0.5]),
        ] {
            assert_eq!(run(params, given), Ok(want.to_vec()), "{params}");
        }
    }

    #[test]
    fn values_that_do_not_fit_are_told() {
        // Of numbers without bounds the mean may have none, and the message no hundreds of digits.
        for (early, shown) in [
            (&[-0.5][..], "index 1: the mean of the early confidence is -0.5"),
            (&[0.0], "mean of the early confidence is 0;"),
            (&[-1e308], "is -1e308;"),
            (&[1e308, 1e308], "is inf;"),
        ] {
            let given: Vec<_> = std::iter::once(None).chain(early.iter().copied().map(Some)).collect();
            assert_says(run("{ scale = \"ratio\" }", &given).unwrap_err(), shown);
        }
    }
}
