use super::*;
use crate::tracker::testing::{follow, texture};
use trackfail_testing::assert_near;

// python3: import numpy as np; rng = np.arange(70); F, G = np.fft.fft2, np.fft.ifft2
// def look(k): return ((rng * 7919 + k * 104729) * 1664525 % 2**20 >> 10).reshape(2, 5, 7) / 1024
// w = np.outer(np.hanning(5), np.hanning(7)); s = lambda n: np.array([i - n if 2 * i >= n else i for i in range(n)])
// Y = F(np.exp(-.5 * (s(5)[:, None]**2 + s(7)**2))); X = [F(w * look(k)) for k in (1, 2, 3)]
// N = .8 * Y * X[0].conj() + .2 * Y * X[1].conj(); D = (.8 * abs(X[0])**2 + .2 * abs(X[1])**2).sum(0)
// r = G((N * X[2]).sum(0) / (D + .01)).real; print(r[0, :3], r[3, 4])
#[test]
fn responses_agree_with_numpy() {
    let look = |k: usize| -> Vec<f32> {
        (0..70).map(|i| (((i * 7919 + k * 104_729) * 1_664_525 % (1 << 20)) >> 10) as f32 / 1024.0).collect()
    };
    let mut filter = Filter::new(Fourier::new(7, 5), &label(7, 5, 1.0), 2);
    let window = hann_plane(7, 5);
    let looks = &[1, 2, 3].map(|k| {
        let planes: Vec<f32> = look(k).iter().zip(window.iter().cycle()).map(|(v, w)| v * w).collect();
        let spectra = planes.chunks_exact(35).flat_map(|plane| filter.fourier.side_by_side(plane));
        spectra.map(Lanes).collect::<Vec<_>>()
    });
    let value = |k: usize| move |pass: usize, group: usize, x: usize| looks[k][(2 * pass + group) * 7 + x];
    filter.learn(value(0), 0.2);
    filter.learn(value(1), 0.2);
    let response = filter.respond(value(2), 0.01);
    assert_near([0, 1, 2, 3 * 7 + 4].map(|k| f64::from(response[k])), NUMPY, 1e-4, "");
}
const NUMPY: [f64; 4] = [0.705008, 0.429179, 0.162831, -0.014818];

#[test]
fn large_targets_start_at_a_larger_scale() {
    let first = Rect::new(40.0, 30.0, 500.0, 420.0);
    let frame = |d: f64| {
        let small = texture(d / 4.0, 0.0, 1.0, false);
        Frame::from_fn(640, 480, |x, y| small.pixel(x / 4, y / 4))
    };
    let target = Target::new(&Params::default(), &frame(0.0), &Region::Rect(first));
    assert!(target.scale > 1.7 && (target.size.0 * target.size.1) as f64 <= 1.01 * MAX_WINDOW_AREA);
    assert_eq!(target.rect(), first);
    let got = follow("dsst", "{ scales = 1 }", &Region::Rect(first), &[frame(0.0), frame(12.0)]).rect();
    assert!((got.x - 52.0).abs() <= 2.0 && (got.y - 30.0).abs() <= 2.0 && got.w == 500.0, "{got:?}");
}

#[test]
fn turned_boxes_start_upright_with_their_area() {
    // Half the area of its bounds, so the sides shrink by the root of a half.
    let diamond = Region::Polygon(vec![(50.0, 20.0), (80.0, 40.0), (50.0, 60.0), (20.0, 40.0)]);
    let got = upright(&diamond);
    let half = 0.5_f64.sqrt();
    let (x, y) = got.center();
    assert_near([x, y, got.w, got.h], [50.0, 40.0, 60.0 * half, 40.0 * half], 1e-9, "");
}
