//! Replay: a tracker whose regions were computed elsewhere and are read from result files.
//!
//! `results` names a folder under `<data root>/results/`. In it, the file of a sequence and run is the one
//! that is there of
//!
//! | file | format, written by | run `r`, from 0 | first pixel |
//! |---|---|---|---|
//! | `<Seq>.json` | [`otb_json`], OTB's authors | entry `r` of the list; of a TRE file, segment `r` | 1 |
//! | `<Seq>.txt` | [`otb_text`]: OTB, pysot, pytracking, the LaSOT toolkit, got10k | run 0 only | 1 |
//! | `<Seq>_00{r+1}.txt` | the same | its own file | 1 |
//! | `<Seq>/<Seq>_00{r+1}.txt` | [`vot`]: VOT, and pysot under `<tracker>/baseline` | its own file | 0 |
//! | the same name | [`got10k`]: GOT-10k; the first line tells which of the two it is | its own file | 1 |
//! | `<results>_00{r}/<Seq>.txt`, beside `results` | [`otb_text`]: pytracking with run numbers | its own folder | 1 |
//!
//! Two of them at once are an error. `*_time.txt` and other files of these toolkits are not looked at.
//!
//! What a result calls its first pixel is what the annotation calls it that the tracker was started with: no
//! toolkit shifts boxes. OTB, UAV123, LaSOT and GOT-10k count from 1, VOT from 0. Where that is not so, as
//! for a tracker whose authors subtract 1, `base = 0` or `base = 1` says it for all files of the folder.
//!
//! A sequence `Jogging-1` may be spelled `Jogging_1` (pytracking) or `Jogging.1` (got10k) in all of these
//! names: what stands before a target's number, of one or two digits, differs between toolkits.
//!
//! Which frame a line belongs to: VOT files have exactly the sequence's frames. Text and GOT-10k files have
//! either as many lines as the official range or as many as the range used. JSON states its frames, see
//! [`align`](super::results::align). The range used must be covered; a run that starts later than the
//! sequence (TRE segments after the first) is refused, because a track is a region for every frame.
//!
//! A box without area in the range used is an error that names it, unless `without_area = "repeat"`: then
//! the last region is repeated and the frame has [`Status::Skipped`], so that such frames can be counted.
//! (IVT's affine box collapses to a point in `Girl` from frame 402 on; no range used here has one.)
//! NaN and infinity are always errors, and so is a first box without area.
//!
//! All reading is done by `open`. `init` answers with the file's first state, whatever region it is given,
//! and starts again from the first frame when it is called again.

use super::results::{Base, Boxes, got10k, official_span, otb_json, otb_text, vot};
use super::{Setup, Start, State, Status, Tracker, TrackerError};
use crate::dataset::{DatasetError, Sequence, text};
use crate::image::Frame;
use crate::plugin::{Entry, ParamError, RawParams, read_params, show_params};
use crate::region::Region;
use serde::{Deserialize, Serialize};
use std::path::{Component, Path, PathBuf};

/// What to do about a box without area.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum WithoutArea {
    /// Refuse the file.
    #[default]
    Error,
    /// Repeat the last region and mark the frame as skipped.
    Repeat,
}

/// Parameters.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Folder under `<data root>/results/`, parts separated by `/`: `otb/OPE/STRUCK`.
    pub results: String,
    /// What to do about a box without area.
    #[serde(default)]
    pub without_area: WithoutArea,
    /// What the files call the left top pixel, 0 or 1; by default what their format does, see the table.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base: Option<Base>,
}

/// Checked parameters.
#[derive(Debug, Clone)]
pub struct Replay(Params);

/// The line in the list of trackers.
pub const ENTRY: Entry<dyn Setup> = Entry {
    kind: "replay",
    version: 1,
    summary: "regions from result files (OTB, VOT, GOT-10k, LaSOT, pysot, pytracking)",
    example: r#"{ results = "otb/OPE/STRUCK" }"#,
    build: |raw: RawParams<'_>| Ok(Box::new(Replay::new(read_params(raw)?)?)),
    schema: || schemars::schema_for!(Params),
};

