//! Sparse coding: least squares with an L1 penalty.
//!
//! ```text
//! minimize  1/2 |y - D b|^2 + lambda |b|_1                   over all b, or over b >= 0
//! g = D'(y - D b) = c - G b,        c = D'y,  G = D'D        the residual's correlations
//! ```
//!
//! `b` is a minimum exactly when `g_j = lambda sign(b_j)` where `b_j` is not 0 and `|g_j| <= lambda` (free) or
//! `g_j <= lambda` (non-negative) elsewhere. The largest violation of this is the *residual*; a solution is good
//! when it is at most `tolerance`.
//!
//! [`Lasso::solve`] takes the dictionary as its Gram matrix, for many signals and one dictionary. It keeps a set
//! A of active coordinates with signs s (Lee, Battle, Raina and Ng, "Efficient sparse coding algorithms", NIPS
//! 2006, algorithm 1; with `b >= 0` that of Lawson and Hanson, "Solving least squares problems", 1974,
//! chapter 23):
//!
//! ```text
//! the largest violation outside A enters it
//! G_AA x = c_A - lambda s_A                                  Cholesky
//! b_A <- x when the signs are s; else as far towards x as they are, what is 0 there leaves A, and again
//! ```
//!
//! This ends at the minimum after about as many rounds as it has coefficients. Coordinate descent alone needs
//! hundreds of passes for atoms as similar as patches of successive frames; it is used where
//! active atoms depend on each other (Friedman, Hastie and Tibshirani, "Regularization paths for generalized
//! linear models via coordinate descent", J. Stat. Softw. 33(1), 2010, Eq. 5):
//!
//! ```text
//! b_j <- S(g_j + G_jj b_j, lambda) / G_jj                    S(v, l) = sign(v) max(|v| - l, 0); max(v - l, 0)
//! ```
//!
//! in order, between passes through all coordinates only through those that are not 0. [`Lasso::with_errors`] takes
//! a few orthonormal atoms together with one atom a pixel (the identity), as models of occlusion do, and
//! descends without writing the large matrix down.

use multiversion::multiversion;

/// Rows are padded to a multiple of this length.
const LANES: usize = 8;

/// Allowed signs of the coefficients.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sign {
    /// Any sign.
    Free,
    /// Zero or positive.
    NonNegative,
}

impl Sign {
    /// Minimizer of `1/2 b^2 - v b + lambda |b|`.
    #[inline(always)]
    fn shrink(self, v: f32, lambda: f32) -> f32 {
        match self {
            Self::NonNegative => (v - lambda).max(0.0),
            Self::Free => v - v.clamp(-lambda, lambda),
        }
    }

    /// Violation of the optimality condition by the correlation `g` at the coefficient `b`.
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

/// A problem of sparse coding, with the tolerance of its solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lasso {
    /// Weight of the L1 norm, at least 0.
    pub lambda: f32,
    /// Allowed signs of the coefficients.
    pub sign: Sign,
    /// Largest residual of a solution, above 0. Below about 1e-6 of the correlations it is rounding error.
    pub tolerance: f32,
    /// Most rounds: solutions for an active set, and passes over coordinates.
    pub rounds: usize,
}

/// Outcome of a solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Number of rounds: solutions for an active set, and passes over coordinates.
    pub rounds: usize,
    /// Residual, at most the tolerance unless the rounds ran out.
    pub residual: f32,
}

/// Buffers of [`Lasso::solve`], whose contents need not be kept.
#[derive(Debug, Clone, Default)]
pub struct Work {
    gradient: Vec<f32>,
    active: Vec<usize>,
    /// Cholesky factor of `G_AA`, by row.
    factor: Vec<f64>,
    /// Solution `x` for the active set.
    target: Vec<f64>,
}

/// The Gram matrix `G = D'D` of a dictionary.
#[derive(Debug, Clone, PartialEq)]
pub struct Gram {
    atoms: usize,
    stride: usize,
    /// Rows of the matrix, each padded with zeros.
    values: Vec<f32>,
}

