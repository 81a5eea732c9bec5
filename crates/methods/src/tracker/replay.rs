//! Replay: a tracker that reads its regions from result files.
//!
//! `results` names a folder under `<data root>/results/`. The file of a sequence and run is one of these:
//!
//! | file | format, written by | run `r`, from 0 | first pixel |
//! |---|---|---|---|
//! | `<Seq>.json` | [`otb_json`], OTB's authors | entry `r` of the list; of a TRE file, segment `r` | 1 |
//! | `<Seq>.txt` | [`otb_text`]: OTB, pysot, pytracking, the LaSOT toolkit, got10k | run 0 only | 1 |
//! | the same name | [`mot`]: MOTChallenge; the first line's columns tell which of the two it is | run 0 only | 1 |
//! | `<Seq>_00{r+1}.txt` | both of these | its own file | 1 |
//! | `<Seq>_bboxes.txt` | [`otb_text`]: long-term runs of SiamFC on VOT's sequences | run 0 only | 0 |
//! | `<Seq>/<Seq>_00{r+1}.txt` | [`vot`]: VOT, and pysot under `<tracker>/baseline` | its own file | 0 |
//! | `longterm/<Seq>/<Seq>_00{r+1}.txt` | the same: pysot on VOT2018-LT | its own file | 0 |
//! | the same names | [`otb_text`]: GOT-10k; the first line, `1` of VOT or a box, tells which of the two it is | its own file | 1 |
//! | `<Seq>.csv` | [`oxuva`]: OxUvA; relative coordinates, frames that were asked for | run 0 only | |
//! | `<results>_00{r}/<Seq>.txt`, beside `results` | [`otb_text`]: pytracking with run numbers | its own folder | 1 |
//!
//! It is an error if two of these files exist. `*_time.txt` and other files of these toolkits are ignored.
//!
//! The first pixel of a result has the same number as in the annotation with which the tracker was started:
//! no toolkit shifts boxes. OTB, UAV123, LaSOT and GOT-10k count from 1, VOT from 0. If a result differs, for
//! example because the authors of the tracker subtract 1, `base = 0` or `base = 1` sets the number for all
//! files of the folder.
//!
//! A sequence `Jogging-1` may be spelled `Jogging_1` (pytracking) or `Jogging.1` (got10k) in all of these
//! names: toolkits differ in the character before the number of a target (one or two digits). If there is no
//! file of these names, a file is read whose name differs only in capital letters, such as `BasketBall.json`
//! in OTB's results of Struck.
//!
//! **Frames of the lines.** A VOT file has exactly the frames of the sequence. A text or GOT-10k file has as
//! many lines as the official range or as the used range. A JSON file states its frames, see
//! [`align`](super::results::align). The file must cover the used range. A run that starts later than the
//! sequence (TRE segments after the first) is refused, because a track has a region for every frame.
//!
//! **Confidence.** OxUvA and MOT have it in their rows. For the other formats it is read from a
//! [file](confidence) beside the boxes, if there is one. It is an error if there are two, unless `confidence`
//! chooses one: `confidence = "motion"` reads `<name>_motion.value` or `<name>_motion.txt`, and a track
//! without that file is missing.
//!
//! **Frames without a box.** No area, NaN, an empty line, a row that says `false` (OxUvA), no row (MOT):
//! these are errors that name the line, unless `without_area` says otherwise. With `"absent"` such a frame
//! means that the tracker says that the target is absent: the frame has [`Status::Absent`], and the rules of
//! scoring decide what it counts as. With `"repeat"` the last region is taken as the answer, with
//! [`Status::Repeated`], so that such frames can be counted. (IVT's affine box collapses to a point in `Girl`
//! from frame 402 on; no range used here has one.) Infinity is always an error, and so is a first frame
//! without a box; where the format leaves out the first frame (OxUvA, MOT), it has the ground truth. Frames
//! that OxUvA's tracker was not asked for are skipped.
//!
//! All files are read at the start. The answer to the start is the first state in the file, whatever region
//! the tracker is given.

mod files;

use super::results::{Base, BoxError, Boxes, NoBox, confidence, mot, otb_json, otb_text, oxuva, rows, vot};
use super::{Facts, RunContext, StartResult, Status, Tracker, TrackerConfig, TrackerError, TrackerState};
use files::{Kind, Source};
use serde::{Deserialize, Serialize};
use std::path::{Component, Path, PathBuf};
use trackfail_core::image::Frame;
use trackfail_core::plugin::{Entry, ParamError, PlainParams, show_params};
use trackfail_core::region::Region;
use trackfail_dataset::{DatasetError, SequenceInfo, text};

/// Treatment of a frame without a box.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum WithoutArea {
    /// Refuse the file.
    #[default]
    Error,
    /// Repeat the last region, which counts as the tracker's answer.
    Repeat,
    /// The tracker says that the target is absent.
    Absent,
}

impl WithoutArea {
    /// Status of a frame without a box; `None` where it is an error.
    fn status(self) -> Option<Status> {
        match self {
            Self::Error => None,
            Self::Repeat => Some(Status::Repeated),
            Self::Absent => Some(Status::Absent),
        }
    }
}

