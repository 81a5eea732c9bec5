//! Scene files: who moves where, before which background.
//!
//! A file has a `title`, the `layout` that `trackfail data render` writes (`otb`, or `vot` with turned boxes
//! as ground truth), and a `[[scene]]` for each sequence. The keys of a scene are the fields of `ScenePlan`
//! and `Actor`: the target, and what is `behind` it and in `front` of it. Curves are lists of `[frame,
//! value]`. Places are in pixels of a world of which the camera shows a part. The four suites of the program
//! are such files, in `scenes/`.

use super::motion::Curve;
use super::scene::{Actor, ScenePlan};
use super::{RenderLayout, scene};
use crate::{DatasetError, Sequence, sorted, text};
use serde::Deserialize;
use serde::de::{Deserializer, Error as _};
use std::ops::RangeInclusive;
use std::path::Path;
use toml::Spanned;

/// Most pixels of a background, including all that the camera passes over.
const MAX_BACKGROUND: f64 = 64e6;

/// Range of all numbers in a scene.
const NUMBERS: RangeInclusive<f64> = -1e5..=1e5;
const NUMBERS_WORDS: &str = "numbers go from -100000 to 100000";

/// The scenes of a suite.
#[derive(Debug, Clone)]
pub struct SceneFile {
    /// One line about the scenes.
    pub title: String,
    /// Layout in which the scenes are written.
    pub layout: RenderLayout,
    pub(super) plans: Vec<ScenePlan>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Wire {
    title: String,
    layout: RenderLayout,
    scene: Vec<Spanned<ScenePlan>>,
}

impl SceneFile {
    /// Names of the sequences, in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.plans.iter().map(|plan| plan.name.as_str())
    }

    /// Sequences with their ground truth, as those of the suite `suite`, on whose name textures and noise
    /// depend. Nothing is painted until a frame is rendered.
    pub fn sequences(&self, suite: &str) -> Vec<Sequence> {
        self.plans.iter().map(|plan| scene::sequence(suite, plan)).collect()
    }
}

/// Reads a scene file.
///
/// # Errors
/// A file that cannot be read, or the first fault in it, with its line and key.
pub fn read(path: &Path) -> Result<SceneFile, DatasetError> {
    parse(path, &text::read(path)?)
}

/// Parses the text of a scene file; `path` is for messages.
pub(super) fn parse(path: &Path, source: &str) -> Result<SceneFile, DatasetError> {
    let line = |place: usize| text::line_of(source.as_bytes(), place);
    let wire: Wire = toml::from_str(source).map_err(|e| {
        let line = line(e.span().map_or(0, |span| span.start));
        let key = source.lines().nth(line - 1).and_then(|line| line.split_once('='));
        let key = key.map_or_else(String::new, |(key, _)| {
            format!("`{}`: ", text::shorten(&text::visible(key.trim())))
        });
        DatasetError::line(path, line, format!("{key}{}", text::shorten_to(&text::visible(e.message()), 200)))
    })?;
    let mut plans: Vec<ScenePlan> = Vec::new();
    for scene in wire.scene {
        let line = line(scene.span().start);
        let mut plan = scene.into_inner();
        let name = text::shorten(&text::visible(&plan.name));
        let fault = |message: &str| DatasetError::line(path, line, format!("scene `{name}`: {message}"));
        check(&plan).map_err(fault)?;
        if plans.iter().any(|other| other.name == plan.name) {
            return Err(fault("`name` is that of another scene of the file"));
        }
        plan.polygon = wire.layout == RenderLayout::Vot;
        plan.attributes = sorted(plan.attributes);
        plans.push(plan.placed());
    }
    Ok(SceneFile { title: wire.title, layout: wire.layout, plans })
}

