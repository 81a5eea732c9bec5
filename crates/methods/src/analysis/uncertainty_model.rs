//! How c_t of a consistent filter is distributed (SanMiguel and Cavallaro, CVIU 131, 2015, sections 5.1 and
//! 7, Fig. 4, 5 and 8 to 11).
//!
//! The first suite is the one that is modeled; with a second one the two are compared. A frame is
//! consistent when its tracking error is below `tau` (Eq. 24); see
//! [`consistency`] for which values are taken.
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
//! Chosen where the source is silent: the distributions of sums that are compared are convolutions of the
//! samples' own histograms, as the paper computes p_2; a suite without consistent frames at some `tau` has
//! no value there. The Kolmogorov-Smirnov distance is that of the samples to the fitted distribution; the
//! paper calls it two-sample.

use super::{Analysis, AnalysisError, Chart, Findings, Grid, Names, Population};
use crate::detector::consistency::{self, Fitted, Fitting, consistent_changes};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use trackfail_core::num::accumulation::{self, Accumulated, AccumulationError};
use trackfail_core::num::distribution::{self, Family};
use trackfail_core::num::gamma_mixture::select::{Terms, terms};
use trackfail_core::num::gamma_mixture::{Component, Mixture};
use trackfail_core::num::kolmogorov;
use trackfail_core::plugin::{Entry, ParamError, Plugin, Range};

pub(crate) const ENTRY: Entry<dyn Analysis> = Entry::of::<UncertaintyModel>(
    "uncertainty-model",
    2,
    "distribution of c_t of a consistent filter: densities, mixture of Gammas, rival families, two suites",
);

#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Error below which a frame is consistent, for the model.
    pub tau: f64,
    /// Errors below which a frame is consistent, for the densities and the comparison of two suites; ascending.
    pub taus: Vec<f64>,
    /// Errors below which a frame is consistent, for the rival families: low, middle and high.
    pub family_taus: [f64; 3],
    /// Lengths of the sums that are compared.
    pub lengths: Vec<usize>,
    /// Rate of false alarms of the cut values.
    pub alpha: f64,
    /// Largest order of the mixture that is tried, 2 to 20.
    pub max_components: usize,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            tau: 0.9,
            taus: (1..=10).map(|k| f64::from(k) / 10.0).collect(),
            family_taus: [0.3, 0.6, 0.9],
            lengths: vec![1, 5, 10, 20, 30, 40, 50, 60],
            alpha: 0.005,
            max_components: 10,
        }
    }
}

/// Refuses lists that are empty, do not ascend or have more than 64 numbers.
pub(super) fn check_ascending<T: PartialOrd + std::fmt::Debug>(
    key: &'static str,
    list: &[T],
) -> Result<(), ParamError> {
    if (1..=64).contains(&list.len()) && list.windows(2).all(|w| w[0] < w[1]) {
        return Ok(());
    }
    Err(ParamError::out_of_range(key, "1 to 64 ascending numbers", format!("{list:?}")))
}

#[derive(Debug, Clone)]
pub struct UncertaintyModel(Params);

impl Plugin for UncertaintyModel {
    type Params = Params;

    const RANGES: &'static [Range] = &[
        Range::of("tau").above(0.0).at_most(1.0),
        Range::of("taus").above(0.0).at_most(1.0),
        Range::of("family_taus").above(0.0).at_most(1.0),
        Range::within("lengths", 1.0, 10_000.0),
        Range::of("alpha").above(0.0).below(0.5),
        Range::within("max_components", 2.0, 20.0),
    ];

    fn make(p: Params) -> Result<Self, ParamError> {
        check_ascending("taus", &p.taus)?;
        check_ascending("family_taus", &p.family_taus)?;
        check_ascending("lengths", &p.lengths)?;
        Ok(Self(p))
    }
}

/// Charts of the families.
const FITS: [&str; 3] = ["fit-low", "fit-middle", "fit-high"];
/// Bins of histograms.
const BINS: usize = 100;
/// Histograms and densities are drawn up to this quantile.
const SHOWN: f64 = 0.995;
/// Level of the two-sample test.
const LEVEL: f64 = 0.05;
/// Weights of the penalty that the chart of the criteria shows.
const WEIGHTS: [usize; 3] = [1, 50, 500];

impl Analysis for UncertaintyModel {
    fn suites(&self) -> (usize, usize) {
        (1, 2)
    }

