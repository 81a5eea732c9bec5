//! Starting points of the iterations: moments of groups of samples.
//!
//! A group of samples with mean `m` and variance `v` gives `shape = m^2 / v` and `scale = v / m`. The
//! groups are: equal counts in ascending order; the posteriors of a normal mixture on `x^(1/3)`, in which
//! a Gamma variable is nearly normal (Wilson and Hilferty 1931; the default of mixtools' `gammamixEM`);
//! the cells nearest, on the scale of `ln x`, to centers drawn at random; and a model with one component
//! less, of which one component is split in two.

use super::binned::Cells;
use super::{Component, MIN_WEIGHT};
use rand::{Rng, RngExt};

/// Least and largest shape at a start. Beyond them a component is too narrow or too wide to attract samples.
const SHAPES: [f64; 2] = [0.05, 1e3];

/// Number of iterations of the normal mixture.
const NORMAL_ITERATIONS: usize = 50;

/// Sums `sum w`, `sum w x` and `sum w x^2` of a group.
#[derive(Clone, Copy, Default)]
struct Group([f64; 3]);

impl Group {
    fn add(&mut self, w: f64, x: f64) {
        self.0[0] += w;
        self.0[1] += w * x;
        self.0[2] += w * x * x;
    }

    fn mean_and_variance(&self) -> (f64, f64) {
        let [w, x, xx] = self.0;
        let mean = x / w;
        (mean, (xx / w - mean * mean).max(0.0))
    }
}

fn components(groups: &[Group], total: f64) -> Vec<Component> {
    let whole: f64 = groups.iter().map(|g| (g.0[0] / total).max(MIN_WEIGHT)).sum();
    let component = |group: &Group| {
        let (mean, variance) = group.mean_and_variance();
        let mean = if mean > 0.0 && mean.is_finite() { mean } else { 1.0 };
        let shape = (mean * mean / variance.max(f64::MIN_POSITIVE)).clamp(SHAPES[0], SHAPES[1]);
        Component { weight: (group.0[0] / total).max(MIN_WEIGHT) / whole, shape, scale: mean / shape }
    };
    groups.iter().map(component).collect()
}

/// Start from `k` groups of equal counts. Cells on a border are shared.
pub(super) fn quantiles(cells: &Cells, k: usize) -> Vec<Component> {
    components(&equal_groups(cells, k, &cells.x), cells.total)
}

fn equal_groups(cells: &Cells, k: usize, x: &[f64]) -> Vec<Group> {
    let mut groups = vec![Group::default(); k];
    let size = cells.total / k as f64;
    let mut before = 0.0;
    for (&n, &x) in cells.count.iter().zip(x) {
        let end = before + n;
        let first = ((before / size) as usize).min(k - 1);
        for (g, group) in groups.iter_mut().enumerate().skip(first) {
            let low = size * g as f64;
            let high = if g + 1 == k { cells.total } else { low + size };
            let share = end.min(high) - before.max(low);
            if share > 0.0 {
                group.add(share, x);
            }
            if end <= high {
                break;
            }
        }
        before = end;
    }
    groups
}

/// Start from the posteriors of a mixture of `k` normal distributions on `x^(1/3)`.
pub(super) fn cube_root(cells: &Cells, k: usize) -> Vec<Component> {
    let root: Vec<f64> = cells.x.iter().map(|x| x.cbrt()).collect();
    let mut groups = equal_groups(cells, k, &root);
    // A thousandth of the spread, in case a normal distribution closes in on one cell.
    let spread = root.last().unwrap_or(&1.0) - root.first().unwrap_or(&0.0);
    let least = (1e-3 * spread).max(1e-9).powi(2);
    let mut original = equal_groups(cells, k, &cells.x);
    let mut log_density = vec![0.0; k];
    for _ in 0..NORMAL_ITERATIONS {
        let normal = |g: &Group| {
            let (mean, variance) = g.mean_and_variance();
            let variance = variance.max(least);
            [(g.0[0] / cells.total).max(MIN_WEIGHT).ln() - 0.5 * variance.ln(), mean, 0.5 / variance]
        };
        let normal: Vec<[f64; 3]> = groups.iter().map(normal).collect();
        let mut next = vec![Group::default(); k];
        original = vec![Group::default(); k];
        for ((&n, &y), &x) in cells.count.iter().zip(&root).zip(&cells.x) {
            let mut largest = f64::NEG_INFINITY;
            for (l, [constant, mean, rate]) in log_density.iter_mut().zip(&normal) {
                // A group that has lost all its samples has no mean.
                *l =
                    if mean.is_nan() { f64::NEG_INFINITY } else { constant - rate * (y - mean) * (y - mean) };
                largest = largest.max(*l);
            }
            let sum: f64 = log_density.iter().map(|l| (l - largest).exp()).sum();
            for ((l, next), original) in log_density.iter().zip(&mut next).zip(&mut original) {
                let r = n * (l - largest).exp() / sum;
                next.add(r, y);
                original.add(r, x);
            }
        }
        groups = next;
    }
    components(&original, cells.total)
}

