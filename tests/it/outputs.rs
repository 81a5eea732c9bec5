//! What the program writes where the user says: on stdout, in files, with which permissions.

use crate::tools::trackfail;
use std::fs::File;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A command line in a shell, in a folder; `$PROGRAM` is the program.
fn shell(folder: &Path, text: &str) -> Output {
    let mut command = Command::new("sh");
    command.args(["-c", text]).current_dir(folder).env("PROGRAM", env!("CARGO_BIN_EXE_trackfail"));
    command.output().unwrap()
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A folder of three JPEG frames in which a square moves.
fn frames(root: &Path) -> PathBuf {
    let folder = root.join("frames");
    std::fs::create_dir(&folder).unwrap();
    for t in 0..3_u32 {
        let pixel = |x, y| {
            if (10 + t..30 + t).contains(&x) && (8..24).contains(&y) { 220 } else { (x * y % 90) as u8 }
        };
        let picture = image::RgbImage::from_fn(96, 64, |x, y| image::Rgb([pixel(x, y), 90, 60]));
        picture.save(folder.join(format!("{}.jpg", t + 1))).unwrap();
    }
    folder
}

#[test]
fn help_that_cannot_be_written_is_an_error() {
    let root = tempfile::tempdir().unwrap();
    for arguments in ["--help", "--version", "run --help", "list trackers"] {
        let output = shell(root.path(), &format!("\"$PROGRAM\" {arguments} > /dev/full"));
        assert_eq!(output.status.code(), Some(1), "{arguments}: {}", told(&output));
        assert!(told(&output).contains("stdout: No space left"), "{arguments}: {}", told(&output));
        let output = shell(root.path(), &format!("\"$PROGRAM\" {arguments}"));
        assert!(output.status.success() && !output.stdout.is_empty(), "{arguments}");
    }
}

#[test]
fn files_have_the_permissions_that_the_umask_leaves() {
    let root = tempfile::tempdir().unwrap();
    frames(root.path());
    let text = "umask 026; \"$PROGRAM\" detect --frames frames --init 11,9,20,16 --tracker ncc --method Displacement \
                --save-boxes boxes.txt --report page.html && : > plain";
    let output = shell(root.path(), text);
    assert!(output.status.success(), "{}", told(&output));
    for name in ["plain", "boxes.txt", "page.html"] {
        let mode = std::fs::metadata(root.path().join(name)).unwrap().permissions().mode() & 0o777;
        assert_eq!(mode, 0o640, "{name}");
    }
}

#[test]
fn boxes_go_through_links_and_devices_and_make_no_folders() {
    let root = tempfile::tempdir().unwrap();
    frames(root.path());
    std::fs::write(root.path().join("real.txt"), "as it was").unwrap();
    std::os::unix::fs::symlink("real.txt", root.path().join("link.txt")).unwrap();
    let follow = |file: &str| {
        let text = format!(
            "\"$PROGRAM\" detect --frames frames --init 11,9,20,16 --tracker ncc --method Displacement \
             --save-boxes {file}"
        );
        shell(root.path(), &text)
    };
    assert!(follow("link.txt").status.success());
    assert!(root.path().join("link.txt").is_symlink());
    let boxes = std::fs::read_to_string(root.path().join("real.txt")).unwrap();
    assert_eq!(boxes.lines().count(), 3);
    let output = follow("/dev/stdout");
    assert!(String::from_utf8_lossy(&output.stdout).contains(&boxes), "{}", told(&output));
    let output = follow("/dev/full");
    assert_eq!(output.status.code(), Some(1));
    assert!(told(&output).contains("/dev/full: "), "{}", told(&output));
    let output = follow("none/boxes.txt");
    assert_eq!(output.status.code(), Some(1));
    assert!(told(&output).contains("there is no folder none; make it first"), "{}", told(&output));
    assert!(!root.path().join("none").exists());
}

#[test]
fn no_output_replaces_an_input() {
    let root = tempfile::tempdir().unwrap();
    frames(root.path());
    let boxes = "11,9,20,16\n12,9,20,16\n13,9,20,16\n";
    std::fs::write(root.path().join("boxes.txt"), boxes).unwrap();
    std::os::unix::fs::symlink("boxes.txt", root.path().join("link.svg")).unwrap();
    let frame = std::fs::read(root.path().join("frames/1.jpg")).unwrap();
    for (output, words) in [
        ("--report boxes.txt", "--report boxes.txt would replace what --boxes boxes.txt reads"),
        ("--report ./frames/../boxes.txt", "would replace what --boxes boxes.txt reads"),
        ("--plot link.svg", "--plot link.svg would replace what --boxes"),
        ("--annotate frames", "--annotate frames would replace what --frames frames reads"),
        ("--report frames/1.jpg", "--report frames/1.jpg would replace what --frames frames/1.jpg reads"),
        ("--companion c.txt --report c.txt", "would replace what --companion c.txt reads"),
    ] {
        std::fs::write(root.path().join("c.txt"), boxes).unwrap();
        let command =
            format!("\"$PROGRAM\" detect --frames frames --boxes boxes.txt --method Displacement {output}");
        let output = shell(root.path(), &command);
        assert_eq!(output.status.code(), Some(2), "{}", told(&output));
        assert!(told(&output).contains(words), "{}", told(&output));
    }
    // Before: patterns, and folders of links, were no inputs, and the second output replaced the first.
    std::fs::create_dir(root.path().join("links")).unwrap();
    for k in 1..=3 {
        std::os::unix::fs::symlink(format!("../frames/{k}.jpg"), root.path().join(format!("links/{k}.jpg")))
            .unwrap();
    }
    std::fs::hard_link(root.path().join("frames/2.jpg"), root.path().join("hard.svg")).unwrap();
    for (inputs, output, words) in [
        (
            "frames/*.jpg --init 11,9,20,16",
            "--save-boxes frames/2.jpg",
            "would replace what --frames frames/2.jpg reads",
        ),
        (
            "'frames/*.jpg' --init 11,9,20,16",
            "--save-boxes frames/2.jpg",
            "--save-boxes frames/2.jpg would replace",
        ),
        ("'frames/*.jpg' --boxes boxes.txt", "--report frames/1.jpg", "--report frames/1.jpg would replace"),
        ("'frames/*.jpg' --boxes boxes.txt", "--plot hard.svg", "--plot hard.svg would replace"),
        ("'frames/*.jpg' --boxes boxes.txt", "--annotate frames", "--annotate frames would replace"),
        ("links --boxes boxes.txt", "--report frames/3.jpg", "--report frames/3.jpg would replace"),
        ("links --boxes boxes.txt", "--annotate links", "--annotate links would replace"),
        (
            "links --boxes boxes.txt",
            "--report a.svg --plot ./a.svg",
            "--plot ./a.svg would replace what --report a.svg writes",
        ),
        (
            "links --boxes boxes.txt",
            "--plot d/000001.png --annotate d",
            "would replace what --plot d/000001.png writes",
        ),
        ("links --boxes boxes.txt", "--report -", "--report -: an output is a file"),
    ] {
        std::fs::create_dir_all(root.path().join("d")).unwrap();
        let command = format!("\"$PROGRAM\" detect --method Displacement --frames {inputs} {output}");
        let refused = shell(root.path(), &command);
        assert_eq!(refused.status.code(), Some(2), "{command}: {}", told(&refused));
        assert!(told(&refused).contains(words) && refused.stdout.is_empty(), "{command}: {}", told(&refused));
        assert!(!root.path().join("-").exists() && !root.path().join("a.svg").exists());
        assert!((1..=3).all(|k| root.path().join(format!("links/{k}.jpg")).is_symlink()));
    }
    assert_eq!(std::fs::read_to_string(root.path().join("boxes.txt")).unwrap(), boxes);
    assert_eq!(std::fs::read(root.path().join("frames/1.jpg")).unwrap(), frame);
    let command = "\"$PROGRAM\" detect --frames frames --boxes boxes.txt --method Displacement --annotate drawn \
                   --report page.html";
    for _ in 0..2 {
        let output = shell(root.path(), command);
        assert!(output.status.success(), "{}", told(&output));
    }
}

// Before: the results that a tracker is replayed from were replaced by what had been read of them.
#[test]
fn exported_tracks_replace_no_results_of_a_data_root() {
    let root = tempfile::tempdir().unwrap();
    let run = |folder: &str| {
        shell(root.path(), &format!("\"$PROGRAM\" run --quiet --data-root data --export-tracks {folder}"))
    };
    std::fs::create_dir_all(root.path().join("data/results/otb")).unwrap();
    assert!(run("data/results/otb").status.success());
    let mine: Vec<_> = std::fs::read_dir(root.path().join("data/results/otb")).unwrap().collect();
    assert!(!mine.is_empty());
    std::os::unix::fs::symlink("data/results", root.path().join("link")).unwrap();
    for folder in ["data/results/otb", "link/otb"] {
        let output = run(folder);
        assert_eq!(output.status.code(), Some(2), "{}", told(&output));
        assert!(told(&output).contains("would replace results in"), "{}", told(&output));
    }
    std::fs::create_dir(root.path().join("elsewhere")).unwrap();
    assert!((0..2).all(|_| run("elsewhere").status.success()));
}

#[test]
fn folders_and_states_are_not_made_where_there_is_no_folder() {
    let root = tempfile::tempdir().unwrap();
    for arguments in
        ["data render synthetic-otb --sequence Girl none/suite", "run --export-tracks none/tracks"]
    {
        let output = shell(root.path(), &format!("\"$PROGRAM\" {arguments}"));
        assert_eq!(output.status.code(), Some(1), "{arguments}: {}", told(&output));
        assert!(
            told(&output).contains("/none; make it first") || told(&output).contains("folder none; make")
        );
    }
    std::os::unix::fs::symlink("nowhere", root.path().join("state")).unwrap();
    let output = shell(root.path(), "\"$PROGRAM\" monitor --state state < /dev/null");
    assert_eq!(output.status.code(), Some(2), "{}", told(&output));
    assert!(told(&output).contains("is a link that leads nowhere"), "{}", told(&output));
    assert!(root.path().join("state").is_symlink());
}

#[test]
fn a_cut_frame_with_an_end_marker_is_named() {
    let root = tempfile::tempdir().unwrap();
    let folder = frames(root.path());
    let second = folder.join("2.jpg");
    let bytes = std::fs::read(&second).unwrap();
    std::fs::write(&second, [&bytes[..bytes.len() * 3 / 4], &[0xFF, 0xD9]].concat()).unwrap();
    let boxes = root.path().join("boxes.txt");
    std::fs::write(&boxes, "11,9,20,16\n12,9,20,16\n13,9,20,16\n").unwrap();
    let output = trackfail()
        .args(["detect", "--method", "NAIVE", "--frames"])
        .arg(&folder)
        .arg("--boxes")
        .arg(&boxes)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(3), "{}", told(&output));
    assert!(told(&output).contains("2.jpg"), "{}", told(&output));
}

#[test]
fn few_bytes_that_claim_a_large_frame_are_named() {
    let root = tempfile::tempdir().unwrap();
    let folder = frames(root.path());
    let first = folder.join("1.jpg");
    let mut bytes = std::fs::read(&first).unwrap();
    // The sides in the frame header.
    let at = bytes.windows(2).position(|w| w == [0xFF, 0xC0]).unwrap();
    bytes[at + 5..at + 9].copy_from_slice(&[0x1B, 0x58, 0x1B, 0x58]);
    File::create(&first).and_then(|mut file| std::io::Write::write_all(&mut file, &bytes)).unwrap();
    let text = "\"$PROGRAM\" detect --frames frames --init 11,9,20,16 --tracker ncc --method Displacement";
    let output = shell(root.path(), text);
    assert_eq!(output.status.code(), Some(3), "{}", told(&output));
    assert!(told(&output).contains("1.jpg") && told(&output).contains("7000x7000"), "{}", told(&output));
}
