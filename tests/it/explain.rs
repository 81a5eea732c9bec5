//! From a number of a table down to the frames, by the results alone.

use crate::tools::Place;
use serde_json::Value;

const SPEC: &str = r#"schema = 1
name = "mine/small"
title = "t"
protocol = "khalid2016/1"
suites.test = "synthetic-vot"
tracker = [{ name = "still" }]
table = [{ name = "t", rows = ["tp", "recall", "score_mean"], columns = "method" }]
method = [
    { name = "level", signal.kind = "rgb-histogram", detector = { kind = "level", below = 0.9 } },
    { name = "signed", signal.kind = "rgb-histogram", detector = { kind = "level", below = 0.9 }, protocol = "sanmiguel2015/1" },
    { name = "frames", signal.kind = "rgb-histogram", detector = { kind = "level", below = 0.9 }, protocol = "sanmiguel2015-segmentation/1" },
]
"#;

fn rows(place: &Place, words: &str) -> Vec<Value> {
    serde_json::from_str(&place.run(&format!("explain {words} --format json")).ends(0).out).unwrap()
}

#[test]
fn a_number_is_taken_apart_down_to_its_frames() {
    let place = Place::with(&[("a.toml", SPEC)]);
    place.run("run a.toml -q").ends(0);
    let pooled = place.read("results/mine/small/measures.csv");
    for method in ["level", "signed", "frames"] {
        let line = pooled.lines().find(|l| l.split(',').nth(2) == Some(method)).unwrap();
        let counts: Vec<u64> = line.split(',').skip(6).take(4).map(|n| n.parse().unwrap()).collect();
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

        // The events listed for each sequence add up to its counts.
        for part in &parts {
            let name = part["sequence"].as_str().unwrap();
            let listed = rows(&place, &format!("mine/small/t tp {method} --sequence '{name}'"));
            if method == "frames" {
                for counted in ["tp", "fp", "fn", "tn"] {
                    let mine = listed.iter().filter(|r| r["counts as"] == counted);
                    assert_eq!(mine.map(|r| of(r, "frames")).sum::<u64>(), of(part, counted));
                }
                continue;
            }
            let count = |outcome: &str| listed.iter().filter(|r| r["outcome"] == outcome).count() as u64;
            let outcomes = ["hit", "false alarm", "missed"].map(count);
            assert_eq!(outcomes, ["tp", "fp", "fn"].map(|n| of(part, n)), "{method} {name}");
            let far = |r: &&Value| r["distance"].as_i64().is_some_and(|d| d.abs() > 5);
            assert!(!listed.iter().any(|r| far(&r)));
            // Every detection is marked in its frame.
            for detection in listed.iter().filter_map(|r| r["detection"].as_u64()).take(3) {
                let words = format!("t tp {method} --sequence '{name}' --frames {detection}");
                let frames = rows(&place, &words);
                assert_eq!(frames.len(), 1);
                assert_eq!(frames[0]["frame"].as_u64(), Some(detection));
                assert!(frames[0]["mark"].as_str().unwrap().contains("detection: "), "{frames:?}");
            }
        }
    }
    // The mean of all scores does not come from counts; it is computed again from the frames.
    let parts = rows(&place, "t score_mean level");
    assert!(parts.iter().any(|p| p["moves"].as_f64().is_some_and(|m| m != 0.0)));
}

#[test]
fn unknown_names_are_refused_with_the_nearest_known_one() {
    let place = Place::with(&[("a.toml", SPEC)]);
    let none = "no finished experiment in results: nothing has been run there yet";
    place.run("explain t tp level").refuses(2, none);
    place.run("run a.toml -q").ends(0);
    for (words, told) in [
        ("x tp level", "unknown table `x`"),
        ("mine/smal/t tp level", "did you mean `mine/small`?"),
        ("mine/small/u tp level", "did you mean `t`?"),
        ("t recal level", "did you mean `recall`?"),
        ("t f1 level", "unknown row `f1`; there is: tp, recall, score_mean"),
        ("t score level", "did you mean `score_mean`?"),
        ("small/t tp level", "unknown finished experiment `small`; did you mean `mine/small`?"),
        ("t tp levl", "did you mean `level`?"),
        ("t tp level --tracker stil", "did you mean `still`?"),
        ("t tp level --sequence \u{1b}[2J", "unknown sequence"),
        ("t tp level --sequence a --frames 9-3", "names no frames"),
        ("t tp level --sequence ball --frames 5000-5001", "--frames 5000-5001: ball has the frames 1 to "),
        ("../t tp level", "unknown finished experiment"),
    ] {
        place.run(&format!("explain {words}")).refuses(2, told);
    }
}
