//! `deep-verification`: a small deep network's judgment of the tracker's box, from three sides. One or two
//! watchdogs (`watchdog-agreement`) follow the target from the first frame on, and the network of one of them
//! looks a second time, at the tracker's own box.
//!
//! ```text
//! v2, v3   values of a watchdog of this version, as in `watchdog-agreement`: I overlap, s score, r = (1 - I) s
//! both     of both watchdogs, with J = IoU(v2, v3) and m = min(s2, s3)
//!   product   r2 r3           least   min(r2, r3)        most   max(r2, r3)             bad
//!   overlap   J                                                                         good
//!   against   J m (1 - max(I2, I3))    the watchdogs agree, and not with the tracker    bad
//!   apart     (1 - J) m                the watchdogs do not agree                       bad
//! here     of the second look: cell j has score S[j] and box R[j], o[j] = IoU(R[j], tracker), j* is the chosen cell
//!   score     S[j*]           overlap  o[j*]                                            good
//!   disagreement   (1 - o[j*]) S[j*]   apart   S[j*] if o[j*] = 0, else 0               bad
//!   distance  of the centers of R[j*] and the tracker's box, as in `watchdog-agreement` bad
//!   middle    largest S of the 3 x 3 cells about the middle of the tracker's box        good
//!   inside    max(-6, lg max S[j] over o[j] > .1)                                       good
//!   outside   max(-6, lg max S[j] over the others)                                      bad
//!   elsewhere lg max S[j] over the others - lg max S[j] over o[j] > .1, within -8 and 8 bad
//! lg S     log(S / (1 - S)) of S within 1e-6 and 1 - 1e-6; no cell at all counts as S = 0
//! ```
//!
//! The values of a frame are those of the four lists, in this order and in the order within each list. The
//! direction of the signal is that of the first value. The default of `here` is `["elsewhere"]`. `t` is a
//! 0-based frame. Scores, overlaps and products are in `[0, 1]`, logarithms are natural.
//!
//! The second look uses the network `look` (default v2) with the template of the first frame, around the
//! tracker's box (of at least 4 pixels a side). It is taken only in the first frame and if the watchdog of
//! this network overlaps the tracker by less than .6. Otherwise the watchdog's own look covers the box, and
//! its cells at the tracker's place are read. Networks that no value needs do not run. A box with NaN
//! coordinates has no cells: scores and overlap are then 0, and the distance is 3.
//!
//! Source: none; a tracker that verifies another at intervals is Parallel Tracking and Verifying (Fan and Ling, ICCV
//! 2017). Choices: the values, by folds of sources (docs/fused.md).

use super::watchdog_agreement::{FAR, Seen, Value as WatchdogValue, Watchdog, once};
use crate::region::Areas;
use crate::signal::prelude::*;
use crate::tracker::nanotrack::Version;
use crate::tracker::nanotrack::look::{Look, Place};
use std::sync::Arc;

pub(crate) const ENTRY: Entry<dyn Signal> = Entry::of::<Params>(
    "deep-verification",
    1,
    "what a deep network says of the tracker's box: its watchdogs, and a second look at the box itself",
)
.more(&[
    "{ v2 = [\"overlap\", \"score\"], here = [\"apart\", \"inside\", \"middle\"] }",
    "{ v2 = [\"disagreement\"], v3 = [\"disagreement\"], both = [\"product\", \"against\"], here = [] }",
    "{ v3 = [\"overlap\"], here = [\"score\", \"elsewhere\"], look = \"v3\" }",
]);

/// Overlap with the watchdog from which on its look also serves as the second look.
const SEEN: f64 = 0.6;
/// Overlap with the tracker's box above which a cell counts as inside.
const INSIDE: f64 = 0.1;
/// Least side of a box for the second look, in pixels.
const LEAST_SIDE: f64 = 4.0;
/// Bound of scores (and of 1 minus scores) before taking logarithms.
const LEAST_SCORE: f64 = 1e-6;
/// Least logarithm; `LARGEST_RATIO` bounds the difference of two.
const LEAST_LOG: f64 = -6.0;
const LARGEST_RATIO: f64 = 8.0;

/// A value from both watchdogs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Both {
    /// Product of both disagreements.
    Product,
    /// Smaller one of both disagreements.
    Least,
    /// Larger one of both disagreements.
    Most,
    /// Overlap of the two watchdogs.
    Overlap,
    /// Certainty of a common place away from the tracker.
    Against,
    /// Certainty of different places.
    Apart,
}

/// A value of the second look.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Here {
    /// Score of the chosen cell.
    Score,
    /// Overlap of the chosen cell's box with the tracker's.
    Overlap,
    /// Product `(1 - overlap) score`.
    Disagreement,
    /// Score if the two boxes do not overlap, else 0.
    Apart,
    /// Distance of their centers in units of the tracker's box, at most 3.
    Distance,
    /// Best score near the middle of the tracker's box.
    Middle,
    /// Logarithm of the best odds among boxes that overlap the tracker's.
    Inside,
    /// Logarithm of the best odds among all other boxes.
    Outside,
    /// Difference `outside - inside`, without their lower bounds.
    Elsewhere,
}

