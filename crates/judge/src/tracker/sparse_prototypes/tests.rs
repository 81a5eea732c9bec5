//! Comparison of costs with NumPy and of a track with the description, and a target that moves.

use super::*;
use crate::tracker::testing::Scene;

const N: usize = 256;
const ALTERNATION: Alternation = Alternation { lambda: 0.05, tolerance: 1e-3, iterations: 20 };

/// Three orthonormal waves, and the mean, of the Python call below.
fn subspace() -> Subspace {
    let wave = |k: usize, n: usize| {
        let t = std::f64::consts::TAU * n as f64 / N as f64;
        (2.0 / N as f64).sqrt() * [t.cos(), t.sin(), (3.0 * t).cos()][k]
    };
    let mean: Vec<f64> = (0..N).map(|n| 0.4 + 0.1 * (0.05 * n as f64).sin()).collect();
    let vector = |(k, by): (usize, f64)| (0..N).map(|n| mean[n] + by * wave(k / 2, n)).collect();
    let distances = [5.0, -5.0, 3.0, -3.0, 2.0, -2.0];
    let vectors: Vec<Vec<f64>> = distances.into_iter().enumerate().map(vector).collect();
    let mut pca = IncrementalPca::new(N);
    pca.update(&vectors, 1.0, 3);
    Subspace::of(&pca)
}

/// A window in the subspace, with noise, an occluded stretch, and another stretch with errors just below
/// lambda.
fn window(amount: f64) -> Vec<f32> {
    (0..N)
        .map(|n| {
            let x = n as f64;
            let hidden = if (60..100).contains(&n) { amount } else { 0.0 };
            let y = 0.4 + 0.1 * (0.05 * x).sin() + 0.08 * (std::f64::consts::TAU * x / 256.0).cos();
            (y + 0.03 * (1.7 * x).sin() + 0.02 * (0.31 * x * x).cos() + hidden) as f32
        })
        .collect()
}

/// Cost of one window.
fn cost(subspace: &Subspace, y: &[f32], how: Option<&Alternation>, work: &mut Comparisons) -> f32 {
    subspace.costs(1, how, |_, out| out.copy_from_slice(y), work)[0]
}

#[test]
fn windows_do_not_see_their_neighbors() {
    let subspace = subspace();
    let windows: Vec<Vec<f32>> =
        (0..11).map(|k| window([0.0, 0.3, -0.6, 0.09][k * k % 4] + 0.01 * k as f64)).collect();
    for how in [None, Some(&ALTERNATION)] {
        let copy = |k: usize, out: &mut [f32]| out.copy_from_slice(&windows[k]);
        let together = subspace.costs(windows.len(), how, copy, &mut Comparisons::default());
        let alone = |y: &Vec<f32>| cost(&subspace, y, how, &mut Comparisons::default());
        assert_eq!(together, windows.iter().map(alone).collect::<Vec<_>>());
        assert!(subspace.costs(0, how, copy, &mut Comparisons::default()).is_empty());
    }
}

// python3: import numpy as np; n=np.arange(256); t=2*np.pi*n/256; L=.05
// U=np.sqrt(2/256)*np.c_[np.cos(t),np.sin(t),np.cos(3*t)]; mu=.4+.1*np.sin(.05*n)
// def E(amount,tol=1e-3):
//   d=mu-(mu+.08*np.cos(t)+.03*np.sin(1.7*n)+.02*np.cos(.31*n*n)+amount*((n>=60)&(n<100)))
//   plain=d-U@(U.T@d); e=0*d; old=(0,)
//   for i in range(20):
//     z=U.T@(d-e); new=np.sign(d-U@z)*np.maximum(abs(d-U@z)-L,0); J=((d-U@z-new)**2).sum()+L*abs(new).sum()
//     if i and abs(J-old[0])<tol: break
//     old=(J*(i>0),z,new); e=new
//   _,z,e=old; s=abs(e)<L; return (plain**2).sum(),((d-U@z-e)[s]**2).sum()+L*(~s).sum(),i
// print([E(a) for a in (0,.09,.3,-.6)],E(.3,1e-9),E(.3,.05))
#[test]
fn costs_agree_with_numpy() {
    let (subspace, mut work) = (subspace(), Comparisons::default());
    let near = |ours: f32, theirs: f64| assert!((f64::from(ours) - theirs).abs() < 1e-5, "{ours} {theirs}");
    assert_eq!(subspace.dimension(), 3);
    for (amount, (plain, occluded)) in [0.0, 0.09, 0.3, -0.6].into_iter().zip(COSTS) {
        near(cost(&subspace, &window(amount), None, &mut work), plain);
        near(cost(&subspace, &window(amount), Some(&ALTERNATION), &mut work), occluded);
    }
    let patient = Alternation { tolerance: 1e-9, ..ALTERNATION };
    near(cost(&subspace, &window(0.3), Some(&patient), &mut work), PATIENT);
    // The first two objectives are that close, but the first counts as 0.
    let hasty = Alternation { tolerance: 0.05, ..ALTERNATION };
    near(cost(&subspace, &window(0.3), Some(&hasty), &mut work), HASTY);
}
const COSTS: [(f64, f64); 4] = [
    (0.16275060539507658, 0.16262590317639097),
    (0.3440045609700989, 0.2924145247976998),
    (2.263234602491789, 2.1915916385533953),
    (8.787246712744263, 2.1979489895319206),
];
const PATIENT: f64 = 2.186948453958617;
const HASTY: f64 = 3.5617254482136764;