    fn names(&self, suites: usize) -> Names {
        let owned = |names: &[&str]| names.iter().map(|n| n.to_string()).collect::<Vec<_>>();
        let numbers =
            ["samples", "floored", "components", "components-daic", "components-dbic", "gamma-best"];
        let mut names = Names {
            numbers: owned(&numbers),
            tables: owned(&["families", "orders", "components"]),
            charts: owned(&["densities", "criteria", "orders", "mixture"]),
        };
        names.charts.extend(owned(&FITS));
        if suites == 2 {
            names.numbers.push("different".to_string());
            names.tables.extend(owned(&["similarity", "cut-difference", "test"]));
            names.charts.extend(owned(&["similarity", "cut-difference"]));
        }
        names
    }

    fn analyze(&self, populations: &[Population<'_>]) -> Result<Findings, AnalysisError> {
        let Some(modeled) = populations.first() else { return Err(AnalysisError::NoSuite) };
        let how = Fitting::by_bic(self.0.tau, self.0.max_components);
        let fitted = consistency::fit(&modeled.tracks, &how)?;
        let mut findings = Findings::default();
        self.model(modeled, &fitted, &mut findings);
        self.families(modeled, &mut findings);
        if let [first, second] = populations {
            self.compare(first, second, &mut findings)?;
        }
        Ok(findings)
    }
}

/// Values of c_t in the consistent frames of a suite, ascending.
pub(super) fn changes(population: &Population<'_>, tau: f64) -> Vec<f64> {
    let mut all: Vec<f64> = population.tracks.iter().flat_map(|t| consistent_changes(t, tau)).collect();
    all.sort_by(f64::total_cmp);
    all
}

/// Density of ascending samples in equal bins from 0 to `end`, at the bins' centers; empty bins are left out.
fn histogram(sorted: &[f64], end: f64) -> Vec<(f64, f64)> {
    let width = end / BINS as f64;
    let below = |x: f64| sorted.partition_point(|v| *v < x);
    let bin = |k: usize| {
        let count = below((k + 1) as f64 * width) - below(k as f64 * width);
        ((k as f64 + 0.5) * width, count as f64 / (sorted.len() as f64 * width))
    };
    (0..BINS).map(bin).filter(|p| p.1 > 0.0).collect()
}

/// A density at the centers of a histogram's bins, as the share of each bin over its width: a pole at 0 has
/// no value of its own. Values far below all of the histogram's are left out, as they would hide its shape.
fn binned(cdf: impl Fn(f64) -> f64, end: f64, histogram: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let least = histogram.iter().map(|p| p.1).fold(f64::INFINITY, f64::min) / 10.0;
    let width = end / BINS as f64;
    let bin = |k: usize| {
        let (from, to) = (k as f64 * width, (k + 1) as f64 * width);
        ((from + to) / 2.0, (cdf(to) - cdf(from)) / width)
    };
    (0..BINS).map(bin).filter(|p| p.1.is_finite() && p.1 >= least).collect()
}

/// Right end of a drawn histogram.
fn end_of(sorted: &[f64]) -> f64 {
    accumulation::empirical_quantile(sorted, SHOWN).filter(|e| *e > 0.0).unwrap_or(1.0)
}

fn chart(name: &str, x: &str, y: &str, curves: Vec<(String, Vec<(f64, f64)>)>) -> Chart {
    Chart { name: name.to_string(), x: x.to_string(), y: y.to_string(), curves, ..Chart::default() }
}

impl UncertaintyModel {
    /// Densities, the criteria, the order and the mixture.
    fn model(&self, population: &Population<'_>, fitted: &Fitted, findings: &mut Findings) {
        let model = &fitted.model;
        let samples = changes(population, self.0.tau);
        let end = end_of(&samples);
        let density = |tau: &f64| {
            let sorted = changes(population, *tau);
            (format!("error below {tau}"), histogram(&sorted, end))
        };
        let densities = self.0.taus.iter().map(density).filter(|(_, points)| !points.is_empty()).collect();
        findings.charts.push(Chart { y_log: true, ..chart("densities", "cₜ", "density", densities) });
        let terms = terms(&fitted.fits, model.samples);
        let least = terms.iter().map(|t| t.deviance).fold(f64::INFINITY, f64::min);
        let mut criteria =
            vec![("deviance above the least".to_string(), by_order(&terms, |t| t.deviance - least))];
        for d in WEIGHTS {
            let penalty = by_order(&terms, |t| d as f64 * t.bic_penalty);
            criteria.push((format!("penalty of dBIC, d = {d}"), penalty));
        }
        findings.charts.push(chart("criteria", "components K", "term of the criterion", criteria));
        let winners = |name: &str, winners: &[usize]| {
            let points = winners.iter().enumerate().map(|(i, k)| ((i + 1) as f64, *k as f64));
            (name.to_string(), points.collect())
        };
        let orders = vec![winners("dAIC", &fitted.daic), winners("dBIC", &fitted.dbic)];
        findings.charts.push(chart("orders", "weight d of the penalty", "chosen K", orders));
        let seen = histogram(&samples, end);
        let mut curves = vec![
            (format!("cₜ of {}", population.suite), seen.clone()),
            ("mixture".to_string(), binned(|v| model.mixture.cdf(v), end, &seen)),
        ];
        for (k, c) in model.mixture.components.iter().enumerate() {
            let Ok(alone) = Mixture::new(vec![Component { weight: 1.0, ..*c }]) else { continue };
            let alone = |v: f64| c.weight * alone.cdf(v);
            curves.push((format!("component {}", k + 1), binned(alone, end, &seen)));
        }
        findings.charts.push(Chart { y_log: true, ..chart("mixture", "cₜ", "density", curves) });
        let rows = model.mixture.components.iter().enumerate();
        let row = |(k, c): (usize, &Component)| {
            let values = [c.weight, c.shape, c.scale, c.mean()];
            ((k + 1).to_string(), values.into_iter().map(Some).collect())
        };
        findings.tables.push(Grid {
            name: "components".to_string(),
            corner: "component".to_string(),
            columns: ["weight γ", "shape η", "scale θ", "mean"].map(String::from).to_vec(),
            rows: rows.map(row).collect(),
        });
        let row = |o: &consistency::Order| {
            let values = [o.log_likelihood / model.samples as f64, o.wins_daic as f64, o.wins_dbic as f64];
            (o.components.to_string(), values.into_iter().map(Some).collect())
        };
        findings.tables.push(Grid {
            name: "orders".to_string(),
            corner: "components K".to_string(),
            columns: ["log-likelihood a sample", "weights won by dAIC", "weights won by dBIC"]
                .map(String::from)
                .to_vec(),
            rows: model.orders.iter().map(row).collect(),
        });
        let number = |name: &str, value: usize| (name.to_string(), value as f64);
        findings.numbers.extend([
            ("samples".to_string(), model.samples as f64),
            ("floored".to_string(), model.clipped.floored as f64),
            number("components", model.mixture.components.len()),
            number("components-daic", model.order_daic),
            number("components-dbic", model.order_dbic),
        ]);
    }