impl Gram {
    /// Gram matrix of a dictionary of `atoms` vectors of `length` numbers each, one after the other.
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
    let n = y.len();
    let (whole, rest) = y.as_chunks::<LANES>();
    let mut quads = dictionary.chunks_exact(4 * n);
    let mut outs = correlations.chunks_exact_mut(4);
    // Four atoms at once share the loads of `y`.
    for (quad, out) in (&mut quads).zip(&mut outs) {
        let (ab, cd) = quad.split_at(2 * n);
        let ((a, b), (c, d)) = (ab.split_at(n), cd.split_at(n));
        let [(a, at), (b, bt), (c, ct), (d, dt)] = [a, b, c, d].map(|v| v.as_chunks::<LANES>());
        let (mut p, mut q, mut r, mut s) = ([0.0; LANES], [0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for ((((y, a), b), c), d) in whole.iter().zip(a).zip(b).zip(c).zip(d) {
            accumulate(&mut p, a, y);
            accumulate(&mut q, b, y);
            accumulate(&mut r, c, y);
            accumulate(&mut s, d, y);
        }
        for ((out, sum), tail) in out.iter_mut().zip([p, q, r, s]).zip([at, bt, ct, dt]) {
            *out = fold(sum) + tail.iter().zip(rest).map(|(d, y)| d * y).sum::<f32>();
        }
    }
    for (d, out) in quads.remainder().chunks_exact(n).zip(outs.into_remainder()) {
        *out = dot_of(d, y);
    }
}

impl Lasso {
    /// Moves `b`, one coefficient per atom, from its current value (zeros are a good start) to a minimum for
    /// the correlations `c` with the atoms. Values of a forbidden sign are set to 0 first.
    ///
    /// Atoms of length 0 keep their coefficient.
    ///
    /// # Panics
    /// When `correlations` or `b` have not as many numbers as there are atoms: a mistake in the caller.
    pub fn solve(&self, gram: &Gram, correlations: &[f32], b: &mut [f32], work: &mut Work) -> Outcome {
        assert_eq!((correlations.len(), b.len()), (gram.atoms, gram.atoms), "numbers of a solution");
        if self.sign == Sign::NonNegative {
            b.iter_mut().for_each(|b| *b = b.max(0.0));
        }
        let rounds = activate(self, gram, correlations, b, work);
        descend(self, gram, b, &mut work.gradient, rounds)
    }

    /// Codes `x` by orthonormal `atoms` and one error per pixel: `x = sum_k z_k u_k + e`, as closely as the
    /// L1 norm of `z` and `e` allows. This is the lasso with the dictionary `[u_1 ... u_k, I]`.
    ///
    /// Returns `z`, `e` and the outcome. A pass visits the atoms in order, then all errors at once.
    ///
    /// # Panics
    /// When an atom is not as long as `x`: a mistake in the caller.
    pub fn with_errors(&self, atoms: &[Vec<f32>], x: &[f32]) -> (Vec<f32>, Vec<f32>, Outcome) {
        assert!(atoms.iter().all(|u| u.len() == x.len()), "length of the atoms");
        let (mut z, mut e) = (vec![0.0; atoms.len()], vec![0.0; x.len()]);
        // The residual of `x`.
        let mut rest = x.to_vec();
        let mut outcome = Outcome { rounds: 0, residual: f32::INFINITY };
        while outcome.rounds < self.rounds && outcome.residual > self.tolerance {
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
            outcome.rounds += 1;
        }
        (z, e, outcome)
    }
}

/// Least squared distance of an atom from the span of the other active ones, relative to its squared length.
const MIN_INDEPENDENCE: f64 = 1e-6;

/// Rounds of the active set. Afterwards `work.gradient` is the gradient at `b`.
#[multiversion(targets("x86_64+avx2"))]
fn activate(lasso: &Lasso, gram: &Gram, correlations: &[f32], b: &mut [f32], work: &mut Work) -> usize {
    let Lasso { lambda, sign, tolerance, rounds } = *lasso;
    let Work { gradient, active, factor, target } = work;
    let (n, stride) = (gram.atoms, gram.stride);
    active.clear();
    active.extend((0..n).filter(|&j| b[j] != 0.0));
    factor.resize(n * n, 0.0);
    let mut factored = 0;
    let mut done = 0;
    loop {
        gradient.clear();
        gradient.extend_from_slice(correlations);
        gradient.resize(stride, 0.0);
        for (j, b) in b.iter().enumerate().filter(|(_, b)| **b != 0.0) {
            shift(gradient, -*b, &gram.values[j * stride..(j + 1) * stride]);
        }
        // A start with coefficients is brought to its minimum before others enter.
        if done > 0 || active.is_empty() {
            let mut best = [0.0_f32; LANES];
            for g in gradient.as_chunks::<LANES>().0 {
                for l in 0..LANES {
                    let v = if sign == Sign::Free { g[l].abs() } else { g[l] };
                    best[l] = best[l].max(v);
                }
            }
            let best = best.iter().fold(0.0_f32, |a, b| a.max(*b));
            let enters = gradient.iter().position(|g| *g == best || (sign == Sign::Free && -*g == best));
            match enters {
                Some(j) if best > lambda + tolerance && !active.contains(&j) => active.push(j),
                _ => return done,
            }
        }
        loop {
            if done >= rounds {
                return done;
            }
            done += 1;
            let independent = extend(gram, active, factored, factor);
            factored = active.len();
            if !independent {
                return done;
            }
            // A coordinate that has just entered is 0 and has the sign of its correlation.
            let signed =
                |j: usize| if b[j] != 0.0 { lambda.copysign(b[j]) } else { lambda.copysign(gradient[j]) };
            target.clear();
            target.extend(active.iter().map(|&j| f64::from(correlations[j] - signed(j))));
            substitute(factor, n, target);
            let mut reach = 1.0_f64;
            let mut leaves = None;
            for (k, (&j, x)) in active.iter().zip(target.iter()).enumerate() {
                let b = f64::from(b[j]);
                if x * f64::from(signed(j)) <= 0.0 {
                    let upto = if b == 0.0 { 0.0 } else { b / (b - x) };
                    if leaves.is_none() || upto < reach {
                        (reach, leaves) = (upto, Some(k));
                    }
                }
            }
            for (&j, x) in active.iter().zip(target.iter()) {
                b[j] = (f64::from(b[j]) + reach * (x - f64::from(b[j]))) as f32;
            }
            let Some(k) = leaves else { break };
            // Rounding may have left it near 0.
            b[active[k]] = 0.0;
            active.remove(k);
            factored = k;
            if reach == 0.0 && k == active.len() {
                // The coordinate that has just entered leaves again: there is no more progress.
                return done;
            }
        }
    }
}

/// Extends the Cholesky factor from row `from` on. Returns true if all active atoms are independent.
#[inline(always)]
fn extend(gram: &Gram, active: &[usize], from: usize, factor: &mut [f64]) -> bool {
    let n = gram.atoms;
    for i in from..active.len() {
        let row = &gram.values[active[i] * gram.stride..];
        let (known, new) = factor.split_at_mut(i * n);
        let own = f64::from(row[active[i]]);
        let mut pivot = own;
        for j in 0..i {
            let mut sum = f64::from(row[active[j]]);
            for (a, b) in new[..j].iter().zip(&known[j * n..j * n + j]) {
                sum -= a * b;
            }
            new[j] = sum * known[j * n + j];
            pivot -= new[j] * new[j];
        }
        if pivot <= MIN_INDEPENDENCE * own {
            return false;
        }
        // The diagonal is kept as its reciprocal.
        new[i] = pivot.sqrt().recip();
    }
    true
}

/// Solves `L L' x = x` in place.
#[inline(always)]
fn substitute(factor: &[f64], n: usize, x: &mut [f64]) {
    for i in 0..x.len() {
        let (before, rest) = x.split_at_mut(i);
        let row = &factor[i * n..i * n + i + 1];
        let sum: f64 = before.iter().zip(row).map(|(x, l)| x * l).sum();
        rest[0] = (rest[0] - sum) * row[i];
    }
    for i in (0..x.len()).rev() {
        let (before, rest) = x.split_at_mut(i);
        let row = &factor[i * n..i * n + i + 1];
        rest[0] *= row[i];
        for (x, l) in before.iter_mut().zip(row) {
            *x -= l * rest[0];
        }
    }
}

/// Coordinate descent from `b` with its gradient, after `done` earlier rounds.
#[multiversion(targets("x86_64+avx2"))]
fn descend(lasso: &Lasso, gram: &Gram, b: &mut [f32], gradient: &mut [f32], mut done: usize) -> Outcome {
    let Lasso { lambda, sign, tolerance, rounds } = *lasso;
    let row = |j: usize| &gram.values[j * gram.stride..(j + 1) * gram.stride];
    let mut active = Vec::with_capacity(b.len());
    loop {
        // The residual before the pass is that of the solution so far.
        let mut residual = 0.0_f32;
        for (j, b) in b.iter().enumerate() {
            if gram.values[j * gram.stride + j] > 0.0 {
                residual = residual.max(sign.violation(gradient[j], *b, lambda));
            }
        }
        if residual <= tolerance || done >= rounds {
            return Outcome { rounds: done, residual };
        }
        active.clear();
        for j in 0..b.len() {
            step(sign, lambda, row(j), j, b, gradient);
            if b[j] != 0.0 {
                active.push(j);
            }
        }
        done += 1;
        while done < rounds {
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

/// Moves coordinate `j` to its minimum.
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

/// Computes `to += by * x` on whole lanes.
#[inline(always)]
fn shift(to: &mut [f32], by: f32, x: &[f32]) {
    for (to, x) in to.as_chunks_mut::<LANES>().0.iter_mut().zip(x.as_chunks::<LANES>().0) {
        for l in 0..LANES {
            to[l] += by * x[l];
        }
    }
}

/// Dot product, summed in lanes.
#[multiversion(targets("x86_64+avx2"))]
fn dot(a: &[f32], b: &[f32]) -> f32 {
    dot_of(a, b)
}

#[inline(always)]
fn dot_of(a: &[f32], b: &[f32]) -> f32 {
    let ((a, at), (b, bt)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut sum = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        accumulate(&mut sum, a, b);
    }
    fold(sum) + at.iter().zip(bt).map(|(a, b)| a * b).sum::<f32>()
}

#[inline(always)]
fn accumulate(sum: &mut [f32; LANES], a: &[f32; LANES], b: &[f32; LANES]) {
    for l in 0..LANES {
        sum[l] += a[l] * b[l];
    }
}

/// Sum of the lanes. Not inlined, since its shuffles would slow down the loops before it.
#[inline(never)]
fn fold(s: [f32; LANES]) -> f32 {
    ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]))
}

#[cfg(test)]
mod tests;
