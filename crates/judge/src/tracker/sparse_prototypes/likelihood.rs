//! Distance of a window from a subspace, with and without an occlusion model.
//!
//! Windows, mean and basis are `f32`, so that a register holds eight numbers. Sums are computed in lanes of a
//! fixed order, which gives the same bits with and without AVX2.

use crate::num::incremental_pca::IncrementalPca;
use multiversion::multiversion;

/// Number of values that are processed together.
const LANES: usize = 16;
/// Number of pixels whose residuals are computed together. Windows are multiples of it.
const WIDE: usize = 64;
/// Number of windows that are compared at a time.
const TOGETHER: usize = 4;

/// Stopping rule of the alternation, and cost of an occluded pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alternation {
    /// Threshold and cost of an error, named `lambda` in the paper.
    pub lambda: f32,
    /// Change of the objective below which the alternation stops.
    pub tolerance: f32,
    /// Most iterations, at least 1.
    pub iterations: usize,
}

/// Mean and basis of the windows so far, of multiples of `WIDE` numbers.
#[derive(Debug, Clone)]
pub struct Subspace {
    mean: Vec<f32>,
    /// Basis vectors, one after the other.
    basis: Vec<f32>,
    /// The same numbers in the order in which `leave` reads them: `WIDE` of each vector after another.
    blocks: Vec<f32>,
}

/// Comparison of one window, with residuals and buffers.
#[derive(Debug, Clone, Default)]
pub struct Comparison {
    /// Index of the window.
    window: usize,
    iteration: usize,
    objective: f32,
    difference: Vec<f32>,
    /// Difference without the errors, which is projected next.
    unoccluded: Vec<f32>,
    /// Residuals `d - U z` of the solution.
    residuals: Vec<f32>,
    next: Vec<f32>,
    coefficients: Vec<f32>,
}

/// Buffers for windows that are compared at a time, so that each basis vector is read only once for all of
/// them.
#[derive(Debug, Clone, Default)]
pub struct Comparisons([Comparison; TOGETHER]);

impl Comparisons {
    /// Residuals `d - U z` of the last window's solution.
    pub fn residuals(&self) -> &[f32] {
        &self.0[0].residuals
    }
}

impl Subspace {
    /// Subspace with this mean and no basis.
    pub fn mean_only(mean: &[f32]) -> Self {
        Self { mean: mean.to_vec(), basis: Vec::new(), blocks: Vec::new() }
    }

    /// Subspace of principal components.
    pub fn of(pca: &IncrementalPca) -> Self {
        let single = |v: &f64| *v as f32;
        let mean: Vec<f32> = pca.mean().iter().map(single).collect();
        let basis: Vec<f32> = pca.basis().iter().flatten().map(single).collect();
        let parts = basis.as_chunks::<WIDE>().0;
        let stride = mean.len() / WIDE;
        let blocks = (0..stride).flat_map(|at| parts.iter().skip(at).step_by(stride).flatten().copied());
        Self { blocks: blocks.collect(), mean, basis }
    }

    /// Mean of the windows.
    pub fn mean(&self) -> &[f32] {
        &self.mean
    }

    /// Number of basis vectors.
    pub fn dimension(&self) -> usize {
        self.basis.len() / self.mean.len().max(1)
    }

    /// Costs of `count` windows, which `sample` writes: `|d - U U'd|^2` with `d` the difference from the
    /// mean, or the cost under the occlusion model (see the tracker's file). The residuals are kept if there
    /// is a single window.
    pub fn costs(
        &self,
        count: usize,
        occlusion: Option<&Alternation>,
        mut sample: impl FnMut(usize, &mut [f32]),
        Comparisons(slots): &mut Comparisons,
    ) -> Vec<f32> {
        let mut costs = vec![0.0; count];
        let mut window = vec![0.0; self.mean.len()];
        let mut start = |k: usize, slot: &mut Comparison| {
            sample(k, &mut window);
            slot.start(k, &self.mean, &window);
        };
        let mut active = count.min(TOGETHER);
        let mut waiting = active..count;
        slots.iter_mut().take(active).enumerate().for_each(|(k, slot)| start(k, slot));
        while active > 0 {
            let busy = &mut slots[..active];
            project(&self.basis, busy);
            leave(&self.blocks, self.dimension(), busy);
            // From the back, so that a slot that takes an ended one's place has had its turn.
            for at in (0..active).rev() {
                let Some(cost) = slots[at].end(occlusion) else { continue };
                costs[slots[at].window] = cost;
                match waiting.next() {
                    Some(k) => start(k, &mut slots[at]),
                    None => {
                        active -= 1;
                        slots.swap(at, active);
                    }
                }
            }
        }
        costs
    }
}

impl Comparison {
    /// Starts the comparison of a window.
    fn start(&mut self, index: usize, mean: &[f32], window: &[f32]) {
        (self.window, self.iteration) = (index, 0);
        // That of the first iteration counts as 0; see the tracker's module.
        self.objective = 0.0;
        self.difference.clear();
        self.difference.extend(mean.iter().zip(window).map(|(m, y)| m - y));
        self.unoccluded.clone_from(&self.difference);
        for buffer in [&mut self.residuals, &mut self.next] {
            buffer.resize(mean.len(), 0.0);
        }
    }

