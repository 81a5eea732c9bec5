//! How well two approximations give the cut value of the sum of L values of c_t (SanMiguel and Cavallaro,
//! CVIU 131, 2015, section 5.2, Fig. 6 and 12).
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

use super::consistent::{LENGTHS, MAX_COMPONENTS, TAU, ascending, check_ascending};
use super::prelude::*;
use crate::detector::consistency::{self, Fitting, consistent_sums};
use rayon::prelude::*;
use statrs::function::erf::erfc;
use std::collections::BTreeSet;
use trackfail_core::num::accumulation::{self, Accumulated, AccumulationError};

pub(crate) const ENTRY: Entry<dyn Analysis> = Entry::of::<Params>(
    "cut-values",
    2,
    "cut values of sums of c_t: empirical, by convolution of the mixture, by the central limit theorem",
);

#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Error below which a frame is consistent.
    #[default(0.9)]
    pub tau: f64,
    /// Lengths of the sums.
    #[default(vec![1, 5, 10, 20, 30, 40, 50, 60])]
    pub lengths: Vec<usize>,
    /// Lengths of the sums that the charts show.
    #[default([5, 20, 60])]
    pub shown_lengths: [usize; 3],
    /// Rates of false alarms.
    #[default(vec![0.001, 0.005, 0.01, 0.02, 0.03, 0.04, 0.05])]
    pub alphas: Vec<f64>,
    /// Largest number of components of the mixture that is tried, 2 to 20.
    #[default(10)]
    pub max_components: usize,
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[
        TAU,
        LENGTHS,
        Range::within("shown_lengths", 1.0, 10_000.0),
        Range::of("alphas").above(0.0).below(0.5),
        MAX_COMPONENTS,
    ];

    fn check(&self) -> Result<(), ParamError> {
        check_ascending("lengths", &self.lengths)?;
        check_ascending("shown_lengths", &self.shown_lengths)?;
        check_ascending("alphas", &self.alphas)
    }
}

/// The three ways to compute a cut value; `empirical` is the reference.
const WAYS: [&str; 3] = ["empirical", "convolution", "CLT"];
/// Number of points of a distribution in a chart.
const POINTS: usize = 200;

/// The distribution of the sum of c_t over windows of one length, in three ways.
struct Sum {
    length: usize,
    /// Sums of all windows, ascending; empty if no track has so many consistent frames in a row.
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

impl Analysis for Params {
    fn layout(&self, _: usize) -> Layout {
        let numbers = [
            "deviation-convolution",
            "deviation-clt",
            "deviation-convolution-low",
            "deviation-convolution-high",
        ];
        let mut layout = Layout::of(numbers).table("cuts", "length, rate", WAYS).table(
            "deviations",
            "from the empirical cut values",
            [WAYS[1], WAYS[2]],
        );
        for (k, length) in self.shown_lengths.iter().enumerate() {
            let (k, rate) = (k + 1, format!("rate of false alarms α (L = {length})"));
            layout = layout.chart(&format!("distribution-{k}"), &format!("sₜ (L = {length})"), "P₂");
            layout = layout.chart(&format!("cuts-{k}"), &rate, "cut value β");
        }
        layout
    }

    fn values(&self, populations: &[Population<'_>]) -> Result<Values, AnalysisError> {
        let tracks = &populations[0].tracks;
        let model = consistency::fit(tracks, &Fitting::by_bic(self.tau, self.max_components))?.model;
        let sum = |length: usize| -> Result<Sum, AccumulationError> {
            let empirical = ascending(tracks.iter().flat_map(|t| consistent_sums(t, self.tau, length)));
            let convolved = Accumulated::of_mixture(&model.mixture, length)?;
            Ok(Sum { length, empirical, convolved, mean: model.mean, variance: model.variance })
        };
        let lengths: BTreeSet<usize> = self.lengths.iter().chain(&self.shown_lengths).copied().collect();
        let sums = lengths.into_par_iter().map(sum).collect::<Result<Vec<Sum>, AccumulationError>>()?;
        let shown = sums.iter().filter(|sum| self.shown_lengths.contains(&sum.length));
        let charts = shown.flat_map(|sum| self.curves(sum)).collect();
        Ok(Values { charts, ..self.deviations(sums.iter().filter(|sum| self.lengths.contains(&sum.length))) })
    }
}

impl Params {
    /// Cut values, and sums of the absolute differences from the empirical cut values.
    fn deviations<'s>(&self, sums: impl Iterator<Item = &'s Sum>) -> Values {
        let alphas = &self.alphas;
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
        let [_, convolved, normal] = deviations.map(Some);
        let total = vec![("total deviation".to_string(), vec![convolved, normal])];
        let numbers = vec![convolved, normal, Some(ends[0]), Some(ends[1])];
        Values { numbers, tables: vec![rows, total], ..Values::default() }
    }

    /// Curves of the two charts of a length: the distributions and the cut values.
    fn curves(&self, sum: &Sum) -> [Vec<Curve>; 2] {
        let least = self.alphas.first().copied().unwrap_or(0.001);
        let end = sum.cuts(least).into_iter().flatten().fold(f64::MIN_POSITIVE, f64::max);
        // A curve for each way, from the values of all three at each place.
        let curves = |places: Vec<(f64, [Option<f64>; 3])>| -> Vec<Curve> {
            let way = |w: usize| places.iter().filter_map(|(x, y)| Some((*x, y[w]?))).collect::<Vec<_>>();
            let named = WAYS.iter().enumerate().map(|(w, name)| (name.to_string(), way(w)));
            named.filter(|(_, points)| !points.is_empty()).collect()
        };
        let at = |i: usize| end * i as f64 / POINTS as f64;
        let distributions = (0..=POINTS).map(|i| (at(i), sum.distributions(at(i)))).collect();
        let cuts = self.alphas.iter().map(|alpha| (*alpha, sum.cuts(*alpha))).collect();
        [curves(distributions), curves(cuts)]
    }
}
