//! Sparse coding: least squares with an L1 penalty, by coordinate descent (Friedman, Hastie and Tibshirani,
//! "Regularization paths for generalized linear models via coordinate descent", J. Stat. Softw. 33(1), 2010,
//! Eq. 5 and section 2.2, "covariance updates").
//!
//! ```text
//! minimise  1/2 |y - D b|^2 + lambda |b|_1                   over all b, or over b >= 0
//! g = D'(y - D b) = c - G b,        c = D'y,  G = D'D        the residual's correlations
//! b_j <- S(g_j + G_jj b_j, lambda) / G_jj                    S(v, l) = sign(v) max(|v| - l, 0); max(v - l, 0)
//! ```
//!
//! `b` is a minimum exactly when `g_j = lambda sign(b_j)` where `b_j` is not 0 and `|g_j| <= lambda` (free) or
//! `g_j <= lambda` (non-negative) elsewhere. The largest violation of this is the *residual*; the descent stops
//! when it is at most `tolerance`, or after `sweeps` passes. A pass goes through the coordinates in order;
//! between passes through all of them only those that are not 0 are visited, until these are at rest.
//!
//! [`Lasso::solve`] takes the dictionary as its Gram matrix, for many signals and one dictionary.
//! [`Lasso::with_errors`] takes a few orthonormal atoms together with one atom a pixel (the identity), as
//! models of occlusion do, without writing the large matrix down.

use multiversion::multiversion;
use serde::{Deserialize, Serialize};

/// Rows are padded to whole multiples of this.
const LANES: usize = 8;

/// Which coefficients are allowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Sign {
    /// All.
    Free,
    /// 0 and above.
    NonNegative,
}

impl Sign {
    /// Minimum of `1/2 b^2 - v b + lambda |b|`.
    #[inline(always)]
    fn shrink(self, v: f32, lambda: f32) -> f32 {
        match self {
            Self::NonNegative => (v - lambda).max(0.0),
            Self::Free => v - v.clamp(-lambda, lambda),
        }
    }

    /// How far the correlation `g` is from that of a minimum at `b`.
    #[inline(always)]
    fn violation(self, g: f32, b: f32, lambda: f32) -> f32 {
        if b != 0.0 {
            (g - lambda.copysign(b)).abs()
        } else if self == Self::Free {
            (g.abs() - lambda).max(0.0)
        } else {
            (g - lambda).max(0.0)
        }
    }
}

/// The problem and when its solution is good enough.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lasso {
    /// Weight of the L1 norm, at least 0.
    pub lambda: f32,
    /// Which coefficients are allowed.
    pub sign: Sign,
    /// Largest residual of a solution, above 0; below about 1e-6 of the correlations is rounding.
    pub tolerance: f32,
    /// Most passes through the coordinates.
    pub sweeps: usize,
}

/// How a descent ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Passes through all or the active coordinates.
    pub sweeps: usize,
    /// The residual, at most the tolerance unless the passes ran out.
    pub residual: f32,
}

/// The Gram matrix `G = D'D` of a dictionary.
#[derive(Debug, Clone, PartialEq)]
pub struct Gram {
    atoms: usize,
    stride: usize,
    /// Row by row, each padded with zeros.
    values: Vec<f32>,
}

impl Gram {
    /// Of a dictionary of `atoms` vectors one after the other, each of `length` numbers.
    ///
    /// # Panics
    /// When `dictionary` has not `atoms * length` numbers: a mistake in the caller.
    pub fn new(dictionary: &[f32], atoms: usize, length: usize) -> Self {
        assert_eq!(dictionary.len(), atoms * length, "numbers of a dictionary");
        let stride = atoms.next_multiple_of(LANES);
        let mut values = vec![0.0; atoms * stride];
        let atom = |k: usize| &dictionary[k * length..(k + 1) * length];
        for i in 0..atoms {
            for j in 0..=i {
                let product = dot(atom(i), atom(j));
                values[i * stride + j] = product;
                values[j * stride + i] = product;
            }
        }
        Self { atoms, stride, values }
    }