impl Replay {
    /// Checks that `results` stays under the data root.
    ///
    /// # Errors
    /// Absolute paths, `.` and `..`, empty parts and backslashes.
    pub fn new(params: Params) -> Result<Self, ParamError> {
        let path = Path::new(&params.results);
        let stays = path.components().all(|c| matches!(c, Component::Normal(_)));
        let plain = params.results.split('/').all(|part| !part.is_empty() && part != "." && part != "..");
        if !stays || !plain || params.results.contains(['\\', '\0']) {
            let rule =
                "a relative path under `results/` of the data root without `..`, such as otb/OPE/STRUCK";
            return Err(ParamError::out_of_range("results", rule, format!("`{}`", params.results)));
        }
        Ok(Self(params))
    }

    /// The states of every frame of a sequence in one run.
    ///
    /// # Errors
    /// [`TrackerError::Missing`] where no file or no data root is there, [`TrackerError::Broken`] where the
    /// file is at fault.
    pub fn read(
        &self,
        sequence: &Sequence,
        run: u32,
        data_root: Option<&Path>,
    ) -> Result<Vec<State>, TrackerError> {
        let source = self.find(sequence, run, data_root)?;
        self.states(&source, sequence, run).map_err(|e| TrackerError::Broken(e.to_string()))
    }

    fn states(&self, source: &Source, sequence: &Sequence, run: u32) -> Result<Vec<State>, DatasetError> {
        let path = source.path.as_path();
        let bytes = text::read_capped(path)?;
        let base = |of_format| self.0.base.unwrap_or(of_format);
        let boxes = match source.kind {
            Kind::Json => otb_json::parse_from(path, &bytes, run, sequence.numbering, base(Base::One))?,
            Kind::Text => text_boxes(path, &bytes, sequence, base(Base::One))?,
            Kind::OwnFolder => match got10k::kind(path, &bytes)? {
                got10k::Kind::Vot => {
                    return vot::parse_from(path, &bytes, &sequence.truth, base(Base::Zero));
                }
                got10k::Kind::Boxes => text_boxes(path, &bytes, sequence, base(Base::One))?,
            },
        };
        self.cut(path, boxes, sequence)
    }

    fn find(&self, sequence: &Sequence, run: u32, data_root: Option<&Path>) -> Result<Source, TrackerError> {
        let Params { results, .. } = &self.0;
        let Some(root) = data_root else {
            return Err(TrackerError::Missing(format!(
                "results `{results}` need a data root; give --data-root or TRACKFAIL_DATA"
            )));
        };
        let below = |folder: &str| folder.split('/').fold(root.join("results"), |path, part| path.join(part));
        let (folder, of_run) = (below(results), format!("{results}_{run:03}"));
        let mut found = Vec::new();
        let mut looked_for = Vec::new();
        for name in spellings(&sequence.name) {
            let numbered = format!("{name}_{:03}.txt", run + 1);
            let mut look = |kind, shown: String| {
                found.push(Source { kind, path: shown.split('/').fold(folder.clone(), |p, s| p.join(s)) });
                looked_for.push(shown);
            };
            look(Kind::Json, format!("{name}.json"));
            if run == 0 {
                look(Kind::Text, format!("{name}.txt"));
            }
            look(Kind::Text, numbered.clone());
            look(Kind::OwnFolder, format!("{name}/{numbered}"));
            let path = below(&of_run).join(format!("{name}.txt"));
            found.push(Source { kind: Kind::Text, path });
        }
        found.retain(|s| s.path.is_file());
        match (found.pop(), found.pop()) {
            (Some(one), None) => Ok(one),
            (Some(a), Some(b)) => Err(TrackerError::Broken(format!(
                "both {} and {} exist; keep the one that is meant",
                a.path.display(),
                b.path.display()
            ))),
            (None, _) => Err(TrackerError::Missing(format!(
                "no result of `{results}` for {}, run {run}: {} has none of {}, and {of_run} beside it has none",
                sequence.name,
                folder.display(),
                looked_for.join(", ")
            ))),
        }
    }

    /// The states of the range used.
    fn cut(&self, path: &Path, boxes: Boxes, sequence: &Sequence) -> Result<Vec<State>, DatasetError> {
        let (first, count) = (sequence.numbering.first, sequence.len());
        let end = u64::from(boxes.first) + boxes.regions.len() as u64;
        let needed = u64::from(first) + count as u64;
        if boxes.first > first || end < needed {
            return Err(DatasetError::content(
                path,
                format!(
                    "frames {} to {} do not cover {} from {first} to {}; runs that start later are not read",
                    boxes.first,
                    end - 1,
                    sequence.name,
                    needed - 1
                ),
            ));
        }
        let from_start = boxes.first == first;
        let used = boxes.regions.into_iter().skip((first - boxes.first) as usize).take(count);
        let mut states: Vec<State> = Vec::with_capacity(count);
        for (t, region) in used.enumerate() {
            let last = states.last().map(|s| s.region.clone());
            states.push(match (region, last) {
                (Ok(region), _) if t == 0 && from_start => State::initialised(region),
                (Ok(region), _) => State::tracked(region),
                (Err(_), Some(region)) if self.0.without_area == WithoutArea::Repeat => {
                    State { region, status: Status::Skipped, posterior: None }
                }
                (Err(message), _) => return Err(DatasetError::content(path, message)),
            });
        }
        Ok(states)
    }
}

