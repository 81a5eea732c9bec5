//! From a number of a table down to the frames, by the results alone.

use crate::sent::place_with;
use crate::tools::{Place, experiment};
use serde_json::Value;
use trackfail_testing::hostile::markup;

const SPEC: &str = r#"tracker = [{ name = "ncc" }]
table = [{ name = "t", rows = ["tp", "recall", "score_mean", "auroc"], columns = "method" }]
method = [
    { name = "level", signal.kind = "rgb-histogram", detector = { kind = "level", below = 0.9 } },
    { name = "signed", signal.kind = "rgb-histogram", detector = { kind = "level", below = 0.9 }, protocol = "sanmiguel2015/1" },
    { name = "frames", signal.kind = "rgb-histogram", detector = { kind = "level", below = 0.9 }, protocol = "frames/1" },
    { name = "clear", signal.kind = "rgb-histogram", detector = { kind = "level", above = 0.9 }, protocol = "frames-clear/1" },
    { name = "nab", signal.kind = "rgb-histogram", detector = { kind = "level", below = 0.9 }, protocol = "nab/1" },
]
"#;

fn rows(place: &Place, words: &str) -> Vec<Value> {
    serde_json::from_str(&place.run(&format!("explain {words} --format json")).ends(0).out).unwrap()
}

#[test]
fn a_number_is_taken_apart_down_to_its_frames() {
    let place = Place::with(&[("a.toml", &experiment("mine/small", "synthetic-vot", SPEC))]);
    place.run("explain t tp level").refuses(2, "no finished experiment in results");
    place.run("run a.toml -q").ends(0);
    let pooled = place.read("results/mine/small/measures.csv");
    for method in ["level", "signed", "frames", "clear", "nab"] {
        let line = pooled.lines().find(|l| l.split(',').nth(2) == Some(method)).unwrap();
        let counts: Vec<u64> = line.split(',').skip(6).take(4).map(|n| n.parse().unwrap()).collect();
        assert!(counts[..3].iter().all(|count| *count > 0), "{method} {counts:?}");
        let parts = rows(&place, &format!("t tp {method}"));
        // As tables show the metric.
        assert_eq!(rows(&place, &format!("t 'True positives' {method}")), parts);
        let of = |part: &Value, name: &str| part[name].as_u64().unwrap();
        for (name, total) in ["tp", "fp", "fn", "tn"].iter().zip(&counts) {
            assert_eq!(parts.iter().map(|p| of(p, name)).sum::<u64>(), *total, "{method} {name}");
        }
        // A sequence moves a count by its own count.
        assert!(parts.iter().all(|p| p["moves"].as_f64() == p["tp"].as_f64()));
        assert!(parts.is_sorted_by_key(|p| std::cmp::Reverse(of(p, "tp"))));

        // The events or stretches of frames listed for each sequence add up to its counts.
        for part in &parts {
            let name = part["sequence"].as_str().unwrap();
            let listed = rows(&place, &format!("mine/small/t tp {method} --sequence '{name}'"));
            for (counted, outcome) in [("tp", "hit"), ("fp", "false alarm"), ("fn", "missed")] {
                let events = listed.iter().filter(|r| r["outcome"] == outcome).count() as u64;
                let stretches = listed.iter().filter(|r| r["counts as"] == counted);
                let frames: u64 = stretches.map(|r| of(r, "frames")).sum();
                assert_eq!(events + frames, of(part, counted), "{method} {name} {counted}");
            }
            // A window of NAB is longer.
            let is_far = |r: &Value| r["distance"].as_i64().is_some_and(|d| d.abs() > 5);
            assert!(method == "nab" || !listed.iter().any(is_far));
            // Every detection is marked in its frame.
            for detection in listed.iter().filter_map(|r| r["detection"].as_u64()).take(3) {
                let frames = rows(&place, &format!("t tp {method} --sequence '{name}' --frames {detection}"));
                assert_eq!(frames.len(), 1);
                assert_eq!(frames[0]["frame"].as_u64(), Some(detection));
                assert!(frames[0]["mark"].as_str().unwrap().contains("detection: "), "{frames:?}");
            }
        }
        // Without a sequence there is another area.
        for part in rows(&place, &format!("t auroc {method}")) {
            assert!(part["without"].as_f64().is_some_and(|v| (0.0..=1.0).contains(&v)), "{part}");
        }
    }
    // The mean of all scores does not come from counts; it is computed again from the frames.
    assert!(rows(&place, "t score_mean level").iter().any(|p| p["moves"].as_f64().is_some_and(|m| m != 0.0)));

    // Unknown names are refused with the nearest known one.
    for (words, told) in [
        ("x tp level", "unknown table `x`"),
        ("mine/smal/t tp level", "did you mean `mine/small`?"),
        ("mine/small/u tp level", "did you mean `t`?"),
        ("t recal level", "did you mean `recall`?"),
        ("t f1 level", "unknown row `f1`; there is: tp, recall, score_mean, auroc"),
        ("t score level", "did you mean `score_mean`?"),
        ("small/t tp level", "unknown finished experiment `small`; did you mean `mine/small`?"),
        ("t tp levl", "did you mean `level`?"),
        ("t tp level --tracker nc", "did you mean `ncc`?"),
        ("t tp level --sequence \u{1b}[2J", "unknown sequence"),
        ("t tp level --sequence a --frames 9-3", "names no frames"),
        ("t tp level --sequence ball --frames 5000-5001", "--frames 5000-5001: ball has the frames 1 to "),
        ("../t tp level", "unknown finished experiment"),
    ] {
        place.run(&format!("explain {words}")).refuses(2, told);
    }
}

// Before: the frames were taken to contradict the scores.
#[test]
fn compact_results_say_that_they_have_no_frames() {
    let place = place_with("khalid2016/table1");
    let number = "explain khalid2016/table1/table1 f_score DTEF --tracker SP";
    place.run(number).ends(0).says("how far a sequence moves the number").never_says("--sequence");
    let down = place.run(&format!("{number} --sequence Girl"));
    down.refuses(2, "khalid2016/table1: these results are compact").tells("without --compact");
}

/// The page of an experiment and the command that it names explain a number alike.
#[test]
fn numbers_are_explained_as_the_command_explains_them() {
    let place = crate::tools::page::page_of_a_run();
    let page = markup(&place.read("reports/mine/page/index.html"));
    let links = page.split('\u{1}').filter(|element| element.starts_with("a\u{2}class=origin"));
    let titles = links.map(|link| link.split("\u{2}title=").nth(1).unwrap().split('\u{3}').next().unwrap());
    let titles: Vec<Vec<&str>> = titles.map(|title| title.split('\n').collect()).collect();
    // Three measures of two methods on two trackers, and of one more on the first.
    assert_eq!(titles.len(), 3 * 5);
    for title in titles {
        let [number, formula, command] = title[..] else { panic!("{title:?}") };
        let out = place.shell(command).out;
        assert!(out.lines().any(|line| line.trim() == formula), "{number}: {formula}\n{out}");
        let (method, tracker) = number.split_once(" is ").unwrap().0.split_once(" on ").unwrap();
        assert!(out.starts_with(&format!("mine/page/t, tracker {tracker}: {method} is ")), "{out}");
        assert_eq!(out.matches(", tracker ").count(), 1, "{out}");
    }
}
