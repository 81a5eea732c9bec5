//! `trackfail data render SUITE DIR`: writes a synthetic suite to disk, in OTB or VOT layout by suite.
//!
//! OTB: `<Seq>/img/0001.png ...`, `<Seq>/groundtruth_rect.txt` (`x,y,w,h`, counted from 1) and
//! `<Seq>/attributes.txt` (one line, separated by commas). VOT: `list.txt`, `<seq>/00000001.png ...`,
//! `<seq>/groundtruth.txt` (8 numbers, counted from 0) and a `<seq>/<attribute>.label` (0 or 1 a line)
//! for each attribute. Numbers are written so that reading them gives the same bits; PNG is lossless.

use crate::cli::{Failure, io_at, output};
use crate::dataset::synthetic::scenes::{self, SceneFile};
use crate::dataset::synthetic::{RenderLayout, SUITES};
use crate::dataset::{Sequence, leftover::TemporaryFolder};
use crate::image;
use crate::plugin::unknown;
use crate::region::Region;
use crate::user_file;
use rayon::prelude::*;
use std::borrow::Cow;
use std::fs;
use std::path::{Path, PathBuf};

/// Prefix of folders that are being filled.
const RENDERING: &str = ".trackfail-render-";

/// Arguments of `trackfail data render`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// Synthetic suite: synthetic-otb, synthetic-vot, synthetic-d1 or synthetic-d2; or a file of your own scenes, FILE.toml
    pub suite: String,
    /// Folder to write; must not exist or be empty
    pub dir: PathBuf,
    /// Only these sequences
    #[arg(long = "sequence", value_name = "NAME")]
    pub sequences: Vec<String>,
}

/// Writes the suite.
///
/// All files are first written to a temporary folder beside `dir`, which is then renamed, so that `dir` is
/// never incomplete.
///
/// # Errors
/// `Usage` for an unknown suite or sequence, a faulty file of scenes, and a folder that is not empty; `Io`
/// for errors of the file system.
pub fn run(args: &Args) -> Result<(), Failure> {
    let (suite, scenes) = &find_suite(&args.suite)?;
    let sequences = chosen(suite, scenes, &args.sequences)?;
    let dir = std::path::absolute(&args.dir).map_err(io_at(&args.dir))?;
    let refuse = |why: &str| Err(Failure::usage(format!("{} {why}", dir.display())));
    match fs::read_dir(&dir).map(|mut entries| entries.next().is_none()) {
        Ok(true) => {}
        Ok(false) => return refuse("is not empty; name a new folder, or empty it first"),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => {}
        Err(e) if e.kind() == std::io::ErrorKind::NotADirectory => return refuse("is not a folder"),
        Err(e) => return Err(io_at(&dir)(e)),
    }
    let Some(parent) = dir.parent() else { return refuse("cannot be written as a whole") };
    user_file::check_folder(&dir).map_err(Failure::io)?;
    let temporary = TemporaryFolder::new_in(parent, RENDERING).map_err(io_at(parent))?;
    let root = temporary.within("suite").map_err(io_at(parent))?;
    sequences.par_iter().try_for_each(|q| write_sequence(&root.join(&q.name), scenes.layout, q))?;
    if scenes.layout == RenderLayout::Vot {
        let names: Vec<&str> = sequences.iter().map(|q| q.name.as_str()).collect();
        write_lines(&root.join("list.txt"), names)?;
    }
    if dir.exists() {
        fs::remove_dir(&dir).map_err(io_at(&dir))?;
    }
    fs::rename(&root, &dir).map_err(io_at(&dir))?;
    let frames: usize = sequences.iter().map(Sequence::len).sum();
    let (count, folder) = (sequences.len(), args.dir.display());
    output::write(&format!("{suite}: {count} sequences, {frames} frames in {folder}\n"))
}

/// Name and scenes of a synthetic suite, or of a file.
fn find_suite(name: &str) -> Result<(String, Cow<'static, SceneFile>), Failure> {
    let path = Path::new(name);
    if path.extension().is_some_and(|extension| extension == "toml") {
        let scenes = scenes::read(path).map_err(Failure::usage)?;
        return Ok((path.file_stem().unwrap_or_default().to_string_lossy().into_owned(), Cow::Owned(scenes)));
    }
    match SUITES.iter().find(|s| s.name == name) {
        Some(suite) => Ok((name.to_owned(), Cow::Borrowed(suite.scenes()))),
        None => Err(Failure::usage(unknown("synthetic suite", name, SUITES.iter().map(|s| s.name)))),
    }
}

fn chosen(suite: &str, scenes: &SceneFile, wanted: &[String]) -> Result<Vec<Sequence>, Failure> {
    let known: Vec<&str> = scenes.names().collect();
    if let Some(name) = wanted.iter().find(|n| !known.contains(&n.as_str())) {
        let what = format!("sequence of {suite}");
        return Err(Failure::usage(unknown(&what, name, known)));
    }
    let mut sequences = scenes.sequences(suite);
    sequences.retain(|q| wanted.is_empty() || wanted.contains(&q.name));
    Ok(sequences)
}

