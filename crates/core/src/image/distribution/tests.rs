use super::*;
use proptest::prelude::*;
use trackfail_testing::assert_near;

// scipy.signal.windows.gaussian(5, 0.625) / its sum, from the middle on (SciPy 1.17.1).
#[test]
fn gaussian_agrees_with_scipy() {
    let expected = [0.6377442641723289, 0.177316693589983, 0.0038111743238525555];
    assert_near(gaussian(0.625, 2), expected, 1e-15, "");
}

const PATCHES: [Patch; 2] = [Patch { strip: 0, top: 0 }, Patch { strip: 1, top: 0 }];

/// Half kernels: horizontal, vertical and over layers.
type Kernels = [Vec<f64>; 3];

fn kernels((u, v, l): (usize, usize, usize)) -> Kernels {
    [gaussian(1.0, u), gaussian(2.0, v), gaussian(0.625, l)]
}

fn smoothing(layers: usize, [u, v, l]: &Kernels, border: Border) -> Smoothing {
    Smoothing::new(layers, u, v, l, border)
}

/// Distance of two windows of width `w` whose layers are stored column by column.
fn l1(smoothing: &Smoothing, w: usize, a: &[u8], b: &[u8]) -> f64 {
    let mut sums = [0.0];
    let size = (w, a.len() / w);
    FieldDistance::default().l1(smoothing, size, &[a, b], PATCHES[0], &[Some(PATCHES[1])], &mut sums);
    sums[0]
}

/// Distribution field by its definition, in `f64`: layers of each pixel, column by column.
fn field(layers: usize, [u, v, l]: &Kernels, border: Border, w: usize, p: &[u8]) -> Vec<Vec<f64>> {
    let h = p.len() / w;
    let place = |at: usize, shift: usize, radius: usize, len: usize| match (at + shift).checked_sub(radius) {
        Some(to) if to < len => Some(to),
        _ if border == Border::Common => None,
        to => Some(to.map_or(0, |_| len - 1)),
    };
    let mut field = Vec::new();
    for (j, i) in (0..w).flat_map(|j| (0..h).map(move |i| (j, i))) {
        let mut pixel = vec![0.0; layers];
        for r in 0..2 * u.len() - 1 {
            for k in 0..2 * v.len() - 1 {
                let (x, y) = (place(j, r, u.len() - 1, w), place(i, k, v.len() - 1, h));
                let (Some(x), Some(y)) = (x, y) else { continue };
                let weight = u[r.abs_diff(u.len() - 1)] * v[k.abs_diff(v.len() - 1)];
                for s in 0..2 * l.len() - 1 {
                    let part = weight * l[s.abs_diff(l.len() - 1)];
                    match (usize::from(p[x * h + y]) + s).checked_sub(l.len() - 1) {
                        Some(m) if m < layers => pixel[m] += part,
                        _ => pixel.iter_mut().for_each(|d| *d += part / layers as f64),
                    }
                }
            }
        }
        field.push(pixel);
    }
    field
}

fn l1_by_definition(layers: usize, kernels: &Kernels, border: Border, w: usize, a: &[u8], b: &[u8]) -> f64 {
    let [a, b] = [a, b].map(|p| field(layers, kernels, border, w, p));
    zip(a.iter().flatten(), b.iter().flatten()).map(|(a, b)| (a - b).abs()).sum()
}

#[test]
fn lost_mass_is_spread_evenly() {
    // Layers 0 and 3 of 4, no spatial smoothing, g = (a, b, a): both lose `a`, the even parts cancel
    // and the difference is (b, a, -a, -b).
    let over_layers = gaussian(0.625, 1);
    let s = Smoothing::new(4, &[1.0], &[1.0], &over_layers, Border::Common);
    let [b, a] = over_layers[..] else { unreachable!() };
    assert!((l1(&s, 1, &[0], &[3]) - 2.0 * (a + b)).abs() < 1e-6);
    // Against layer 1 (a, b, a, 0) the first has (b, a, 0, 0) + a / 4.
    let expected = (b - a + a / 4.0).abs() + (a - b + a / 4.0).abs() + (a / 4.0 - a).abs() + a / 4.0;
    assert!((l1(&s, 1, &[0], &[1]) - expected).abs() < 1e-6);
}