/// How a file is read.
#[derive(Debug, Clone, Copy)]
enum Kind {
    Json,
    Text,
    /// In a folder of the sequence's own: VOT or GOT-10k.
    OwnFolder,
}

struct Source {
    kind: Kind,
    path: PathBuf,
}

/// A sequence's name, and where it ends in a target's number also the other ways to write that.
fn spellings(name: &str) -> Vec<String> {
    let mut all = vec![name.to_owned()];
    if let Some((head, number)) = name.rsplit_once('-') {
        // Three digits would be a run's number.
        let short = (1..=2).contains(&number.len()) && number.bytes().all(|b| b.is_ascii_digit());
        if short && !head.is_empty() {
            all.extend([format!("{head}_{number}"), format!("{head}.{number}")]);
        }
    }
    all
}

fn text_boxes(path: &Path, bytes: &[u8], sequence: &Sequence, base: Base) -> Result<Boxes, DatasetError> {
    let rows = otb_text::parse_rows(path, bytes)?;
    let span = official_span(sequence.numbering);
    let start = match rows.len() {
        n if n as u64 == span => sequence.numbering.official.0,
        n if n == sequence.len() => sequence.numbering.first,
        n => {
            let message = format!(
                "{n} boxes; {} has {span} frames, {} of them used, and none is made up or dropped",
                sequence.name,
                sequence.len()
            );
            return Err(DatasetError::content(path, message));
        }
    };
    let regions = rows.into_iter().map(|(line, row)| {
        Region::from_numbers(&row).map(|r| base.to_zero(r)).map_err(|e| format!("line {line}: {e}"))
    });
    Ok(Boxes { first: start, regions: regions.collect() })
}

impl Setup for Replay {
    fn params(&self) -> serde_json::Value {
        show_params(&self.0)
    }

    fn uses_seed(&self) -> bool {
        false
    }

    fn needs_truth(&self) -> bool {
        true
    }

    fn inputs(&self, start: &Start<'_>) -> Result<Vec<PathBuf>, TrackerError> {
        Ok(vec![self.find(start.sequence, start.run, start.data_root)?.path])
    }

    fn open(&self, start: &Start<'_>) -> Result<Box<dyn Tracker>, TrackerError> {
        let states = self.read(start.sequence, start.run, start.data_root)?;
        Ok(Box::new(Player { states, next: 0 }))
    }
}

struct Player {
    states: Vec<State>,
    next: usize,
}

impl Player {
    fn step(&mut self) -> Result<State, TrackerError> {
        let state = self.states.get(self.next).cloned().ok_or_else(|| {
            let message = format!("the result has {} frames; there is no further one", self.states.len());
            TrackerError::Broken(message)
        })?;
        self.next += 1;
        Ok(state)
    }
}

impl Tracker for Player {
    fn init(&mut self, _: &Frame, _: &Region) -> Result<State, TrackerError> {
        self.next = 0;
        self.step()
    }

    fn update(&mut self, _: &Frame) -> Result<State, TrackerError> {
        self.step()
    }

