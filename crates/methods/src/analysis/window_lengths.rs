//! Effects of the window length L on AVU: how long changes last, how often s_t passes the cut value, with
//! which delay, and whether c_t has the same distribution on the tested tracks as on the tracks that the
//! model is learned from (SanMiguel and Cavallaro, CVIU 131, 2015, Eq. 8, 11 and 20, the text to Fig. 13).
//!
//! ```text
//! s[t] = c[t - L + 1] + ... + c[t]           alarm at t: s[t] > beta            Eq. 8, 11
//! d[t] = b[t] - b[t - 1],   b[t] = 1 where e[t] = 1, else 0                     Eq. 20
//! rate = #{t in G : s[t] > beta} / #G,   G: windows of L frames with e < tau
//! spread = sqrt(Var s / (L Var c)),  1 if the values of a window were independent
//! D = sup_x |F(x) - H(x)|,  F, H: empirical distributions of c of two kinds of frames
//! ```
//!
//! `c` is c_t, without unit; `e` the tracking error; `t` a 0-based frame; `beta` the cut value that AVU
//! learns from the first suite for a rate `alpha` of false alarms ([`consistency`], convolution). AVU learns
//! from the first suite and is tested on the second; of the second only the runs are taken that methods are
//! tested on. Durations are numbers of frames. Alarms and changes are counted as in `sanmiguel2015/1`.
//!
//! | table | rows | columns |
//! |---|---|---|
//! | `durations` | a loss, a recovery | their number; how many last to the end of the track; quartiles of how long they last |
//! | `changes` | L | shares of changes that last less than L frames, those cut by the end of the track not among them |
//! | `rates` | L | beta; the quantile of s_t that it should be; spread; shares of windows and of lost frames beyond these |
//! | `delays` | L | of losses and recoveries, those that s_t passes beta for within the tolerance, later, already before, and never |
//! | `quantiles` | rates | quantiles of c_t: consistent frames of both suites, nearly lost and lost frames of the second |
//! | `distances` | kinds of frames | D to the consistent frames of the first suite, with the test at 5 % |
//!
//! The test assumes independent values of c_t. Neighboring frames are not independent, so its p is too small.

use super::consistent::{
    self, ALPHA, LENGTHS, MAX_COMPONENTS, TAU, TEST, ascending, check_ascending, two_sample_test,
};
use super::prelude::*;
use crate::detector::consistency::{self, Fitting, consistent_sums, undefined_frames};
use crate::detector::{Example, changes};
use crate::score::sanmiguel2015::{TOLERANCE, events};
use rayon::prelude::*;
use trackfail_core::num::accumulation::{self, Accumulated, AccumulationError};
use trackfail_core::num::gamma_mixture::Mixture;

pub(crate) const ENTRY: Entry<dyn Analysis> = Entry::of::<Params>(
    "window-lengths",
    2,
    "how long changes last, how often and how late sums of c_t pass their cut value, and drift of c_t, by length",
);

#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Error below which a frame is consistent, above 0 and at most 1.
    pub tau: f64,
    /// Rate of false alarms of the cut values, above 0 and below 0.5.
    pub alpha: f64,
    /// Window lengths L.
    pub lengths: Vec<usize>,
    /// Largest number of components of the mixture that is tried, 2 to 20.
    pub max_components: usize,
}

impl Default for Params {
    fn default() -> Self {
        Self { tau: 0.9, alpha: 0.005, lengths: vec![1, 5, 10, 20, 30, 40, 50, 60], max_components: 10 }
    }
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[TAU, ALPHA, LENGTHS, MAX_COMPONENTS];

    fn check(&self) -> Result<(), ParamError> {
        check_ascending("lengths", &self.lengths)
    }
}

/// Quantiles of c_t in the table `quantiles`.
const SHOWN: [f64; 7] = [0.5, 0.75, 0.9, 0.95, 0.99, 0.995, 0.999];

