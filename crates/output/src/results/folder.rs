//! A results folder, written and read.
//!
//! A results folder may come from somebody else. Each file must therefore be a regular file of limited size
//! with the digest given in the manifest. Names in the manifest are compared, never opened. Links are
//! followed when reading.

use super::bytes::{to_csv, to_parquet};
use super::cells::method_label;
use super::files::{Frame, MeasureRow, Measured, OF_FOLDER, Pair, Row, Score, Signal, Target};
use super::json::{from_json, to_dense_json, write_json};
use super::manifest::{self, FailedCell, Manifest, hashed, sha256};
use super::measures::{self, Measure};
use super::rows::{Rows, TableError, packed};
use super::run::{self, RunRecord};
use super::scores::{self, CellScore};
use super::{
    ANALYSES, ResultsError, SPEC, STILLS, USER_SUITES, beside, fill, frame_measures, frame_pairs, models,
    readings,
};
use polars::prelude::DataFrame;
use std::collections::BTreeMap;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use trackfail_core::image::{self, Frame as Picture};
use trackfail_dataset::suite::Catalog;
use trackfail_dataset::text;
use trackfail_engine::Outcome;
use trackfail_engine::execute::analyse::Analysed;
use trackfail_engine::execute::supervise::catch;
use trackfail_engine::spec::limits::MAX_BYTES;
use trackfail_engine::spec::{self, Experiment};
use trackfail_engine::store::{self, StoreError};

/// Size of the largest manifest that is read, in bytes.
pub(super) const MAX_MANIFEST: u64 = 64 << 20;
/// Size of the largest other file that is read, in bytes.
pub(super) const MAX_FILE: u64 = 1 << 30;

/// Amount of data in a results folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Detail {
    /// All data, including those of single frames.
    Frames,
    /// Small results for keeping: no data of single frames, no models, no rows of missing sequences, and
    /// scores as Parquet.
    Sequences,
}

/// A folder being written, with the digests of the files so far.
struct Written<'f> {
    folder: &'f Path,
    files: BTreeMap<String, String>,
}

impl Written<'_> {
    fn put(&mut self, name: &str, bytes: &[u8]) -> Result<(), ResultsError> {
        self.files.insert(name.to_string(), sha256(bytes));
        Ok(store::write(&self.folder.join(name), bytes)?)
    }

    /// Writes a table as Parquet in compact results, otherwise as CSV.
    fn put_rows(&mut self, name: &str, rows: DataFrame, detail: Detail) -> Result<(), ResultsError> {
        match detail {
            Detail::Frames => self.put(name, &to_csv(rows)?),
            Detail::Sequences => self.put(&packed(name), &to_parquet(rows)?),
        }
    }
}

/// Writes all results of a run into an empty folder, except the tables, which the report makes.
///
/// # Errors
/// When a file cannot be written.
pub fn write(
    folder: &Path,
    experiment: &Experiment,
    outcome: &Outcome<'_>,
    record: &RunRecord,
    detail: Detail,
) -> Result<(), ResultsError> {
    let mut written = Written { folder, files: BTreeMap::new() };
    written.put(SPEC, experiment.source.as_bytes())?;
    if let Some(suites) = experiment.catalog.user_text(experiment.suites.values().map(String::as_str)) {
        written.put(USER_SUITES, suites.as_bytes())?;
    }
    let suite = outcome.suite();
    written.put_rows(Score::NAME, scores::frame(experiment, outcome, detail)?, detail)?;
    written.put(MeasureRow::NAME, &MeasureRow::csv(suite, measures::rows(outcome)?)?)?;
    if !outcome.cells.is_empty() {
        let rows = frame_measures::measure(experiment, outcome)?;
        let measured = rows.iter().map(|row| Measured {
            of: (&row.tracker, &row.first.method, &row.first.params),
            measures: row.measures,
        });
        written.put_rows(Measured::NAME, Measured::frame(suite, measured)?, detail)?;
        if experiment.leaderboard {
            written.put(Pair::NAME, &Pair::csv(suite, frame_pairs::rows(&rows))?)?;
        }
    }
    if readings::has_readings(experiment) {
        written.put(Row::NAME, &Row::csv(suite, readings::rows(experiment, outcome)?)?)?;
    }
    if detail == Detail::Frames {
        write_frames(&mut written, experiment, outcome)?;
        models::write(folder, outcome)?;
    }
    if !outcome.analyses.is_empty() {
        written.put(ANALYSES, &to_dense_json(&folder.join(ANALYSES), &outcome.analyses)?)?;
    }
    write_json(&folder.join(run::FILE), record)?;
    let manifest = Manifest { files: written.files, ..Manifest::new(experiment, outcome) };
    Ok(write_json(&folder.join(manifest::FILE), &manifest)?)
}

