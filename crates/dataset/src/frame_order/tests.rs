use super::*;
use proptest::prelude::*;
use trackfail_testing::assert_says;

fn paths(names: &[&str]) -> Vec<PathBuf> {
    names.iter().map(PathBuf::from).collect()
}

/// First and last number, and true if the files stay in the order given.
fn kept(names: impl IntoIterator<Item = String>) -> (u32, u32, bool) {
    let given: Vec<PathBuf> = names.into_iter().map(PathBuf::from).collect();
    let found = numbered(given.iter().rev().cloned().collect()).unwrap();
    let ends = (*found.keys().next().unwrap(), *found.keys().next_back().unwrap());
    (ends.0, ends.1, found.into_values().eq(given))
}

fn error(names: &[&str]) -> String {
    numbered(paths(names)).unwrap_err().to_string()
}

// The names are those of cvat#6180, roboflow/trackers PR 558, TUM RGB-D, and what cameras, players and robots write; the
// order is the one in which they are written out here.
#[test]
fn names_of_many_programs_are_in_the_order_of_people() {
    let hash =
        ["cfcd2084", "c4ca4238", "c81e728d", "eccbc87e", "a87ff679", "e4da3b7f", "1679091c", "8f14e450"];
    let clock = |t: u32| format!("{:02}-59-{:02}", 9 + t / 60, t % 60);
    let day = |t: u32| (1 + t / 60, if t < 60 { 235_900 + t } else { t - 60 });
    let stamp = |t: u32| (1_305_031_102 + t / 30, t % 30 * 33_000);
    for (case, names) in [
        (1, (1..41).map(|t| format!("{t}.png")).collect::<Vec<_>>()),
        (2, (1..41).map(|t| format!("DJI_1000({t}).png")).collect()),
        (3, (1..41).map(|t| format!("img ({t}).png")).collect()),
        (4, (5..13).zip(hash).map(|(t, hash)| format!("clip_mp4-{t}_jpg.rf.{hash}.png")).collect()),
        (5, (40..80).map(|t| format!("cam_2024-01-02_{}.png", clock(t))).collect()),
        (6, (40..80).map(|t| format!("{}.500.png", clock(t))).collect()),
        (7, (30..90).map(|t| format!("IMG_2024010{}_{:06}.png", day(t).0, day(t).1)).collect()),
        (8, (1..41).map(|t| format!("{}.{:06}.png", stamp(t).0, stamp(t).1)).collect()),
        (9, (1..41).map(|t| format!("{}_{:09}.png", stamp(t).0, stamp(t).1 * 1000)).collect()),
        (10, (1..41).map(|t| format!("frame_{}.png", 1_700_000_000_000_u64 + 33 * t)).collect()),
        (11, (1..41).map(|t| format!("frame{t}_score{}.png", t * 37 % 101)).collect()),
        (12, (1..41).map(|t| format!("frame_{t}_of_40.png")).collect()),
        (13, (20..50).map(|t| format!("2024-{:02}-{:02}.png", 1 + t / 31, 1 + t % 31)).collect()),
        (14, (1..41).map(|t| format!("take{}/{t:04}.png", 1 + t / 20)).collect()),
        (15, ["a", "b", "c"].map(|name| format!("{name}.png")).to_vec()),
    ] {
        let last = names.len() as u32;
        assert_eq!(kept(names), (1, last, true), "case {case}");
    }
}

#[test]
fn numbers_at_the_end_are_the_frames_own() {
    for (names, first, last) in [
        ((300..311).map(|t| format!("{t:04}.jpg")).collect::<Vec<_>>(), 300, 310),
        ((8..13).map(|t| format!("sh010.{t}.png")).collect(), 8, 12),
        (vec!["img_9.jpeg".into(), "img_10.PNG".into(), "img_20.png".into()], 9, 20),
        (vec!["clip_1280x720_7.png".into(), "clip_1280x720_11.png".into()], 7, 11),
        (vec!["1_100.png".into(), "1_200.png".into(), "2_300.png".into()], 100, 300),
        (vec!["a_0001.png".into(), "b_0002.png".into()], 1, 2),
        // A number in another place counts from 1, gaps included.
        (vec!["300_rgb.png".into(), "301_rgb.png".into(), "310_rgb.png".into()], 1, 11),
        (vec!["7.png".into()], 7, 7),
        (vec!["img (7).png".into()], 1, 1),
    ] {
        let shown = names.join(" ");
        assert_eq!(kept(names), (first, last, true), "{shown}");
    }
}

#[test]
fn a_file_without_a_number_is_named() {
    for names in [["1.png", "background.png", "10.png"], ["img (1).png", "img.png", "img (2).png"]] {
        let told = error(&names);
        assert!(told.starts_with(&format!("{}: no number in this name", names[1])), "{told}");
    }
}

#[test]
fn two_files_of_a_number_are_named() {
    for (names, number) in [
        (["img1.png", "img01.png", "img2.png"], 1),
        (["1.jpg", "2.jpg", "2.png"], 2),
        (["1.png", "2.png", "2_mask.png"], 2),
        (["11.png", "12.png", "12 (1).png"], 12),
        (["clip-3_jpg.rf.a8.png", "clip-3_jpg.rf.b9.png", "clip-4_jpg.rf.c7.png"], 3),
        (["cam1_01.png", "cam1_02.png", "cam2_01.png"], 1),
        (["b09.jpg", "img_9.jpg", "img_10.jpg"], 9),
    ] {
        let told = error(&names);
        assert!(told.contains(&format!("frame {number} again, after ")), "{names:?}: {told}");
    }
}

