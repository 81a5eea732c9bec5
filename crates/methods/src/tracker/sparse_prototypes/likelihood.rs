//! Distance of a window from a subspace, with and without an occlusion model.
//!
//! Windows, mean and basis are `f32`, so that eight numbers go through a register; sums are made in lanes
//! of a fixed order, which gives the same bits with and without AVX2.

use crate::num::incremental_pca::IncrementalPca;
use multiversion::multiversion;

/// Numbers that are processed together.
const LANES: usize = 16;
/// Pixels whose residuals are computed together; windows are whole multiples of it.
const WIDE: usize = 64;

/// Stopping rule of the alternation, and price of an occluded pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alternation {
    /// Threshold and price of an error, `lambda`.
    pub lambda: f32,
    /// Smallest change of the objective that is worth another iteration.
    pub tolerance: f32,
    /// Most iterations, at least 1.
    pub iterations: usize,
}

/// Mean and basis of the windows so far, whole multiples of `WIDE` numbers.
#[derive(Debug, Clone)]
pub struct Subspace {
    mean: Vec<f32>,
    /// One vector after the other.
    basis: Vec<f32>,
}

/// Buffers of a comparison, and its residuals.
#[derive(Debug, Clone, Default)]
pub struct Comparison {
    difference: Vec<f32>,
    errors: Vec<f32>,
    /// `d - U z` of the comparison's solution.
    pub residuals: Vec<f32>,
    next: Vec<f32>,
    coefficients: Vec<f32>,
}

impl Subspace {
    /// A subspace with this mean and no basis.
    pub fn mean_only(mean: &[f32]) -> Self {
        Self { mean: mean.to_vec(), basis: Vec::new() }
    }

    /// The subspace of principal components.
    pub fn of(pca: &IncrementalPca) -> Self {
        let single = |v: &f64| *v as f32;
        Self {
            mean: pca.mean().iter().map(single).collect(),
            basis: pca.basis().iter().flatten().map(single).collect(),
        }
    }

    /// The mean.
    pub fn mean(&self) -> &[f32] {
        &self.mean
    }

    /// Number of basis vectors.
    pub fn dimension(&self) -> usize {
        self.basis.len() / self.mean.len().max(1)
    }

    /// `|d - U U'd|^2` of the difference `d` of a window from the mean.
    pub fn distance(&self, window: &[f32], work: &mut Comparison) -> f32 {
        work.look(&self.mean, window);
        project(&self.basis, &work.difference, &mut work.coefficients);
        leave(&self.basis, &work.difference, &work.coefficients, &mut work.residuals);
        sum_of(&work.residuals, |r| r * r)
    }

    /// The cost of a window under the occlusion model; see the tracker's module. `work.residuals` are those
    /// of the solution.
    pub fn occluded_distance(&self, window: &[f32], how: &Alternation, work: &mut Comparison) -> f32 {
        let Alternation { lambda, tolerance, iterations } = *how;
        work.look(&self.mean, window);
        // That of the first iteration counts as 0; see the tracker's module.
        let mut objective = 0.0_f32;
        for iteration in 0..iterations {
            if iteration == 0 {
                project(&self.basis, &work.difference, &mut work.coefficients);
            } else {
                unoccluded(&work.difference, &work.residuals, lambda, &mut work.errors);
                project(&self.basis, &work.errors, &mut work.coefficients);
            }
            leave(&self.basis, &work.difference, &work.coefficients, &mut work.next);
            if iteration > 0 {
                let now = penalized(&work.next, lambda);
                if (objective - now).abs() < tolerance {
                    break;
                }
                objective = now;
            }
            std::mem::swap(&mut work.residuals, &mut work.next);
        }
        cost(&work.residuals, lambda)
    }
}

impl Comparison {
    /// Computes the difference from the mean, and resizes the buffers.
    fn look(&mut self, mean: &[f32], window: &[f32]) {
        self.difference.clear();
        self.difference.extend(mean.iter().zip(window).map(|(m, y)| m - y));
        for buffer in [&mut self.errors, &mut self.residuals, &mut self.next] {
            buffer.resize(mean.len(), 0.0);
        }
    }
}