/// Names of the two kinds of changes, and their signs.
const KINDS: [(&str, i32); 2] = [("loss", 1), ("recovery", -1)];

/// A change of a track (a loss or a recovery), and the time until the next one.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Change {
    sign: i32,
    from: usize,
    /// Frame of the next change, or the number of frames if there is none.
    to: usize,
    /// True if there is no later change.
    to_the_end: bool,
}

impl Change {
    fn is_shorter(&self, length: usize) -> bool {
        !self.to_the_end && self.to - self.from < length
    }
}

/// The changes of a track in order of time.
fn changes_of(error: &[f64]) -> Vec<Change> {
    let truth = events(error);
    let places: Vec<usize> = (0..truth.len()).filter(|t| truth[*t] != 0).collect();
    let ends = places.iter().skip(1).copied().map(Some).chain([None]);
    let change = |(&from, end): (&usize, Option<usize>)| Change {
        sign: truth[from],
        from,
        to: end.unwrap_or(truth.len()),
        to_the_end: end.is_none(),
    };
    places.iter().zip(ends).map(change).collect()
}

/// Ways in which s_t follows a change, in the order of [`MEETINGS`].
#[derive(Debug, Clone, Copy, PartialEq)]
enum Meeting {
    /// s_t crosses the cut value within the tolerance.
    InTime,
    /// s_t crosses the cut value later, before the next change.
    Late,
    /// s_t is already on the right side of the cut value before the tolerance begins, and stays there.
    Before,
    Never,
}

const MEETINGS: [&str; 4] = ["in time", "late", "before", "never"];

fn meeting(change: &Change, alarm: &[bool], crossings: &[i32]) -> Meeting {
    let crosses =
        |from: usize, to: usize| (from..to.min(crossings.len())).any(|t| crossings[t] == change.sign);
    let last = change.from + TOLERANCE;
    if crosses(change.from.saturating_sub(TOLERANCE), last + 1) {
        Meeting::InTime
    } else if alarm[change.from] == (change.sign > 0) {
        Meeting::Before
    } else if crosses(last + 1, change.to) {
        Meeting::Late
    } else {
        Meeting::Never
    }
}

/// Columns of the table `rates`.
const RATES: [&str; 8] =
    ["cut value β", "quantile", "spread", "learned", "tested", "lost", "lost, quantile", "silent"];

/// Values for one window length.
struct OfLength {
    length: usize,
    /// Values of [`RATES`], in this order: the cut value; the quantile of s_t on consistent windows that the
    /// cut value approximates; the spread; the share of sums above the cut value on consistent windows of the
    /// first suite, on consistent windows of the second, and on lost frames of the second; the share of those
    /// lost frames above the quantile (what this L would give at the exact rate); and the share of those lost
    /// frames for which s_t has not been above the cut value since the loss.
    rates: [Option<f64>; 8],
    /// Number of upward crossings of the cut value in the second suite, then the number of changes by kind
    /// and [`MEETINGS`].
    delays: Vec<usize>,
}

/// `part / all`; `None` if `all` is 0.
fn share(part: usize, all: usize) -> Option<f64> {
    (all > 0).then(|| part as f64 / all as f64)
}

fn variance(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n
}

