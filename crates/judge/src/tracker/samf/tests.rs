use super::*;
use crate::tracker::testing::texture;

#[test]
fn channels_are_those_of_the_table() {
    let region = Region::Rect(Rect::new(60.0, 40.0, 32.0, 24.0));
    for (gray, channels) in [(false, 42), (true, 33)] {
        let frame = texture(0.0, 0.0, 1.0, gray);
        let Follower { place, mut look, .. } = Params::default().follower(&frame, &region);
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
