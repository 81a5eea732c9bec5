//! Principal components that are updated batch by batch, with the mean (Ross, Lim, Lin and Yang,
//! "Incremental learning for robust visual tracking", IJCV 77, 2008, section 3.1, their algorithm R-SVD with
//! mean update).
//!
//! ```text
//! batch of m vectors with mean b; so far n vectors with mean a, basis U, singular values D
//! B = [x_1 - b, ..., x_m - b, sqrt(m n / (m + n)) (a - b)]          the last column only when n > 0
//! [f U D, B] = U' D' V'                                             (SVD)
//! U <- U',  D <- D',  a <- (f n a + m b) / (f n + m),  n <- f n + m
//! ```
//!
//! With the forgetting factor `f = 1` and all components kept, `U` and `D` are those of the matrix whose
//! columns are all vectors minus their mean. With `f < 1` older batches count less and less. Components with
//! `D_k^2 < 1e-6 sum D^2` are dropped, and so are all beyond a given number.
//!
//! Choices: the source first reduces the matrix by a QR decomposition, which gives the same `U'` and `D'`.
//! Here the columns themselves are rotated until they are orthogonal (Hestenes, "Inversion of matrices by
//! biorthogonalization", J. SIAM 6, 1958), which is exact even for dependent columns. The bound also applies
//! to the first batch. The authors' code keeps as many components as that batch has vectors, the last of
//! which consists of rounding errors.

/// Least share of a component in the sum of squared singular values.
const MIN_SHARE: f64 = 1e-6;
/// Largest cosine at which two columns count as orthogonal.
const MAX_COSINE: f64 = 1e-14;
/// Most passes over the pairs of columns. About ten are needed.
const MAX_PASSES: usize = 60;
const LANES: usize = 8;

/// Mean, basis and singular values of the vectors so far.
#[derive(Debug, Clone, PartialEq)]
pub struct IncrementalPca {
    mean: Vec<f64>,
    basis: Vec<Vec<f64>>,
    singular_values: Vec<f64>,
    count: f64,
}

impl IncrementalPca {
    /// Initial state for vectors of `dimension` numbers: mean 0, no basis.
    pub fn new(dimension: usize) -> Self {
        Self { mean: vec![0.0; dimension], basis: Vec::new(), singular_values: Vec::new(), count: 0.0 }
    }

    /// Mean of the vectors, `dimension` numbers.
    pub fn mean(&self) -> &[f64] {
        &self.mean
    }

    /// Components: orthonormal vectors of `dimension` numbers, in the order of the singular values.
    pub fn basis(&self) -> &[Vec<f64>] {
        &self.basis
    }

    /// Adds a batch of vectors and keeps at most `most` components; `forgetting` is above 0 and at most 1.
    ///
    /// A batch that is empty, overflows or has a number that is not finite is ignored.
    ///
    /// # Panics
    /// When a vector has another dimension: a mistake in the caller.
    pub fn update(&mut self, batch: &[Vec<f64>], forgetting: f64, most: usize) {
        let dimension = self.mean.len();
        assert!(batch.iter().all(|x| x.len() == dimension), "dimension of a batch");
        if batch.is_empty() {
            return;
        }
        let size = batch.len() as f64;
        let mut mean = vec![0.0; dimension];
        for x in batch {
            mean.iter_mut().zip(x).for_each(|(m, x)| *m += x / size);
        }
        let difference = |x: &[f64], by: f64| x.iter().zip(&mean).map(|(x, m)| by * (x - m)).collect();
        let mut columns: Vec<Vec<f64>> = batch.iter().map(|x| difference(x, 1.0)).collect();
        if self.count > 0.0 {
            columns.push(difference(&self.mean, (size * self.count / (size + self.count)).sqrt()));
        }
        for (u, d) in self.basis.iter().zip(&self.singular_values) {
            columns.push(u.iter().map(|u| forgetting * d * u).collect());
        }
        if !columns.iter().all(|c| dot(c, c).is_finite()) {
            return;
        }
        orthogonalize(&mut columns);

        let mut spread: Vec<(f64, Vec<f64>)> = columns.into_iter().map(|c| (dot(&c, &c), c)).collect();
        spread.sort_by(|a, b| b.0.total_cmp(&a.0));
        let total: f64 = spread.iter().map(|(square, _)| square).sum();
        spread.truncate(most);
        spread.retain(|(square, _)| *square > 0.0 && *square >= MIN_SHARE * total);
        self.singular_values = spread.iter().map(|(square, _)| square.sqrt()).collect();
        let unit = |(square, c): (f64, Vec<f64>)| c.into_iter().map(|v| v / square.sqrt()).collect();
        self.basis = spread.into_iter().map(unit).collect();
        let old = forgetting * self.count;
        for (a, b) in self.mean.iter_mut().zip(&mean) {
            *a = (old * *a + size * b) / (old + size);
        }
        self.count = old + size;
    }
}