/// Writes the files with data of single frames.
fn write_frames(
    written: &mut Written<'_>,
    experiment: &Experiment,
    outcome: &Outcome<'_>,
) -> Result<(), ResultsError> {
    let folder = written.folder;
    let stream = |name: &str, write: fn(&Outcome<'_>, &mut dyn Write) -> Result<(), ResultsError>| {
        let mut digest = String::new();
        let path = folder.join(name);
        store::write_with(&path, |file| {
            digest = hashed(&path, file, |file| write(outcome, file))?;
            Ok::<_, ResultsError>(())
        })?;
        Ok::<_, ResultsError>((name.to_string(), digest))
    };
    let (frames, signals) =
        rayon::join(|| stream(Frame::NAME, fill::frames), || stream(Signal::NAME, fill::signals));
    written.files.extend([frames?, signals?]);
    written.put(Target::NAME, &fill::truth(outcome)?)?;
    for (name, bytes) in fill::pieces(experiment, outcome)?.into_iter().chain(fill::followed(outcome)?) {
        written.put(name, &bytes)?;
    }
    Ok(())
}

/// Names of the files that runs write by themselves, those of compact results too.
pub(super) fn names() -> Vec<String> {
    let others = [packed(Score::NAME), packed(Measured::NAME), ANALYSES.to_string()];
    OF_FOLDER.map(str::to_string).into_iter().chain(others).collect()
}

/// Removes files of earlier runs that these results do not have.
///
/// # Errors
/// When a file cannot be removed.
pub fn remove_others(results: &Results) -> Result<(), ResultsError> {
    for name in names().into_iter().filter(|name| !results.has(name)) {
        let path = results.folder.join(&name);
        match std::fs::remove_file(&path) {
            Err(e) if e.kind() != ErrorKind::NotFound => return Err(StoreError::new(&path, e).into()),
            _ => {}
        }
    }
    Ok(())
}

/// A results folder that was read. Files with a row for each cell or frame are read on request.
pub struct Results {
    /// Path of the folder.
    pub folder: PathBuf,
    /// The experiment as it was run.
    pub experiment: Experiment,
    /// Data, versions and parameters behind the results.
    pub manifest: Manifest,
    /// Pooled numbers.
    pub measures: Vec<Measure>,
    /// Measures by frame; empty for runs of earlier versions.
    pub frame_measures: frame_measures::ByMethod,
    /// Findings of the analyses.
    pub analyses: Vec<Analysed>,
    /// Kept results whose rows stand beside the own ones, where the experiment asks for them.
    pub beside: Option<beside::Beside>,
}

impl Results {
    /// Reads a folder, with the kept results beside its own.
    ///
    /// # Errors
    /// See [`ResultsError`].
    pub fn read(folder: &Path) -> Result<Self, ResultsError> {
        let mut results = Self::read_alone(folder)?;
        if let Some(kept) = results.kept()? {
            beside::join(&mut results, kept)?;
        }
        Ok(results)
    }

    /// Reads a folder without kept results beside its own.
    ///
    /// # Errors
    /// See [`ResultsError`].
    pub fn read_alone(folder: &Path) -> Result<Self, ResultsError> {
        let path = folder.join(manifest::FILE);
        if !path.exists() {
            return Err(ResultsError::Unfinished(folder.to_path_buf()));
        }
        let manifest = manifest::parse(&path, &read_file(&path, MAX_MANIFEST)?)?;
        Self::of_manifest(folder, manifest)
    }

    /// Reads the copy of the kept results that the experiment asks for.
    pub(super) fn kept(&self) -> Result<Option<Self>, ResultsError> {
        if self.experiment.beside.is_none() {
            return Ok(None);
        }
        let bytes = read_whole(&self.folder, &self.manifest, beside::FILE, MAX_MANIFEST)?;
        let manifest = manifest::parse(&self.folder.join(beside::FILE), &bytes)?;
        Self::of_manifest(&self.folder.join(beside::FOLDER), manifest).map(Some)
    }

