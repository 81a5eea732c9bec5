//! Solutions compared with scikit-learn, with manual results, and with the conditions of a minimum.

use super::*;
use proptest::prelude::*;
use trackfail_testing::assert_near;

const LENGTH: usize = 21;

fn lasso(lambda: f32, sign: Sign) -> Lasso {
    Lasso { lambda, sign, tolerance: 1e-6, rounds: 100_000 }
}

/// Dictionary and signal of the Python calls below.
fn example() -> (Vec<f32>, Vec<f32>) {
    let dictionary =
        (0..9).flat_map(|k| (0..LENGTH).map(move |i| ((7 * k + 3 * i + k * i) as f32).sin())).collect();
    let y = (0..LENGTH).map(|i| (0.3 * i as f32).cos() + 0.2 * ((5 * i) as f32).sin()).collect();
    (dictionary, y)
}

fn solved(lasso: &Lasso, dictionary: &[f32], y: &[f32], b: &mut [f32]) -> Outcome {
    let mut c = vec![0.0; b.len()];
    correlate(dictionary, y, &mut c);
    lasso.solve(&Gram::new(dictionary, b.len(), y.len()), &c, b, &mut Work::default())
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
        assert_near(b.into_iter().map(f64::from), want, 2e-5, format!("{sign:?}"));
    }
}
const FREE: [f64; 9] =
    [-0.0, 0.00011844, 0.07291597, 0.66489777, -0.0682692, -0.0320019, -0.0, -0.0398478, -0.0200684];
const POSITIVE: [f64; 9] = [0.0, 0.0, 0.08402870529283697, 0.6823360277052, 0.0, 0.0, 0.0, 0.0, 0.0];

// By hand: orthogonal atoms of length 2 decouple, b = S(c, lambda) / 4.
#[test]
fn orthogonal_atoms_take_a_round_each() {
    let mut b = [0.0; 4];
    let dictionary = [2.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0];
    let free = lasso(1.0, Sign::Free);
    let outcome = solved(&free, &dictionary, &[1.5, -2.5, 0.25], &mut b);
    assert_eq!((b, outcome), ([0.5, -1.0, 0.0, 0.0], Outcome { rounds: 2, residual: 0.0 }));
    solved(&lasso(1.0, Sign::NonNegative), &dictionary, &[1.5, -2.5, 0.25], &mut b);
    assert_eq!(b, [0.5, 0.0, 0.0, 0.0]);
    // One round too few: the outcome has the residual.
    let none = Lasso { rounds: 0, ..free };
    b.fill(0.0);
    assert_eq!(solved(&none, &dictionary, &[1.5, -2.5, 0.25], &mut b), Outcome { rounds: 0, residual: 4.0 });
}

// By hand: two equal atoms and a third; the minimum of the sum of the equal ones is that of one of them.
#[test]
fn atoms_may_depend_on_each_other() {
    let dictionary = [1.0, 0.0, 1.0, 0.0, 0.6, 0.8];
    for start in [[0.0; 3], [0.4, 0.4, 0.0], [0.1, 0.0, 2.0]] {
        let mut b = start;
        let outcome = solved(&lasso(0.1, Sign::Free), &dictionary, &[1.0, 0.25], &mut b);
        assert!(outcome.residual <= 1e-6, "{outcome:?}");
        // g_3 = .6 (1 - .6 v - u) + .8 (.25 - .8 v) = .1 and g_1 = 1 - .6 v - u = .1
        let v = (0.2 + 0.06 - 0.1) / 0.64;
        assert!((b[2] - v).abs() < 1e-5 && (b[0] + b[1] - 0.9 + 0.6 * v).abs() < 1e-5, "{b:?}");
    }
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
        prop_assert!(outcome.residual <= 1e-6 || outcome.rounds == 100_000);
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
        let (z, e, outcome) = problem.with_errors(&atoms, &x);
        prop_assert!(outcome.residual <= 1e-6 || outcome.rounds == 100_000);
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
