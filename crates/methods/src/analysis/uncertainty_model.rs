//! Distribution of c_t of a consistent filter (SanMiguel and Cavallaro, CVIU 131, 2015, sections 5.1 and 7,
//! Fig. 4, 5 and 8 to 11).
//!
//! The model is fitted to the first suite. If there is a second suite, the two are compared. A frame is
//! consistent when its tracking error is below `tau` (Eq. 24); see [`consistency`] for which values are
//! taken.
//!
//! | what | paper | from |
//! |---|---|---|
//! | chart `densities` | Fig. 4 | histogram of c_t for each of `taus` |
//! | chart `criteria` | Fig. 5 | deviance -2 ln L_K above its least value, and the penalties d v_K ln n |
//! | chart `similarity`, table `similarity` | Fig. 8 | largest distance between the two suites' distributions of the sum of L values |
//! | chart `cut-difference` | Fig. 9 | D = abs(beta_1 - beta_2) / min(beta_1, beta_2) |
//! | table `test` | text to Fig. 8 | two-sample Kolmogorov-Smirnov test of c_t at 5 % |
//! | charts `fit-low`, `fit-middle`, `fit-high`, table `families` | Fig. 10 | well-known distributions by maximum likelihood, with their Kolmogorov-Smirnov distance, for each of `family_taus` |
//! | chart `orders`, table `orders` | Fig. 11 | the order that dAIC and dBIC choose for each weight d |
//! | chart `mixture`, table `components` | | the chosen mixture |
//!
//! Our choices where the paper says nothing: the distributions of the sums are convolutions of the histogram
//! of the samples, as the paper computes p_2. A suite without consistent frames at some `tau` has no value
//! there. The Kolmogorov-Smirnov distance is between the samples and the fitted distribution, although the
//! paper calls it two-sample.

use super::consistent::{
    ALPHA, LENGTHS, MAX_COMPONENTS, TAU, TEST, changes, check_ascending, two_sample_test,
};
use super::prelude::*;
use crate::detector::consistency::{self, Fitted, Fitting};
use rayon::prelude::*;
use trackfail_core::num::accumulation::{self, Accumulated, AccumulationError};
use trackfail_core::num::distribution::{self, Family};
use trackfail_core::num::gamma_mixture::select::{Terms, terms};
use trackfail_core::num::gamma_mixture::{Component, Mixture};
use trackfail_core::num::kolmogorov;

pub(crate) const ENTRY: Entry<dyn Analysis> = Entry::of::<Params>(
    "uncertainty-model",
    2,
    "distribution of c_t of a consistent filter: densities, mixture of Gammas, rival families, two suites",
);

#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Error below which a frame is consistent, for the model.
    #[default(0.9)]
    pub tau: f64,
    /// Errors below which a frame is consistent, for the densities and the comparison of two suites; ascending.
    #[default((1..=10).map(|k| f64::from(k) / 10.0).collect())]
    pub taus: Vec<f64>,
    /// Errors below which a frame is consistent, for the fits of other families: low, middle and high.
    #[default([0.3, 0.6, 0.9])]
    pub family_taus: [f64; 3],
    /// Lengths of the sums that are compared.
    #[default(vec![1, 5, 10, 20, 30, 40, 50, 60])]
    pub lengths: Vec<usize>,
    /// Rate of false alarms of the cut values.
    #[default(0.005)]
    pub alpha: f64,
    /// Largest number of components of the mixture that is tried, 2 to 20.
    #[default(10)]
    pub max_components: usize,
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[
        TAU,
        Range::of("taus").above(0.0).at_most(1.0),
        Range::of("family_taus").above(0.0).at_most(1.0),
        LENGTHS,
        ALPHA,
        MAX_COMPONENTS,
    ];

    fn check(&self) -> Result<(), ParamError> {
        check_ascending("taus", &self.taus)?;
        check_ascending("family_taus", &self.family_taus)?;
        check_ascending("lengths", &self.lengths)
    }
}

/// Number of bins of a histogram.
const BINS: usize = 100;
/// Quantile at which the axis of histograms and densities ends.
const SHOWN: f64 = 0.995;
/// Weights of the penalty that the chart `criteria` shows.
const WEIGHTS: [usize; 3] = [1, 50, 500];

impl Analysis for Params {
    fn suites(&self) -> (usize, usize) {
        (1, 2)
    }

    fn layout(&self, suites: usize) -> Layout {
        let numbers =
            ["samples", "floored", "components", "components-daic", "components-dbic", "gamma-best"];
        let orders = ["log-likelihood a sample", "weights won by dAIC", "weights won by dBIC"];
        let mut layout = Layout::of(numbers)
            .table("components", "component", ["weight γ", "shape η", "scale θ", "mean"])
            .table("orders", "components K", orders)
            .table("families", "error below", Family::ALL.map(Family::name))
            .chart("densities", "cₜ", "density")
            .logarithmic()
            .chart("criteria", "components K", "term of the criterion")
            .chart("orders", "weight d of the penalty", "chosen K")
            .chart("mixture", "cₜ", "density")
            .logarithmic();
        for name in ["fit-low", "fit-middle", "fit-high"] {
            layout = layout.chart(name, "cₜ", "density").logarithmic();
        }
        if suites == 1 {
            return layout;
        }
        layout.numbers.push("different".to_string());
        let tau = "error below τ";
        let lengths = || self.lengths.iter().map(|l| format!("L = {l}"));
        let values = ["values of the first", "values of the second"];
        layout
            .table("similarity", tau, lengths())
            .table("cut-difference", tau, lengths())
            .table("test", tau, TEST.into_iter().chain(values))
            .chart("similarity", tau, "largest distance of the distributions")
            .chart("cut-difference", tau, "D = |β₁ - β₂| / min(β₁, β₂)")
    }