/// Start from the cells nearest to `k` different samples drawn at random.
pub(super) fn random<R: Rng + ?Sized>(cells: &Cells, k: usize, rng: &mut R) -> Vec<Component> {
    let mut centers: Vec<usize> = Vec::with_capacity(k);
    // Some draws pick a cell, the others a sample: samples alone hardly ever start in a thin tail.
    while centers.len() < k.min(cells.x.len()) {
        let mut at = rng.random_range(0..cells.x.len());
        if rng.random::<f64>() < 0.7 {
            let mut left = rng.random::<f64>() * cells.total;
            let is_drawn = |n: &f64| {
                left -= n;
                left < 0.0
            };
            at = cells.count.iter().position(is_drawn).unwrap_or(at);
        }
        if !centers.contains(&at) {
            centers.push(at);
        }
    }
    let mut groups = vec![Group::default(); k];
    for ((&n, &x), &ln) in cells.count.iter().zip(&cells.x).zip(&cells.ln) {
        let distance = |&c: &usize| (cells.ln[c] - ln).abs();
        let nearest =
            (0..centers.len()).min_by(|&a, &b| distance(&centers[a]).total_cmp(&distance(&centers[b])));
        groups[nearest.unwrap_or(0)].add(n, x);
    }
    components(&groups, cells.total)
}

/// Model with component `at` split in halves, whose means are half a standard deviation (at most half the
/// mean), times `apart`, to either side. With `apart = 0` the halves are equal, and so the likelihood is that
/// of the model.
pub(super) fn split(model: &[Component], at: usize, apart: f64) -> Vec<Component> {
    let mut out = model.to_vec();
    let c = model[at];
    let reach = apart * 0.5_f64.min(0.5 / c.shape.sqrt());
    out[at] = Component { weight: c.weight / 2.0, scale: c.scale * (1.0 - reach), ..c };
    out.push(Component { weight: c.weight / 2.0, scale: c.scale * (1.0 + reach), ..c });
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::gamma_mixture::Binned;

    #[test]
    fn groups_of_equal_counts_share_a_cell_on_their_border() {
        // Six samples in two cells, 1 1 1 1 | 4 4: halves are {1 1 1} and {1 4 4}.
        let cells = Binned::new([1.0, 4.0, 1.0, 1.0, 4.0, 1.0]).unwrap().cells(1);
        let groups = equal_groups(&cells, 2, &cells.x);
        assert_eq!(groups[0].0, [3.0, 3.0, 3.0]);
        assert_eq!(groups[1].0, [3.0, 9.0, 33.0]);
        let start = quantiles(&cells, 2);
        // Mean 3 and variance 2: shape 4.5.
        assert!((start[1].shape - 4.5).abs() < 1e-12 && (start[1].mean() - 3.0).abs() < 1e-12);
    }

    #[test]
    fn the_cube_root_start_separates_distant_groups() {
        let x =
            (0..1000).map(f64::from).map(|i| if i % 4.0 == 0.0 { 8.0 + 0.001 * i } else { 0.5 + 0.0001 * i });
        let start = cube_root(&Binned::new(x).unwrap().cells(1), 2);
        assert!((start[0].weight - 0.75).abs() < 1e-9 && (start[1].mean() - 8.498).abs() < 1e-6, "{start:?}");
    }

    #[test]
    fn a_split_keeps_weight_and_mean() {
        let model = [Component { weight: 1.0, shape: 4.0, scale: 2.0 }];
        let halves = split(&model, 0, 1.0);
        assert_eq!((halves[0].mean(), halves[1].mean()), (6.0, 10.0));
        assert_eq!(halves[0].weight + halves[1].weight, 1.0);
    }
}