/// Checks a scene for faults that involve several keys.
fn check(plan: &ScenePlan) -> Result<(), &'static str> {
    if !text::is_name(&plan.name) || plan.name.contains(['"', '\\', '/']) || plan.name.starts_with('.') {
        return Err("`name` is a plain word without slashes, quotes and a dot at its start");
    }
    if !plan.attributes.iter().all(|a| text::is_name(a) && a.trim() == a && !a.contains(',')) {
        return Err("`attributes` are words without commas that do not begin with one of = + - @");
    }
    let own = |a: &Actor| !a.x.is_empty() && !a.y.is_empty() && a.crosses.is_none() && a.along.is_none();
    let follows = |a: &Actor| a.x.is_empty() && a.y.is_empty() && a.crosses.is_some() != a.along.is_some();
    if !own(&plan.target) {
        return Err("the target has `x` and `y`, and neither `crosses` nor `along`");
    }
    if !plan.behind.iter().chain(&plan.front).all(|a| own(a) || follows(a)) {
        return Err("whoever is `behind` or in `front` has either `x` and `y`, or `crosses`, or `along`");
    }
    let span = |curve: &[(f64, f64)], side: usize| {
        let low = curve.iter().map(|p| p.1).fold(f64::INFINITY, f64::min);
        let high = curve.iter().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max);
        (high - low).max(0.0) + 2.0 * plan.shake.abs() + side as f64
    };
    if span(&plan.camera_x, plan.size.0) * span(&plan.camera_y, plan.size.1) > MAX_BACKGROUND {
        return Err(
            "`camera_x` and `camera_y` go too far, the background would have more than 64 million pixels",
        );
    }
    Ok(())
}

/// Reads a value that `fits` must accept; `words` state the rule in the error.
fn fitting<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
    from: D,
    words: &str,
    fits: impl Fn(&T) -> bool,
) -> Result<T, D::Error> {
    let value = T::deserialize(from)?;
    if fits(&value) { Ok(value) } else { Err(D::Error::custom(words)) }
}

/// True if both numbers are in the range.
fn both<T: PartialOrd>(range: &RangeInclusive<T>, (a, b): &(T, T)) -> bool {
    range.contains(a) && range.contains(b)
}

/// Reads a number within [`NUMBERS`].
pub(super) fn number<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    fitting(from, NUMBERS_WORDS, |number| NUMBERS.contains(number))
}

/// Reads a pair of numbers within [`NUMBERS`].
pub(super) fn numbers<'de, D: Deserializer<'de>>(from: D) -> Result<(f64, f64), D::Error> {
    fitting(from, NUMBERS_WORDS, |pair| both(&NUMBERS, pair))
}

/// Reads a number of frames.
pub(super) fn frames<'de, D: Deserializer<'de>>(from: D) -> Result<usize, D::Error> {
    fitting(from, "a sequence has 1 to 100000 frames", |frames| (1..=100_000).contains(frames))
}

/// Reads width and height of frames.
pub(super) fn frame_size<'de, D: Deserializer<'de>>(from: D) -> Result<(usize, usize), D::Error> {
    fitting(from, "frames are 16 to 4096 pixels wide and high", |size| both(&(16..=4096), size))
}

/// Reads width and height of an actor.
pub(super) fn actor_size<'de, D: Deserializer<'de>>(from: D) -> Result<(f64, f64), D::Error> {
    fitting(from, "it is 1 to 4096 pixels wide and high", |size| both(&(1.0..=4096.0), size))
}

/// Reads a list of `[frame, value]` in which frames rise.
pub(super) fn curve<'de, D: Deserializer<'de>>(from: D) -> Result<Curve, D::Error> {
    let points: Curve =
        fitting(from, NUMBERS_WORDS, |points: &Curve| points.iter().all(|p| both(&NUMBERS, p)))?;
    let rises = points.is_sorted_by(|a, b| a.0 < b.0);
    if rises { Ok(points) } else { Err(D::Error::custom("the frames of a list of `[frame, value]` rise")) }
}

