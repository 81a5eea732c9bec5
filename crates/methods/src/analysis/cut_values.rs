//! How well approximations give the cut value of the sum of L values of c_t (SanMiguel and Cavallaro, CVIU
//! 131, 2015, section 5.2, Fig. 6 and 12).
//!
//! The cut value beta(alpha, L) is where the distribution of s_t of a consistent filter reaches 1 - alpha.
//! Empirically it is the quantile of s_t over all windows of consistent frames; it is approximated by the
//! L-fold convolution of the learned mixture and by the central limit theorem.
//!
//! | what | paper | from |
//! |---|---|---|
//! | charts `distribution-1`, `-2`, `-3` | Fig. 6 | P_2 empirical, convolved and normal, for each of `shown_lengths` |
//! | charts `cuts-1`, `-2`, `-3` | Fig. 12 | beta over `alphas` for the same lengths |
//! | table `cuts` | Fig. 12 | beta for every length and rate |
//! | table `deviations` | text | sum over all lengths and rates of the absolute difference from the empirical cut value (the paper: 34.75 and 86.15; its grid is not stated) |

use super::uncertainty_model::check_ascending;
use super::{Analysis, AnalysisError, Chart, Findings, Grid, Names, Population};
use crate::detector::consistency::{self, Fitting, consistent_sums};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use statrs::function::erf::erfc;
use std::collections::BTreeSet;
use trackfail_core::num::accumulation::{self, Accumulated, AccumulationError};
use trackfail_core::plugin::{Entry, ParamError, Plugin, Range};

pub(crate) const ENTRY: Entry<dyn Analysis> = Entry::of::<CutValues>(
    "cut-values",
    2,
    "cut values of sums of c_t: empirical, by convolution of the mixture, by the central limit theorem",
);

#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Error below which a frame is consistent.
    pub tau: f64,
    /// Lengths of the sums.
    pub lengths: Vec<usize>,
    /// Lengths that charts show.
    pub shown_lengths: [usize; 3],
    /// Rates of false alarms.
    pub alphas: Vec<f64>,
    /// Largest order of the mixture that is tried, 2 to 20.
    pub max_components: usize,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            tau: 0.9,
            lengths: vec![1, 5, 10, 20, 30, 40, 50, 60],
            shown_lengths: [5, 20, 60],
            alphas: vec![0.001, 0.005, 0.01, 0.02, 0.03, 0.04, 0.05],
            max_components: 10,
        }
    }
}

#[derive(Debug, Clone)]
pub struct CutValues(Params);

impl Plugin for CutValues {
    type Params = Params;

    const RANGES: &'static [Range] = &[
        Range::of("tau").above(0.0).at_most(1.0),
        Range::within("lengths", 1.0, 10_000.0),
        Range::within("shown_lengths", 1.0, 10_000.0),
        Range::of("alphas").above(0.0).below(0.5),
        Range::within("max_components", 2.0, 20.0),
    ];

    fn make(p: Params) -> Result<Self, ParamError> {
        check_ascending("lengths", &p.lengths)?;
        check_ascending("shown_lengths", &p.shown_lengths)?;
        check_ascending("alphas", &p.alphas)?;
        Ok(Self(p))
    }
}

/// The three ways to compute a cut value, the empirical one first.
const WAYS: [&str; 3] = ["empirical", "convolution", "CLT"];
/// Points of a drawn distribution.
const POINTS: usize = 200;

/// The distribution of the sum of one length, in three ways.
struct Sum {
    length: usize,
    /// Ascending; empty where no track has so many consistent frames in a row.
    empirical: Vec<f64>,
    convolved: Accumulated,
    mean: f64,
    variance: f64,
}

impl Sum {
    fn cuts(&self, alpha: f64) -> [Option<f64>; 3] {
        [
            accumulation::empirical_quantile(&self.empirical, 1.0 - alpha),
            self.convolved.upper_quantile(alpha).ok(),
            Some(accumulation::clt_quantile(self.mean, self.variance, self.length, alpha)),
        ]
    }

    fn distributions(&self, v: f64) -> [Option<f64>; 3] {
        let n = self.empirical.len();
        let length = self.length as f64;
        let share = (n > 0).then(|| self.empirical.partition_point(|s| *s <= v) as f64 / n as f64);
        let deviation = (2.0 * length * self.variance).sqrt();
        let normal = 0.5 * erfc((length * self.mean - v) / deviation);
        [share, Some(self.convolved.cdf(v)), Some(normal)]
    }
}

impl Analysis for CutValues {
    fn suites(&self) -> (usize, usize) {
        (1, 1)
    }

    fn names(&self, _: usize) -> Names {
        let owned = |names: &[&str]| names.iter().map(|n| n.to_string()).collect::<Vec<_>>();
        let numbers = [
            "deviation-convolution",
            "deviation-clt",
            "deviation-convolution-low",
            "deviation-convolution-high",
        ];
        let mut names =
            Names { numbers: owned(&numbers), tables: owned(&["cuts", "deviations"]), charts: Vec::new() };
        for k in 1..=self.0.shown_lengths.len() {
            names.charts.extend([format!("distribution-{k}"), format!("cuts-{k}")]);
        }
        names
    }