    fn reset(&mut self) {
        self.next = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::{Frames, Numbering, lock};
    use crate::region::Rect;

    fn replay(results: &str) -> Replay {
        let text = format!("{{ results = \"{results}\" }}");
        Replay::new(read_params(RawParams::parse(&text).unwrap()).unwrap()).unwrap()
    }

    /// Frames 3 and 4 of official 2..=5.
    fn sequence() -> Sequence {
        Sequence {
            name: "S".into(),
            numbering: Numbering { first: 3, official: (2, 5) },
            truth: vec![Some(Region::Rect(Rect::new(9.0, 9.0, 9.0, 9.0))); 2],
            attributes: vec![],
            frame_attributes: vec![],
            digest: "0".into(),
            frames: Frames::Files(vec![].into()),
        }
    }

    fn with_files(files: &[(&str, &str)]) -> tempfile::TempDir {
        let root = tempfile::tempdir().unwrap();
        for (name, text) in files {
            let path = root.path().join("results/a").join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        root
    }

    fn lefts(states: &[State]) -> Vec<f64> {
        states.iter().map(|s| s.region.rect().x).collect()
    }

    const JSON: &str = r#"[{"startFrame":1,"endFrame":4,"resType":"rect",
        "res":[[1,1,1,1],[2,1,1,1],[3,1,1,1],[4,1,1,1]]},
        {"startFrame":4,"endFrame":5,"resType":"rect","res":[[4,1,1,1],[5,1,1,1]]}]"#;

    #[test]
    fn formats_and_runs() {
        let four = "1,1,1,1\n2,1,1,1\n3,1,1,1\n4,1,1,1";
        for (file, text, run, want) in [
            ("S.json", JSON, 0, [1.0, 2.0]),
            ("S.txt", four, 0, [1.0, 2.0]),
            ("S.txt", "7,1,1,1\n8,1,1,1\n", 0, [6.0, 7.0]),
            ("S_001.txt", "7,1,1,1\n8,1,1,1\n", 0, [6.0, 7.0]),
            ("S_003.txt", four, 2, [1.0, 2.0]),
            ("S/S_001.txt", "1\n4,4,2,2", 0, [9.0, 4.0]),
            ("S/S_012.txt", "1\n2", 11, [9.0, 9.0]),
            // GOT-10k, three repetitions; of the official range and of the range used.
            ("S/S_001.txt", "1.000,1.000,1.000,1.000\n2,1,1,1\n3,1,1,1\n4,1,1,1\n", 0, [1.0, 2.0]),
            ("S/S_003.txt", "\u{feff}7,1,1,1\r\n8,1,1,1\r\n", 2, [6.0, 7.0]),
            // pytracking, without a run's number and with.
            ("S.txt", "7\t1\t1\t1\n8\t1\t1\t1\n", 0, [6.0, 7.0]),
            ("../a_000/S.txt", "7\t1\t1\t1\n8\t1\t1\t1\n", 0, [6.0, 7.0]),
            ("../a_004/S.txt", "7\t1\t1\t1\n8\t1\t1\t1\n", 4, [6.0, 7.0]),
            // pysot, and blanks.
            ("S.txt", "7.5,1.5,1.0,1.0\n8.25,1,1,1\n", 0, [6.5, 7.25]),
            ("S.txt", "7 1 1,  1\n8 1\t1 1", 0, [6.0, 7.0]),
        ] {
            let root = with_files(&[(file, text), ("S/S_001_time.txt", "1\n1"), ("S_time.txt", "0.1")]);
            let states = replay("a").read(&sequence(), run, Some(root.path()));
            assert_eq!(lefts(&states.unwrap()), want, "{file}");
        }
    }

    #[test]
    fn the_first_pixel_may_be_given() {
        for (file, text, default, other) in [
            ("S.txt", "7,1,1,1\n8,1,1,1", [6.0, 7.0], (0, [7.0, 8.0])),
            ("S.json", JSON, [1.0, 2.0], (0, [2.0, 3.0])),
            ("S/S_001.txt", "7,1,1,1\n8,1,1,1", [6.0, 7.0], (0, [7.0, 8.0])),
            // The truth of the first frame is no part of the file and does not move.
            ("S/S_001.txt", "1\n8,1,1,1", [9.0, 8.0], (1, [9.0, 7.0])),
        ] {
            let root = with_files(&[(file, text)]);
            let read = |params: String| {
                let replay = Replay::new(read_params(RawParams::parse(&params).unwrap()).unwrap()).unwrap();
                lefts(&replay.read(&sequence(), 0, Some(root.path())).unwrap())
            };
            assert_eq!(read("{ results = \"a\" }".into()), default, "{file}");
            let (base, moved) = other;
            assert_eq!(read(format!("{{ results = \"a\", base = {base} }}")), moved, "{file}");
            assert_eq!(read(format!("{{ results = \"a\", base = {} }}", 1 - base)), default, "{file}");
        }
        for bad in ["2", "-1", "\"0\"", "0.5", "true"] {
            assert!(ENTRY.build_from_text(&format!("{{ results = \"a\", base = {bad} }}")).is_err(), "{bad}");
        }
        let setup = ENTRY.build_from_text("{ results = \"a\", base = 0 }").unwrap();
        assert_eq!(setup.params()["base"], 0);
        // Not given is no key of an address, so that those of before stay.
        assert!(ENTRY.build_from_text(ENTRY.example).unwrap().params().get("base").is_none());
    }