// Which of the two is meant, nobody can tell without a date.
#[test]
fn a_clock_that_may_have_passed_midnight_is_in_doubt() {
    let message = error(&["00.00.00.png", "00.00.01.png", "23.59.58.png", "23.59.59.png"]);
    assert_says(&message, "from frame 1 on it is 00.00.00.png, 00.00.01.png, 23.59.58.png");
    assert_says(&message, "but 23.59.58.png, 23.59.59.png, 00.00.00.png, ... by the clock past midnight");
    let day = |t: u32| format!("{:02}.00.{:02}.png", 8 + t / 4, t % 4);
    assert_eq!(kept((0..40).map(day)), (1, 40, true));
    let dated = |t: u32| format!("2024-01-0{}T{:02}-59-5{}.png", 1 + t / 2, 23 * (1 - t / 2), 8 + t % 2);
    assert_eq!(kept((0..4).map(dated)), (1, 4, true));
}

#[test]
fn clocks_of_twelve_hours_are_read() {
    let name = |time: &str| format!("Screenshot 2024-01-02 at {time}.png");
    let times = "12.00.01\u{202f}AM|1.00.00\u{202f}am|12.59.58 PM|12.59.59 PM|1.00.00 PM|11.00.01 PM";
    let names: Vec<String> = times.split('|').map(name).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let order = numbered(paths(&names)).unwrap();
    assert!(order.into_iter().eq((1..).zip(paths(&names))));
    let seconds = ["1.00.57 PM", "1.00.58 PM", "1.00.59 PM"].map(name);
    assert_eq!(kept(seconds), (1, 3, true));
    // Elsewhere the letters are a part of the name.
    let others = ["1.00.00 pmx.png", "12.00.00 pmx.png"];
    assert!(numbered(paths(&others)).unwrap().into_values().eq(paths(&others)));
}

#[test]
fn doubt_shows_both_orders() {
    let told = error(&["cam1_0002.png", "cam2_0001.png", "cam1_0004.png", "cam2_0003.png"]);
    assert!(told.contains(
        "the order of the frames is in doubt: from frame 1 on it is cam1_0002.png, cam1_0004.png, "
    ));
    assert!(told.contains(", ... by all numbers in the names, but cam2_0001.png, cam1_0002.png, "), "{told}");
    // Fractions without zeros at their end.
    let told = error(&["1305031102.5.png", "1305031103.25.png", "1305031103.5.png", "1305031103.75.png"]);
    assert!(told.contains("from frame 2 on it is 1305031103.5.png, 1305031103.25.png, "), "{told}");
    for names in [
        &["0.25.png", "0.5.png", "0.75.png"][..],
        &["a_0002.png", "b_0001.png"],
        &["a_0001.png", "b_0005.png"],
        &["crop10_3.png", "crop37_1.png", "crop74_2.png"],
        &["DJI_1000.png", "DJI_1000(1).png", "DJI_1000(2).png"],
    ] {
        let doubt = numbered(paths(names)).unwrap_err();
        assert!(matches!(doubt, DatasetError::FrameOrder { .. }), "{names:?}: {doubt}");
    }
}

proptest! {
    /// Names that differ in one number are ordered by it, whatever surrounds or pads it.
    #[test]
    fn one_number_in_a_fixed_name_is_the_order(
        prefix in "([A-Za-z0-9_-]{0,8}[A-Za-z_ (-])?",
        suffix in "([A-Za-z_) -][A-Za-z0-9_-]{0,8})?",
        width in 0_usize..7,
        frames in prop::collection::btree_set(0_u32..100_000, 2..40),
        seed in any::<u64>(),
    ) {
        let file = |t: &u32| PathBuf::from(format!("{prefix}{t:0width$}{suffix}.png"));
        let given: Vec<PathBuf> = frames.iter().map(file).collect();
        let mut mixed = given.clone();
        mixed.sort_by_key(|path| path.to_string_lossy().bytes().fold(seed, |sum, b| sum.rotate_left(9) ^ u64::from(b)));
        let found = numbered(mixed).unwrap();
        if suffix.is_empty() {
            prop_assert!(found.keys().eq(&frames));
        } else {
            let first = frames.first().copied().unwrap_or_default();
            prop_assert!(found.keys().copied().eq(frames.iter().map(|t| t - first + 1)));
        }
        prop_assert!(found.into_values().eq(given));
    }

    /// The natural order is found from any order in which a folder lists its files.
    #[test]
    fn the_order_of_a_listing_does_not_matter(
        names in prop::collection::btree_set("[ab019 ._-]{1,6}", 1..8)
            .prop_map(|names| names.into_iter().collect::<Vec<_>>())
            .prop_shuffle(),
    ) {
        let mixed: Vec<PathBuf> = names.iter().map(|name| PathBuf::from(format!("x/{name}.png"))).collect();
        let mut sorted = mixed.clone();
        sorted.sort();
        let natural = natural_order(mixed.clone());
        prop_assert_eq!(&natural, &natural_order(sorted.clone()));
        let (a, b) = (numbered(mixed), numbered(sorted));
        prop_assert_eq!(format!("{a:?}"), format!("{b:?}"));
        if let Ok(found) = a {
            prop_assert!(found.into_values().eq(natural));
        }
    }
}