    /// Ends an iteration. Returns the cost after the last one.
    fn end(&mut self, occlusion: Option<&Alternation>) -> Option<f32> {
        let Some(&Alternation { lambda, tolerance, iterations }) = occlusion else {
            std::mem::swap(&mut self.residuals, &mut self.next);
            return Some(sum_of(&self.residuals, |r| r * r));
        };
        if self.iteration > 0 {
            let now = penalized(&self.next, lambda);
            if (self.objective - now).abs() < tolerance {
                return Some(cost(&self.residuals, lambda));
            }
            self.objective = now;
        }
        std::mem::swap(&mut self.residuals, &mut self.next);
        self.iteration += 1;
        if self.iteration >= iterations {
            return Some(cost(&self.residuals, lambda));
        }
        unoccluded(&self.difference, &self.residuals, lambda, &mut self.unoccluded);
        None
    }
}

/// Error of a pixel with residual `r`: the amount beyond `lambda`.
#[inline(always)]
pub fn error(r: f32, lambda: f32) -> f32 {
    r - r.clamp(-lambda, lambda)
}

/// Differences minus the errors of the residuals, `d - e`.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn unoccluded(difference: &[f32], residuals: &[f32], lambda: f32, out: &mut [f32]) {
    for ((out, d), r) in out.iter_mut().zip(difference).zip(residuals) {
        *out = d - error(*r, lambda);
    }
}

/// Coefficients `U'x` of the vectors that the slots project.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn project(basis: &[f32], slots: &mut [Comparison]) {
    let Some(pixels) = slots.first().map(|slot| slot.difference.len() / LANES) else { return };
    slots.iter_mut().for_each(|slot| slot.coefficients.clear());
    let (basis, _) = basis.as_chunks::<LANES>();
    // Four vectors stay in the nearest cache for all windows.
    let mut quads = basis.chunks_exact(4 * pixels);
    for quad in &mut quads {
        let (ab, cd) = quad.split_at(2 * pixels);
        let ((a, b), (c, d)) = (ab.split_at(pixels), cd.split_at(pixels));
        for slot in slots.iter_mut() {
            // Additions wait for the one before in their lane, so the vectors take turns.
            let (mut p, mut q, mut r, mut s) = ([0.0; LANES], [0.0; LANES], [0.0; LANES], [0.0; LANES]);
            let x = slot.unoccluded.as_chunks::<LANES>().0;
            for ((((x, a), b), c), d) in x.iter().zip(a).zip(b).zip(c).zip(d) {
                accumulate(&mut p, a, x);
                accumulate(&mut q, b, x);
                accumulate(&mut r, c, x);
                accumulate(&mut s, d, x);
            }
            slot.coefficients.extend([fold(p), fold(q), fold(r), fold(s)]);
        }
    }
    for u in quads.remainder().chunks_exact(pixels) {
        for slot in slots.iter_mut() {
            let mut sum = [0.0_f32; LANES];
            for (u, x) in u.iter().zip(slot.unoccluded.as_chunks::<LANES>().0) {
                accumulate(&mut sum, u, x);
            }
            slot.coefficients.push(fold(sum));
        }
    }
}

#[inline(always)]
fn accumulate(sum: &mut [f32; LANES], u: &[f32; LANES], x: &[f32; LANES]) {
    for l in 0..LANES {
        sum[l] += u[l] * x[l];
    }
}

/// Residuals `d - U z`, written to each slot's `next`.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn leave(blocks: &[f32], dimension: usize, slots: &mut [Comparison]) {
    let (blocks, _) = blocks.as_chunks::<WIDE>();
    let parts = slots.first().map_or(0, |slot| slot.difference.len() / WIDE);
    for at in 0..parts {
        let block = &blocks[at * dimension..(at + 1) * dimension];
        for slot in slots.iter_mut() {
            let mut rest = slot.difference.as_chunks::<WIDE>().0[at];
            for (u, z) in block.iter().zip(&slot.coefficients) {
                for l in 0..WIDE {
                    rest[l] -= z * u[l];
                }
            }
            slot.next.as_chunks_mut::<WIDE>().0[at] = rest;
        }
    }
}

/// Objective `sum (r - e)^2 + lambda |e|_1`.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn penalized(residuals: &[f32], lambda: f32) -> f32 {
    sum_of(residuals, |r| {
        let kept = r.abs().min(lambda);
        kept * kept + lambda * (r.abs() - kept)
    })
}

/// Cost `sum (r - e)^2` over the pixels with `|e| < lambda`, plus `lambda` for each other pixel.
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

/// Sum of the lanes. Not inlined, since its shuffles would slow down the loops before it.
#[inline(never)]
fn fold(mut s: [f32; LANES]) -> f32 {
    for half in [8, 4, 2, 1] {
        for l in 0..half {
            s[l] += s[l + half];
        }
    }
    s[0]
}