    fn analyze(&self, populations: &[Population<'_>]) -> Result<Findings, AnalysisError> {
        let [population] = populations else { return Err(AnalysisError::OneSuite) };
        let p = &self.0;
        let how = Fitting::by_bic(p.tau, p.max_components);
        let model = consistency::fit(&population.tracks, &how)?.model;
        let sum = |length: usize| -> Result<Sum, AccumulationError> {
            let sums = population.tracks.iter().flat_map(|t| consistent_sums(t, p.tau, length));
            let mut empirical: Vec<f64> = sums.collect();
            empirical.sort_by(f64::total_cmp);
            let convolved = Accumulated::of_mixture(&model.mixture, length, &accumulation::Grid::default());
            Ok(Sum { length, empirical, convolved: convolved?, mean: model.mean, variance: model.variance })
        };
        let lengths: BTreeSet<usize> = p.lengths.iter().chain(&p.shown_lengths).copied().collect();
        let sums = lengths.into_par_iter().map(sum).collect::<Result<Vec<Sum>, AccumulationError>>()?;
        let mut findings = Findings::default();
        self.tables(sums.iter().filter(|sum| p.lengths.contains(&sum.length)), &mut findings);
        let shown = sums.iter().filter(|sum| p.shown_lengths.contains(&sum.length));
        for (k, sum) in shown.enumerate() {
            findings.charts.extend(self.charts(k + 1, sum));
        }
        Ok(findings)
    }
}

impl CutValues {
    fn tables<'s>(&self, sums: impl Iterator<Item = &'s Sum>, findings: &mut Findings) {
        let alphas = &self.0.alphas;
        let mut rows = Vec::new();
        let mut deviations = [0.0; 3];
        // Deviations of the convolution at the smallest and at the largest rate.
        let mut ends = [0.0; 2];
        for sum in sums {
            for (i, alpha) in alphas.iter().enumerate() {
                let cuts = sum.cuts(*alpha);
                if let [Some(empirical), ..] = cuts {
                    for (total, cut) in deviations.iter_mut().zip(cuts) {
                        *total += cut.map_or(0.0, |c| (c - empirical).abs());
                    }
                    let convolved = cuts[1].map_or(0.0, |c| (c - empirical).abs());
                    ends[0] += if i == 0 { convolved } else { 0.0 };
                    ends[1] += if i + 1 == alphas.len() { convolved } else { 0.0 };
                }
                rows.push((format!("L = {}, α = {alpha}", sum.length), cuts.to_vec()));
            }
        }
        findings.tables.push(Grid {
            name: "cuts".to_string(),
            corner: "length, rate".to_string(),
            columns: WAYS.map(String::from).to_vec(),
            rows,
        });
        findings.tables.push(Grid {
            name: "deviations".to_string(),
            corner: "from the empirical cut values".to_string(),
            columns: WAYS[1..].iter().map(|w| w.to_string()).collect(),
            rows: vec![("total deviation".to_string(), vec![Some(deviations[1]), Some(deviations[2])])],
        });
        findings.numbers.extend([
            ("deviation-convolution".to_string(), deviations[1]),
            ("deviation-clt".to_string(), deviations[2]),
            ("deviation-convolution-low".to_string(), ends[0]),
            ("deviation-convolution-high".to_string(), ends[1]),
        ]);
    }

    fn charts(&self, k: usize, sum: &Sum) -> [Chart; 2] {
        let least = self.0.alphas.first().copied().unwrap_or(0.001);
        let end = sum.cuts(least).into_iter().flatten().fold(f64::MIN_POSITIVE, f64::max);
        // A curve for each way, from the values of all three at each place.
        let curves = |places: Vec<(f64, [Option<f64>; 3])>| -> Vec<(String, Vec<(f64, f64)>)> {
            let way = |w: usize| places.iter().filter_map(|(x, y)| Some((*x, y[w]?))).collect::<Vec<_>>();
            let named = WAYS.iter().enumerate().map(|(w, name)| (name.to_string(), way(w)));
            named.filter(|(_, points)| !points.is_empty()).collect()
        };
        let at = |i: usize| end * i as f64 / POINTS as f64;
        let distributions = (0..=POINTS).map(|i| (at(i), sum.distributions(at(i)))).collect();
        let cuts = self.0.alphas.iter().map(|alpha| (*alpha, sum.cuts(*alpha))).collect();
        let chart = |name: &str, x: &str, y: &str, curves| Chart {
            name: format!("{name}-{k}"),
            x: format!("{x} (L = {})", sum.length),
            y: y.to_string(),
            curves,
            ..Chart::default()
        };
        [
            chart("distribution", "sₜ", "P₂", curves(distributions)),
            chart("cuts", "rate of false alarms α", "cut value β", curves(cuts)),
        ]
    }
}
