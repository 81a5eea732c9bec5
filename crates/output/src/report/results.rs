//! Reading a results folder back.
//!
//! A folder may come from somebody else. So every file is read through a cap on its size, must be a file,
//! and must have the digest that the manifest states; names in the manifest are compared and never opened.
//! Links are followed for reading.

use crate::dataset::suite::Catalog;
use crate::dataset::{DatasetError, text};
use crate::engine::execute::analyse::Analysed;
use crate::engine::execute::supervise::catch;
use crate::engine::store;
use crate::region::{Rect, Region};
use crate::spec::limits::LONGEST;
use crate::spec::{self, Experiment, SpecError};
use crate::table::folder::{self, ANALYSES, FolderError, USER_SUITES};
use crate::table::frame;
use crate::table::layout::Layout;
use crate::table::manifest::{FORMAT, Manifest, sha256};
use crate::table::measures::Measure;
use crate::table::quality;
use crate::table::records::{self, CellScore};
use polars::prelude::DataFrame;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Largest manifest that is read, in bytes.
const LARGEST_MANIFEST: u64 = 64 << 20;
/// Largest table that is read, in bytes.
const LARGEST_TABLE: u64 = 1 << 30;

/// A results folder that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ResultsError {
    /// A file is absent, unreadable or no table.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// The experiment file kept beside the results is wrong.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// The folder holds no finished run.
    #[error("{}: no manifest.json; run the experiment first", .0.display())]
    Unfinished(PathBuf),
    /// Written by a later program.
    #[error("{}: results format {found}; this program reads up to {FORMAT}", path.display())]
    Format {
        /// The folder.
        path: PathBuf,
        /// Its format.
        found: u32,
    },
}

impl From<store::StoreError> for ResultsError {
    fn from(e: store::StoreError) -> Self {
        Self::Folder(e.into())
    }
}

impl From<frame::FrameError> for ResultsError {
    fn from(e: frame::FrameError) -> Self {
        Self::Folder(e.into())
    }
}

/// A results folder: everything but the frames.
pub struct Results {
    /// Where it is.
    pub folder: PathBuf,
    /// The experiment as it was run.
    pub experiment: Experiment,
    /// What the results rest on.
    pub manifest: Manifest,
    /// Pooled numbers.
    pub measures: Vec<Measure>,
    /// What analyses found out.
    pub analyses: Vec<Analysed>,
}

impl Results {
    /// Reads a folder.
    ///
    /// # Errors
    /// See [`ResultsError`].
    pub fn read(folder: &Path) -> Result<Self, ResultsError> {
        let path = folder.join("manifest.json");
        if !path.exists() {
            return Err(ResultsError::Unfinished(folder.to_path_buf()));
        }
        let manifest = parse_manifest(&path, &read_file(&path, LARGEST_MANIFEST)?)?;
        let spec = folder.join("experiment.toml");
        let text = String::from_utf8(read_whole(folder, &manifest, "experiment.toml", LONGEST as u64)?)
            .map_err(|_| store::StoreError::new(&spec, "is not UTF-8 text"))?;
        let mut catalog = Catalog::default();
        if manifest.files.contains_key(USER_SUITES) {
            let suites = read_whole(folder, &manifest, USER_SUITES, text::LARGEST_TEXT)?;
            catalog
                .add_file(&folder.join(USER_SUITES), &suites)
                .map_err(|e| store::StoreError::new(&folder.join(USER_SUITES), e))?;
        }
        let experiment = spec::parse_with(&spec.display().to_string(), &text, &catalog, None)?;
        let measures = read_whole(folder, &manifest, "measures.csv", LARGEST_TABLE)?;
        let mut measures = records::read_measures(measures)
            .map_err(|e| store::StoreError::new(&folder.join("measures.csv"), e))?;
        for measure in &mut measures {
            measure.pooled.chance = experiment.chance_of(&measure.method);
        }
        // Where every analysis failed there is no file of them.
        let analyses = if manifest.files.contains_key(ANALYSES) {
            let bytes = read_whole(folder, &manifest, ANALYSES, LARGEST_TABLE)?;
            serde_json::from_slice(&bytes)
                .map_err(|error| FolderError::Json { path: folder.join(ANALYSES), error })?
        } else {
            Vec::new()
        };
        Ok(Self { folder: folder.to_path_buf(), experiment, manifest, measures, analyses })
    }