#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Values of the watchdog v2, without repetitions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub v2: Vec<WatchdogValue>,
    /// Values of a watchdog v3, without repetitions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub v3: Vec<WatchdogValue>,
    /// Values of both watchdogs.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub both: Vec<Both>,
    /// Values of the second look.
    #[serde(default = "elsewhere")]
    pub here: Vec<Here>,
    /// Network of the second look.
    #[serde(default, skip_serializing_if = "is_default")]
    pub look: Version,
}

fn elsewhere() -> Vec<Here> {
    vec![Here::Elsewhere]
}

impl Params {
    /// True if a value needs the network.
    fn uses(&self, version: Version) -> bool {
        let mine = match version {
            Version::V2 => &self.v2,
            Version::V3 => &self.v3,
        };
        let looks = self.look == version && !self.here.is_empty();
        !mine.is_empty() || !self.both.is_empty() || looks
    }

    /// Direction and bounds of each value.
    fn kinds(&self) -> Vec<(Direction, (f64, f64))> {
        use Direction::{HigherIsBetter, LowerIsBetter};
        let (unit, log) = ((0.0, 1.0), log_odds(1.0));
        let of_both = |value: &Both| match value {
            Both::Overlap => (HigherIsBetter, unit),
            Both::Product | Both::Least | Both::Most | Both::Against | Both::Apart => (LowerIsBetter, unit),
        };
        let of_here = |value: &Here| match value {
            Here::Score | Here::Overlap | Here::Middle => (HigherIsBetter, unit),
            Here::Disagreement | Here::Apart => (LowerIsBetter, unit),
            Here::Distance => (LowerIsBetter, (0.0, FAR)),
            Here::Inside => (HigherIsBetter, (LEAST_LOG, log)),
            Here::Outside => (LowerIsBetter, (LEAST_LOG, log)),
            Here::Elsewhere => (LowerIsBetter, (-LARGEST_RATIO, LARGEST_RATIO)),
        };
        let watchdogs = self.v2.iter().chain(&self.v3).map(|value| (value.direction(), value.bounds()));
        watchdogs.chain(self.both.iter().map(of_both)).chain(self.here.iter().map(of_here)).collect()
    }
}

impl PlainParams for Params {
    fn check(&self) -> Result<(), ParamError> {
        let Self { v2, v3, both, here, .. } = self;
        once("v2", v2)?;
        once("v3", v3)?;
        once("both", both)?;
        once("here", here)?;
        let has_values = !self.kinds().is_empty();
        ParamError::unless(has_values, "here", "not empty without `v2`, `v3` and `both`", "[]")
    }
}

impl Signal for Params {
    fn facts(&self) -> Facts {
        let kinds = self.kinds();
        let (direction, bounds) = kinds[0];
        Facts { symbol: "vₜ", width: kinds.len(), ..Facts::of(direction, bounds) }
    }

    fn start(&self, _: &RunContext<'_>) -> Result<Box<dyn Session>, TrackerError> {
        let watchdog = |version| self.uses(version).then(|| Watchdog::new(version));
        let (v2, v3) = (watchdog(Version::V2), watchdog(Version::V3));
        Ok(Box::new(Verifying { params: self.clone(), v2, v3 }))
    }
}

/// Watchdogs of a track.
struct Verifying {
    params: Params,
    v2: Option<Watchdog>,
    v3: Option<Watchdog>,
}

impl Verifying {
    /// All values in the next frame; `None` if a watchdog cannot start.
    fn next(&mut self, observation: &Observation<'_>) -> Option<Vec<f64>> {
        let step = |watchdog: &mut Option<Watchdog>| match watchdog {
            Some(watchdog) => watchdog.look(observation).map(Some),
            None => Some(None),
        };
        let (v2, v3) = (step(&mut self.v2)?, step(&mut self.v3)?);
        let of = |seen: &Option<(Seen, _)>, values: &[WatchdogValue]| -> Vec<f64> {
            seen.iter().flat_map(|(seen, _)| values.iter().map(|value| seen.value(*value))).collect()
        };
        let mut values = [of(&v2, &self.params.v2), of(&v3, &self.params.v3)].concat();
        if let (Some((v2, _)), Some((v3, _))) = (&v2, &v3) {
            values.extend(self.params.both.iter().map(|value| both(v2, v3, *value)));
        }
        let looked = if self.params.look == Version::V2 { v2 } else { v3 };
        if let Some((seen, look)) = looked.filter(|_| !self.params.here.is_empty()) {
            let look = look.filter(|_| seen.overlap >= SEEN);
            let second = self.second(look, observation.frame, &observation.state.region);
            values.extend(self.params.here.iter().map(|value| second.value(*value)));
        }
        Some(values)
    }

