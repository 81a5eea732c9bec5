//! Effects of the window length L on AVU: how long changes last, how often s_t passes its cut value, how late, and
//! whether c_t of the tested tracks is distributed as that of the tracks that its model was learned from (SanMiguel and
//! Cavallaro, CVIU 131, 2015, Eq. 8, 11 and 20, the text to Fig. 13).
//!
//! ```text
//! s[t] = c[t - L + 1] + ... + c[t]           alarm at t: s[t] > beta            Eq. 8, 11
//! d[t] = b[t] - b[t - 1],   b[t] = 1 where e[t] = 1, else 0                     Eq. 20
//! rate = #{t in G : s[t] > beta} / #G,   G: windows of L frames with e < tau
//! spread = sqrt(Var s / (L Var c)),  1 if the values of a window were independent
//! D = sup_x |F(x) - H(x)|,  F, H: empirical distributions of c of two kinds of frames
//! ```
//!
//! `c` is c_t, without unit; `e` the tracking error; `t` a 0-based frame; `beta` the cut value that AVU learns from the
//! first suite for a rate `alpha` of false alarms ([`consistency`], convolution). The first suite is the one that is
//! learned from, the second the one that is tested, of which as many runs are taken as methods are tested on. Durations
//! and shares count frames, alarms and changes are counted as `sanmiguel2015/1` does.
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
//! The test takes values of c_t as independent, which those of neighboring frames are not: its p is too small.

use super::uncertainty_model::{check_ascending, two_sample_test};
use super::{Analysis, AnalysisError, Chart, Findings, Grid, Names, Population};
use crate::detector::consistency::{self, Fitting, consistent_changes, consistent_sums, undefined_frames};
use crate::detector::{Example, changes};
use crate::score::sanmiguel2015::{TOLERANCE, events};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use trackfail_core::num::accumulation::{self, Accumulated, AccumulationError};
use trackfail_core::num::gamma_mixture::Mixture;
use trackfail_core::plugin::{Entry, ParamError, Plugin, Range};

pub(crate) const ENTRY: Entry<dyn Analysis> = Entry::of::<WindowLengths>(
    "window-lengths",
    1,
    "how long changes last, how often and how late sums of c_t pass their cut value, and drift of c_t, by length",
);

#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Error below which a frame is consistent, above 0 and at most 1.
    pub tau: f64,
    /// Rate of false alarms of the cut values, above 0 and below 0.5.
    pub alpha: f64,
    /// Lengths of the windows, L.
    pub lengths: Vec<usize>,
    /// Largest order of the mixture that is tried, 2 to 20.
    pub max_components: usize,
}

impl Default for Params {
    fn default() -> Self {
        Self { tau: 0.9, alpha: 0.005, lengths: vec![1, 5, 10, 20, 30, 40, 50, 60], max_components: 10 }
    }
}

#[derive(Debug, Clone)]
pub struct WindowLengths(Params);

impl Plugin for WindowLengths {
    type Params = Params;

    const RANGES: &'static [Range] = &[
        Range::of("tau").above(0.0).at_most(1.0),
        Range::of("alpha").above(0.0).below(0.5),
        Range::within("lengths", 1.0, 10_000.0),
        Range::within("max_components", 2.0, 20.0),
    ];

    fn make(p: Params) -> Result<Self, ParamError> {
        check_ascending("lengths", &p.lengths)?;
        Ok(Self(p))
    }
}

/// The quantiles of c_t that are shown.
const SHOWN: [f64; 7] = [0.5, 0.75, 0.9, 0.95, 0.99, 0.995, 0.999];

/// Words for the two kinds of changes, with their signs.
const KINDS: [(&str, i32); 2] = [("loss", 1), ("recovery", -1)];

/// A change of a track, and how long the state after it lasts.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Change {
    sign: i32,
    from: usize,
    /// Frame of the next change, or one past the last frame.
    to: usize,
    /// Whether there is no other change after it.
    to_the_end: bool,
}

impl Change {
    fn is_shorter(&self, length: usize) -> bool {
        !self.to_the_end && self.to - self.from < length
    }
}

