//! `trackfail detect` on one's own frames and boxes.

use crate::tools::{Place, rows};
use trackfail_testing::assert_near;

#[test]
fn prints_a_row_for_each_frame_and_method() {
    let place = Place::new();
    let boxes = place.render("synthetic-otb", "Girl");
    place.write("boxes.txt", boxes.join("\n"));
    let text = place.run("detect --frames suite/Girl/img --boxes boxes.txt --all").ends(0).out;
    assert_eq!(text.lines().next().unwrap(), "frame,method,score,label,change,state");
    let all = rows(&text);
    for method in ["DTEF", "NAIVE", "RAW", "CovF", "RgbHist", "RLHist"] {
        let mine: Vec<_> = all.iter().filter(|r| r["method"] == method).collect();
        assert_eq!(mine.len(), boxes.len(), "{method}");
        // Changes are the differences of the labels.
        let mut label = 0;
        for row in mine {
            let now: i32 = row["label"].parse().unwrap();
            assert_eq!(row["change"].parse::<i32>().unwrap(), now - label);
            label = now;
        }
    }
    // Nothing that lies beside the frames matters.
    place.remove("suite/Girl/groundtruth_rect.txt");
    let beside = "detect --frames suite/Girl --boxes boxes.txt --method RAW";
    let clean = place.run(beside).ends(0).out;
    place.write("suite/Girl/groundtruth_rect.txt", "1,2\n");
    let again = place.run(&format!("{beside} --boxes-format xywh --base 1"));
    assert_eq!((again.out, again.err), (clean, String::new()));
}

/// A rendered sequence, followed from the box of its first frame.
const FOLLOW: &str = "detect --frames suite/car-shade/img --init";

#[test]
fn a_target_is_followed_and_doubts_are_told_frame_by_frame() {
    let place = Place::new();
    let first = place.render("synthetic-d1", "car-shade").remove(0);
    let text = place.run(&format!("{FOLLOW} {first} --all --save-boxes boxes.txt")).ends(0).out;
    let all = rows(&text);
    let count = place.list("suite/car-shade/img").len();
    for method in ["DTEF", "AVU", "Two-MChi", "M-model", "ARTE", "ARTE*"] {
        assert_eq!(all.iter().filter(|r| r["method"] == method).count(), count, "{method}");
    }
    assert!(all.iter().all(|r| r["method"] != "EmpTh"));
    // The target is lost for a while, which ARTE* does not miss.
    assert!(all.iter().any(|r| r["method"] == "ARTE*" && r["label"] == "1"));

    // The boxes that were saved are those that were judged.
    assert_eq!(place.read("boxes.txt").lines().count(), count);
    let judged = "detect --frames suite/car-shade/img --boxes boxes.txt --method RgbHist";
    let of = |text: &str| -> Vec<f64> {
        let mine = rows(text).into_iter().filter(|r| r["method"] == "RgbHist");
        mine.map(|r| r["score"].parse().unwrap()).collect()
    };
    // The file counts pixels from 1, which costs the last digit of a coordinate.
    assert_near(of(&place.run(judged).ends(0).out), of(&text), 1e-6, judged);
}

// Before: they were dropped without a word.
#[test]
fn options_of_the_other_mode_are_refused() {
    let place = Place::new();
    for (mode, options) in [
        ("--boxes boxes.txt", "--tracker kcf; --params {}; --seed 3; --model none; --save-boxes saved.txt"),
        ("--init 1,2,3,4", "--boxes-format mot; --absent; --confidence none; --companion none"),
    ] {
        for option in options.split("; ") {
            let ran = place.run(&format!("detect --frames none {mode} {option}"));
            ran.refuses(2, "cannot be used with").tells(option.split(' ').next().unwrap());
        }
    }
}

#[test]
fn what_cannot_be_judged_is_told() {
    let place = Place::with(&[
        ("three.json", "{ \"model\": { \"consistency\": 3 } }"),
        ("none.json", "{}"),
        ("boxes.txt", "1,2,3,4\n"),
    ]);
    let first = place.render("synthetic-d1", "car-shade").remove(0);
    for (more, code, words) in [
        ("--method ARTE* --tracker ncc", 2, "needs a tracker with a posterior"),
        ("--method EmpTh", 2, "trained on annotated sequences"),
        ("--method AVU --params '{ particles = 50 }'", 2, "give --model"),
        ("--method DTFE", 2, "did you mean `DTEF`?"),
        ("--tracker kfc", 2, "did you mean `kcf`?"),
        ("--tracker replay", 2, "ground truth or result files"),
        ("--method AVU --model three.json", 3, "no model of consistency"),
        ("--method AVU --model none.json", 3, "holds no learned model"),
    ] {
        place.run(&format!("{FOLLOW} {first} {more}")).ends(code).tells(words);
    }
    let outside = "--init 5000,1,9,9 lies outside of the frame of 320x240 pixels";
    place.run(&format!("{FOLLOW} 5000,1,9,9")).ends(2).tells(outside).tells("suite/car-shade/img");
    for wrong in ["1,2,3", "a,b,c,d", "'1,2,3,4\n5,6,7,8'"] {
        place.run(&format!("{FOLLOW} {wrong}")).ends(2);
    }
    let boxes = "detect --frames suite/car-shade/img --boxes boxes.txt --method ARTE*";
    place.run(boxes).ends(2).tells("give --init instead of --boxes");
}