    /// Number of atoms.
    pub fn atoms(&self) -> usize {
        self.atoms
    }
}

/// Correlations `c = D'y` of a signal with the atoms of a dictionary, laid out as for [`Gram::new`].
///
/// # Panics
/// When `y` is empty: a mistake in the caller.
#[multiversion(targets("x86_64+avx2"))]
pub fn correlate(dictionary: &[f32], y: &[f32], correlations: &mut [f32]) {
    // Four atoms at once share what is loaded of `y`.
    let (n, mut atoms) = (y.len(), 0);
    for (quad, out) in dictionary.chunks_exact(4 * n).zip(correlations.chunks_exact_mut(4)) {
        let mut sums = [[0.0_f32; LANES]; 4];
        let whole = n - n % LANES;
        for at in (0..whole).step_by(LANES) {
            let y = &y[at..at + LANES];
            for (k, sum) in sums.iter_mut().enumerate() {
                let d = &quad[k * n + at..k * n + at + LANES];
                for l in 0..LANES {
                    sum[l] += d[l] * y[l];
                }
            }
        }
        for (k, (out, sum)) in out.iter_mut().zip(sums).enumerate() {
            let rest: f32 = (whole..n).map(|at| quad[k * n + at] * y[at]).sum();
            *out = fold(sum) + rest;
        }
        atoms += 4;
    }
    for (d, out) in dictionary.chunks_exact(n).zip(correlations).skip(atoms) {
        *out = dot_of(d, y);
    }
}

impl Lasso {
    /// Improves `b`, one number an atom, from where it is (zeros are a good start) to a minimum for the
    /// correlations `c` with the atoms. Where the start is not allowed it is taken as 0.
    ///
    /// Atoms of length 0 keep the coefficient 0. `gradient` is a buffer, whatever it holds.
    ///
    /// # Panics
    /// When `correlations` or `b` have not as many numbers as there are atoms: a mistake in the caller.
    pub fn solve(
        &self,
        gram: &Gram,
        correlations: &[f32],
        b: &mut [f32],
        gradient: &mut Vec<f32>,
    ) -> Outcome {
        assert_eq!((correlations.len(), b.len()), (gram.atoms, gram.atoms), "numbers of a solution");
        if self.sign == Sign::NonNegative {
            b.iter_mut().for_each(|b| *b = b.max(0.0));
        }
        gradient.clear();
        gradient.extend_from_slice(correlations);
        gradient.resize(gram.stride, 0.0);
        descend(self, gram, b, gradient)
    }

    /// Codes `x` by orthonormal `atoms` and an error a pixel, `x = sum_k z_k u_k + e` as nearly as the L1 norm of
    /// `z` and `e` lets it: the lasso with the dictionary `[u_1 ... u_k, I]`.
    ///
    /// Gives `z`, `e` and the outcome. A pass visits the atoms in order, then all errors at once.
    ///
    /// # Panics
    /// When an atom is not as long as `x`: a mistake in the caller.
    pub fn with_errors(&self, atoms: &[Vec<f32>], x: &[f32]) -> (Vec<f32>, Vec<f32>, Outcome) {
        assert!(atoms.iter().all(|u| u.len() == x.len()), "length of the atoms");
        let (mut z, mut e) = (vec![0.0; atoms.len()], vec![0.0; x.len()]);
        // What is left of `x`.
        let mut rest = x.to_vec();
        let mut outcome = Outcome { sweeps: 0, residual: f32::INFINITY };
        while outcome.sweeps < self.sweeps && outcome.residual > self.tolerance {
            for (z, u) in z.iter_mut().zip(atoms) {
                let new = self.sign.shrink(dot(u, &rest) + *z, self.lambda);
                let change = new - *z;
                rest.iter_mut().zip(u).for_each(|(r, u)| *r -= change * u);
                *z = new;
            }
            for (e, r) in e.iter_mut().zip(&mut rest) {
                let whole = *r + *e;
                *e = self.sign.shrink(whole, self.lambda);
                *r = whole - *e;
            }
            // The errors are at their minimum for these atoms.
            outcome.residual = z.iter().zip(atoms).fold(0.0, |worst: f32, (z, u)| {
                worst.max(self.sign.violation(dot(u, &rest), *z, self.lambda))
            });
            outcome.sweeps += 1;
        }
        (z, e, outcome)
    }
}

