//! Outputs stand where the user wants them: on stdout or in files, with the permissions that belong to them.

use crate::tools::Place;
use std::os::unix::fs::symlink;

const BOXES: &str = "11,9,20,16\n12,9,20,16\n13,9,20,16\n";

/// A place with `boxes.txt` and a folder `frames` of three JPEG frames in which a square moves.
fn place() -> Place {
    let place = Place::with(&[("boxes.txt", BOXES)]);
    place.frames("frames/0.jpg", 3, (96, 64), |t, x, y| {
        let inside = (10 + t..30 + t).contains(&x) && (8..24).contains(&y);
        [if inside { 220 } else { (x * y % 90) as u8 }, 90, 60]
    });
    place
}

/// The words that follow the square.
const FOLLOW: &str = "detect --frames frames --init 11,9,20,16 --tracker ncc --method Displacement";

#[test]
fn a_full_disk_is_an_error_and_a_closed_pipe_is_none() {
    let place = place();
    let detect = "detect --boxes boxes.txt --boxes-format xywh --base 1 --format";
    let detect = ["csv", "json", "table"].map(|format| format!("{detect} {format}"));
    let all = ["--help", "--version", "run --help", "list trackers"].map(String::from);
    let all = [&all[..], &detect].concat();
    for arguments in &all {
        let full = place.shell(&format!("trackfail {arguments} > /dev/full")).ends(1);
        assert!(full.err.starts_with("error: stdout: No space left"), "{arguments}: {}", full.err);
        assert!(!place.run(arguments).ends(0).out.is_empty(), "{arguments}");
    }
    // The reader is gone before the program writes.
    let closed = all.iter().map(|arguments| format!("trackfail {arguments}; echo $? >&2; "));
    let closed = place.shell(&format!("{{ sleep 1; {} }} | true", closed.collect::<String>()));
    assert_eq!(closed.err, "0\n".repeat(all.len()));
}

#[test]
fn boxes_go_through_links_and_devices_and_make_no_folders() {
    let place = place();
    place.write("real.txt", "as it was");
    symlink("real.txt", place.path("link.txt")).unwrap();
    let follow = |file: &str| place.run(&format!("{FOLLOW} --save-boxes {file}"));
    follow("link.txt").ends(0);
    assert!(place.path("link.txt").is_symlink());
    let boxes = place.read("real.txt");
    assert_eq!(boxes.lines().count(), 3);
    follow("/dev/stdout").says(&boxes);
    follow("/dev/full").ends(1).tells("/dev/full: ");
    follow("none/boxes.txt").ends(1).tells("there is no folder none; make it first");
    assert!(!place.has("none"));
}

// Before: patterns, and folders of links, were no inputs, and the second output replaced the first.
#[test]
fn no_output_replaces_an_input() {
    let place = place();
    let frame = place.bytes("frames/1.jpg");
    symlink("boxes.txt", place.path("link.svg")).unwrap();
    let links = place.folder("links");
    for k in 1..=3 {
        symlink(format!("../frames/{k}.jpg"), links.join(format!("{k}.jpg"))).unwrap();
    }
    std::fs::hard_link(place.path("frames/2.jpg"), place.path("hard.svg")).unwrap();
    place.folder("d");
    place.write("c.txt", BOXES);
    let (boxes, init) = ("--boxes boxes.txt", "--init 11,9,20,16");
    for (frames, track, outputs, words) in [
        ("frames", boxes, "--report ./frames/../boxes.txt", "would replace what --boxes boxes.txt reads"),
        ("frames", boxes, "--plot link.svg", "--plot link.svg would replace what --boxes"),
        ("frames", boxes, "--annotate frames", "--annotate frames would replace what --frames frames reads"),
        ("frames", boxes, "--report frames/1.jpg", "would replace what --frames frames/1.jpg reads"),
        ("frames", boxes, "--companion c.txt --report c.txt", "would replace what --companion c.txt reads"),
        ("frames/*.jpg", init, "--save-boxes frames/2.jpg", "would replace what --frames frames/2.jpg reads"),
        ("'frames/*.jpg'", init, "--save-boxes frames/2.jpg", "--save-boxes frames/2.jpg would replace"),
        ("'frames/*.jpg'", boxes, "--plot hard.svg", "--plot hard.svg would replace"),
        ("'frames/*.jpg'", boxes, "--annotate frames", "--annotate frames would replace"),
        ("links", boxes, "--report frames/3.jpg", "--report frames/3.jpg would replace"),
        ("links", boxes, "--annotate links", "--annotate links would replace"),
        ("links", boxes, "--report a.svg --plot ./a.svg", "would replace what --report a.svg writes"),
        ("links", boxes, "--plot d/000001.png --annotate d", "would replace what --plot d/000001.png writes"),
        ("links", boxes, "--report -", "--report -: an output is a file"),
    ] {
        let line = format!("trackfail detect --method Displacement --frames {frames} {track} {outputs}");
        place.shell(&line).refuses(2, words);
        assert!(!place.has("-") && !place.has("a.svg"));
        assert!((1..=3).all(|k| links.join(format!("{k}.jpg")).is_symlink()));
    }
    assert_eq!((place.read("boxes.txt").as_str(), place.bytes("frames/1.jpg")), (BOXES, frame));
    let again = "--frames frames --boxes boxes.txt --annotate drawn --report page.html";
    (0..2).for_each(|_| drop(place.run(&format!("detect --method Displacement {again}")).ends(0)));
}

// Before: the results that a tracker is replayed from were replaced by what had been read of them.
#[test]
fn exported_tracks_replace_no_results_of_a_data_root() {
    let place = Place::new();
    let run = |folder: &str| place.run(&format!("run --quiet --data-root data --export-tracks {folder}"));
    place.folder("data/results/otb");
    run("data/results/otb").ends(0);
    assert!(!place.list("data/results/otb").is_empty());
    symlink("data/results", place.path("link")).unwrap();
    for folder in ["data/results/otb", "link/otb"] {
        run(folder).ends(2).tells("would replace results in");
    }
    place.folder("elsewhere");
    (0..2).for_each(|_| drop(run("elsewhere").ends(0)));
}

#[test]
fn folders_and_states_are_not_made_where_there_is_no_folder() {
    let place = Place::new();
    place.run("data render synthetic-otb --sequence Girl none/suite").ends(1).tells("none; make it first");
    place.run("run --export-tracks none/tracks").ends(1).tells("none; make it first");
    symlink("nowhere", place.path("state")).unwrap();
    place.shell("trackfail monitor --state state < /dev/null").ends(2).tells("is a link that leads nowhere");
    assert!(place.path("state").is_symlink());
}

#[test]
fn a_cut_frame_is_named() {
    let place = place();
    let bytes = place.bytes("frames/2.jpg");
    // With an end marker.
    place.write("frames/2.jpg", [&bytes[..bytes.len() * 3 / 4], &[0xFF, 0xD9]].concat());
    place.run("detect --method NAIVE --frames frames --boxes boxes.txt").ends(3).tells("2.jpg");
}