    fn values(&self, populations: &[Population<'_>]) -> Result<Values, AnalysisError> {
        let how = Fitting::by_bic(self.tau, self.max_components);
        let fitted = consistency::fit(&populations[0].tracks, &how)?;
        let mut values = self.model(&populations[0], &fitted);
        self.families(&populations[0], &mut values);
        if let [first, second] = populations {
            self.compare(first, second, &mut values)?;
        }
        Ok(values)
    }
}

/// Histogram of ascending samples as a density: equal bins from 0 to `end`, one point at the center of each
/// bin that is not empty.
fn histogram(sorted: &[f64], end: f64) -> Vec<(f64, f64)> {
    let width = end / BINS as f64;
    let below = |x: f64| sorted.partition_point(|v| *v < x);
    let bin = |k: usize| {
        let count = below((k + 1) as f64 * width) - below(k as f64 * width);
        ((k as f64 + 0.5) * width, count as f64 / (sorted.len() as f64 * width))
    };
    (0..BINS).map(bin).filter(|p| p.1 > 0.0).collect()
}

/// A density at the centers of the bins: the probability of each bin divided by its width, so that a pole at
/// 0 does no harm. Values far below those of the histogram are left out, since they would flatten the chart.
fn binned(cdf: impl Fn(f64) -> f64, end: f64, histogram: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let least = histogram.iter().map(|p| p.1).fold(f64::INFINITY, f64::min) / 10.0;
    let width = end / BINS as f64;
    let bin = |k: usize| {
        let (from, to) = (k as f64 * width, (k + 1) as f64 * width);
        ((from + to) / 2.0, (cdf(to) - cdf(from)) / width)
    };
    (0..BINS).map(bin).filter(|p| p.1.is_finite() && p.1 >= least).collect()
}

/// Right end of the axis of a histogram.
fn end_of(sorted: &[f64]) -> f64 {
    accumulation::empirical_quantile(sorted, SHOWN).filter(|e| *e > 0.0).unwrap_or(1.0)
}

/// A row with all values present.
fn row(heading: impl ToString, values: &[f64]) -> Row {
    (heading.to_string(), values.iter().copied().map(Some).collect())
}

impl Params {
    /// Values of the densities, the criteria, the order and the mixture.
    fn model(&self, population: &Population<'_>, fitted: &Fitted) -> Values {
        let model = &fitted.model;
        let samples = changes(population, self.tau);
        let end = end_of(&samples);
        let density = |tau: &f64| {
            let sorted = changes(population, *tau);
            (format!("error below {tau}"), histogram(&sorted, end))
        };
        let densities = self.taus.iter().map(density).filter(|(_, points)| !points.is_empty()).collect();
        let terms = terms(&fitted.fits, model.samples);
        let least = terms.iter().map(|t| t.deviance).fold(f64::INFINITY, f64::min);
        let mut criteria =
            vec![("deviance above the least".to_string(), by_order(&terms, |t| t.deviance - least))];
        for d in WEIGHTS {
            let penalty = by_order(&terms, |t| d as f64 * t.bic_penalty);
            criteria.push((format!("penalty of dBIC, d = {d}"), penalty));
        }
        let winners = |name: &str, winners: &[usize]| {
            let points = winners.iter().enumerate().map(|(i, k)| ((i + 1) as f64, *k as f64));
            (name.to_string(), points.collect())
        };
        let orders = vec![winners("dAIC", &fitted.daic), winners("dBIC", &fitted.dbic)];
        let seen = histogram(&samples, end);
        let mut mixture = vec![
            (format!("cₜ of {}", population.suite), seen.clone()),
            ("mixture".to_string(), binned(|v| model.mixture.cdf(v), end, &seen)),
        ];
        for (k, c) in model.mixture.components.iter().enumerate() {
            let Ok(alone) = Mixture::new(vec![Component { weight: 1.0, ..*c }]) else { continue };
            let alone = |v: f64| c.weight * alone.cdf(v);
            mixture.push((format!("component {}", k + 1), binned(alone, end, &seen)));
        }
        let components = model.mixture.components.iter().zip(1..);
        let of_component = |(c, k): (&Component, usize)| row(k, &[c.weight, c.shape, c.scale, c.mean()]);
        let of_order = |o: &consistency::Order| {
            let likelihood = o.log_likelihood / model.samples as f64;
            row(o.components, &[likelihood, o.wins_daic as f64, o.wins_dbic as f64])
        };
        let orders_found = [model.mixture.components.len(), model.order_daic, model.order_dbic];
        let numbers = [model.samples as f64, model.clipped.floored as f64].into_iter();
        Values {
            numbers: numbers.chain(orders_found.map(|k| k as f64)).map(Some).collect(),
            tables: vec![components.map(of_component).collect(), model.orders.iter().map(of_order).collect()],
            charts: vec![densities, criteria, orders, mixture],
        }
    }