/// Parameters of `replay`.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Folder under `<data root>/results/`, with `/` between parts, such as `otb/OPE/STRUCK`.
    pub results: String,
    /// Treatment of a frame without a box (no area, NaN, an empty line): `error` refuses the file,
    /// `repeat` repeats the last region, `absent` means that the tracker says that the target is absent.
    #[serde(default)]
    pub without_area: WithoutArea,
    /// Number of the top left pixel in the files, 0 or 1; by default the number of their format, see the
    /// table.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base: Option<Base>,
    /// Name of the confidence in the file beside the boxes, which is `<name>_<confidence>.value` or `.txt`;
    /// by default the only file with a known name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub confidence: Option<String>,
    /// Number of the target in files of several targets (MOT).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub id: Option<i64>,
}

/// `replay` in the list of trackers.
pub const ENTRY: Entry<dyn TrackerConfig> = Entry::of::<Params>(
    "replay",
    1,
    "regions and confidence from result files (OTB, VOT, GOT-10k, LaSOT, pysot, pytracking, OxUvA, MOT)",
)
.example(r#"{ results = "otb/OPE/STRUCK" }"#);

impl PlainParams for Params {
    /// Refuses a folder outside the data root (absolute paths, `.` and `..`, empty parts, backslashes), and a
    /// `confidence` that cannot be part of a file name.
    fn check(&self) -> Result<(), ParamError> {
        let results = &self.results;
        let stays = Path::new(results).components().all(|c| matches!(c, Component::Normal(_)));
        let plain = results.split('/').all(|part| !part.is_empty() && part != "." && part != "..");
        let is_fine = stays && plain && !results.contains(['\\', '\0']);
        let rule = "a relative path under `results/` of the data root without `..`, such as otb/OPE/STRUCK";
        ParamError::unless(is_fine, "results", rule, format!("`{results}`"))?;
        let Some(name) = &self.confidence else { return Ok(()) };
        let is_fine = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || "_-".contains(c));
        let rule = "letters, digits, `_` and `-`, such as confidence";
        ParamError::unless(is_fine, "confidence", rule, format!("`{name}`"))
    }

    fn shown(&self) -> serde_json::Value {
        let mut shown = show_params(self);
        if self.without_area == WithoutArea::Repeat {
            // Tracks of its first version have these frames as skipped ones; they are other tracks.
            shown["without_area"] = "repeat/2".into();
        }
        shown
    }
}

impl Params {
    /// The states of all frames of a sequence in one run.
    ///
    /// # Errors
    /// [`TrackerError::Missing`] without a file or a data root, [`TrackerError::Broken`] if there are two files,
    /// [`TrackerError::File`] for a file with faults.
    pub fn read(
        &self,
        sequence: &dyn SequenceInfo,
        run: u32,
        data_roots: &[PathBuf],
    ) -> Result<Vec<TrackerState>, TrackerError> {
        let source = files::find(self, sequence, run, data_roots)?;
        self.states(&source, sequence, run).map_err(TrackerError::file)
    }

    fn states(
        &self,
        source: &Source,
        sequence: &dyn SequenceInfo,
        run: u32,
    ) -> Result<Vec<TrackerState>, DatasetError> {
        let path = source.path.as_path();
        let bytes = text::read_capped(path)?;
        let base = |of_format| self.base.unwrap_or(of_format);
        let of_lines = |rows, of_format| otb_text::parse(path, rows, sequence, base(of_format));
        let mut boxes = match source.kind {
            Kind::Json => otb_json::parse(path, &bytes, run, sequence.numbering(), base(Base::One))?,
            Kind::Csv => oxuva::parse(path, &bytes, sequence)?,
            Kind::Text => match rows::read_after_header(path, &bytes)? {
                rows if mot::is_mot(&rows) => mot::parse(path, rows, sequence, base(Base::One), self.id)?,
                rows => of_lines(rows, Base::One)?,
            },
            Kind::LongTerm => of_lines(rows::read_after_header(path, &bytes)?, Base::Zero)?,
            Kind::OwnFolder => {
                let rows = rows::read(path, &bytes)?;
                match rows.first().map_or(&[][..], |(_, row)| row) {
                    [1.0] => {
                        let without_box = self.without_area.status();
                        let mut states =
                            vot::parse(path, rows, sequence.truth(), base(Base::Zero), without_box)?;
                        if let Some(values) = values(source, states.len())? {
                            states.iter_mut().zip(values).for_each(|(state, value)| state.confidence = value);
                        }
                        return Ok(states);
                    }
                    [_, _, _, _] => of_lines(rows, Base::One)?,
                    _ => return Err(DatasetError::line(path, 1, NEITHER)),
                }
            }
        };
        let in_rows = boxes.confidence.iter().any(Option::is_some) && self.confidence.is_none();
        if !in_rows && let Some(values) = values(source, boxes.regions.len())? {
            boxes.confidence = values;
        }
        self.cut(path, boxes, sequence)
    }

