//! Reading a results folder.
//!
//! A folder may come from somebody else. So every file is read through a cap on its size, must be a file,
//! and must have the digest that the manifest states; names in the manifest are compared and never opened.
//! Links are followed for reading.

use super::column::TableFile;
use super::frame::TableError;
use super::manifest::{self, Manifest, sha256};
use super::measures::{self, Measure};
use super::scores::{self, CellScore};
use super::truth::{self, Truth};
use super::{ResultsError, SPEC, USER_SUITES, analyses, frame_measures, frame_pairs, readings};
use std::path::{Path, PathBuf};
use trackfail_core::image::{self, Frame};
use trackfail_dataset::suite::Catalog;
use trackfail_dataset::text;
use trackfail_engine::execute::analyse::Analysed;
use trackfail_engine::execute::supervise::catch;
use trackfail_engine::spec::limits::MAX_BYTES;
use trackfail_engine::spec::{self, Experiment};
use trackfail_engine::store;

/// Size of the largest manifest that is read, in bytes.
const MAX_MANIFEST: u64 = 64 << 20;
/// Size of the largest other file that is read, in bytes.
const MAX_FILE: u64 = 1 << 30;

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
            .map_err(|_| store::StoreError::new(&spec, "is not UTF-8 text"))?;
        let mut catalog = Catalog::default();
        if manifest.files.contains_key(USER_SUITES) {
            let suites = read_whole(folder, &manifest, USER_SUITES, text::MAX_TEXT_BYTES)?;
            catalog.add_file(&folder.join(USER_SUITES), &suites)?;
        }
        let experiment = spec::parse_with(&spec.display().to_string(), &text, &catalog, None)?;
        let mut measures = read_table(folder, &manifest, measures::FILE.name, measures::read)?;
        measures::count_not_there(&mut measures, &manifest.cells_failed);
        for measure in &mut measures {
            measure.pooled.chance = experiment.chance_of(&measure.method);
        }
        let mut by_method = frame_measures::ByMethod::default();
        let name = name_of(&manifest, &frame_measures::FILE);
        if manifest.files.contains_key(&name) {
            by_method = read_table(folder, &manifest, &name, frame_measures::read)?;
            frame_measures::attach(&by_method, &mut measures);
        }
        let analyses = if manifest.files.contains_key(analyses::FILE) {
            analyses::read(folder, &read_whole(folder, &manifest, analyses::FILE, MAX_FILE)?)?
        } else {
            Vec::new()
        };
        let mut results = Self {
            folder: folder.to_path_buf(),
            experiment,
            manifest,
            measures,
            frame_measures: by_method,
            analyses,
        };
        results.put_in_order();
        Ok(results)
    }

    /// Reads the counts of every cell that has any.
    ///
    /// # Errors
    /// When the file is absent or damaged.
    pub fn scores(&self) -> Result<Vec<CellScore>, ResultsError> {
        self.table(&name_of(&self.manifest, &scores::FILE), scores::read)
    }

    /// Reads the ground truth; frames without annotation are left out.
    ///
    /// # Errors
    /// When the file is absent or damaged.
    pub fn truth(&self) -> Result<Truth, ResultsError> {
        self.table_if_any(truth::FILE.name, truth::read)
    }

    /// Reads how far readings are from the published numbers; nothing where the experiment has no readings.
    ///
    /// # Errors
    /// When the file is damaged.
    pub fn readings(&self) -> Result<Vec<readings::Row>, ResultsError> {
        self.table_if_any(readings::FILE.name, readings::read)
    }

    /// Reads the differences between methods frame by frame; nothing where the run wrote none.
    ///
    /// # Errors
    /// When the file is damaged.
    pub fn frame_pairs(&self) -> Result<Vec<frame_pairs::Pair>, ResultsError> {
        self.table_if_any(frame_pairs::FILE.name, frame_pairs::read)
    }

    /// Whether the run wrote a file.
    pub(super) fn has(&self, name: &str) -> bool {
        self.manifest.files.contains_key(name)
    }

    /// Reads a file with columns.
    pub(super) fn table<T>(
        &self,
        name: &str,
        read: impl FnOnce(Vec<u8>) -> Result<T, TableError>,
    ) -> Result<T, ResultsError> {
        read_table(&self.folder, &self.manifest, name, read)
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
        self.folder.join(super::STILLS).join(figure).join(format!("{frame:06}.png"))
    }

    /// Writes a video frame that a figure shows beside the results; `frame` counts from 0.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write_still(&self, figure: &str, frame: usize, pixels: &Frame) -> Result<(), store::StoreError> {
        let path = self.still_path(figure, frame);
        let png = image::encode_png(pixels).map_err(|e| store::StoreError::new(&path, e))?;
        store::write(&path, &png)
    }

    /// Reads a video frame that a figure shows; `frame` counts from 0.
    ///
    /// # Errors
    /// When it is absent or not a picture.
    pub fn still(&self, figure: &str, frame: usize) -> Result<Frame, ResultsError> {
        let path = self.still_path(figure, frame);
        let bytes = read_file(&path, image::MAX_FILE_BYTES)?;
        Ok(image::decode(&bytes).map_err(|e| store::StoreError::new(&path, e))?)
    }
}

/// Name of a file that compact results have packed.
fn name_of(manifest: &Manifest, file: &TableFile) -> String {
    let packed = file.packed();
    if manifest.files.contains_key(&packed) { packed } else { file.name.to_string() }
}

/// The bytes of a file of at most `limit` bytes.
fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>, ResultsError> {
    let about = std::fs::metadata(path).map_err(|e| store::StoreError::new(path, e))?;
    if !about.is_file() {
        return Err(store::StoreError::new(path, "not a file").into());
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

/// A file with columns, which must be the one that the run wrote.
fn read_table<T>(
    folder: &Path,
    manifest: &Manifest,
    name: &str,
    read: impl FnOnce(Vec<u8>) -> Result<T, TableError>,
) -> Result<T, ResultsError> {
    let bytes = read_whole(folder, manifest, name, MAX_FILE)?;
    let path = folder.join(name);
    // polars panics on some damaged files, and whoever damages one can make its digest fit.
    match catch(|| read(bytes)) {
        Ok(table) => table.map_err(|source| ResultsError::Table { path, source }),
        Err(_) => Err(ResultsError::Damaged(path)),
    }
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
