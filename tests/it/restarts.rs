//! Restarts of the reset protocol: pages, figures and `explain` count as the run did, under both protocols.

use crate::tools::{Place, experiment};
use serde_json::Value;
use std::collections::BTreeMap;
use trackfail::report::explain::explain;
use trackfail::report::figures;
use trackfail::report::sequences::collect;
use trackfail::results::{Results, TrackSeries};
use trackfail::sampling::Units;
use trackfail::score::pooled::median_delay;
use trackfail::table::layout::{Origin, origins};

// Worked by hand on `ball`, which has 180 frames; frames count from 0 here. The tracker loses its target in 42 and 88, is
// silent for four frames, and starts anew in 47 and 93.
// `late` alarms in every 15th frame: 45 and 90 find the losses, 3 and 2 frames late; the other 10 alarms are false.
// `late anew` begins again with each piece: 0, 15, 30; 47, 62, 77; 93, 108, 123, 138, 153, 168. Those of 47 and 93 are the
// restarts' own and count for nothing, so that both losses are missed.
// `early anew`: 10, 25, 40; 57, 72, 87; 103, 118, 133, 148, 163, 178. 40 and 87 find the losses, 2 frames and 1 early.
const SPEC: &str = r#"method = [
    { name = "late", detector = { kind = "periodic", period = 15 } },
    { name = "late anew", detector = { kind = "periodic", period = 15 }, protocol = "khalid2016/2" },
    { name = "early anew", detector = { kind = "periodic", period = 15, phase = 10 }, protocol = "khalid2016/2" },
    { name = "restarts anew", detector = { kind = "periodic", period = 1000 }, protocol = "khalid2016/2" },
    { name = "oracle anew", detector = { kind = "oracle" }, protocol = "khalid2016/2" },
    { name = "histogram", signal.kind = "rgb-histogram", detector = { kind = "level", below = 0.9 } },
    { name = "histogram anew", signal.kind = "rgb-histogram", detector = { kind = "level", below = 0.9 }, protocol = "khalid2016/2" },
    { name = "signed", signal.kind = "rgb-histogram", detector = { kind = "level", below = 0.9 }, protocol = "sanmiguel2015/1" },
    { name = "frames", signal.kind = "rgb-histogram", detector = { kind = "level", below = 0.9 }, protocol = "frames/1" },
]
table = [
    { name = "t", rows = ["tp", "recall", "delay_median", "score_mean", "score_std", "auroc", "found_at_5", "aurc", "range_f", "nab"], columns = "method" },
]
figure = [
    { name = "delays", kind = "delay", methods = ["late", "late anew", "early anew"] },
    { name = "strip", kind = "strips", panels = [["error"], ["score:late anew"]] },
]
tracker = [
    { name = "scripted", protocol = "vot-reset", losses = [{ frame = 42, length = 5 }, { frame = 88, length = 5 }] },
]
"#;

#[test]
fn pages_figures_and_explanations_count_as_the_run_did() {
    let place = Place::with(&[("a.toml", &experiment("mine/restarts", "synthetic-vot", SPEC))]);
    place.run("run a.toml -q").ends(0);
    let results = Results::read(&place.path("results/mine/restarts")).unwrap();
    the_table_of_counts_is_that_of_the_run(&results);
    the_page_marks_what_the_run_counted(&place, &results);
    figures_show_what_the_run_counted(&results);
    explain_takes_the_frames_that_count(results);
}

fn the_table_of_counts_is_that_of_the_run(results: &Results) {
    let tallies = collect(results, None).unwrap().tallies();
    let shown = |sequence: &str, method: &str| {
        let row = tallies.rows.iter().find(|row| row.sequence == sequence).unwrap();
        row.cells[tallies.methods.iter().position(|name| name == method).unwrap()].clone()
    };
    let by_hand = [("late", "2 / 0 / 10"), ("late anew", "0 / 2 / 10"), ("early anew", "2 / 0 / 10")];
    for (method, counts) in by_hand {
        assert_eq!(shown("ball", method), counts, "{method}");
    }
    let scores = results.scores().unwrap();
    assert_eq!(scores.len(), tallies.rows.len() * tallies.methods.len());
    for score in &scores {
        let counts = score.counts;
        let expected = format!("{} / {} / {}", counts.tp, counts.fn_, counts.fp);
        assert_eq!(shown(&score.sequence, &score.method), expected, "{score:?}");
    }
}