/// The error of a pixel with residual `r`: what exceeds `lambda`.
#[inline(always)]
pub fn error(r: f32, lambda: f32) -> f32 {
    r - r.clamp(-lambda, lambda)
}

/// `d - e` for the errors of the residuals.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn unoccluded(difference: &[f32], residuals: &[f32], lambda: f32, out: &mut [f32]) {
    for ((out, d), r) in out.iter_mut().zip(difference).zip(residuals) {
        *out = d - error(*r, lambda);
    }
}

/// `U'x`.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn project(basis: &[f32], x: &[f32], out: &mut Vec<f32>) {
    out.clear();
    let (x, _) = x.as_chunks::<LANES>();
    let (basis, _) = basis.as_chunks::<LANES>();
    // Additions wait for the one before in their lane, so four vectors take turns.
    let mut quads = basis.chunks_exact(4 * x.len());
    for quad in &mut quads {
        let (ab, cd) = quad.split_at(2 * x.len());
        let ((a, b), (c, d)) = (ab.split_at(x.len()), cd.split_at(x.len()));
        let (mut p, mut q, mut r, mut s) = ([0.0; LANES], [0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for ((((x, a), b), c), d) in x.iter().zip(a).zip(b).zip(c).zip(d) {
            accumulate(&mut p, a, x);
            accumulate(&mut q, b, x);
            accumulate(&mut r, c, x);
            accumulate(&mut s, d, x);
        }
        out.extend([fold(p), fold(q), fold(r), fold(s)]);
    }
    for u in quads.remainder().chunks_exact(x.len()) {
        let mut sum = [0.0_f32; LANES];
        for (u, x) in u.iter().zip(x) {
            accumulate(&mut sum, u, x);
        }
        out.push(fold(sum));
    }
}

#[inline(always)]
fn accumulate(sum: &mut [f32; LANES], u: &[f32; LANES], x: &[f32; LANES]) {
    for l in 0..LANES {
        sum[l] += u[l] * x[l];
    }
}

/// `d - U z`.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn leave(basis: &[f32], difference: &[f32], z: &[f32], out: &mut [f32]) {
    let (difference, _) = difference.as_chunks::<WIDE>();
    let (out, _) = out.as_chunks_mut::<WIDE>();
    let (basis, _) = basis.as_chunks::<WIDE>();
    for (at, (out, d)) in out.iter_mut().zip(difference).enumerate() {
        let mut rest = *d;
        for (u, z) in basis.iter().skip(at).step_by(difference.len()).zip(z) {
            for l in 0..WIDE {
                rest[l] -= z * u[l];
            }
        }
        *out = rest;
    }
}

/// `sum (r - e)^2 + lambda |e|_1`.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn penalized(residuals: &[f32], lambda: f32) -> f32 {
    sum_of(residuals, |r| {
        let kept = r.abs().min(lambda);
        kept * kept + lambda * (r.abs() - kept)
    })
}

/// `sum (r - e)^2` over the pixels with `|e| < lambda`, plus `lambda` for each of the others.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn cost(residuals: &[f32], lambda: f32) -> f32 {
    sum_of(residuals, |r| {
        let kept = r.abs().min(lambda);
        if r.abs() - kept < lambda { kept * kept } else { lambda }
    })
}

#[inline(always)]
fn sum_of(x: &[f32], f: impl Fn(f32) -> f32) -> f32 {
    let mut sum = [0.0_f32; LANES];
    for x in x.as_chunks::<LANES>().0 {
        for l in 0..LANES {
            sum[l] += f(x[l]);
        }
    }
    fold(sum)
}

/// The sum of the lanes. Not inlined: its shuffles would reach back into the loops before.
#[inline(never)]
fn fold(mut s: [f32; LANES]) -> f32 {
    for half in [8, 4, 2, 1] {
        for l in 0..half {
            s[l] += s[l + half];
        }
    }
    s[0]
}