/// Reads a curve of magnifications.
pub(super) fn scale<'de, D: Deserializer<'de>>(from: D) -> Result<Curve, D::Error> {
    let points = curve(from)?;
    let fits = points.iter().all(|p| (0.01..=100.0).contains(&p.1));
    if fits { Ok(points) } else { Err(D::Error::custom("magnifications are 0.01 to 100")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENES: &str = "title = \"Mine\"\nlayout = \"otb\"\n\n[[scene]]\nname = \"walk\"\nattributes = [\"b\", \"a\"]\n\
        size = [160, 120]\nframes = 30\nground = \"street\"\n\n[scene.target]\nkind = \"person\"\nsize = [20, 60]\n\
        x = [[0, 40], [29, 120]]\ny = [[0, 70]]\nstrides = true\n\n[[scene.front]]\nkind = \"post\"\nsize = [9, 99]\n\
        crosses = { frame = 15, velocity = [-1, 0] }\n";

    #[test]
    fn a_file_of_ones_own_is_rendered() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mine.toml");
        std::fs::write(&path, SCENES).unwrap();
        let file = read(&path).unwrap();
        assert_eq!((file.title.as_str(), file.names().collect::<Vec<_>>()), ("Mine", vec!["walk"]));
        let sequence = file.sequences("mine").swap_remove(0);
        assert_eq!((sequence.len(), sequence.size().unwrap()), (30, (160, 120)));
        assert_eq!(sequence.attributes, ["a", "b"]);
        assert_ne!(sequence.frame(0).unwrap(), sequence.frame(29).unwrap());
        // Where pixels change, so does the digest.
        std::fs::write(&path, SCENES.replace("[29, 120]", "[29, 121]")).unwrap();
        let changed = read(&path).unwrap().sequences("mine").swap_remove(0);
        assert_ne!(sequence.digest().unwrap(), changed.digest().unwrap());
    }

    #[test]
    fn the_example_of_the_documents_is_a_file_of_scenes() {
        let example = include_str!("../../../../docs/datasets.md").split("```toml\n").nth(1).unwrap();
        let file = parse(Path::new("docs"), example.split("```").next().unwrap()).unwrap();
        assert_eq!(file.sequences("mine")[0].len(), 60);
    }

    #[test]
    fn faults_name_file_line_and_key() {
        for (before, after, words) in [
            ("size = [160", "size = [0", "line 7: `size`: frames are 16 to 4096"),
            ("size = [20,", "size = [-2,", "line 13: `size`: it is 1 to 4096"),
            ("frames = 30", "frames = 0", "line 8: `frames`: a sequence has 1 to"),
            ("frames = 30", "frame = 30", "line 8: `frame`: unknown field `frame`"),
            ("\"street\"", "\"moon\"", "line 9: `ground`: unknown variant `moon`"),
            ("[29, 120]", "[29, nan]", "line 14: `x`: numbers go from"),
            ("[29, 120]", "[0, 120]", "line 14: `x`: the frames of a list"),
            ("[29, 120]", "[29]", "line 14: `x`: "),
            ("x = [[0, 40], [29, 120]]\n", "", "line 4: scene `walk`: the target has `x` and `y`"),
            ("crosses = ", "x = [[0, 1]]\ncrosses = ", "line 4: scene `walk`: whoever is `behind`"),
            ("crosses = { frame = 15, velocity = [-1, 0] }\n", "", "line 4: scene `walk`: whoever is"),
            ("[\"b\", \"a\"]", "[\"=b\"]", "line 4: scene `walk`: `attributes` are words without commas"),
            ("[\"b\", \"a\"]", "[\"b,a\"]", "line 4: scene `walk`: `attributes` are words without commas"),
            ("[\"b\", \"a\"]", "[\" b\"]", "line 4: scene `walk`: `attributes` are words without commas"),
            ("\"walk\"", "\"a/b\"", "line 4: scene `a/b`: `name` is a plain word"),
            ("strides = true", "scale = [[0, 0]]", "line 16: `scale`: magnifications are 0.01 to"),
            (
                "ground = ",
                "camera_x = [[0, 0], [9, 99999]]\ncamera_y = [[0, 0], [9, 99999]]\nground = ",
                "too far",
            ),
            ("layout = \"otb\"", "layout = \"got\"", "line 2: `layout`: unknown variant `got`"),
        ] {
            let text = SCENES.replace(before, after);
            assert_ne!(text, SCENES, "{before}");
            let error = parse(Path::new("mine.toml"), &text).unwrap_err().to_string();
            assert!(error.starts_with("mine.toml, line ") && error.contains(words), "{error}");
        }
        let twice = SCENES.to_owned() + SCENES.split_once("\n\n").unwrap().1;
        let error = parse(Path::new("mine.toml"), &twice).unwrap_err();
        trackfail_testing::assert_says(error, "line 22: scene `walk`: `name` is that of another");
    }
}