fn write_sequence(folder: &Path, layout: RenderLayout, q: &Sequence) -> Result<(), Failure> {
    let (images, digits) = match layout {
        RenderLayout::Otb => (folder.join("img"), 4),
        RenderLayout::Vot => (folder.to_path_buf(), 8),
    };
    fs::create_dir_all(&images).map_err(io_at(&images))?;
    (0..q.len()).into_par_iter().try_for_each(|t| {
        let path = images.join(format!("{:0digits$}.png", q.number(t)));
        let frame = q.frame(t).map_err(Failure::io)?;
        let png = image::encode_png(&frame).map_err(Failure::io)?;
        fs::write(&path, png).map_err(io_at(&path))
    })?;
    match layout {
        RenderLayout::Otb => {
            let rows = q.truth.iter().map(|r| otb_line(r.as_ref()));
            write_lines(&folder.join("groundtruth_rect.txt"), rows)?;
            write_lines(&folder.join("attributes.txt"), [q.attributes.join(",")])
        }
        RenderLayout::Vot => {
            write_lines(&folder.join("groundtruth.txt"), q.truth.iter().map(|r| vot_line(r.as_ref())))?;
            for (name, flags) in &q.frame_attributes {
                let rows = flags.iter().map(|&f| u8::from(f).to_string());
                write_lines(&folder.join(format!("{name}.label")), rows)?;
            }
            Ok(())
        }
    }
}

/// Line `x,y,w,h` with pixels counted from 1. OTB marks a frame without target by zeros.
fn otb_line(region: Option<&Region>) -> String {
    let Some(r) = region.map(Region::rect) else { return "0,0,0,0".to_string() };
    join(&[r.x + 1.0, r.y + 1.0, r.w, r.h])
}

/// Line of all corners with pixels counted from 0. VOT marks a frame without target by NaN.
fn vot_line(region: Option<&Region>) -> String {
    let corners = region.map_or_else(|| vec![(f64::NAN, f64::NAN); 4], Region::corners);
    join(&corners.iter().flat_map(|c| [c.0, c.1]).collect::<Vec<_>>())
}

/// Joins numbers, each in the shortest form that is read back as the same bits.
fn join(numbers: &[f64]) -> String {
    numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(",")
}

fn write_lines<S: AsRef<str>>(path: &Path, lines: impl IntoIterator<Item = S>) -> Result<(), Failure> {
    let text: String = lines.into_iter().flat_map(|line| [line.as_ref(), "\n"].map(String::from)).collect();
    fs::write(path, text).map_err(io_at(path))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::Exit;
    use crate::dataset::format::{otb, vot};
    use crate::dataset::{content_digest, synthetic};

    fn args(suite: &str, dir: &Path, sequence: &str) -> Args {
        Args { suite: suite.into(), dir: dir.into(), sequences: vec![sequence.into()] }
    }

    fn same_pixels(path: &Path, q: &Sequence, t: usize) {
        let decoded = image::decode(&fs::read(path).unwrap()).unwrap();
        assert!(decoded == q.frame(t).unwrap(), "{}", path.display());
    }

    // The readers' own tests have the numbers of each layout by hand.
    #[test]
    fn both_layouts_are_read_back_to_the_same_digest() {
        let root = tempfile::tempdir().unwrap();
        for (suite, name, first, list) in [
            ("synthetic-otb", "Girl", "img/0001.png", None),
            ("synthetic-vot", "poster", "00000001.png", Some("poster\n")),
        ] {
            let q = synthetic::suite(suite).unwrap().into_iter().find(|q| q.name == name).unwrap();
            let dir = root.path().join(suite);
            run(&args(suite, &dir, name)).unwrap();
            let folder = dir.join(name);
            let read = match list {
                None => otb::load(&folder, &Default::default()).unwrap(),
                Some(_) => vot::load(&folder, &Default::default()).unwrap(),
            };
            assert_eq!(content_digest(&read).unwrap(), content_digest(&q).unwrap(), "{suite}");
            same_pixels(&folder.join(first), &q, 0);
            assert_eq!(fs::read_to_string(dir.join("list.txt")).ok().as_deref(), list);
        }
        // Nothing but the suites is left.
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 2);
    }

    #[test]
    fn scenes_of_ones_own_are_rendered() {
        let root = tempfile::tempdir().unwrap();
        let (file, dir) = (root.path().join("mine.toml"), root.path().join("mine"));
        let scene = "[[scene]]\nname = \"ball\"\nsize = [64, 48]\nframes = 3\nground = \"plaza\"\n\n[scene.target]\n\
            kind = \"ball\"\nsize = [12, 12]\nx = [[0, 20], [2, 40]]\ny = [[0, 24]]\n";
        let mine = format!("title = \"Mine\"\nlayout = \"otb\"\n\n{scene}");
        fs::write(&file, &mine).unwrap();
        run(&args(file.to_str().unwrap(), &dir, "ball")).unwrap();
        let truth = fs::read_to_string(dir.join("ball/groundtruth_rect.txt")).unwrap();
        assert_eq!(truth.lines().nth(2), Some("35,19,12,12"));
        let q = scenes::read(&file).unwrap().sequences("mine").swap_remove(0);
        same_pixels(&dir.join("ball/img/0003.png"), &q, 2);
        fs::write(&file, mine.replace("48", "4")).unwrap();
        let error = run(&args(file.to_str().unwrap(), &root.path().join("new"), "ball")).unwrap_err();
        assert_eq!(error.code(), 2);
    }

    #[test]
    fn refuses_what_it_cannot_do() {
        let root = tempfile::tempdir().unwrap();
        let usage = |a: Args| match run(&a) {
            Err(failure) if failure.exit == Exit::Usage => failure.to_string(),
            other => panic!("{other:?}"),
        };
        let new = root.path().join("new");
        assert!(usage(args("synthetic-ot", &new, "Girl")).contains("`synthetic-otb`"));
        assert!(usage(args("synthetic-otb", &new, "Girll")).contains("`Girl`"));
        assert!(!new.exists());
        fs::write(root.path().join("mine.txt"), "mine").unwrap();
        assert!(usage(args("synthetic-otb", root.path(), "Girl")).contains("not empty"));
        assert!(usage(args("synthetic-otb", &root.path().join("mine.txt"), "Girl")).contains("not a folder"));
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 1);
    }
}