    fn of_manifest(folder: &Path, manifest: Manifest) -> Result<Self, ResultsError> {
        let spec = folder.join(SPEC);
        let text = String::from_utf8(read_whole(folder, &manifest, SPEC, MAX_BYTES as u64)?)
            .map_err(|_| StoreError::new(&spec, "is not UTF-8 text"))?;
        let mut catalog = Catalog::default();
        if manifest.files.contains_key(USER_SUITES) {
            let suites = read_whole(folder, &manifest, USER_SUITES, text::MAX_TEXT_BYTES)?;
            catalog.add_file(&folder.join(USER_SUITES), &suites)?;
        }
        let experiment = spec::parse_with(&spec.display().to_string(), &text, &catalog, None)?;
        let mut results = Self {
            folder: folder.to_path_buf(),
            experiment,
            manifest,
            measures: Vec::new(),
            frame_measures: BTreeMap::new(),
            analyses: Vec::new(),
            beside: None,
        };
        results.measures = results.table(MeasureRow::NAME, measures::read)?;
        for measure in &mut results.measures {
            let label = method_label(&measure.method, &measure.params);
            let is_mine = |c: &&FailedCell| c.missing && c.tracker == measure.tracker && c.method == label;
            measure.not_there = results.manifest.cells_failed.iter().filter(is_mine).count();
            measure.pooled.chance = results.experiment.chance_of(&measure.method);
        }
        results.frame_measures =
            results.table_if_any(&results.name_of(Measured::NAME), frame_measures::read)?;
        frame_measures::attach(&results.frame_measures, &mut results.measures);
        if results.has(ANALYSES) {
            let bytes = read_whole(folder, &results.manifest, ANALYSES, MAX_FILE)?;
            results.analyses = from_json(&folder.join(ANALYSES), &bytes)?;
        }
        results.put_in_order();
        Ok(results)
    }

    /// Reads the counts of all cells that have any.
    ///
    /// # Errors
    /// When the file is absent or damaged.
    pub fn scores(&self) -> Result<Vec<CellScore>, ResultsError> {
        let mut scores = self.table(&self.name_of(Score::NAME), scores::read)?;
        scores.extend(self.beside.iter().flat_map(|beside| beside.scores.iter().cloned()));
        Ok(scores)
    }

    /// Reads the differences between readings and published numbers; empty if the experiment has no readings.
    ///
    /// # Errors
    /// When the file is damaged.
    pub fn readings(&self) -> Result<Vec<Row>, ResultsError> {
        self.table_if_any(Row::NAME, |bytes| Row::rows(&Row::read(bytes)?))
    }

    /// Reads the differences between methods in measures by frame; empty if the run wrote none.
    ///
    /// # Errors
    /// When the file is damaged.
    pub fn frame_pairs(&self) -> Result<Vec<Pair>, ResultsError> {
        let mut pairs = self.table_if_any(Pair::NAME, |bytes| Pair::rows(&Pair::read(bytes)?))?;
        pairs.extend(self.beside.iter().flat_map(|beside| beside.pairs.iter().cloned()));
        Ok(pairs)
    }

    /// True for a tracker of the experiment itself, not of kept rows beside it.
    pub fn is_own(&self, tracker: &str) -> bool {
        self.manifest.trackers.iter().any(|own| own.label == tracker)
    }

    /// The cells without a result, with those of kept rows.
    pub fn cells_failed(&self) -> impl Iterator<Item = &FailedCell> {
        let kept = self.beside.iter().flat_map(|beside| &beside.failed);
        self.manifest.cells_failed.iter().chain(kept)
    }

    /// True if the run wrote the file.
    fn has(&self, name: &str) -> bool {
        self.manifest.files.contains_key(name)
    }

    /// Name of a file, which is packed in compact results.
    fn name_of(&self, name: &str) -> String {
        let packed = packed(name);
        if self.has(&packed) { packed } else { name.to_string() }
    }

