use super::*;
use crate::region::Areas;
use crate::tracker::testing;

/// Reference boxes and scores are from benches/peers/nanotrack.py, on the frames of `trackfail data render
/// synthetic-otb` (60 of Girl), from the second frame on. That program resizes crops in steps of 1/2048,
/// which moves boxes by hundredths of a pixel at first; later a crop sometimes begins one pixel off.
#[test]
fn tracks_are_those_of_onnxruntime() {
    let (girl, start, frames) = testing::excerpt(60);
    for (version, oracle) in
        [("v2", include_str!("onnxruntime_v2.txt")), ("v3", include_str!("onnxruntime_v3.txt"))]
    {
        let config = ENTRY.build_from_text(&format!("{{ version = \"{version}\" }}")).unwrap();
        let states = testing::track(&*config, &girl, 1, &start, &frames);
        let lines: Vec<&str> = oracle.lines().collect();
        assert_eq!(lines.len(), states.len() - 1);
        let mut overlaps = Vec::new();
        for (state, line) in states[1..].iter().zip(&lines) {
            let want: Vec<f64> = line.split(' ').map(|v| v.parse().unwrap()).collect();
            let region = Region::Rect(Rect::new(want[0], want[1], want[2], want[3]));
            overlaps.push(Areas::Exact.overlap(&state.region, &region, None));
            assert!((state.confidence.unwrap() - want[4]).abs() < 0.01, "{version}: {line}");
        }
        let least = |overlaps: &[f64]| overlaps.iter().copied().fold(1.0, f64::min);
        assert!(least(&overlaps[..3]) > 0.99, "{version}: {overlaps:?}");
        assert!(least(&overlaps) > 0.85, "{version}: {overlaps:?}");
        assert!(overlaps.iter().sum::<f64>() / overlaps.len() as f64 > 0.95, "{version}: {overlaps:?}");
    }
}

#[test]
fn a_saved_tracker_goes_on() {
    let (girl, start, frames) = testing::excerpt(6);
    for version in ["v2", "v3"] {
        let config = ENTRY.build_from_text(&format!("{{ version = \"{version}\" }}")).unwrap();
        let (mut tracker, _) = config.start(&testing::context(&girl, 1), &frames[0], &start).unwrap();
        tracker.update(&frames[1]).unwrap();
        let saved = tracker.save().unwrap();
        let mut resumed = config.resume(&saved).unwrap();
        for frame in &frames[2..] {
            assert_eq!(resumed.update(frame).unwrap(), tracker.update(frame).unwrap());
        }
        let other = ENTRY.build_from_text("{ version = \"v3\" }").unwrap();
        assert_eq!(other.resume(&saved).is_some(), version == "v3");
        assert!(config.resume(&saved[..saved.len() - 1]).is_none());
        assert!(config.resume(&[]).is_none());
    }
}
