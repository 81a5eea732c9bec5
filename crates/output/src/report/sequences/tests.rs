use super::json::{beside, embedded, in_a_page};
use super::*;
use crate::results::MethodSeries;
use proptest::prelude::*;
use serde_json::{Value, json};
use trackfail_dataset::text::visible;
use trackfail_methods::score::{TrackScore, khalid2016};

/// A track of `frames` frames; the target is lost in frames 20 to 29.
fn track(frames: usize) -> TrackSeries {
    TrackSeries {
        rects: (0..frames).map(|t| Rect::new(t as f64 / 3.0, 10.0, 20.0, 30.0)).collect(),
        error: (0..frames).map(|t| if (20..30).contains(&t) { 1.0 } else { 0.25 }).collect(),
        ..TrackSeries::default()
    }
}

/// Results of a method on a track; its alarm starts `late` frames after the loss.
fn said(track: &TrackSeries, late: usize, threshold: Option<f64>) -> Said {
    let frames = track.error.len();
    let series = MethodSeries {
        score: (0..frames).map(|t| t as f64 * 1e-4).collect(),
        alarm: (0..frames).map(|t| (20 + late..30 + late).contains(&t)).collect(),
        changes: vec![0; frames],
        ..MethodSeries::default()
    };
    let judged = track.judge(&khalid2016::PROTOCOL, &series.alarm, &series.changes);
    Said::new(track, &series, &judged, threshold)
}

/// Two trackers on two sequences of `frames` frames. The first method alarms 2 frames after the loss, the
/// second 12.
fn sequences(name: &str, frames: usize) -> Sequences {
    let truth = |slant: f64| {
        let polygon = vec![(0.0, slant), (4.04, 0.0), (4.04, 3.0), (0.0, 3.0)];
        (0..frames).map(|t| (t != 1).then(|| Region::Polygon(polygon.clone()))).collect()
    };
    let sequence = |name: &str, slant: f64| Sequence {
        name: name.into(),
        first: 1,
        size: Some((320, 240)),
        attributes: vec![name.to_string()],
        truth: truth(slant),
        stills: BTreeSet::from([3]),
        ..Sequence::default()
    };
    let series = track(frames);
    let first = [(0_usize, said(&series, 2, Some(0.0041))), (1, said(&series, 12, Some(0.0041)))];
    let second = [(1_usize, said(&series, 12, None))];
    let thresholds = vec![Some(0.0041), None];
    let method =
        |name: &str| Method { name: name.into(), thresholds: thresholds.clone(), ..Method::default() };
    Sequences {
        trackers: vec![name.to_string(), "KCF".into()],
        methods: vec![method(name), method("RAW")],
        sequences: vec![sequence(name, 0.0), sequence("Bolt", 1.0)],
        tracks: vec![
            Track::new([0, 0], &series, &series.rects, first.clone().into()),
            Track::new([0, 1], &series, &[], second.into()),
            Track::new([1, 0], &series, &series.rects, first.into()),
        ],
        ..Sequences::default()
    }
}

/// Restores the values of a column of differences.
fn column(differences: &Value) -> Vec<Option<i64>> {
    let mut sum = 0;
    let mut next = |v: &Value| {
        sum += v.as_i64()?;
        Some(sum)
    };
    differences.as_array().unwrap().iter().map(&mut next).collect()
}

/// All series as the page has them.
fn packed(all: &Sequences) -> Value {
    serde_json::from_str(&embedded(all, usize::MAX).unwrap()).unwrap()
}

#[test]
fn series_that_are_too_long_are_not_packed() {
    let all = sequences("Girl", 60);
    let whole = embedded(&all, usize::MAX).unwrap();
    assert_eq!(embedded(&all, whole.len()), Some(whole.clone()));
    for most in [0, 1000, whole.len() / 2, whole.len() - 1] {
        assert_eq!(embedded(&all, most), None, "{most}");
    }
}

#[test]
fn counts_by_hand() {
    let tallies = sequences("Girl", 60).tallies();
    let cells: Vec<_> = tallies.rows.iter().map(|r| r.cells.clone()).collect();
    assert_eq!(cells, [["1 / 0 / 0", "0 / 1 / 1"], ["", "0 / 1 / 1"], ["1 / 0 / 0", "0 / 1 / 1"]]);
    assert_eq!(tallies.totals, ["2 / 0 / 0", "0 / 3 / 3"]);
    assert_eq!(tallies.attributes, ["Bolt", "Girl"]);
    assert_eq!((tallies.rows[0].marks.as_str(), tallies.rows[2].marks.as_str()), ("1", "0"));
}