    /// The experiment's tables, from the counts of [`Results::scores`] where one needs them.
    pub fn layouts(&self, scores: &[CellScore]) -> Vec<Layout> {
        folder::layouts(&self.experiment, &self.measures, scores, &self.analyses, &self.manifest)
    }

    /// Reads the counts of every cell that has any, sequence by sequence.
    ///
    /// # Errors
    /// When the table is absent or lacks a column.
    pub fn scores(&self) -> Result<Vec<CellScore>, ResultsError> {
        let bytes = read_whole(&self.folder, &self.manifest, "scores.csv", LARGEST_TABLE)?;
        let scores = records::read_scores(bytes);
        Ok(scores.map_err(|e| store::StoreError::new(&self.folder.join("scores.csv"), e))?)
    }

    /// Reads the tracks of one tracker's first run.
    ///
    /// # Errors
    /// When a table is absent or lacks a column.
    pub fn tracks(&self, tracker: &str) -> Result<Vec<TrackSeries>, ResultsError> {
        let mut tracks = self.read_frames(|label| label == tracker)?;
        self.add_signals(tracker, &mut tracks)?;
        if self.manifest.files.contains_key(quality::CONDITIONS) {
            self.add_conditions(tracker, &mut tracks)?;
        }
        Ok(tracks)
    }

    /// The bytes of a file of the folder, which must be the one that the run wrote.
    pub(super) fn bytes(&self, name: &str) -> Result<Vec<u8>, ResultsError> {
        read_whole(&self.folder, &self.manifest, name, LARGEST_TABLE)
    }

    /// Reads the tracks of every tracker's first run, without signals and conditions.
    ///
    /// # Errors
    /// When the table is absent or lacks a column.
    pub fn all_tracks(&self) -> Result<Vec<TrackSeries>, ResultsError> {
        self.read_frames(|_| true)
    }

    pub(super) fn parquet(&self, name: &str, columns: &[&str]) -> Result<DataFrame, ResultsError> {
        let bytes = read_whole(&self.folder, &self.manifest, name, LARGEST_TABLE)?;
        let fail = |e: &dyn std::fmt::Display| store::StoreError::new(&self.folder.join(name), e.to_string());
        // polars panics on some damaged files, and whoever damages one can make its digest fit.
        match catch(|| frame::from_parquet(bytes, columns)) {
            Ok(table) => Ok(table.map_err(|e| fail(&e))?),
            Err(_) => Err(fail(&"a damaged Parquet file; run the experiment again").into()),
        }
    }

    fn read_frames(&self, wanted: impl Fn(&str) -> bool) -> Result<Vec<TrackSeries>, ResultsError> {
        let columns = [
            "sequence", "tracker", "run", "frame", "x", "y", "w", "h", "error", "method", "score", "label",
            "change",
        ];
        let table = self.parquet("frames.parquet", &columns)?;
        let (sequence, tracker) = (frame::texts(&table, "sequence")?, frame::texts(&table, "tracker")?);
        let (method, run) = (frame::texts(&table, "method")?, frame::integers(&table, "run")?);
        let number = frame::integers(&table, "frame")?;
        let [x, y, w, h] = ["x", "y", "w", "h"].map(|c| frame::floats(&table, c));
        let (x, y, w, h) = (x?, y?, w?, h?);
        let (error, score) = (frame::floats(&table, "error")?, frame::floats(&table, "score")?);
        let label = frame::small_integers(&table, "label")?;
        let change = frame::small_integers(&table, "change")?;
        let mut tracks: Vec<TrackSeries> = Vec::new();
        for i in (0..sequence.len()).filter(|i| run[*i] == 0 && wanted(&tracker[*i])) {
            if tracks.last().is_none_or(|t| t.sequence != sequence[i] || t.tracker != tracker[i]) {
                let (sequence, tracker) = (sequence[i].clone(), tracker[i].clone());
                tracks.push(TrackSeries { sequence, tracker, ..TrackSeries::default() });
            }
            let Some(track) = tracks.last_mut() else { continue };
            let is_new = track.methods.last().is_none_or(|m| m.name != method[i]);
            if is_new {
                track.methods.push(MethodSeries { name: method[i].clone(), ..MethodSeries::default() });
            }
            if track.methods.len() == 1 {
                track.numbers.push(number[i]);
                track.rects.push(Rect::new(x[i], y[i], w[i], h[i]));
                track.error.push(error[i]);
            }
            if let Some(m) = track.methods.last_mut() {
                m.score.push(score[i]);
                m.alarm.push(label[i] != 0);
                m.changes.push(change[i]);
            }
        }
        Ok(tracks)
    }