/// Rotates pairs of columns until all are orthogonal. Their span and the sum of their outer products stay the
/// same.
fn orthogonalize(columns: &mut [Vec<f64>]) {
    for _ in 0..MAX_PASSES {
        let mut turned = false;
        let mut squares: Vec<f64> = columns.iter().map(|c| dot(c, c)).collect();
        for j in 1..columns.len() {
            let (before, after) = columns.split_at_mut(j);
            let Some(b) = after.first_mut() else { continue };
            for (i, a) in before.iter_mut().enumerate() {
                let product = dot(a, b);
                if product.abs() <= MAX_COSINE * (squares[i] * squares[j]).sqrt() {
                    continue;
                }
                turned = true;
                let cotangent = (squares[j] - squares[i]) / (2.0 * product);
                let tangent = 1.0_f64.copysign(cotangent) / (cotangent.abs() + cotangent.hypot(1.0));
                let cosine = 1.0 / tangent.hypot(1.0);
                let sine = cosine * tangent;
                for (a, b) in a.iter_mut().zip(b.iter_mut()) {
                    (*a, *b) = (cosine * *a - sine * *b, sine * *a + cosine * *b);
                }
                squares[i] = (squares[i] - tangent * product).max(0.0);
                squares[j] = (squares[j] + tangent * product).max(0.0);
            }
        }
        if !turned {
            return;
        }
    }
}