    /// Rival families for three errors.
    fn families(&self, population: &Population<'_>, findings: &mut Findings) {
        let mut rows = Vec::new();
        let mut gamma_best = true;
        for (tau, name) in self.0.family_taus.iter().zip(FITS) {
            let samples = changes(population, *tau);
            let end = end_of(&samples);
            let one = |family: &Family| {
                // A family that cannot be fitted has no value; too few samples are no fault of the data.
                let fit = distribution::fit(*family, &samples).ok()?;
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
            findings.charts.push(Chart { y_log: true, ..chart(name, "cₜ", "density", curves) });
            let distances: Vec<Option<f64>> = fits.iter().map(|f| f.as_ref().map(|(_, d)| *d)).collect();
            let gamma = Family::ALL.iter().position(|f| *f == Family::Gamma).and_then(|g| distances[g]);
            gamma_best &= gamma.is_some_and(|g| distances.iter().flatten().all(|d| *d >= g));
            rows.push((format!("{tau} ({} samples)", samples.len()), distances));
        }
        findings.tables.push(Grid {
            name: "families".to_string(),
            corner: "error below".to_string(),
            columns: Family::ALL.iter().map(|f| f.name().to_string()).collect(),
            rows,
        });
        findings.numbers.push(("gamma-best".to_string(), f64::from(u8::from(gamma_best))));
    }

    /// Two suites: distances of the distributions of sums, and of their cut values.
    fn compare(
        &self,
        first: &Population<'_>,
        second: &Population<'_>,
        findings: &mut Findings,
    ) -> Result<(), AnalysisError> {
        let grid = accumulation::Grid::default();
        let one = |a: &[f64], b: &[f64], length: usize| {
            let sum = |samples: &[f64]| Accumulated::from_samples(samples, length, &grid);
            let (a, b) = (sum(a)?, sum(b)?);
            // Both have their masses on the same grid.
            let points = a.masses().chain(b.masses()).map(|(v, _)| v + grid.step / 2.0);
            let distance = kolmogorov::two_distributions(|v| a.cdf(v), |v| b.cdf(v), points);
            let (x, y) = (a.upper_quantile(self.0.alpha)?, b.upper_quantile(self.0.alpha)?);
            Ok((distance, (x - y).abs() / x.min(y)))
        };
        let samples: Vec<_> =
            self.0.taus.par_iter().map(|tau| (changes(first, *tau), changes(second, *tau))).collect();
        let of_tau = |(a, b): &(Vec<f64>, Vec<f64>)| -> Result<Vec<Option<(f64, f64)>>, AccumulationError> {
            if a.is_empty() || b.is_empty() {
                return Ok(vec![None; self.0.lengths.len()]);
            }
            self.0.lengths.iter().map(|length| one(a, b, *length).map(Some)).collect()
        };
        let values = samples.par_iter().map(of_tau).collect::<Result<Vec<_>, _>>();
        let values = values.map_err(AnalysisError::Compared)?;
        let columns: Vec<String> = self.0.lengths.iter().map(|l| format!("L = {l}")).collect();
        type Pick = fn(&(f64, f64)) -> f64;
        let parts: [(&str, &str, Pick); 2] = [
            ("similarity", "largest distance of the distributions", |v| v.0),
            ("cut-difference", "D = |β₁ - β₂| / min(β₁, β₂)", |v| v.1),
        ];
        for (name, y, pick) in parts {
            let value = |t: usize, l: usize| values[t][l].as_ref().map(pick);
            let taus = || self.0.taus.iter().enumerate();
            let curve = |(l, label): (usize, &String)| {
                let points = taus().filter_map(|(t, tau)| Some((*tau, value(t, l)?)));
                (label.clone(), points.collect())
            };
            let curves = columns.iter().enumerate().map(curve).collect();
            findings.charts.push(chart(name, "error below τ", y, curves));
            let row = |(t, tau): (usize, &f64)| {
                (tau.to_string(), (0..self.0.lengths.len()).map(|l| value(t, l)).collect())
            };
            findings.tables.push(Grid {
                name: name.to_string(),
                corner: "error below τ".to_string(),
                columns: columns.clone(),
                rows: taus().map(row).collect(),
            });
        }
        let test = |(a, b): &(Vec<f64>, Vec<f64>)| {
            two_sample_test(a, b).map_or(vec![None; 5], |v| v.map(Some).to_vec())
        };
        findings.tables.push(Grid {
            name: "test".to_string(),
            corner: "error below τ".to_string(),
            columns: ["distance", "critical at 5 %", "p", "values of the first", "values of the second"]
                .map(String::from)
                .to_vec(),
            rows: self.0.taus.iter().map(f64::to_string).zip(samples.iter().map(test)).collect(),
        });
        let of_model = two_sample_test(&changes(first, self.0.tau), &changes(second, self.0.tau));
        let differs = of_model.is_some_and(|[distance, critical, ..]| distance > critical);
        findings.numbers.push(("different".to_string(), f64::from(u8::from(differs))));
        Ok(())
    }
}

/// The two-sample test of ascending samples: distance, critical value, p, and their numbers.
pub(super) fn two_sample_test(a: &[f64], b: &[f64]) -> Option<[f64; 5]> {
    if a.is_empty() || b.is_empty() {
        return None;
    }
    let distance = kolmogorov::two_samples(a, b);
    let size = kolmogorov::effective_size(a.len(), b.len());
    let (critical, p) = (kolmogorov::critical(LEVEL, size), kolmogorov::p_value(distance, size));
    Some([distance, critical, p, a.len() as f64, b.len() as f64])
}

fn by_order(terms: &[Terms], value: impl Fn(&Terms) -> f64) -> Vec<(f64, f64)> {
    terms.iter().map(|t| (t.k as f64, value(t))).collect()
}