    fn add_signals(&self, wanted: &str, tracks: &mut [TrackSeries]) -> Result<(), ResultsError> {
        let columns = ["sequence", "tracker", "run", "method", "signal", "forecast"];
        let table = self.parquet("signals.parquet", &columns)?;
        let (sequence, tracker) = (frame::texts(&table, "sequence")?, frame::texts(&table, "tracker")?);
        let (method, run) = (frame::texts(&table, "method")?, frame::integers(&table, "run")?);
        let (signal, forecast) = (frame::floats(&table, "signal")?, frame::floats(&table, "forecast")?);
        for i in (0..sequence.len()).filter(|i| tracker[*i] == wanted && run[*i] == 0) {
            if let Some(m) = method_of(tracks, &sequence[i], &method[i]) {
                m.signal.push(signal[i]);
                m.forecast.push(forecast[i]);
            }
        }
        Ok(())
    }

    fn add_conditions(&self, wanted: &str, tracks: &mut [TrackSeries]) -> Result<(), ResultsError> {
        let table =
            self.parquet(quality::CONDITIONS, &["sequence", "tracker", "run", "method", "condition"])?;
        let (sequence, tracker) = (frame::texts(&table, "sequence")?, frame::texts(&table, "tracker")?);
        let (method, run) = (frame::texts(&table, "method")?, frame::integers(&table, "run")?);
        let condition = frame::floats(&table, "condition")?;
        for i in (0..sequence.len()).filter(|i| tracker[*i] == wanted && run[*i] == 0) {
            if let Some(m) = method_of(tracks, &sequence[i], &method[i]) {
                m.condition.push(condition[i]);
            }
        }
        Ok(())
    }

    /// The ground truth by sequence and frame number.
    ///
    /// # Errors
    /// When the table is absent or lacks a column.
    pub fn truth(&self) -> Result<BTreeMap<(String, i64), Region>, ResultsError> {
        let names = ["x1", "y1", "x2", "y2", "x3", "y3", "x4", "y4"];
        let columns: Vec<&str> = ["sequence", "frame"].into_iter().chain(names).collect();
        let table = self.parquet("truth.parquet", &columns)?;
        let (sequence, number) = (frame::texts(&table, "sequence")?, frame::integers(&table, "frame")?);
        let mut corners = Vec::new();
        for name in names {
            corners.push(frame::floats(&table, name)?);
        }
        let mut truth = BTreeMap::new();
        for i in 0..sequence.len() {
            let numbers: Vec<f64> = corners.iter().map(|c| c[i]).collect();
            if let Ok(region) = Region::from_numbers(&numbers) {
                truth.insert((sequence[i].clone(), number[i]), region);
            }
        }
        Ok(truth)
    }
}

fn method_of<'t>(
    tracks: &'t mut [TrackSeries],
    sequence: &str,
    method: &str,
) -> Option<&'t mut MethodSeries> {
    let track = tracks.iter_mut().find(|t| t.sequence == sequence)?;
    track.methods.iter_mut().find(|m| m.name == method)
}

/// A manifest from its bytes; `path` names it in messages.
///
/// # Errors
/// Anything but a manifest, and one of a later format.
pub fn parse_manifest(path: &Path, bytes: &[u8]) -> Result<Manifest, ResultsError> {
    let manifest: Manifest = serde_json::from_slice(bytes)
        .map_err(|error| FolderError::Json { path: path.to_path_buf(), error })?;
    if manifest.format > FORMAT {
        let folder = path.parent().unwrap_or(path).to_path_buf();
        return Err(ResultsError::Format { path: folder, found: manifest.format });
    }
    Ok(manifest)
}