// With one iteration the solution is that of e = 0.
#[test]
fn the_solution_is_the_one_before_the_last_iteration() {
    let (subspace, mut work) = (subspace(), Comparisons::default());
    cost(&subspace, &window(0.3), None, &mut work);
    let projection = work.residuals().to_vec();
    for how in [
        Alternation { iterations: 1, ..ALTERNATION },
        // Stops in the second iteration.
        Alternation { tolerance: f32::INFINITY, ..ALTERNATION },
    ] {
        cost(&subspace, &window(0.3), Some(&how), &mut work);
        assert_eq!(work.residuals(), projection, "{how:?}");
    }
    cost(&subspace, &window(0.3), Some(&ALTERNATION), &mut work);
    assert_ne!(work.residuals(), projection);
}

const TO_THE_RIGHT: Scene = Scene { step: (1, 0), ..Scene::WAVES };

// The occlusion comes when the basis is full, after the first batch.
#[test]
fn occlusion_moves_sp_less_than_ivt() {
    let frames: Vec<Frame> =
        (0..60).map(|t| TO_THE_RIGHT.frame(t / 2, if t < 30 { 0.0 } else { 18.0 })).collect();
    let errors = ["sparse-prototypes", "ivt"].map(|kind| {
        let params = "{ max_basis = 4, noise = [3, 3, 0.01, 0, 0, 0] }";
        let error = |(t, state): (i64, TrackerState)| {
            let ((x, y), truth) = (state.region.rect().center(), TO_THE_RIGHT.rect(t / 2).center());
            (x - truth.0).hypot(y - truth.1)
        };
        (0..).zip(TO_THE_RIGHT.run(kind, params, 5, &frames)).skip(30).map(error).sum::<f64>() / 30.0
    });
    assert!(3.0 * errors[0] < errors[1] && errors[0] < 4.0, "{errors:?}");
}

#[test]
fn sp_is_ivt_until_the_basis_is_full() {
    let frames: Vec<Frame> = (0..26).map(|t| TO_THE_RIGHT.frame(t, (t % 7) as f64)).collect();
    let [sp, ivt] =
        ["sparse-prototypes", "ivt"].map(|kind| TO_THE_RIGHT.run(kind, "{ samples = 50 }", 3, &frames));
    assert_eq!(sp[..16], ivt[..16]);
    assert_ne!(sp, ivt);
}

#[test]
fn the_posterior_is_of_the_components_with_noise() {
    let run = |params: &str| {
        TO_THE_RIGHT.run("sparse-prototypes", params, 3, &TO_THE_RIGHT.frames(3)).pop().unwrap()
    };
    let upright = run("{ samples = 100, noise = [4, 4, 0.01, 0, 0.005, 0] }");
    let moments = upright.posterior.unwrap();
    assert!((0..4).all(|k| moments.covariance[5 * k] > 0.0) && moments.effective_samples < 100.0);
    assert!(moments.likelihood > 0.0 && moments.likelihood <= 1.0);
    assert!(matches!(upright.region, Region::Rect(_)));
    let turning = run("{ samples = 100 }");
    assert_eq!(turning.posterior.unwrap().mean.len(), 6);
    assert!(matches!(&turning.region, Region::Polygon(p) if p.len() == 4));
}

// What hides the target costs more than 745 * 1e-4.
#[test]
fn the_first_candidate_is_taken_where_all_likelihoods_vanish() {
    let frames: Vec<Frame> = (0..3).map(|t| TO_THE_RIGHT.frame(t, 9.0 * t as f64)).collect();
    let run = |scale: f64, more: &str| {
        let params = format!("{{ samples = 40, likelihood_scale = {scale:?}{more} }}");
        TO_THE_RIGHT.run("sparse-prototypes", &params, 3, &frames)
    };
    let first_word = ", underflow = \"first\"";
    let (best, first) = (run(1e-4, ""), run(1e-4, first_word));
    assert_ne!(best[1].region, first[1].region);
    let posterior = first[2].posterior.as_ref().unwrap();
    assert!((posterior.effective_samples - 40.0).abs() < 1e-9 && posterior.likelihood == 0.0);
    // It changes nothing where they do not vanish.
    assert_eq!(run(900.0, ""), run(900.0, first_word));
}

/// Tracker that was started on a frame without contrast.
fn tracking(params: Params) -> Tracking {
    let frame = Frame::new(100, 80, vec![9; 3 * 100 * 80]);
    Tracking::new(params, true, 1, &frame, &Region::Rect(Rect::new(30.0, 20.0, 40.0, 40.0))).unwrap()
}

// By hand, with a basis that is orthogonal to what hides the target: 64, 300 and 700 of 1024 pixels are far beyond lambda, which are shares of .06, .29 and .68.
#[test]
fn occluded_pixels_are_not_learned() {
    let mut tracker = tracking(Params { max_basis: 1, ..Params::default() });
    let ripple: Vec<f64> = (0..PIXELS).map(|n| if n % 2 == 0 { 0.02 } else { -0.02 }).collect();
    let mut pca = IncrementalPca::new(PIXELS);
    pca.update(&[vec![0.5; PIXELS], ripple.iter().map(|r| 0.5 + r).collect()], 1.0, 1);
    tracker.subspace = Subspace::of(&pca);
    for (hidden, learned, replaced) in [(64, true, false), (300, true, true), (700, false, false)] {
        let window: Vec<f32> = (0..PIXELS).map(|n| if n < hidden { 0.9 } else { 0.5 }).collect();
        let mut cleaned = window.clone();
        assert_eq!(tracker.clean(&mut cleaned), learned, "{hidden}");
        assert_eq!(cleaned[hidden..], window[hidden..]);
        let expected = if replaced { &tracker.subspace.mean()[..hidden] } else { &window[..hidden] };
        assert_eq!(&cleaned[..hidden], expected, "{hidden}");
    }
}