    /// The states of the frames that the sequence uses.
    fn cut(
        &self,
        path: &Path,
        boxes: Boxes,
        sequence: &dyn SequenceInfo,
    ) -> Result<Vec<TrackerState>, DatasetError> {
        let (first, count) = (sequence.numbering().first, sequence.frames());
        let end = u64::from(boxes.first) + boxes.regions.len() as u64;
        let needed = u64::from(first) + count as u64;
        if boxes.first > first || end < needed {
            let frames = format!("frames {} to {}", boxes.first, end - 1);
            let used = format!("{} from {first} to {}", sequence.name(), needed - 1);
            let message = format!("{frames} do not cover {used}; runs that start later are not read");
            return Err(DatasetError::content(path, message));
        }
        let from_start = boxes.first == first;
        let skipped = (first - boxes.first) as usize;
        let mut confidence = boxes.confidence.into_iter().skip(skipped);
        let used = boxes.regions.into_iter().skip(skipped).take(count);
        let truth = sequence.truth().first().and_then(Option::as_ref);
        let mut states: Vec<TrackerState> = Vec::with_capacity(count);
        for (t, region) in used.enumerate() {
            let last = states.last().map(|s| s.region.clone());
            let mut state = match (region, last) {
                (Ok(region), _) if t == 0 && from_start => TrackerState::initialized(region),
                (Ok(region), _) => TrackerState::tracked(region),
                (Err(e), last) => {
                    let start = truth.filter(|_| from_start || e.source == NoBox::NotAsked);
                    self.without_box(e, last, start).map_err(|e| DatasetError::content(path, e))?
                }
            };
            state.confidence = confidence.next().flatten();
            states.push(state);
        }
        Ok(states)
    }

    /// State of a frame without a box after a frame with region `last`; `last` is `None` in the first frame,
    /// where the tracker may have been given `start`.
    fn without_box(
        &self,
        reason: BoxError,
        last: Option<Region>,
        start: Option<&Region>,
    ) -> Result<TrackerState, String> {
        match (&reason.source, self.without_area.status(), last) {
            (NoBox::NotAsked | NoBox::NoRow, _, None) => match start {
                Some(region) => Ok(TrackerState::initialized(region.clone())),
                None => Err(format!("{reason}, and no start with the ground truth of this frame either")),
            },
            (NoBox::NotAsked, _, Some(last)) => Ok(TrackerState::new(last, Status::Skipped)),
            (source, Some(status), Some(last)) if source.may_be_absence() => {
                Ok(TrackerState::new(last, status))
            }
            (source, None, Some(_)) if source.may_be_absence() => {
                Err(format!("{reason} (`without_area = \"absent\"` takes this as the target's absence)"))
            }
            _ => Err(reason.to_string()),
        }
    }
}

/// Message about a file in a folder named after the sequence that has neither format. The first line of VOT
/// is always the mark `1`, that of GOT-10k always a box.
const NEITHER: &str = "neither VOT's mark `1`, with which a run begins (an initialization), nor the four numbers \
                       x,y,w,h of a GOT-10k result";

/// The confidence of each frame, from the file beside the boxes; `None` without such a file.
fn values(source: &Source, frames: usize) -> Result<Option<Vec<Option<f64>>>, DatasetError> {
    let read = |path: &PathBuf| confidence::parse(path, &text::read_capped(path)?, frames);
    source.confidence.as_ref().map(read).transpose()
}

impl TrackerConfig for Params {
    fn facts(&self) -> Facts {
        Facts { needs_truth: true, reads_pixels: false, ..Facts::BOXES }
    }

    fn gives_confidence(&self, context: &RunContext<'_>) -> bool {
        let states = self.read(context.sequence, context.run, context.data_roots);
        states.is_ok_and(|states| states.iter().any(|state| state.confidence.is_some()))
    }

    fn inputs(&self, context: &RunContext<'_>) -> Result<Vec<PathBuf>, TrackerError> {
        let source = files::find(self, context.sequence, context.run, context.data_roots)?;
        // A file with faults is no track, so that nothing relies on it.
        self.states(&source, context.sequence, context.run).map_err(TrackerError::file)?;
        Ok(std::iter::once(source.path).chain(source.confidence).collect())
    }

    fn start(&self, context: &RunContext<'_>, _: &Frame, _: &Region) -> StartResult {
        let states = self.read(context.sequence, context.run, context.data_roots)?;
        let mut player = Player { frames: states.len(), states: states.into_iter() };
        let first = player.step()?;
        Ok((Box::new(player), first))
    }
}

struct Player {
    frames: usize,
    states: std::vec::IntoIter<TrackerState>,
}

impl Player {
    fn step(&mut self) -> Result<TrackerState, TrackerError> {
        let ended = || format!("the result ends after {} frames; the sequence is longer", self.frames);
        self.states.next().ok_or_else(|| TrackerError::Broken(ended()))
    }
}

impl Tracker for Player {
    fn update(&mut self, _: &Frame) -> Result<TrackerState, TrackerError> {
        self.step()
    }
}

#[cfg(test)]
mod tests;