/// The changes of a track, in their order.
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

/// How s_t meets a change.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Meeting {
    /// s_t crosses the cut value within the tolerance.
    InTime,
    /// s_t is on the side of the change all the time from before the tolerance.
    Before,
    /// s_t crosses later, while the state lasts.
    Late,
    Never,
}

const MEETINGS: [(&str, Meeting); 4] = [
    ("in time", Meeting::InTime),
    ("late", Meeting::Late),
    ("before", Meeting::Before),
    ("never", Meeting::Never),
];

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

/// Numbers of one length.
struct Row {
    length: usize,
    cut: f64,
    /// The quantile of s_t on consistent windows that the cut value stands for.
    empirical: Option<f64>,
    spread: Option<f64>,
    /// Shares beyond the cut value: consistent windows of both suites, lost frames of the second.
    rates: [Option<f64>; 3],
    /// Share of lost frames of the second suite beyond the empirical quantile: what L gives at the rate that is meant.
    power: Option<f64>,
    /// Share of lost frames of the second suite before which, since the loss, no s_t was beyond the cut value.
    silent: Option<f64>,
    /// Times that s_t of the second suite passes the cut value from below.
    alarms: usize,
    /// Changes of the second suite by kind and by [`MEETINGS`].
    met: [[usize; 4]; 2],
}

/// A share; nothing of nothing.
fn share(part: usize, all: usize) -> Option<f64> {
    (all > 0).then(|| part as f64 / all as f64)
}

fn mean_and_variance(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n)
}

