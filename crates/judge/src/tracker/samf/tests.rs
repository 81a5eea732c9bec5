use super::*;
use crate::region::Rect;
use crate::tracker::testing::{self, texture};
use proptest::prelude::*;

fn follow(params: &str, region: &Region, frames: &[Frame]) -> Rect {
    testing::follow(&ENTRY, params, region, frames).rect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn whole_cells_are_followed_without_bias(
        dx in -3_i32..4, dy in -3_i32..4, gray in any::<bool>(), x in 60.0..64.0, y in 40.0..44.0,
    ) {
        // The window is exactly as large as the sample, so that shifts of the frame are shifts of the cells.
        let first = Rect::new(x, y, 32.0, 24.0);
        let (dx, dy) = (4.0 * f64::from(dx), 4.0 * f64::from(dy));
        let frames = [texture(0.0, 0.0, 1.0, gray), texture(dx, dy, 1.0, gray)];
        let got = follow("{}", &Region::Rect(first), &frames);
        let want = first.shifted(dx, dy);
        prop_assert!((got.x - want.x).abs() < 1e-6 && (got.y - want.y).abs() < 1e-6, "{:?} {:?}", got, want);
        prop_assert_eq!((got.w, got.h), (32.0, 24.0));
    }
}

#[test]
fn grows_and_shrinks_with_its_target() {
    let first = Rect::new(60.0, 40.0, 40.0, 40.0);
    for step in [1.008_f64, 1.0 / 1.008] {
        let frames: Vec<Frame> = (0..20).map(|t| texture(0.0, 0.0, step.powi(t), false)).collect();
        let got = follow("{}", &Region::Rect(first), &frames);
        let want = 40.0 * step.powi(19);
        assert!(
            (got.w / want - 1.0).abs() < 0.06 && (got.w - got.h).abs() < 1e-9,
            "{got:?} instead of {want}"
        );
        assert_eq!(follow("{ scales = [1] }", &Region::Rect(first), &frames).w, 40.0);
    }
}

#[test]
fn channels_are_those_of_the_table() {
    let region = Region::Rect(Rect::new(60.0, 40.0, 32.0, 24.0));
    for (gray, names, channels) in
        [(false, true, 42), (false, false, 32), (true, true, 33), (true, false, 33)]
    {
        let p = Params { color_names: names, ..Params::default() };
        let frame = texture(0.0, 0.0, 1.0, gray);
        let Follower { place, mut look, .. } = Samf(p).follower(&frame, &region);
        let mut features = Vec::new();
        look.look(&place, &frame, 1.0, &mut features);
        let cells = 20 * 15;
        assert_eq!(features.len(), channels * cells);
        let extra = &features[31 * cells..];
        // Center (76.5, 52.5), window 80 x 60: the first sample is at (38, 23.5), between columns 37 and 38 of row 23.
        let place = |x: usize, y: usize| {
            let mut sum = [0.0; 3];
            for j in 0..4 {
                for i in 0..4 {
                    // Half-way between two columns, rounded half up.
                    let (a, b) = (frame.pixel(x + i, y + j), frame.pixel(x + i + 1, y + j));
                    for c in 0..3 {
                        sum[c] += ((f64::from(a[c]) + f64::from(b[c])) / 2.0 + 0.5).floor() / 16.0;
                    }
                }
            }
            0.2989 * sum[0] + 0.587 * sum[1] + 0.114 * sum[2]
        };
        let want = place(37 + 4 * 3, 23 + 4 * 5) / 255.0 - 0.5;
        let got = f64::from(extra[5 * 20 + 3]);
        assert!((got - want).abs() < 2e-3, "{got} {want}");
        if gray {
            assert_eq!(extra[..cells], extra[cells..]);
        }
    }
}

#[test]
fn there_are_some_scales() {
    let key = |scales: &[f64]| {
        ENTRY.build_from_text(&format!("{{ scales = {scales:?} }}")).err().and_then(|e| e.key)
    };
    assert_eq!((key(&[]), key(&[1.0, 0.1])), (Some("scales"), Some("scales")));
    assert_eq!((key(&[1.0; MAX_SCALES]), key(&[1.0; MAX_SCALES + 1])), (None, Some("scales")));
}