/// The descent of [`Lasso::solve`]; `gradient` holds `c`, padded with zeros.
#[multiversion(targets("x86_64+avx2"))]
fn descend(lasso: &Lasso, gram: &Gram, b: &mut [f32], gradient: &mut [f32]) -> Outcome {
    let Lasso { lambda, sign, tolerance, sweeps } = *lasso;
    let row = |j: usize| &gram.values[j * gram.stride..(j + 1) * gram.stride];
    for (j, b) in b.iter().enumerate().filter(|(_, b)| **b != 0.0) {
        shift(gradient, -*b, row(j));
    }
    let mut active = Vec::with_capacity(b.len());
    let mut done = 0;
    loop {
        // The residual before the pass is that of the solution so far.
        let mut residual = 0.0_f32;
        for (j, b) in b.iter().enumerate() {
            if gram.values[j * gram.stride + j] > 0.0 {
                residual = residual.max(sign.violation(gradient[j], *b, lambda));
            }
        }
        if residual <= tolerance || done >= sweeps {
            return Outcome { sweeps: done, residual };
        }
        active.clear();
        for j in 0..b.len() {
            step(sign, lambda, row(j), j, b, gradient);
            if b[j] != 0.0 {
                active.push(j);
            }
        }
        done += 1;
        while done < sweeps {
            let mut worst = 0.0_f32;
            for &j in &active {
                worst = worst.max(sign.violation(gradient[j], b[j], lambda));
            }
            if worst <= tolerance {
                break;
            }
            for &j in &active {
                step(sign, lambda, row(j), j, b, gradient);
            }
            done += 1;
        }
    }
}

/// Brings coordinate `j` to its minimum.
#[inline(always)]
fn step(sign: Sign, lambda: f32, row: &[f32], j: usize, b: &mut [f32], gradient: &mut [f32]) {
    let own = row[j];
    if own > 0.0 {
        let new = sign.shrink(gradient[j] + own * b[j], lambda) / own;
        let change = new - b[j];
        if change != 0.0 {
            b[j] = new;
            shift(gradient, -change, row);
        }
    }
}

/// `to += by * x` on whole lanes.
#[inline(always)]
fn shift(to: &mut [f32], by: f32, x: &[f32]) {
    for (to, x) in to.chunks_exact_mut(LANES).zip(x.chunks_exact(LANES)) {
        for l in 0..LANES {
            to[l] += by * x[l];
        }
    }
}

/// The sum of products, in lanes.
#[multiversion(targets("x86_64+avx2"))]
fn dot(a: &[f32], b: &[f32]) -> f32 {
    dot_of(a, b)
}