fn the_page_marks_what_the_run_counted(place: &Place, results: &Results) {
    let page = place.read("reports/mine/restarts/index.html");
    let (_, series) = page.split_once("id=\"series\">").unwrap();
    let (series, _) = series.split_once("</script>").unwrap();
    let all: Value = serde_json::from_str(series).unwrap();
    let place = |list: &str, name: &str| {
        all[list].as_array().unwrap().iter().position(|entry| entry["name"] == name).unwrap()
    };
    let mut delays: BTreeMap<String, Vec<i64>> = BTreeMap::new();
    // Of `frames/1` each frame counts, not the marks.
    for score in results.scores().unwrap().iter().filter(|score| score.method != "frames") {
        let track = format!("{}-0", place("sequences", &score.sequence));
        let said = &all["data"][&track]["said"][place("methods", &score.method).to_string()];
        let marks = said["marks"].as_array().unwrap().iter();
        let marks: Vec<(Option<i64>, Option<i64>)> =
            marks.map(|mark| (mark[0].as_i64(), mark[1].as_i64())).collect();
        let count = |is_it: fn(&(Option<i64>, Option<i64>)) -> bool| {
            marks.iter().filter(|mark| is_it(mark)).count() as u64
        };
        let hits = count(|mark| mark.0.is_some() && mark.1.is_some());
        let (missed, false_alarms) = (count(|mark| mark.1.is_none()), count(|mark| mark.0.is_none()));
        let counts = score.counts;
        assert_eq!((hits, missed, false_alarms), (counts.tp, counts.fn_, counts.fp), "{score:?}: {marks:?}");
        let found = marks.iter().filter_map(|(event, detection)| Some((*detection)? - (*event)?));
        delays.entry(score.method.clone()).or_default().extend(found);
    }
    assert_eq!(delays.len(), 8);
    for (method, delays) in delays {
        let by_hand = match method.as_str() {
            "late" => Some(2.5),
            "late anew" => None,
            "early anew" => Some(-1.5),
            _ => results.measures.iter().find(|measure| measure.method == method).unwrap().pooled.delay,
        };
        assert_eq!(median_delay(delays), by_hand, "{method}");
    }
}

/// The figures of the experiment over these tracks.
fn drawn(results: &Results, tracks: &[TrackSeries]) -> Vec<String> {
    let units = Units::new(&results.experiment, &results.scores().unwrap());
    let svg = |figure| figures::make(results, tracks, &units, figure).unwrap().draw().unwrap().svg;
    results.experiment.figures.iter().map(svg).collect()
}

// An alarm in a restart's own frame counts for nothing, so figures are the same without it.
fn figures_show_what_the_run_counted(results: &Results) {
    let tracks = results.all_tracks().unwrap();
    let without = |method: &str, frames: &[usize]| {
        let mut tracks = tracks.clone();
        for series in tracks.iter_mut().flat_map(|t| &mut t.methods).filter(|m| m.name == method) {
            for t in frames {
                assert!(series.alarm[*t], "{method}: {t}");
                series.alarm[*t] = false;
            }
        }
        drawn(results, &tracks)
    };
    let figures = drawn(results, &tracks);
    assert!(figures == without("late anew", &[47, 93]));
    assert!(figures[0] != without("early anew", &[87])[0]);
    assert!(figures[1] != without("late anew", &[62])[1]);
}

fn explain_takes_the_frames_that_count(mut results: Results) {
    // The number of an attribute that all sequences have is made of the frames again.
    let names: Vec<String> = results.manifest.suite.present.iter().map(|(name, _)| name.clone()).collect();
    results.manifest.suite.attributes =
        names.into_iter().map(|name| (name, vec!["any".to_string()])).collect();
    let scores = results.scores().unwrap();
    let cells = origins(&results.experiment, &results.experiment.tables[0], &results.measures);
    assert_eq!(cells.len(), 10 * 9);
    for cell in &cells {
        let printed = explain(&results, &scores, cell).unwrap();
        let again = Origin { attribute: Some("any".to_string()), ..cell.clone() };
        let again = explain(&results, &scores, &again).unwrap().value;
        let near = |(one, other): (f64, f64)| (one - other).abs() < 1e-9;
        let is_same = printed.value.zip(again).map_or(printed.value == again, near);
        assert!(is_same, "{cell:?}: {:?} {again:?}", printed.value);
        // By hand: `ball` has 43 + 41 + 86 frames that count, alarms (score 1) in ten of them and in neither of the two that
        // are lost; the area is P(lost above good) + P(equal) / 2.
        let by_hand = match (cell.method.as_str(), cell.metric.name()) {
            ("late anew", "score_mean") => 10.0 / 170.0,
            ("late anew", "auroc") => 0.5 * 158.0 / 168.0,
            // Alarms in the restarts' own frames find nothing; the frames that are skipped need not be found.
            ("restarts anew", "range_f") => 0.0,
            ("oracle anew", "range_f" | "recall") => 1.0,
            _ => continue,
        };
        let alone = printed.parts.iter().find(|part| part.sequence == "ball").unwrap().alone.unwrap();
        assert!((alone - by_hand).abs() < 1e-12, "{cell:?}: {alone}");
    }
}
