//! Windows as nine overlapping patches, and how well the templates explain each patch by its own place.

use super::super::affine_candidates::{PIXELS, SIDE};
use crate::num::lasso::{Gram, Lasso, Work, correlate};

/// Side of a patch.
const PATCH: usize = 16;
/// Distance between neighboring patches.
const STEP: usize = 8;
/// Number of patches in a row, and in a column.
const ACROSS: usize = (SIDE - PATCH) / STEP + 1;
/// Number of patches in a window.
pub const PATCHES: usize = ACROSS * ACROSS;
/// Number of pixels in a patch.
const AREA: usize = PATCH * PATCH;

/// Divides a vector by its length, if it has one.
pub fn normalize(v: &mut [f32]) {
    let square: f64 = v.iter().map(|v| f64::from(*v).powi(2)).sum();
    if square > 0.0 {
        let by = square.sqrt().recip() as f32;
        v.iter_mut().for_each(|v| *v *= by);
    }
}

/// Cuts a window of 32 x 32 into patches of length 1, column by column, and appends them.
fn cut(window: &[f32], patches: &mut Vec<f32>) {
    for k in 0..PATCHES {
        let (left, top) = (k / ACROSS * STEP, k % ACROSS * STEP);
        let start = patches.len();
        for row in top..top + PATCH {
            patches.extend_from_slice(&window[row * SIDE + left..row * SIDE + left + PATCH]);
        }
        normalize(&mut patches[start..]);
    }
}

/// Patches of all templates.
#[derive(Debug, Clone)]
pub struct Dictionary {
    /// Patches, template by template.
    atoms: Vec<f32>,
    gram: Gram,
}

/// Buffers of a coding.
#[derive(Debug, Clone, Default)]
pub struct Coding {
    patches: Vec<f32>,
    correlations: Vec<f32>,
    solver: Work,
    coefficients: Vec<f32>,
}

impl Dictionary {
    /// Dictionary of at least one template of length 1 with 1024 numbers.
    pub fn of(templates: &[Vec<f32>]) -> Self {
        let mut atoms = Vec::with_capacity(templates.len() * PATCHES * AREA);
        for template in templates {
            debug_assert_eq!(template.len(), PIXELS);
            cut(template, &mut atoms);
        }
        let gram = Gram::new(&atoms, templates.len() * PATCHES, AREA);
        Self { atoms, gram }
    }

    /// The alignment-pooled confidence of a window, from 0 to 9.
    pub fn confidence(&self, window: &[f32], lasso: &Lasso, work: &mut Coding) -> f64 {
        let atoms = self.gram.atoms();
        work.patches.clear();
        cut(window, &mut work.patches);
        work.correlations.resize(atoms, 0.0);
        let mut trace = 0.0;
        for (place, patch) in work.patches.chunks_exact(AREA).enumerate() {
            correlate(&self.atoms, patch, &mut work.correlations);
            work.coefficients.clear();
            work.coefficients.resize(atoms, 0.0);
            lasso.solve(&self.gram, &work.correlations, &mut work.coefficients, &mut work.solver);
            let (mut own, mut all) = (0.0, f64::EPSILON);
            for template in work.coefficients.chunks_exact(PATCHES) {
                own += f64::from(template[place].abs());
                all += template.iter().map(|b| f64::from(b.abs())).sum::<f64>();
            }
            trace += own / all;
        }
        trace
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::lasso::Sign;

    const LASSO: Lasso = Lasso { lambda: 0.01, sign: Sign::NonNegative, tolerance: 1e-6, rounds: 100_000 };

    /// Window `t` of the Python call below, of length 1.
    fn window(t: usize) -> Vec<f32> {
        let value = |i: usize, j: usize| {
            let (i, j, t) = (i as f64, j as f64, t as f64);
            1.2 + (0.21 * i + 0.05 * t).sin() * (0.17 * j).cos() + 0.3 * (0.9 * i + 0.7 * j + t).sin()
        };
        let mut window: Vec<f32> = (0..PIXELS).map(|n| value(n / SIDE, n % SIDE) as f32).collect();
        normalize(&mut window);
        window
    }

    // python3: import numpy as np; from sklearn.linear_model import Lasso; i,j=np.mgrid[:32,:32]
    // unit=lambda v:v/np.linalg.norm(v)
    // W=lambda t:unit(1.2+np.sin(.21*i+.05*t)*np.cos(.17*j)+.3*np.sin(.9*i+.7*j+t))
    // cut=lambda w:[unit(w[r:r+16,c:c+16].ravel()) for c in (0,8,16) for r in (0,8,16)]
    // D=np.array([p for t in range(10) for p in cut(W(t))]).T
    // def conf(w,positive):
    //   s=0
    //   for k,p in enumerate(cut(w)):
    //     b=Lasso(alpha=.01/256,fit_intercept=False,positive=positive,tol=1e-12,max_iter=10**6).fit(D,p).coef_
    //     v=abs(b).reshape(10,9).sum(0); s+=v[k]/v.sum()
    //   return s
    // [conf(w,p) for p in (True,False) for w in (W(12),np.roll(W(3),2,0))]
    #[test]
    fn confidence_agrees_with_scikit_learn() {
        let dictionary = Dictionary::of(&(0..10).map(window).collect::<Vec<_>>());
        let mut rolled = window(3);
        rolled.rotate_right(2 * SIDE);
        let mut want = CONFIDENCES.iter();
        for sign in [Sign::NonNegative, Sign::Free] {
            for w in [&window(12), &rolled] {
                let ours = dictionary.confidence(w, &Lasso { sign, ..LASSO }, &mut Coding::default());
                let want = want.next().unwrap();
                assert!((ours - want).abs() < 1e-3, "{sign:?}: {ours} {want}");
            }
        }
    }
    const CONFIDENCES: [f64; 4] = [7.25098275651226, 6.927856887811533, 6.790352139876893, 6.577621557323917];

    // A window that is the only template codes every patch by itself.
    #[test]
    fn a_template_has_full_confidence_and_a_dark_window_none() {
        let dictionary = Dictionary::of(&[window(2)]);
        let confidence = |w: &[f32]| dictionary.confidence(w, &LASSO, &mut Coding::default());
        assert!((confidence(&window(2)) - 9.0).abs() < 1e-4);
        assert_eq!(confidence(&[0.0; PIXELS]), 0.0);
    }

    // By hand: patch 3 is the first of the second column of patches, and 1 the second of the first.
    #[test]
    fn patches_are_cut_column_by_column() {
        let mut patches = vec![];
        cut(&(0..PIXELS).map(|n| n as f32).collect::<Vec<_>>(), &mut patches);
        let ratio = |k: usize| patches[k * AREA] / patches[k * AREA + 1];
        assert!((ratio(3) - 8.0 / 9.0).abs() < 1e-6);
        assert!((ratio(1) - 256.0 / 257.0).abs() < 1e-6);
        assert_eq!(patches.len(), 9 * 256);
    }
}