impl WindowLengths {
    fn row(
        &self,
        length: usize,
        mixture: &Mixture,
        variance: f64,
        [trained, tested]: [&[Example<'_>]; 2],
    ) -> Result<Row, AccumulationError> {
        let Params { tau, alpha, .. } = self.0;
        let sum = Accumulated::of_mixture(mixture, length, &accumulation::Grid::default())?;
        let cut = sum.upper_quantile(alpha)?;
        let windows = |tracks: &[Example<'_>]| -> Vec<f64> {
            tracks.iter().flat_map(|t| consistent_sums(t, tau, length)).collect()
        };
        let beyond = |sums: &[f64]| share(sums.iter().filter(|s| **s > cut).count(), sums.len());
        let (mut learned, checked) = (windows(trained), windows(tested));
        let spread = (mean_and_variance(&learned).1 / (length as f64 * variance)).sqrt();
        let rates = [beyond(&learned), beyond(&checked)];
        learned.sort_by(f64::total_cmp);
        let empirical = accumulation::empirical_quantile(&learned, 1.0 - alpha);
        let (mut lost, mut lost_beyond, mut powerful, mut silent, mut alarms) = (0, 0, 0, 0, 0);
        let mut met = [[0; 4]; 2];
        for track in tested {
            let sums = accumulation::sums(track.signal, length);
            let alarm: Vec<bool> = sums.iter().map(|s| *s > cut).collect();
            let crossings = changes(&alarm);
            alarms += crossings.iter().filter(|c| **c > 0).count();
            for change in changes_of(track.error) {
                let (kind, how) = (usize::from(change.sign < 0), meeting(&change, &alarm, &crossings));
                met[kind][MEETINGS.iter().position(|m| m.1 == how).unwrap_or(0)] += 1;
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
        let [of_learned, of_checked] = rates;
        Ok(Row {
            length,
            cut,
            empirical,
            spread: Some(spread).filter(|s| s.is_finite()),
            rates: [of_learned, of_checked, share(lost_beyond, lost)],
            power: share(powerful, lost).filter(|_| empirical.is_some()),
            silent: share(silent, lost),
            alarms,
            met,
        })
    }
}

fn grid(name: &str, corner: &str, columns: &[&str], rows: Vec<(String, Vec<Option<f64>>)>) -> Grid {
    let columns = columns.iter().map(|c| c.to_string()).collect();
    Grid { name: name.to_string(), corner: corner.to_string(), columns, rows }
}

/// Table of how long changes last.
fn durations(all: &[Change]) -> Grid {
    let row = |(name, sign): (&str, i32)| {
        let of_kind = || all.iter().filter(move |c| c.sign == sign);
        let mut lasting: Vec<f64> = of_kind().map(|c| (c.to - c.from) as f64).collect();
        lasting.sort_by(f64::total_cmp);
        let to_the_end = of_kind().filter(|c| c.to_the_end).count();
        let counts = [lasting.len(), to_the_end].map(|n| Some(n as f64));
        let quartiles = [0.25, 0.5, 0.75].map(|p| accumulation::empirical_quantile(&lasting, p));
        (name.to_string(), counts.into_iter().chain(quartiles).collect())
    };
    let columns = ["number", "to the end", "quartile", "median", "upper quartile"];
    grid("durations", "change", &columns, KINDS.map(row).to_vec())
}

/// Table of the changes that last less than each length.
fn shorter(all: &[Change], lengths: &[usize]) -> Grid {
    let row = |&length: &usize| {
        let of = |wanted: &dyn Fn(&Change) -> bool| {
            let mine: Vec<&Change> = all.iter().filter(|c| wanted(c)).collect();
            share(mine.iter().filter(|c| c.is_shorter(length)).count(), mine.len())
        };
        let [loss, recovery] = KINDS.map(|(_, sign)| of(&|c| c.sign == sign));
        (length.to_string(), vec![of(&|_| true), loss, recovery])
    };
    let columns = ["all changes", "losses", "recoveries"];
    grid("changes", "length L", &columns, lengths.iter().map(row).collect())
}

/// Tables of the cut values and of how changes are met.
fn by_length(rows: &[Row]) -> [Grid; 2] {
    let rate = |row: &Row| {
        let [learned, checked, lost] = row.rates;
        let ends = [lost, row.power, row.silent];
        let values =
            [Some(row.cut), row.empirical, row.spread, learned, checked].into_iter().chain(ends).collect();
        (row.length.to_string(), values)
    };
    let columns =
        ["cut value β", "quantile", "spread", "learned", "tested", "lost", "lost, quantile", "silent"];
    let rates = grid("rates", "length L", &columns, rows.iter().map(rate).collect());
    let delay = |row: &Row| {
        let met = row.met.iter().flatten().map(|n| Some(*n as f64));
        (row.length.to_string(), [Some(row.alarms as f64)].into_iter().chain(met).collect())
    };
    let names = KINDS.iter().flat_map(|(kind, _)| MEETINGS.map(|(how, _)| format!("{kind} {how}")));
    let columns: Vec<String> = ["alarms".to_string()].into_iter().chain(names).collect();
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    [rates, grid("delays", "length L", &columns, rows.iter().map(delay).collect())]
}

impl Analysis for WindowLengths {
    fn suites(&self) -> (usize, usize) {
        (2, 2)
    }

    fn is_tested(&self, suite: usize) -> bool {
        suite == 1
    }

    fn names(&self, _: usize) -> Names {
        let owned = |names: &[&str]| names.iter().map(|n| n.to_string()).collect::<Vec<_>>();
        Names {
            numbers: owned(&["largest-rate", "least-rate", "shorter", "distance", "distance-lost"]),
            tables: owned(&["durations", "changes", "rates", "delays", "quantiles", "distances"]),
            charts: owned(&["rates"]),
        }
    }

    fn analyze(&self, populations: &[Population<'_>]) -> Result<Findings, AnalysisError> {
        let [trained, tested] = populations else { return Err(AnalysisError::TwoSuites) };
        let p = &self.0;
        let model = consistency::fit(&trained.tracks, &Fitting::by_bic(p.tau, p.max_components))?.model;
        let tracks = [&trained.tracks[..], &tested.tracks[..]];
        let row = |length: &usize| self.row(*length, &model.mixture, model.variance, tracks);
        let rows = p.lengths.par_iter().map(row).collect::<Result<Vec<Row>, AccumulationError>>()?;
        let all: Vec<Change> = tested.tracks.iter().flat_map(|t| changes_of(t.error)).collect();
        let kinds = Kinds::of(trained, tested, p.tau);

        let mut findings = Findings::default();
        findings.tables.extend([durations(&all), shorter(&all, &p.lengths)]);
        findings.tables.extend(by_length(&rows));
        findings.tables.extend([kinds.quantiles(), kinds.distances()]);
        let rates = || rows.iter().filter_map(|r| r.rates[0]);
        let longest = p.lengths.last().copied().unwrap_or(1);
        let short = share(all.iter().filter(|c| c.is_shorter(longest)).count(), all.len());
        let distance = |k: usize| kinds.distance(k).map_or(0.0, |d| d[0]);
        findings.numbers.extend([
            ("largest-rate".to_string(), rates().fold(0.0, f64::max)),
            ("least-rate".to_string(), rates().fold(1.0, f64::min)),
            ("shorter".to_string(), short.unwrap_or(0.0)),
            ("distance".to_string(), distance(1)),
            ("distance-lost".to_string(), distance(3)),
        ]);
        let curve = |name: &str, of: &dyn Fn(&Row) -> Option<f64>| {
            let points = rows.iter().filter_map(|r| Some((r.length as f64, of(r)?)));
            (name.to_string(), points.collect::<Vec<_>>())
        };
        let curves = [
            curve("consistent, learned from", &|r| r.rates[0]),
            curve("consistent, tested", &|r| r.rates[1]),
            curve("lost", &|r| r.rates[2]),
            curve("α", &|_| Some(p.alpha)),
        ];
        findings.charts.push(Chart {
            name: "rates".to_string(),
            x: "window length L".to_string(),
            y: "share beyond the cut value".to_string(),
            curves: curves.into_iter().filter(|(_, points)| !points.is_empty()).collect(),
            ..Chart::default()
        });
        Ok(findings)
    }
}

/// Values of c_t by kind of frame, ascending: consistent ones of both suites, then of the second suite those that are
/// neither, and the lost ones.
struct Kinds([Vec<f64>; 4]);

const KINDS_OF_FRAMES: [&str; 4] =
    ["consistent, learned from", "consistent, tested", "nearly lost, tested", "lost, tested"];

impl Kinds {
    fn of(trained: &Population<'_>, tested: &Population<'_>, tau: f64) -> Self {
        let between = |from: f64, to: f64| {
            let of_track = move |track: &Example<'_>| {
                let first = undefined_frames(track.signal);
                let frames = track.signal.iter().zip(track.error).skip(first);
                let mine = frames.filter(move |(_, e)| (from..to).contains(*e));
                mine.map(|(c, _)| *c).collect::<Vec<_>>()
            };
            tested.tracks.iter().flat_map(of_track).collect::<Vec<f64>>()
        };
        let consistent = |population: &Population<'_>| {
            population.tracks.iter().flat_map(|t| consistent_changes(t, tau)).collect::<Vec<f64>>()
        };
        let lost = f64::INFINITY;
        let mut kinds = [consistent(trained), consistent(tested), between(tau, 1.0), between(1.0, lost)];
        kinds.iter_mut().for_each(|values| values.sort_by(f64::total_cmp));
        Self(kinds)
    }

    fn quantiles(&self) -> Grid {
        let row = |p: f64| {
            let values = self.0.iter().map(|values| accumulation::empirical_quantile(values, p));
            (p.to_string(), values.collect())
        };
        grid("quantiles", "quantile", &KINDS_OF_FRAMES, SHOWN.map(row).to_vec())
    }

    /// The test of one kind against the first.
    fn distance(&self, kind: usize) -> Option<[f64; 5]> {
        two_sample_test(&self.0[0], &self.0[kind])
    }

    fn distances(&self) -> Grid {
        let row = |kind: usize| {
            let values = self.distance(kind).map_or(vec![None; 5], |v| v.map(Some).to_vec());
            (KINDS_OF_FRAMES[kind].to_string(), values)
        };
        let columns = ["distance", "critical at 5 %", "p", "values learned from", "values"];
        grid("distances", "frames", &columns, (1..4).map(row).collect())
    }
}

#[cfg(test)]
mod tests;
