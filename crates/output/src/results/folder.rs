//! A results folder, written and read.
//!
//! A folder that is read may come from somebody else. So every file is read through a cap on its size, must be a file,
//! and must have the digest that the manifest states; names in the manifest are compared and never opened.
//! Links are followed for reading.

use super::files::{Frame, MeasureRow, Measured, Pair, Row, Score, Signal, Target, of_folder};
use super::json::{from_json, to_dense_json, write_json};
use super::manifest::{self, Hashed, Manifest, sha256};
use super::measures::{self, Measure};
use super::rows::{Rows, TableError, packed, to_csv, to_parquet};
use super::run::{self, RunRecord};
use super::scores::{self, CellScore};
use super::{
    ResultsError, SPEC, STILLS, USER_SUITES, analyses, fill, frame_measures, frame_pairs, models, readings,
};
use polars::prelude::DataFrame;
use rayon::prelude::*;
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
const MAX_MANIFEST: u64 = 64 << 20;
/// Size of the largest other file that is read, in bytes.
const MAX_FILE: u64 = 1 << 30;

/// How much results say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Detail {
    /// Everything.
    Frames,
    /// Nothing of single frames, no models, no rows of sequences that are not there, and scores as Parquet: small enough to
    /// be kept.
    Sequences,
}

/// A folder with the digests of what was written into it.
struct Written<'f> {
    folder: &'f Path,
    files: BTreeMap<String, String>,
}

impl Written<'_> {
    fn put(&mut self, name: &str, bytes: &[u8]) -> Result<(), ResultsError> {
        self.files.insert(name.to_string(), sha256(bytes));
        Ok(store::write(&self.folder.join(name), bytes)?)
    }

    /// A file that is Parquet in compact results, and CSV in others.
    fn put_rows(&mut self, name: &str, rows: DataFrame, detail: Detail) -> Result<(), ResultsError> {
        match detail {
            Detail::Frames => self.put(name, &to_csv(rows)?),
            Detail::Sequences => self.put(&packed(name), &to_parquet(rows)?),
        }
    }
}

/// Writes everything that a run found out into an empty folder; the tables are made from it by the report.
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
        let measured = Measured::frame(suite, rows.iter().map(frame_measures::Row::measured))?;
        written.put_rows(Measured::NAME, measured, detail)?;
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
        written.put(analyses::FILE, &to_dense_json(&folder.join(analyses::FILE), &outcome.analyses)?)?;
    }
    write_json(&folder.join(run::FILE), record)?;
    let manifest = Manifest { files: written.files, ..Manifest::new(experiment, outcome) };
    write_json(&folder.join(manifest::FILE), &manifest)
}