#[inline(always)]
fn dot_of(a: &[f32], b: &[f32]) -> f32 {
    let (a, b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f32 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    let mut sum = [0.0; LANES];
    for (a, b) in a.zip(b) {
        for l in 0..LANES {
            sum[l] += a[l] * b[l];
        }
    }
    fold(sum) + rest
}

/// The sum of the lanes.
#[inline(always)]
fn fold(s: [f32; LANES]) -> f32 {
    ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const LENGTH: usize = 21;

    fn lasso(lambda: f32, sign: Sign) -> Lasso {
        Lasso { lambda, sign, tolerance: 1e-6, sweeps: 100_000 }
    }

    /// The dictionary and the signal of the Python calls below.
    fn example() -> (Vec<f32>, Vec<f32>) {
        let dictionary =
            (0..9).flat_map(|k| (0..LENGTH).map(move |i| ((7 * k + 3 * i + k * i) as f32).sin())).collect();
        let y = (0..LENGTH).map(|i| (0.3 * i as f32).cos() + 0.2 * ((5 * i) as f32).sin()).collect();
        (dictionary, y)
    }

    fn solved(lasso: &Lasso, dictionary: &[f32], y: &[f32], b: &mut [f32]) -> Outcome {
        let mut c = vec![0.0; b.len()];
        correlate(dictionary, y, &mut c);
        lasso.solve(&Gram::new(dictionary, b.len(), y.len()), &c, b, &mut vec![])
    }

    // python3: import numpy as np; from sklearn.linear_model import Lasso; i=np.arange(21.)[:,None]; k=np.arange(9)
    // D=np.sin(7*k+3*i+k*i); y=np.cos(.3*i[:,0])+.2*np.sin(5*i[:,0])
    // for positive in (False,True): print(Lasso(alpha=.1/21,fit_intercept=False,positive=positive,tol=1e-14,
    //   max_iter=10**6).fit(D,y).coef_)
    #[test]
    fn agrees_with_scikit_learn() {
        let (dictionary, y) = example();
        for (sign, want) in [(Sign::Free, FREE), (Sign::NonNegative, POSITIVE)] {
            let mut b = vec![0.0; 9];
            solved(&lasso(0.1, sign), &dictionary, &y, &mut b);
            for (b, want) in b.iter().zip(want) {
                assert!((f64::from(*b) - want).abs() < 2e-5, "{sign:?}: {b} {want}");
            }
        }
    }
    const FREE: [f64; 9] = [
        -0.0,
        0.00011844146706669386,
        0.07291597238533679,
        0.664897771652466,
        -0.06826918782148321,
        -0.03200192715686501,
        -0.0,
        -0.03984781806821826,
        -0.02006842492649003,
    ];
    const POSITIVE: [f64; 9] = [0.0, 0.0, 0.08402870529283697, 0.6823360277052, 0.0, 0.0, 0.0, 0.0, 0.0];

    const FREE_ERRORS: [f64; 6] = [2.9152151888023425, -0.0, 0.0, 0.020345061014852603, -0.0, 0.0];
    const POSITIVE_ERRORS: [f64; 6] = [3.1068299030031215, 0.0, 0.0, 0.0, 0.0, 0.0];

    // python3, as above: t=2*np.pi*i/21; U=np.sqrt(2/21)*np.c_[np.cos(t),np.sin(t),np.cos(2*t)]
    // Lasso(alpha=.08/21,...).fit(np.c_[U,np.eye(21)],y).coef_[[0,1,2,3,8,20]], for both signs
    #[test]
    fn with_errors_agrees_with_scikit_learn() {
        let (_, y) = example();
        let atoms = [0, 1, 2].map(|k| {
            let wave = |i: usize| {
                let t = std::f64::consts::TAU * i as f64 / 21.0;
                ((2.0_f64 / 21.0).sqrt() * [t.cos(), t.sin(), (2.0 * t).cos()][k]) as f32
            };
            (0..LENGTH).map(wave).collect()
        });
        for (sign, want) in [(Sign::Free, FREE_ERRORS), (Sign::NonNegative, POSITIVE_ERRORS)] {
            let (z, e, outcome) = lasso(0.08, sign).with_errors(&atoms, &y);
            assert!(outcome.residual <= 1e-6);
            for (ours, want) in [z[0], z[1], z[2], e[0], e[5], e[17]].into_iter().zip(want) {
                assert!((f64::from(ours) - want).abs() < 2e-5, "{sign:?}: {ours} {want}");
            }
        }
    }

    // By hand: orthogonal atoms of length 2 decouple, b = S(c, lambda) / 4.
    #[test]
    fn orthogonal_atoms_are_solved_in_one_pass() {
        let mut b = [0.0; 4];
        let dictionary = [2.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0];
        let free = lasso(1.0, Sign::Free);
        let outcome = solved(&free, &dictionary, &[1.5, -2.5, 0.25], &mut b);
        assert_eq!((b, outcome), ([0.5, -1.0, 0.0, 0.0], Outcome { sweeps: 1, residual: 0.0 }));
        solved(&lasso(1.0, Sign::NonNegative), &dictionary, &[1.5, -2.5, 0.25], &mut b);
        assert_eq!(b, [0.5, 0.0, 0.0, 0.0]);
        // A pass too few: what is left is said.
        let none = Lasso { sweeps: 0, ..free };
        b.fill(0.0);
        assert_eq!(
            solved(&none, &dictionary, &[1.5, -2.5, 0.25], &mut b),
            Outcome { sweeps: 0, residual: 4.0 }
        );
    }

    fn signs() -> impl Strategy<Value = Sign> {
        prop_oneof![Just(Sign::Free), Just(Sign::NonNegative)]
    }

    proptest! {
        // The conditions of a minimum, from the definition and in f64.
        #[test]
        fn solutions_are_minima(
            dictionary in prop::collection::vec(-1.0..1.0_f32, 12 * LENGTH),
            y in prop::collection::vec(-1.0..1.0_f32, LENGTH),
            start in prop::collection::vec(0.0..1.0_f32, 12),
            lambda in 0.01..2.0_f32,
            sign in signs(),
        ) {
            let mut b = start;
            let outcome = solved(&lasso(lambda, sign), &dictionary, &y, &mut b);
            prop_assert!(outcome.residual <= 1e-6 || outcome.sweeps == 100_000);
            let rest: Vec<f64> = (0..LENGTH)
                .map(|i| f64::from(y[i]) - (0..12).map(|k| f64::from(b[k]) * f64::from(dictionary[k * LENGTH + i])).sum::<f64>())
                .collect();
            for k in 0..12 {
                let g: f64 = (0..LENGTH).map(|i| rest[i] * f64::from(dictionary[k * LENGTH + i])).sum();
                let (b, lambda) = (f64::from(b[k]), f64::from(lambda));
                let slack = 1e-4;
                if b != 0.0 {
                    prop_assert!((g - lambda * b.signum()).abs() < slack, "{k}: {b} {g}");
                } else {
                    prop_assert!(g <= lambda + slack && (sign == Sign::NonNegative || g >= -lambda - slack));
                }
                prop_assert!(sign == Sign::Free || b >= 0.0);
            }
        }

        #[test]
        fn both_forms_agree(
            x in prop::collection::vec(-1.0..1.0_f32, LENGTH),
            angles in prop::array::uniform2(0.0..6.3_f32),
            lambda in 0.01..0.5_f32,
            sign in signs(),
        ) {
            // Two orthonormal atoms and the identity, written down.
            let mut atoms = vec![vec![0.0; LENGTH]; 2];
            for (k, angle) in angles.into_iter().enumerate() {
                (atoms[k][10 * k], atoms[k][10 * k + 7]) = (angle.cos(), angle.sin());
            }
            let mut dictionary: Vec<f32> = atoms.concat();
            dictionary.extend((0..LENGTH * LENGTH).map(|n| if n % LENGTH == n / LENGTH { 1.0 } else { 0.0 }));
            let problem = lasso(lambda, sign);
            let mut b = vec![0.0; LENGTH + 2];
            solved(&problem, &dictionary, &x, &mut b);
            let (z, e, _) = problem.with_errors(&atoms, &x);
            // Minimisers need not be unique, minima are.
            let value = |z: &[f32], e: &[f32]| -> f64 {
                let square: f64 = (0..LENGTH)
                    .map(|i| f64::from(x[i] - e[i] - z[0] * atoms[0][i] - z[1] * atoms[1][i]).powi(2))
                    .sum();
                square / 2.0 + f64::from(lambda) * z.iter().chain(e).map(|v| f64::from(v.abs())).sum::<f64>()
            };
            prop_assert!((value(&b[..2], &b[2..]) - value(&z, &e)).abs() < 1e-4);
        }
    }
}