    /// Reads a file with columns. Its digest must be that of the manifest.
    fn table<T>(
        &self,
        name: &str,
        read: impl FnOnce(Vec<u8>) -> Result<T, TableError>,
    ) -> Result<T, ResultsError> {
        let bytes = read_whole(&self.folder, &self.manifest, name, MAX_FILE)?;
        let path = self.folder.join(name);
        // polars panics on some damaged files, and whoever damages one can make its digest fit.
        let table = catch(|| read(bytes)).map_err(|_| damaged(&path))?;
        Ok(table.map_err(|e| StoreError::new(&path, e))?)
    }

    /// Reads a file with columns that only some results have. Returns the default if the run wrote none.
    pub(super) fn table_if_any<T: Default>(
        &self,
        name: &str,
        read: impl FnOnce(Vec<u8>) -> Result<T, TableError>,
    ) -> Result<T, ResultsError> {
        if self.has(name) { self.table(name, read) } else { Ok(T::default()) }
    }

    fn still_path(&self, figure: &str, frame: usize) -> PathBuf {
        self.folder.join(STILLS).join(figure).join(format!("{frame:06}.png"))
    }

    /// Writes a video frame for a figure beside the results; `frame` is 0-based.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_still(&self, figure: &str, frame: usize, pixels: &Picture) -> Result<(), StoreError> {
        let path = self.still_path(figure, frame);
        let png = image::encode_png(pixels).map_err(|e| StoreError::new(&path, e))?;
        store::write(&path, &png)
    }

    /// Reads a video frame of a figure; `frame` is 0-based.
    ///
    /// # Errors
    /// When the file is absent or not a picture.
    pub fn still(&self, figure: &str, frame: usize) -> Result<Picture, ResultsError> {
        let path = self.still_path(figure, frame);
        let bytes = read_file(&path, image::MAX_FILE_BYTES)?;
        Ok(image::decode(&bytes).map_err(|e| StoreError::new(&path, e))?)
    }
}

/// The bytes of a file of at most `limit` bytes.
pub(super) fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>, ResultsError> {
    let about = std::fs::metadata(path).map_err(|e| StoreError::new(path, e))?;
    if !about.is_file() {
        return Err(StoreError::new(path, "not a file").into());
    }
    Ok(text::read_at_most(path, limit)?)
}

/// A file of the folder, which must be the one that the run wrote.
pub(super) fn read_whole(
    folder: &Path,
    manifest: &Manifest,
    name: &str,
    limit: u64,
) -> Result<Vec<u8>, ResultsError> {
    let path = folder.join(name);
    let bytes = read_file(&path, limit)?;
    if manifest.files.get(name) != Some(&sha256(&bytes)) {
        let changed = "not the file that the run wrote (its SHA-256 is not the manifest's); run it again";
        return Err(StoreError::new(&path, changed).into());
    }
    Ok(bytes)
}

/// Error for a file with columns that is so damaged that polars fails.
pub(super) fn damaged(path: &Path) -> StoreError {
    StoreError::new(path, "a damaged file; run the experiment again")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::manifest::parse;
    use crate::testing::MANIFEST;
    use proptest::prelude::*;
    use trackfail_testing::damaged;

    const MEASURES: &[u8] =
        b"suite,tracker,method,params,done,failed,tp,fp,fn,tn,events,detections,precision,recall,\
        f_score,fpr,score_mean,score_std\ns,t,\"m,\",a=1;b=2,1,0,1,2,3,4,4,3,0.3,0.2,,0.1,,\n";

    #[test]
    fn formats_of_later_programs_are_refused() {
        let path = Path::new("a/manifest.json");
        assert_eq!(parse(path, MANIFEST).unwrap().suite.present, [("q".to_string(), 9)]);
        let later = String::from_utf8_lossy(MANIFEST).replace("\"format\":1", "\"format\":99");
        let error = parse(path, later.as_bytes()).unwrap_err();
        assert_eq!(
            error.to_string(),
            format!("a: results format 99; this program reads up to {}", manifest::FORMAT)
        );
        assert_eq!(measures::read(MEASURES.to_vec()).unwrap()[0].method, "m,");
    }

    proptest! {
        #[test]
        fn any_results_are_read_or_refused(
            manifest in damaged(MANIFEST),
            measures in damaged(MEASURES),
            bytes in prop::collection::vec(any::<u8>(), 0..200),
        ) {
            for (manifest, measures) in [(&manifest, &measures), (&bytes, &bytes)] {
                let _ = parse(Path::new("manifest.json"), manifest);
                let _ = measures::read(measures.clone());
            }
        }
    }
}