/// Dot product, summed in lanes.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    let mut sum = [0.0; LANES];
    for (a, b) in a.zip(b) {
        for l in 0..LANES {
            sum[l] += a[l] * b[l];
        }
    }
    sum.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use trackfail_testing::assert_near;

    /// Row `t` of the matrix in the Python calls below, whose spectrum decreases.
    fn vector(t: usize) -> Vec<f64> {
        let value = |j: u32| {
            let (t, j) = (t as f64, f64::from(j));
            let wave = |k: f64| (1.3 * k * t + 0.2 * j).sin() * (0.7 * k * j).cos() / k;
            [1.0, 2.0, 3.0, 4.0, 5.0].map(wave).iter().sum::<f64>() + 0.1 * j
        };
        (0..12).map(value).collect()
    }

    fn batches(sizes: &[usize], forgetting: f64, most: usize) -> IncrementalPca {
        let mut pca = IncrementalPca::new(12);
        let mut next = 0;
        for size in sizes {
            let batch: Vec<_> = (next..next + size).map(vector).collect();
            pca.update(&batch, forgetting, most);
            next += size;
        }
        pca
    }

    // The definition: eigenvectors of the scatter matrix, whose eigenvalues are the squares and have all of the scatter.
    // python3: import numpy as np; t,j,k=np.ogrid[:20,:12,1:6]
    // X=(np.sin(1.3*k*t+.2*j)*np.cos(.7*k*j)/k).sum(2)+.1*np.arange(12); np.linalg.svd(X-X.mean(0))[1][:2]
    #[test]
    fn batches_have_the_components_of_all_vectors() {
        let all: Vec<Vec<f64>> = (0..20).map(vector).collect();
        let mean: Vec<f64> = (0..12).map(|j| all.iter().map(|x| x[j]).sum::<f64>() / 20.0).collect();
        let off = |x: &Vec<f64>| x.iter().zip(&mean).map(|(x, m)| x - m).collect::<Vec<f64>>();
        let off: Vec<Vec<f64>> = all.iter().map(off).collect();
        for sizes in [&[20][..], &[5, 5, 5, 5], &[1, 13, 6]] {
            let pca = batches(sizes, 1.0, 99);
            let what = format!("{sizes:?}");
            assert_near(pca.mean(), &mean, 1e-13, &what);
            assert_near(&pca.singular_values[..2], [6.305867325651224, 5.124947299305144], 1e-11, &what);
            for (u, s) in pca.basis().iter().zip(&pca.singular_values) {
                let of_scatter = |j: usize| off.iter().map(|x| dot(x, u) * x[j]).sum::<f64>();
                assert_near((0..12).map(of_scatter), u.iter().map(|u| s * s * u), 1e-10, &what);
            }
            let [squares, scatter] = [pca.singular_values.clone(), off.concat()]
                .map(|list| list.iter().map(|v| v * v).sum::<f64>());
            assert_near([squares], [scatter], 1e-10, &what);
        }
    }

    // python3, as above: f=.9; m,n=X[:8].mean(0),8; U,D,_=np.linalg.svd((X[:8]-m).T,full_matrices=False)
    // B=np.c_[(X[8:]-X[8:].mean(0)).T,np.sqrt(12*n/(12+n))*(m-X[8:].mean(0))]
    // np.linalg.svd(np.c_[f*U*D,B])[1][:4], ((f*n*m+12*X[8:].mean(0))/(f*n+12))[:2]
    #[test]
    fn forgetting_shrinks_the_older_part() {
        let pca = batches(&[8, 12], 0.9, 99);
        assert_near(pca.singular_values[..4].iter().chain(&pca.mean()[..2]), FORGOTTEN, 1e-12, "");
    }
    const FORGOTTEN: [f64; 6] = [
        6.0705759139060715,
        4.963862351975791,
        2.96598323056888,
        2.2052195968681714,
        0.013408389509485173,
        0.058642659518653883,
    ];

    #[test]
    fn equal_vectors_have_no_components() {
        let mut pca = IncrementalPca::new(3);
        for _ in 0..3 {
            pca.update(&[vec![1.0, 2.0, 4.0], vec![1.0, 2.0, 4.0]], 1.0, 9);
            assert_eq!((pca.mean(), pca.basis().len()), (&[1.0, 2.0, 4.0][..], 0));
        }
        let before = pca.clone();
        pca.update(&[], 1.0, 9);
        pca.update(&[vec![1.0, f64::NAN, 0.0]], 1.0, 9);
        pca.update(&[vec![1e300, 0.0, 0.0], vec![-1e300, 0.0, 0.0]], 1.0, 9);
        assert_eq!(pca, before);
        pca.update(&[vec![1.0, 2.0, 5.0]], 1.0, 9);
        assert_eq!(pca.basis().len(), 1);
    }

    proptest! {
        #[test]
        fn the_basis_stays_orthonormal(
            numbers in prop::collection::vec(-1.0..1.0_f64, 6 * 24),
            sizes in prop::collection::vec(1_usize..5, 1..7),
            forgetting in 0.5..=1.0_f64,
            most in 1_usize..6,
        ) {
            let mut pca = IncrementalPca::new(6);
            let mut rows = numbers.chunks_exact(6).map(<[f64]>::to_vec);
            for size in sizes {
                pca.update(&rows.by_ref().take(size).collect::<Vec<_>>(), forgetting, most);
                prop_assert!(pca.basis().len() <= most && pca.singular_values.is_sorted_by(|a, b| a >= b));
                for (i, u) in pca.basis().iter().enumerate() {
                    let products = pca.basis().iter().map(|v| dot(u, v));
                    assert_near(products, (0..pca.basis().len()).map(|j| f64::from(i == j)), 1e-10, i);
                }
            }
        }
    }
}