impl Params {
    fn of_length(
        &self,
        length: usize,
        mixture: &Mixture,
        of_one: f64,
        [trained, tested]: [&[Example<'_>]; 2],
    ) -> Result<OfLength, AccumulationError> {
        let Params { tau, alpha, .. } = *self;
        let cut = Accumulated::of_mixture(mixture, length)?.upper_quantile(alpha)?;
        let windows = |tracks: &[Example<'_>]| -> Vec<f64> {
            tracks.iter().flat_map(|t| consistent_sums(t, tau, length)).collect()
        };
        let beyond = |sums: &[f64]| share(sums.iter().filter(|s| **s > cut).count(), sums.len());
        let (learned, checked) = (windows(trained), windows(tested));
        let spread = (variance(&learned) / (length as f64 * of_one)).sqrt();
        let (of_learned, of_checked) = (beyond(&learned), beyond(&checked));
        let empirical = accumulation::empirical_quantile(&ascending(learned.into_iter()), 1.0 - alpha);
        let (mut lost, mut lost_beyond, mut powerful, mut silent) = (0, 0, 0, 0);
        let mut delays = vec![0; 1 + KINDS.len() * MEETINGS.len()];
        for track in tested {
            let sums = accumulation::sums(track.signal, length);
            let alarm: Vec<bool> = sums.iter().map(|s| *s > cut).collect();
            let crossings = changes(&alarm);
            delays[0] += crossings.iter().filter(|c| **c > 0).count();
            for change in changes_of(track.error) {
                let kind = usize::from(change.sign < 0);
                delays[1 + kind * MEETINGS.len() + meeting(&change, &alarm, &crossings) as usize] += 1;
                if change.sign > 0 {
                    let state = change.from..change.to;
                    lost += state.len();
                    lost_beyond += state.clone().filter(|t| alarm[*t]).count();
                    powerful += state.filter(|t| empirical.is_some_and(|q| sums[*t] > q)).count();
                    let earliest = change.from.saturating_sub(TOLERANCE);
                    let first = (earliest..change.to).find(|t| alarm[*t]).unwrap_or(change.to);
                    silent += first.saturating_sub(change.from);
                }
            }
        }
        let rates = [
            Some(cut),
            empirical,
            Some(spread).filter(|s| s.is_finite()),
            of_learned,
            of_checked,
            share(lost_beyond, lost),
            share(powerful, lost).filter(|_| empirical.is_some()),
            share(silent, lost),
        ];
        Ok(OfLength { length, rates, delays })
    }
}

/// Rows of the table `durations`.
fn durations(all: &[Change]) -> Vec<Row> {
    let row = |(name, sign): (&str, i32)| {
        let of_kind = || all.iter().filter(move |c| c.sign == sign);
        let lasting = ascending(of_kind().map(|c| (c.to - c.from) as f64));
        let to_the_end = of_kind().filter(|c| c.to_the_end).count();
        let counts = [lasting.len(), to_the_end].map(|n| Some(n as f64));
        let quartiles = [0.25, 0.5, 0.75].map(|p| accumulation::empirical_quantile(&lasting, p));
        (name.to_string(), counts.into_iter().chain(quartiles).collect())
    };
    KINDS.map(row).to_vec()
}

/// Share of the changes of this sign (`None`: of both) that last less than `length` frames.
fn share_shorter(all: &[Change], length: usize, sign: Option<i32>) -> Option<f64> {
    let mine = || all.iter().filter(|c| sign.is_none_or(|sign| c.sign == sign));
    share(mine().filter(|c| c.is_shorter(length)).count(), mine().count())
}

impl Analysis for Params {
    fn suites(&self) -> (usize, usize) {
        (2, 2)
    }

    fn is_tested(&self, suite: usize) -> bool {
        suite == 1
    }

    fn layout(&self, _: usize) -> Layout {
        let lasting = ["number", "to the end", "quartile", "median", "upper quartile"];
        let met = KINDS.iter().flat_map(|(kind, _)| MEETINGS.map(|how| format!("{kind} {how}")));
        Layout::of(["largest-rate", "least-rate", "shorter", "distance", "distance-lost"])
            .table("durations", "change", lasting)
            .table("changes", "length L", ["all changes", "losses", "recoveries"])
            .table("rates", "length L", RATES)
            .table("delays", "length L", ["alarms".to_string()].into_iter().chain(met))
            .table("quantiles", "quantile", KINDS_OF_FRAMES)
            .table("distances", "frames", TEST.into_iter().chain(["values learned from", "values"]))
            .chart("rates", "window length L", "share beyond the cut value")
    }

    fn values(&self, populations: &[Population<'_>]) -> Result<Values, AnalysisError> {
        let [trained, tested] = [&populations[0], &populations[1]];
        let model = consistency::fit(&trained.tracks, &Fitting::by_bic(self.tau, self.max_components))?.model;
        let tracks = [&trained.tracks[..], &tested.tracks[..]];
        let of_length = |length: &usize| self.of_length(*length, &model.mixture, model.variance, tracks);
        let rows = self.lengths.par_iter().map(of_length).collect::<Result<Vec<_>, AccumulationError>>()?;
        let all: Vec<Change> = tested.tracks.iter().flat_map(|t| changes_of(t.error)).collect();
        let shares = |length: &usize| {
            let of = |sign| share_shorter(&all, *length, sign);
            (length.to_string(), vec![of(None), of(Some(KINDS[0].1)), of(Some(KINDS[1].1))])
        };
        let delays =
            |row: &OfLength| (row.length.to_string(), row.delays.iter().map(|n| Some(*n as f64)).collect());
        let kinds = kinds_of_frames(trained, tested, self.tau);
        let quantiles = |rate: f64| {
            let values = kinds.iter().map(|values| accumulation::empirical_quantile(values, rate));
            (rate.to_string(), values.collect())
        };
        let tests = [1, 2, 3].map(|kind| two_sample_test(&kinds[0], &kinds[kind]));
        let distances = |kind: usize| (KINDS_OF_FRAMES[kind].to_string(), tests[kind - 1].to_vec());

        let of_learned = || rows.iter().filter_map(|r| r.rates[3]);
        let longest = self.lengths.last().copied().unwrap_or(1);
        let numbers = [
            of_learned().reduce(f64::max),
            of_learned().reduce(f64::min),
            share_shorter(&all, longest, None),
            tests[0][0],
            tests[2][0],
        ];
        let curve = |name: &str, of: &dyn Fn(&OfLength) -> Option<f64>| -> Curve {
            let points = rows.iter().filter_map(|r| Some((r.length as f64, of(r)?)));
            (name.to_string(), points.collect())
        };
        let curves = [
            curve(KINDS_OF_FRAMES[0], &|r| r.rates[3]),
            curve(KINDS_OF_FRAMES[1], &|r| r.rates[4]),
            curve("lost", &|r| r.rates[5]),
            curve("α", &|_| Some(self.alpha)),
        ];
        Ok(Values {
            numbers: numbers.to_vec(),
            tables: vec![
                durations(&all),
                self.lengths.iter().map(shares).collect(),
                rows.iter().map(|row| (row.length.to_string(), row.rates.to_vec())).collect(),
                rows.iter().map(delays).collect(),
                SHOWN.map(quantiles).to_vec(),
                (1..4).map(distances).collect(),
            ],
            charts: vec![curves.into_iter().filter(|(_, points)| !points.is_empty()).collect()],
        })
    }
}

/// Kinds of frames: the consistent frames of the first and of the second suite, then the nearly lost and the
/// lost frames of the second.
const KINDS_OF_FRAMES: [&str; 4] =
    ["consistent, learned from", "consistent, tested", "nearly lost, tested", "lost, tested"];

/// Values of c_t for each of [`KINDS_OF_FRAMES`], ascending.
fn kinds_of_frames(trained: &Population<'_>, tested: &Population<'_>, tau: f64) -> [Vec<f64>; 4] {
    let between = |from: f64, to: f64| {
        let of_track = |track: &Example<'_>| {
            let frames = track.signal.iter().zip(track.error).skip(undefined_frames(track.signal));
            let mine = frames.filter(|(_, e)| (from..to).contains(*e));
            mine.map(|(c, _)| *c).collect::<Vec<_>>()
        };
        ascending(tested.tracks.iter().flat_map(of_track))
    };
    let [learned, consistent] = [trained, tested].map(|suite| consistent::changes(suite, tau));
    [learned, consistent, between(tau, 1.0), between(1.0, f64::INFINITY)]
}

#[cfg(test)]
mod tests;