/// The bytes of a file of at most `limit` bytes.
pub(super) fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>, store::StoreError> {
    let about = std::fs::metadata(path).map_err(|e| store::StoreError::new(path, e))?;
    if !about.is_file() {
        return Err(store::StoreError::new(path, "not a file"));
    }
    text::read_at_most(path, limit).map_err(|e| match e {
        DatasetError::Io { source, .. } => store::StoreError::new(path, source),
        DatasetError::Content { message, .. } => store::StoreError::new(path, message),
        other => store::StoreError::new(path, other),
    })
}

/// A file of the folder, which must be the one that the run wrote.
fn read_whole(folder: &Path, manifest: &Manifest, name: &str, limit: u64) -> Result<Vec<u8>, ResultsError> {
    let path = folder.join(name);
    let bytes = read_file(&path, limit)?;
    if manifest.files.get(name) != Some(&sha256(&bytes)) {
        let message = "not the file that the run wrote (its SHA-256 is not the manifest's); run it again";
        return Err(store::StoreError::new(&path, message).into());
    }
    Ok(bytes)
}

/// One track with what every method made of it.
#[derive(Debug, Clone, Default)]
pub struct TrackSeries {
    /// Sequence.
    pub sequence: String,
    /// Label of the tracker.
    pub tracker: String,
    /// Frame numbers.
    pub numbers: Vec<i64>,
    /// The tracker's rectangles.
    pub rects: Vec<Rect>,
    /// O_t, NaN where unknown.
    pub error: Vec<f64>,
    /// Methods, sorted by name.
    pub methods: Vec<MethodSeries>,
}

impl TrackSeries {
    /// The series of a method.
    pub fn method(&self, name: &str) -> Option<&MethodSeries> {
        self.methods.iter().find(|m| m.name == name)
    }
}

/// What one method made of a track.
#[derive(Debug, Clone, Default)]
pub struct MethodSeries {
    /// Name with its grid point.
    pub name: String,
    /// Score compared with the threshold.
    pub score: Vec<f64>,
    /// Alarm.
    pub alarm: Vec<bool>,
    /// Changes of the label: +1, -1, 0.
    pub changes: Vec<i32>,
    /// Signal; empty for methods with a grid or without a signal.
    pub signal: Vec<f64>,
    /// Forecast, NaN where there is none.
    pub forecast: Vec<f64>,
    /// Condition of the tracker, from 0 (scanning) to 1 (locked on); empty for methods that do not follow it.
    pub condition: Vec<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use trackfail_testing::damaged;

    const MANIFEST: &[u8] =
        br#"{"format":1,"experiment":"a","spec_digest":"00","version":"0.1.0","revision":null,
        "protocol":"khalid2016/1","seed":1,"suite":{"name":"s","wanted":1,"present":[["q",9]],"missing":[]},
        "digests":{"s":[["q","00"]]},"trackers":[],"methods":[],"cells_done":1,"cells_failed":[],"rules":{},
        "differing":[],"files":{"measures.csv":"00"},"host":{"os":"linux","architecture":"x","processors":1},
        "wall_seconds":0.5}"#;
    const MEASURES: &[u8] =
        b"suite,tracker,method,params,done,failed,tp,fp,fn,tn,events,detections,precision,recall,\
        f_score,fpr,score_mean,score_std\ns,t,\"m,\",a=1;b=2,1,0,1,2,3,4,4,3,0.3,0.2,,0.1,,\n";

    #[test]
    fn formats_of_later_programs_are_refused() {
        let path = Path::new("a/manifest.json");
        assert_eq!(parse_manifest(path, MANIFEST).unwrap().suite.present, [("q".to_string(), 9)]);
        let later = String::from_utf8_lossy(MANIFEST).replace("\"format\":1", "\"format\":99");
        let error = parse_manifest(path, later.as_bytes()).unwrap_err();
        assert!(matches!(error, ResultsError::Format { found: 99, .. }), "{error}");
        assert_eq!(records::read_measures(MEASURES.to_vec()).unwrap()[0].method, "m,");
    }

    proptest! {
        #[test]
        fn damaged_results_are_read_or_refused(manifest in damaged(MANIFEST), measures in damaged(MEASURES)) {
            let _ = parse_manifest(Path::new("manifest.json"), &manifest);
            let _ = records::read_measures(measures);
        }

        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = parse_manifest(Path::new("manifest.json"), &bytes);
            let _ = records::read_measures(bytes);
        }
    }
}