    #[test]
    fn a_targets_number_may_be_spelled_otherwise() {
        assert_eq!(spellings("Jogging-1"), ["Jogging-1", "Jogging_1", "Jogging.1"]);
        assert_eq!(spellings("car-racing-12"), ["car-racing-12", "car-racing_12", "car-racing.12"]);
        for plain in ["Girl2", "-1", "GOT-10k_Val_000001", "car-001", "a-b", "a-"] {
            assert_eq!(spellings(plain), [plain]);
        }
        let boxes = "7,1,1,1\n8,1,1,1";
        let second = Sequence { name: "S-2".into(), ..sequence() };
        for file in ["S-2.txt", "S_2.txt", "S.2.txt", "S_2_001.txt", "S_2/S_2_001.txt", "../a_000/S_2.txt"] {
            let root = with_files(&[(file, boxes), ("S.txt", "1,1,1,1"), ("S_1.txt", "")]);
            let states = replay("a").read(&second, 0, Some(root.path())).unwrap();
            assert_eq!(lefts(&states), [6.0, 7.0], "{file}");
        }
        let root = with_files(&[("S_2.txt", boxes), ("S.2.txt", boxes)]);
        match replay("a").read(&second, 0, Some(root.path())) {
            Err(TrackerError::Broken(m)) => assert!(m.contains("S_2.txt") && m.contains("S.2.txt"), "{m}"),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn absent_results_are_missing() {
        let root = with_files(&[("S.txt", "1,1,1,1"), ("T_001.txt", "")]);
        let missing = |result: Result<Vec<State>, TrackerError>| match result {
            Err(TrackerError::Missing(message)) => message,
            other => panic!("{other:?}"),
        };
        assert!(missing(replay("a").read(&sequence(), 0, None)).contains("--data-root"));
        assert!(missing(replay("b").read(&sequence(), 0, Some(root.path()))).contains("S/S_001.txt"));
        let second = missing(replay("a").read(&sequence(), 1, Some(root.path())));
        assert!(second.contains("S_002.txt") && second.contains("a_001 beside"), "{second}");
    }

    #[test]
    fn what_does_not_fit_is_broken() {
        for (files, run, word) in [
            (&[("S.json", JSON)][..], 1, "start later"),
            (&[("S.json", JSON)], 2, "no run 2"),
            (&[("S.txt", "1,1,1,1")], 0, "1 boxes"),
            (&[("S.txt", "1,1,1,1\n1,1,1,1\n1,1,1,1")], 0, "3 boxes"),
            (&[("S.txt", "1,1,1,1\n1,1,0,1")], 0, "S.txt: line 2"),
            (&[("S.txt", "1,1,1,1\n1,nan,1,1")], 0, "S.txt, line 2"),
            (&[("S.txt", "")], 0, "empty"),
            (&[("S/S_001.txt", "1")], 0, "1 lines for 2"),
            (&[("S.txt", "1,1,1,1\n1,1,1,1"), ("S.json", JSON)], 0, "both"),
            (&[("S.txt", "1,1,1,1\n1,1,1,1"), ("../a_000/S.txt", "1,1,1,1\n1,1,1,1")], 0, "a_000/S.txt"),
            (&[("S/S_001.txt", "0\n1")], 0, "S_001.txt, line 1: neither"),
            (&[("S/S_001.txt", "1,1\n1,1")], 0, "S_001.txt, line 1: neither"),
            (&[("S/S_001.txt", "5,5,1,1\n1")], 0, "S_001.txt, line 2: 1 numbers"),
            (&[("S/S_001.txt", "5,5,1,1\n5,5,1,inf")], 0, "S_001.txt, line 2"),
            (&[("S/S_001.txt", "5,5,1,1\n5,5,1,0")], 0, "S_001.txt: line 2"),
            (&[("S/S_001.txt", "5,5,1,1\n5,5,1,1\n5,5,1,1")], 0, "3 boxes"),
            (&[("S/S_001.txt", "5,5,1,1")], 0, "1 boxes"),
            (&[("../a_001/S.txt", "7\t1\t1\t1\n8\t1\t0\t1")], 1, "S.txt: line 2"),
        ] {
            let root = with_files(files);
            match replay("a").read(&sequence(), run, Some(root.path())) {
                Err(TrackerError::Broken(message)) => assert!(message.contains(word), "{message}"),
                other => panic!("{files:?}: {other:?}"),
            }
        }
    }

    #[test]
    fn boxes_without_area_may_be_repeated_and_are_marked() {
        let files = [("S.txt", "5,1,1,1\n6,1,0,1"), ("T.txt", "5,1,0,1\n6,1,1,1")];
        let root = with_files(&files);
        let mut repeat = replay("a");
        repeat.0.without_area = WithoutArea::Repeat;
        let states = repeat.read(&sequence(), 0, Some(root.path())).unwrap();
        assert_eq!((lefts(&states), states[1].status), (vec![4.0, 4.0], Status::Skipped));
        let other = Sequence { name: "T".into(), ..sequence() };
        assert!(repeat.read(&other, 0, Some(root.path())).is_err());
    }

    #[test]
    fn paths_stay_under_the_data_root() {
        for bad in ["", "/etc", "../x", "a/../b", "a//b", "./a", "a/.", "a\\\\b", "a/"] {
            let text = format!("{{ results = \"{bad}\" }}");
            let error = ENTRY.build_from_text(&text).err().unwrap();
            assert_eq!(error.key, Some("results"), "{bad}");
        }
        assert!(ENTRY.build_from_text("{ results = \"a\", more = 1 }").is_err());
        assert!(ENTRY.build_from_text("{ results = \"a\", label = \" \" }").is_err());
        let setup = ENTRY.build_from_text(ENTRY.example).unwrap();
        assert_eq!(setup.params()["results"], "otb/OPE/STRUCK");
        assert_eq!(setup.params()["without_area"], "error");
    }

    #[test]
    fn plays_in_order_and_again() {
        let root = with_files(&[("S.json", JSON)]);
        let s = sequence();
        let start = Start { sequence: &s, run: 0, seed: 0, data_root: Some(root.path()) };
        let mut tracker = replay("a").open(&start).unwrap();
        let frame = Frame::new(1, 1, vec![0; 3]);
        let region = s.truth[0].clone().unwrap();
        for _ in 0..2 {
            let first = tracker.init(&frame, &region).unwrap();
            // The file starts one frame before the range used, so this is no initialisation.
            assert_eq!((first.region.rect().x, first.status), (1.0, Status::Tracked));
            assert_eq!(tracker.update(&frame).unwrap().region.rect().x, 2.0);
            assert!(tracker.update(&frame).is_err());
        }
        tracker.reset();
        assert_eq!(tracker.init(&frame, &region).unwrap().region.rect().x, 1.0);
    }

    #[test]
    fn real_results_cover_the_real_sequences() {
        let Some(root) = crate::testing::real_data("real_results_cover_the_real_sequences") else { return };
        let otb = lock::suite("otb-dtef20").unwrap().load(Some(&root)).sequences;
        for tracker in ["OPE/STRUCK", "OPE/MEEM", "OPE/MUSTer", "TRE/IVT"] {
            let setup = replay(&format!("otb/{tracker}"));
            for s in &otb {
                let states = setup.read(s, 0, Some(&root)).unwrap();
                assert_eq!(states.len(), s.len());
                assert_eq!(states[0].status, Status::Initialised);
                // OTB starts every tracker with the ground truth; Struck rounds, IVT draws its own.
                let truth = s.truth[0].as_ref().unwrap();
                let share = states[0].region.intersection(truth) / truth.area();
                assert!(share > 0.9, "{tracker} {}: {share}", s.name);
            }
        }
        let vot = lock::suite("vot2014").unwrap().load(Some(&root)).sequences;
        for (tracker, runs) in [
            ("GOTURN/baseline", 3),
            ("PFTracker/baseline_lite", 1),
            ("CFTTracker/baseline_lite", 1),
            ("kalman/baseline_lite_25", 1),
        ] {
            let setup = replay(&format!("vot2014/{tracker}"));
            for s in &vot {
                for run in 0..runs {
                    let states = setup.read(s, run, Some(&root)).unwrap();
                    assert_eq!(states.len(), s.len());
                }
                assert!(matches!(setup.read(s, runs, Some(&root)), Err(TrackerError::Missing(_))));
            }
        }
    }
}