    /// Values of the fits of other families, for three errors.
    fn families(&self, population: &Population<'_>, values: &mut Values) {
        let mut rows = Vec::new();
        let mut gamma_best = true;
        for tau in self.family_taus {
            let samples = changes(population, tau);
            let end = end_of(&samples);
            let one = |family: &Family| {
                // A family that cannot be fitted has no value; too few samples are no fault of the data.
                let fit = distribution::fit(*family, &samples)?;
                let distance = kolmogorov::one_sample(&samples, |v| fit.cdf(v));
                Some((fit, distance))
            };
            let fits: Vec<_> = Family::ALL.par_iter().map(one).collect();
            let seen = histogram(&samples, end);
            let mut curves = vec![(format!("cₜ, error below {tau}"), seen.clone())];
            for (family, fit) in Family::ALL.iter().zip(&fits) {
                let points = fit.as_ref().map(|(fit, _)| binned(|v| fit.cdf(v), end, &seen));
                curves.push((family.name().to_string(), points.unwrap_or_default()));
            }
            curves.retain(|(_, points)| !points.is_empty());
            values.charts.push(curves);
            let distances: Vec<Option<f64>> = fits.iter().map(|f| f.as_ref().map(|(_, d)| *d)).collect();
            let gamma = Family::ALL.iter().position(|f| *f == Family::Gamma).and_then(|g| distances[g]);
            gamma_best &= gamma.is_some_and(|g| distances.iter().flatten().all(|d| *d >= g));
            rows.push((format!("{tau} ({} samples)", samples.len()), distances));
        }
        values.tables.push(rows);
        values.numbers.push(Some(f64::from(u8::from(gamma_best))));
    }

    /// Values of the comparison of two suites: distances of the distributions of sums, and differences of cut
    /// values.
    fn compare(
        &self,
        first: &Population<'_>,
        second: &Population<'_>,
        values: &mut Values,
    ) -> Result<(), AnalysisError> {
        let Params { tau, taus, lengths, alpha, .. } = self;
        let one = |a: &[f64], b: &[f64], length: usize| {
            let [a, b] = [Accumulated::from_samples(a, length)?, Accumulated::from_samples(b, length)?];
            // Both have their masses on the same grid, between whose cells their distribution functions are linear.
            let ends = a.masses().chain(b.masses()).map(|(v, _)| v + accumulation::STEP / 2.0);
            let distance = ends.map(|v| (a.cdf(v) - b.cdf(v)).abs()).fold(0.0, f64::max);
            let (x, y) = (a.upper_quantile(*alpha)?, b.upper_quantile(*alpha)?);
            Ok([distance, (x - y).abs() / x.min(y)])
        };
        let samples: Vec<_> =
            taus.par_iter().map(|tau| (changes(first, *tau), changes(second, *tau))).collect();
        let of_tau = |(a, b): &(Vec<f64>, Vec<f64>)| -> Result<Vec<Option<[f64; 2]>>, AccumulationError> {
            if a.is_empty() || b.is_empty() {
                return Ok(vec![None; lengths.len()]);
            }
            lengths.iter().map(|length| one(a, b, *length).map(Some)).collect()
        };
        let found = samples.par_iter().map(of_tau).collect::<Result<Vec<_>, _>>();
        let found = found.map_err(AnalysisError::Compared)?;
        // The distances of the distributions, then those of the cut values.
        for part in [0, 1] {
            let value = |t: usize, l: usize| found[t][l].map(|pair| pair[part]);
            let curve = |(l, length): (usize, &usize)| -> Curve {
                let points = taus.iter().enumerate().filter_map(|(t, tau)| Some((*tau, value(t, l)?)));
                (format!("L = {length}"), points.collect())
            };
            values.charts.push(lengths.iter().enumerate().map(curve).collect());
            let row = |(t, tau): (usize, &f64)| -> Row {
                (tau.to_string(), (0..lengths.len()).map(|l| value(t, l)).collect())
            };
            values.tables.push(taus.iter().enumerate().map(row).collect());
        }
        let tests = samples.iter().map(|(a, b)| two_sample_test(a, b).to_vec());
        values.tables.push(taus.iter().map(f64::to_string).zip(tests).collect());
        let of_model = two_sample_test(&changes(first, *tau), &changes(second, *tau));
        let differs = matches!(of_model, [Some(distance), Some(critical), ..] if distance > critical);
        values.numbers.push(Some(f64::from(u8::from(differs))));
        Ok(())
    }
}

fn by_order(terms: &[Terms], value: impl Fn(&Terms) -> f64) -> Vec<(f64, f64)> {
    terms.iter().map(|t| (t.k as f64, value(t))).collect()
}