#[test]
fn weights_keep_their_sum() {
    for (half, total) in [(gaussian(1.0, 4), UNITS), (gaussian(1000.0, 31), UNITS), (gaussian(2.0, 7), 1000)]
    {
        let units = whole(&half, total);
        assert_eq!(units[0] + 2 * units[1..].iter().sum::<u32>(), total);
        for (&units, g) in zip(&units, &half) {
            assert!((f64::from(units) - g * f64::from(total)).abs() <= 1.0);
        }
    }
}

fn planes() -> impl Strategy<Value = (usize, Vec<u8>, Vec<u8>)> {
    (1..24_usize, 1..40_usize, 1..20_u8).prop_flat_map(|(w, h, step)| {
        let plane = move |low: u8| proptest::collection::vec(low..low + step, w * h);
        (Just(w), (0..=20 - step).prop_flat_map(plane), (0..=20 - step).prop_flat_map(plane))
    })
}

fn radii() -> impl Strategy<Value = (usize, usize, usize)> {
    prop_oneof![Just((4, 7, 2)), Just((4, 4, 2)), Just((7, 7, 2)), (0..12_usize, 0..9_usize, 0..6_usize)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn agrees_with_the_definition((w, a, b) in planes(), radii in radii(), more in 0..30_usize) {
        let kernels = kernels(radii);
        for border in [Border::Common, Border::Replicate] {
            let d = l1(&smoothing(20 + more, &kernels, border), w, &a, &b);
            let expected = l1_by_definition(20 + more, &kernels, border, w, &a, &b);
            prop_assert!((d - expected).abs() <= 1e-6 * expected, "{} {}", d, expected);
        }
    }

    #[test]
    fn is_a_bounded_distance((w, a, b) in planes(), radii in radii()) {
        for border in [Border::Common, Border::Replicate] {
            let s = smoothing(20, &kernels(radii), border);
            prop_assert_eq!(l1(&s, w, &a, &a), 0.0);
            let d = l1(&s, w, &a, &b);
            prop_assert_eq!(d, l1(&s, w, &b, &a));
            prop_assert!(d >= 0.0 && d <= (2.0 + 1e-6) * a.len() as f64);
            // A window beside the others changes nothing, nor do buffers used before.
            let (mut sums, mut buffers) = ([0.0; 3], FieldDistance::default());
            let [p, q] = PATCHES;
            let size = (w, a.len() / w);
            buffers.l1(&s, size, &[&b, &a], p, &[Some(q), None, Some(p)], &mut sums);
            sums = [0.0; 3];
            buffers.l1(&s, size, &[&a, &b], p, &[None, Some(q), Some(p)], &mut sums);
            prop_assert_eq!(sums, [0.0, d, 0.0]);
        }
    }

    #[test]
    fn windows_of_one_strip_are_windows((w, a, b) in planes(), radii in radii(), top in 0..20_usize) {
        let (h, rows) = (a.len() / w, a.len() / w + top);
        // `b`, below some rows of `a`, and with its last row once more.
        let mut strip = Vec::new();
        for (a, b) in zip(a.chunks_exact(h), b.chunks_exact(h)) {
            strip.extend(a.iter().cycle().take(top));
            strip.extend_from_slice(b);
        }
        prop_assert_eq!(strip.len(), w * rows);
        for border in [Border::Common, Border::Replicate] {
            let s = smoothing(20, &kernels(radii), border);
            let mut sums = [0.0];
            let lower = Patch { strip: 1, top };
            FieldDistance::default().l1(&s, (w, h), &[&a, &strip], PATCHES[0], &[Some(lower)], &mut sums);
            let alone = l1(&s, w, &a, &b);
            prop_assert!((sums[0] - alone).abs() <= 1e-12 * alone);
        }
    }
}