#[test]
fn series_by_hand() {
    let all = packed(&sequences("Girl", 60));
    for (place, value) in [
        ("/trackers", json!(["Girl", "KCF"])),
        ("/methods/1/thresholds", json!([0.0041, null])),
        ("/start", json!([0, 0, 0])),
        ("/tracks", json!([[0, 0, null], [0, 1, null], [1, 0, null]])),
        ("/sequences/0/stills", json!([3])),
        ("/sequences/0/frames", json!(60)),
        ("/sequences/0/size/1", json!(240)),
        ("/words/outcome", json!(["hit", "missed", "false alarm"])),
        ("/data/0-0/said/0/marks", json!([[20, 22, 0, 0]])),
        ("/data/0-0/said/1/marks", json!([[20, null, 0, 0], [null, 32, 0, 0]])),
        ("/data/0-0/said/0/alarms", json!([22, 31])),
        // Four digits of 0.0041: steps of 1e-6; without a threshold four digits of the largest score, 0.0059.
        ("/data/0-0/said/0/digits", json!(6)),
        ("/data/0-1/said/1/digits", json!(6)),
    ] {
        assert_eq!(all.pointer(place), Some(&value), "{place}");
    }
    // Upright polygons are rectangles; the slanted ones have corners.
    let sides = |sequence: &str| all["truth"][sequence].as_array().unwrap().len();
    assert_eq!((sides("0"), sides("1")), (4, 8));
    assert_eq!(column(&all["truth"]["0"][2])[..3], [Some(40), None, Some(40)]);
    let track = &all["data"]["0-0"];
    assert_eq!(column(&track["box"][0])[..4], [Some(0), Some(3), Some(7), Some(10)]);
    assert_eq!(column(&track["error"])[19..21], [Some(250), Some(1000)]);
    assert_eq!(column(&track["said"]["0"]["score"])[..3], [Some(0), Some(100), Some(200)]);
    assert!(all["data"]["0-1"]["background"].is_null() && !track["background"].is_null());
}

#[test]
fn no_error_below_one_is_rounded_to_lost() {
    let mut all = sequences("Girl", 4);
    let series = TrackSeries { error: vec![0.99999, 1.0, f64::NAN, 0.5], ..track(4) };
    all.tracks = vec![Track::new([0, 0], &series, &[], BTreeMap::new())];
    let all = packed(&all);
    assert_eq!(column(&all["data"]["0-0"]["error"]), [Some(999), Some(1000), None, Some(500)]);
}

#[test]
fn long_series_lie_in_files_that_hold_the_same() {
    let all = sequences("Girl", 40_000);
    let mut files: Vec<(String, String)> = Vec::new();
    let split = beside::<()>(&all, |name, text| {
        files.push((name.to_string(), text.to_string()));
        Ok(())
    });
    let (split, count) = split.unwrap();
    assert_eq!(beside(&all, |_, _| Err("full")), Err("full"));
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!((count, &names[..]), (3, &["data/00-000.js", "data/00-001.js", "data/01-000.js"][..]));
    let whole = packed(&all);
    let index: Value = serde_json::from_str(&split).unwrap();
    assert_eq!(index["tracks"], json!([[0, 0, 0], [0, 1, 2], [1, 0, 1]]));
    assert!(index["data"].as_object().unwrap().is_empty() && split.len() < 1000);
    for track in index["tracks"].as_array().unwrap() {
        let [s, t, file] = [0, 1, 2].map(|k| track[k].as_u64().unwrap() as usize);
        let text = &files[file].1;
        let part = text.strip_prefix("trackfail(").unwrap().strip_suffix(");\n").unwrap();
        let part: Value = serde_json::from_str(part).unwrap();
        let key = format!("{s}-{t}");
        assert_eq!(part["data"][&key], whole["data"][&key]);
        assert_eq!(part["truth"][s.to_string()], whole["truth"][s.to_string()]);
    }
}

proptest! {
    #[test]
    fn any_name_is_the_same_name_in_the_page(name in "\\PC{0,40}|[<>&\"'/!\\\\\\-\u{2028}\u{2029}\u{202e}\\x00-\\x1f]{0,40}") {
        let packed = embedded(&sequences(&name, 25), usize::MAX).unwrap();
        let is_markup = packed.contains(['<', '>', '&', '\u{2028}', '\u{2029}']);
        prop_assert!(!is_markup);
        let all: Value = serde_json::from_str(&packed).unwrap();
        prop_assert_eq!(all["sequences"][0]["name"].as_str().unwrap(), visible(&name));
        let json = serde_json::to_string(&name).unwrap();
        let back: String = serde_json::from_str(&in_a_page(&json)).unwrap();
        prop_assert_eq!(back, name);
    }

    #[test]
    fn any_numbers_are_read_back_as_near_as_shown(values in prop::collection::vec(prop::num::f64::ANY, 1..30)) {
        let mut all = sequences("Girl", values.len());
        let rects = values.iter().map(|v| Rect::new(*v, *v, *v, *v)).collect();
        let series = TrackSeries { rects, ..track(values.len()) };
        let method = MethodSeries { score: values.clone(), ..MethodSeries::default() };
        let said = Said::new(&series, &method, &TrackScore::default(), Some(0.0041));
        all.tracks = vec![Track::new([0, 0], &series, &[], BTreeMap::from([(0, said)]))];
        let all = packed(&all);
        let track = &all["data"]["0-0"];
        for (got, v) in column(&track["box"][1]).into_iter().zip(&values) {
            prop_assert_eq!(got.is_some(), (v * 10.0).is_finite());
            if v.abs() < 1e12 {
                prop_assert!((got.unwrap() as f64 / 10.0 - v).abs() <= 0.0501);
            }
        }
        prop_assert_eq!(column(&track["said"]["0"]["score"]).len(), values.len());
    }
}
