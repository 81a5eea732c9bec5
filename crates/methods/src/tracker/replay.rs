//! Replay: a tracker that reads its regions from result files.
//!
//! `results` names a folder under `<data root>/results/`. The file of a sequence and run is one of these:
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
//! It is an error if two of them exist. `*_time.txt` and other files of these toolkits are ignored.
//!
//! A result counts pixels from the same number as the annotation that the tracker was started with: no
//! toolkit shifts boxes. OTB, UAV123, LaSOT and GOT-10k count from 1, VOT from 0. For other results, such as
//! those of a tracker whose authors subtract 1, `base = 0` or `base = 1` sets it for all files of the folder.
//!
//! A sequence `Jogging-1` may be spelled `Jogging_1` (pytracking) or `Jogging.1` (got10k) in all of these
//! names: what stands before a target's number, of one or two digits, differs between toolkits.
//!
//! The frames of the lines: VOT files have exactly the sequence's frames. Text and GOT-10k files have
//! either as many lines as the official range or as many as the range used. JSON states its frames, see
//! [`align`](super::results::align). The range used must be covered; a run that starts later than the
//! sequence (TRE segments after the first) is refused, because a track is a region for every frame.
//!
//! A box without area in the range used is an error that names it, unless `without_area = "repeat"`: then
//! the last region is repeated and the frame has [`Status::Skipped`], so that such frames can be counted.
//! (IVT's affine box collapses to a point in `Girl` from frame 402 on; no range used here has one.)
//! NaN and infinity are always errors, and so is a first box without area.
//!
//! All files are read at the start, whose answer is the file's first state, whatever region it is given.

use super::results::{Base, BoxError, Boxes, got10k, official_span, otb_json, otb_text, vot};
use super::{RunContext, StartResult, Status, Tracker, TrackerConfig, TrackerError, TrackerState};
use crate::dataset::{DatasetError, Sequence, text};
use crate::image::Frame;
use crate::plugin::{Entry, ParamError, RawParams, read_params, show_params};
use crate::region::Region;
use serde::{Deserialize, Serialize};
use std::path::{Component, Path, PathBuf};

/// Treatment of a box without area.
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
    /// Treatment of a box without area: `error` refuses the file, `repeat` repeats the last region.
    #[serde(default)]
    pub without_area: WithoutArea,
    /// Index of the left top pixel in the files, 0 or 1; by default that of their format, see the table.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base: Option<Base>,
}

/// Checked parameters.
#[derive(Debug, Clone)]
pub struct Replay(Params);

/// The line in the list of trackers.
pub const ENTRY: Entry<dyn TrackerConfig> = Entry {
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
    /// [`TrackerError::Missing`] without a file or a data root, [`TrackerError::Broken`] if there are two files,
    /// [`TrackerError::Results`] for a file with faults.
    pub fn read(
        &self,
        sequence: &Sequence,
        run: u32,
        data_roots: &[PathBuf],
    ) -> Result<Vec<TrackerState>, TrackerError> {
        let source = self.find(sequence, run, data_roots)?;
        Ok(self.states(&source, sequence, run)?)
    }

    fn states(
        &self,
        source: &Source,
        sequence: &Sequence,
        run: u32,
    ) -> Result<Vec<TrackerState>, DatasetError> {
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

    /// The result file in the first data root that has one.
    fn find(&self, sequence: &Sequence, run: u32, data_roots: &[PathBuf]) -> Result<Source, TrackerError> {
        let mut first = None;
        for root in data_roots {
            match self.find_below(root, sequence, run) {
                Err(missing @ TrackerError::Missing(_)) => first = first.or(Some(missing)),
                found => return found,
            }
        }
        Err(first.unwrap_or_else(|| {
            TrackerError::Missing(format!(
                "results `{}` are files of a data root, and none is given; add --data-root DIR or set TRACKFAIL_DATA",
                self.0.results
            ))
        }))
    }

    fn find_below(&self, root: &Path, sequence: &Sequence, run: u32) -> Result<Source, TrackerError> {
        let Params { results, .. } = &self.0;
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

    /// The states of the frames that the sequence uses.
    fn cut(&self, path: &Path, boxes: Boxes, sequence: &Sequence) -> Result<Vec<TrackerState>, DatasetError> {
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
        let mut states: Vec<TrackerState> = Vec::with_capacity(count);
        for (t, region) in used.enumerate() {
            let last = states.last().map(|s| s.region.clone());
            states.push(match (region, last) {
                (Ok(region), _) if t == 0 && from_start => TrackerState::initialized(region),
                (Ok(region), _) => TrackerState::tracked(region),
                (Err(_), Some(region)) if self.0.without_area == WithoutArea::Repeat => {
                    TrackerState::new(region, Status::Skipped)
                }
                (Err(e), _) => return Err(DatasetError::content(path, e.to_string())),
            });
        }
        Ok(states)
    }
}

/// Format of a file.
#[derive(Debug, Clone, Copy)]
enum Kind {
    Json,
    Text,
    /// In a folder named after the sequence: VOT or GOT-10k.
    OwnFolder,
}

struct Source {
    kind: Kind,
    path: PathBuf,
}

/// The name of a sequence and, if it ends in the number of a target, its other spellings.
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
        let at = || format!("line {line}");
        Region::from_numbers(&row).map(|r| base.to_zero(r)).map_err(|source| BoxError { at: at(), source })
    });
    Ok(Boxes { first: start, regions: regions.collect() })
}

impl TrackerConfig for Replay {
    fn params(&self) -> serde_json::Value {
        show_params(&self.0)
    }

    fn uses_seed(&self) -> bool {
        false
    }

    fn needs_truth(&self) -> bool {
        true
    }

    fn reads_pixels(&self) -> bool {
        false
    }

    fn inputs(&self, context: &RunContext<'_>) -> Result<Vec<PathBuf>, TrackerError> {
        let source = self.find(context.sequence, context.run, context.data_roots)?;
        // A file with faults is no track, so that nothing relies on it.
        self.states(&source, context.sequence, context.run)?;
        Ok(vec![source.path])
    }

    fn start(&self, context: &RunContext<'_>, _: &Frame, _: &Region) -> StartResult {
        let states = self.read(context.sequence, context.run, context.data_roots)?;
        let mut player = Player { states, next: 0 };
        let first = player.step()?;
        Ok((Box::new(player), first))
    }
}

struct Player {
    states: Vec<TrackerState>,
    next: usize,
}

impl Player {
    fn step(&mut self) -> Result<TrackerState, TrackerError> {
        let state = self.states.get(self.next).cloned().ok_or_else(|| {
            let message = format!("the result has {} frames; there is no further one", self.states.len());
            TrackerError::Broken(message)
        })?;
        self.next += 1;
        Ok(state)
    }
}

impl Tracker for Player {
    fn update(&mut self, _: &Frame) -> Result<TrackerState, TrackerError> {
        self.step()
    }
}

#[cfg(test)]
mod tests;