/// Writes the files that tell of single frames.
fn write_frames(
    written: &mut Written<'_>,
    experiment: &Experiment,
    outcome: &Outcome<'_>,
) -> Result<(), ResultsError> {
    let folder = written.folder;
    type WriteTo = fn(&Outcome<'_>, &mut dyn Write) -> Result<(), ResultsError>;
    let streamed: [(&str, WriteTo); 2] = [(Frame::NAME, fill::frames), (Signal::NAME, fill::signals)];
    let stream = |&(name, write): &(&str, WriteTo)| {
        let mut digest = String::new();
        let path = folder.join(name);
        store::write_with(&path, |file| {
            let mut file = Hashed::new(file);
            let filled = write(outcome, &mut file);
            digest = file.finish(&path, filled)?;
            Ok::<_, ResultsError>(())
        })?;
        Ok((name.to_string(), digest))
    };
    let digests = streamed.par_iter().map(stream).collect::<Result<Vec<_>, ResultsError>>()?;
    written.files.extend(digests);
    written.put(Target::NAME, &fill::truth(outcome)?)?;
    for (name, bytes) in fill::pieces(experiment, outcome)?.into_iter().chain(fill::followed(outcome)?) {
        written.put(name, &bytes)?;
    }
    Ok(())
}

/// Removes what an earlier run left in the folder of results that have no such file.
///
/// # Errors
/// When a file cannot be removed.
pub fn remove_others(results: &Results) -> Result<(), ResultsError> {
    let plain = of_folder().map(|file| file.name.to_string());
    let all =
        plain.into_iter().chain([packed(Score::NAME), packed(Measured::NAME), analyses::FILE.to_string()]);
    for name in all.filter(|name| !results.has(name)) {
        let path = results.folder.join(&name);
        match std::fs::remove_file(&path) {
            Err(e) if e.kind() != ErrorKind::NotFound => return Err(StoreError::new(&path, e).into()),
            _ => {}
        }
    }
    Ok(())
}

/// A results folder. Files with a row for each cell or frame are read when they are asked for.
pub struct Results {
    /// Where it is.
    pub folder: PathBuf,
    /// The experiment as it was run.
    pub experiment: Experiment,
    /// Data, versions and parameters that the results rest on.
    pub manifest: Manifest,
    /// Pooled numbers.
    pub measures: Vec<Measure>,
    /// Measures frame by frame; of the runs of earlier versions there are none.
    pub frame_measures: frame_measures::ByMethod,
    /// Findings of the analyses.
    pub analyses: Vec<Analysed>,
}

impl Results {
    /// Reads a folder.
    ///
    /// # Errors
    /// See [`ResultsError`].
    pub fn read(folder: &Path) -> Result<Self, ResultsError> {
        let path = folder.join(manifest::FILE);
        if !path.exists() {
            return Err(ResultsError::Unfinished(folder.to_path_buf()));
        }
        let manifest = manifest::parse(&path, &read_file(&path, MAX_MANIFEST)?)?;
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
        };
        results.measures = results.table(MeasureRow::NAME, measures::read)?;
        measures::count_not_there(&mut results.measures, &results.manifest.cells_failed);
        for measure in &mut results.measures {
            measure.pooled.chance = results.experiment.chance_of(&measure.method);
        }
        results.frame_measures =
            results.table_if_any(&results.name_of(Measured::NAME), frame_measures::read)?;
        frame_measures::attach(&results.frame_measures, &mut results.measures);
        if results.has(analyses::FILE) {
            let bytes = read_whole(folder, &results.manifest, analyses::FILE, MAX_FILE)?;
            results.analyses = from_json(&folder.join(analyses::FILE), &bytes)?;
        }
        results.put_in_order();
        Ok(results)
    }

    /// Reads the counts of every cell that has any.
    ///
    /// # Errors
    /// When the file is absent or damaged.
    pub fn scores(&self) -> Result<Vec<CellScore>, ResultsError> {
        self.table(&self.name_of(Score::NAME), scores::read)
    }

    /// Reads how far readings are from the published numbers; nothing where the experiment has no readings.
    ///
    /// # Errors
    /// When the file is damaged.
    pub fn readings(&self) -> Result<Vec<Row>, ResultsError> {
        self.table_if_any(Row::NAME, |bytes| Row::rows(&Row::read(bytes)?))
    }

    /// Reads the differences between methods frame by frame; nothing where the run wrote none.
    ///
    /// # Errors
    /// When the file is damaged.
    pub fn frame_pairs(&self) -> Result<Vec<Pair>, ResultsError> {
        self.table_if_any(Pair::NAME, |bytes| Pair::rows(&Pair::read(bytes)?))
    }

    /// Whether the run wrote a file.
    fn has(&self, name: &str) -> bool {
        self.manifest.files.contains_key(name)
    }

    /// Name of a file that compact results have packed.
    fn name_of(&self, name: &str) -> String {
        let packed = packed(name);
        if self.has(&packed) { packed } else { name.to_string() }
    }

    /// Reads a file with columns, which must be the one that the run wrote.
    fn table<T>(
        &self,
        name: &str,
        read: impl FnOnce(Vec<u8>) -> Result<T, TableError>,
    ) -> Result<T, ResultsError> {
        let bytes = read_whole(&self.folder, &self.manifest, name, MAX_FILE)?;
        let path = self.folder.join(name);
        // polars panics on some damaged files, and whoever damages one can make its digest fit.
        match catch(|| read(bytes)) {
            Ok(table) => table.map_err(|source| ResultsError::Table { path, source }),
            Err(_) => Err(ResultsError::Damaged(path)),
        }
    }

    /// Reads a file with columns that only some results have; nothing where the run wrote none.
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

    /// Writes a video frame that a figure shows beside the results; `frame` counts from 0.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write_still(&self, figure: &str, frame: usize, pixels: &Picture) -> Result<(), StoreError> {
        let path = self.still_path(figure, frame);
        let png = image::encode_png(pixels).map_err(|e| StoreError::new(&path, e))?;
        store::write(&path, &png)
    }

    /// Reads a video frame that a figure shows; `frame` counts from 0.
    ///
    /// # Errors
    /// When it is absent or not a picture.
    pub fn still(&self, figure: &str, frame: usize) -> Result<Picture, ResultsError> {
        let path = self.still_path(figure, frame);
        let bytes = read_file(&path, image::MAX_FILE_BYTES)?;
        Ok(image::decode(&bytes).map_err(|e| StoreError::new(&path, e))?)
    }
}