    /// Second look at the tracker's box, read from `look` or computed.
    fn second(&self, look: Option<Arc<Look>>, frame: &Frame, region: &Region) -> Second {
        if !region.is_finite() {
            return Second::NOTHING;
        }
        let bounds = region.bounds();
        let (w, h) = (bounds.w.max(LEAST_SIDE), bounds.h.max(LEAST_SIDE));
        let (x, y) = bounds.center();
        let rect = Rect::new(x - w / 2.0, y - h / 2.0, w, h);
        let watchdog = if self.params.look == Version::V2 { &self.v2 } else { &self.v3 };
        let look = look.or_else(|| watchdog.as_ref()?.look_at(frame, &rect));
        look.map_or(Second::NOTHING, |look| Second::of(&look, &rect))
    }
}

impl Session for Verifying {
    fn push(&mut self, observation: &Observation<'_>) -> Result<Vec<f64>, TrackerError> {
        Ok(self.next(observation).unwrap_or_else(|| vec![f64::NAN]))
    }

    fn save(&self) -> Option<Vec<u8>> {
        let memory = |watchdog: &Option<Watchdog>| watchdog.as_ref().and_then(Watchdog::memory);
        saved::to_bytes(&(memory(&self.v2), memory(&self.v3)))
    }

    fn restore(&mut self, saved: &[u8]) -> bool {
        let restored = |watchdog: &mut Option<Watchdog>, memory| {
            watchdog.as_mut().is_none_or(|watchdog| watchdog.restore(memory))
        };
        saved::from_bytes(saved)
            .is_some_and(|(v2, v3)| restored(&mut self.v2, v2) && restored(&mut self.v3, v3))
    }
}

/// A value from both watchdogs.
fn both(v2: &Seen, v3: &Seen, value: Both) -> f64 {
    let [a, b] = [v2, v3].map(|seen| seen.value(WatchdogValue::Disagreement));
    let together = Areas::Exact.overlap(&Region::Rect(v2.rect), &Region::Rect(v3.rect), None);
    let sure = v2.score.min(v3.score);
    match value {
        Both::Product => a * b,
        Both::Least => a.min(b),
        Both::Most => a.max(b),
        Both::Overlap => together,
        Both::Against => together * sure * (1.0 - v2.overlap.max(v3.overlap)),
        Both::Apart => (1.0 - together) * sure,
    }
}

/// Second look, compared with the tracker.
struct Second {
    /// Chosen cell, compared with the tracker.
    chosen: Seen,
    middle: f64,
    /// Best score among cells inside the tracker's box; `outside` is that of the others.
    inside: f64,
    outside: f64,
}

impl Second {
    /// A second look without cells.
    const NOTHING: Self = Self {
        chosen: Seen {
            score: 0.0,
            overlap: 0.0,
            distance: FAR,
            rect: Rect { x: 0.0, y: 0.0, w: 0.0, h: 0.0 },
        },
        middle: 0.0,
        inside: 0.0,
        outside: 0.0,
    };

    fn of(look: &Look, tracker: &Rect) -> Self {
        let region = Region::Rect(*tracker);
        let at = Place::of(tracker).center;
        let near = |i: usize, k: usize| {
            (i as f64 - (look.side / 2) as f64 - ((at[k] - look.place.center[k]) / look.cell).round()).abs()
                <= 1.0
        };
        let (mut middle, mut inside, mut outside) = (0.0_f64, 0.0_f64, 0.0_f64);
        for (i, cell) in look.cells.iter().enumerate() {
            if near(i % look.side, 0) && near(i / look.side, 1) {
                middle = middle.max(cell.score);
            }
            let overlap = Areas::Exact.overlap(&Region::Rect(look.rect(cell)), &region, None);
            let best = if overlap > INSIDE { &mut inside } else { &mut outside };
            *best = best.max(cell.score);
        }
        let chosen = look.chosen();
        let chosen = Seen::of(chosen.score, look.rect(chosen), &region);
        Self { chosen, middle, inside, outside }
    }

    fn value(&self, value: Here) -> f64 {
        let (inside, outside) = (log_odds(self.inside), log_odds(self.outside));
        match value {
            Here::Score => self.chosen.score,
            Here::Overlap => self.chosen.overlap,
            Here::Disagreement => self.chosen.value(WatchdogValue::Disagreement),
            Here::Apart => self.chosen.value(WatchdogValue::Apart),
            Here::Distance => self.chosen.distance,
            Here::Middle => self.middle,
            Here::Inside => inside.max(LEAST_LOG),
            Here::Outside => outside.max(LEAST_LOG),
            Here::Elsewhere => (outside - inside).clamp(-LARGEST_RATIO, LARGEST_RATIO),
        }
    }
}

/// Logarithm of the odds of a score.
fn log_odds(score: f64) -> f64 {
    let score = score.clamp(LEAST_SCORE, 1.0 - LEAST_SCORE);
    libm::log(score / (1.0 - score))
}

#[cfg(test)]
mod tests;