/// The bytes of a file of at most `limit` bytes.
fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>, ResultsError> {
    let about = std::fs::metadata(path).map_err(|e| StoreError::new(path, e))?;
    if !about.is_file() {
        return Err(StoreError::new(path, "not a file").into());
    }
    Ok(text::read_at_most(path, limit)?)
}

/// A file of the folder, which must be the one that the run wrote.
fn read_whole(folder: &Path, manifest: &Manifest, name: &str, limit: u64) -> Result<Vec<u8>, ResultsError> {
    let path = folder.join(name);
    let bytes = read_file(&path, limit)?;
    if manifest.files.get(name) != Some(&sha256(&bytes)) {
        return Err(ResultsError::Changed(path));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::manifest::parse;
    use proptest::prelude::*;
    use trackfail_testing::damaged;

    const MANIFEST: &[u8] = br#"{"format":1,"experiment":"a","spec_digest":"00","version":"0.1.0",
        "protocol":"khalid2016/1","seed":1,"suite":{"name":"s","wanted":1,"present":[["q",9]],"missing":[]},
        "digests":{"s":[["q","00"]]},"trackers":[],"methods":[],"cells_done":1,"cells_failed":[],"rules":{},
        "differing":[],"files":{"measures.csv":"00"}}"#;
    const MEASURES: &[u8] =
        b"suite,tracker,method,params,done,failed,tp,fp,fn,tn,events,detections,precision,recall,\
        f_score,fpr,score_mean,score_std\ns,t,\"m,\",a=1;b=2,1,0,1,2,3,4,4,3,0.3,0.2,,0.1,,\n";

    #[test]
    fn formats_of_later_programs_are_refused() {
        let path = Path::new("a/manifest.json");
        assert_eq!(parse(path, MANIFEST).unwrap().suite.present, [("q".to_string(), 9)]);
        let later = String::from_utf8_lossy(MANIFEST).replace("\"format\":1", "\"format\":99");
        let error = parse(path, later.as_bytes()).unwrap_err();
        assert!(matches!(error, ResultsError::Format { found: 99, .. }), "{error}");
        assert_eq!(measures::read(MEASURES.to_vec()).unwrap()[0].method, "m,");
    }

    proptest! {
        #[test]
        fn damaged_results_are_read_or_refused(manifest in damaged(MANIFEST), measures in damaged(MEASURES)) {
            let _ = parse(Path::new("manifest.json"), &manifest);
            let _ = measures::read(measures);
        }

        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = parse(Path::new("manifest.json"), &bytes);
            let _ = measures::read(bytes);
        }
    }
}
