//! Results as one file, for others: how it is packed, and what its receiver checks.
//!
//! The file is a zip of `manifest.json` and of every file that it names, with the copy of kept results, whose files
//! `beside/kept.json` names. Of what a run leaves beside those, models and the frames of figures are sent too, and the
//! manifest that is sent names them. Tables are not sent, since reports make them again, and neither is `run.json`, which
//! tells of the machine.
//!
//! Received files may come from anybody. They are unpacked by the rules for downloads, into a temporary folder, and take
//! their place when all is checked. Their manifest can name what its writer likes: names that no run gives a file are refused,
//! since a second manifest would be that of another experiment.

use super::folder::{MAX_FILE, MAX_MANIFEST, names, read_file, read_whole};
use super::json::to_json;
use super::manifest::{self, Manifest, sha256};
use super::{Results, ResultsError, SPEC, STILLS, TABLES, USER_SUITES, beside, models, run};
use std::collections::{BTreeMap, BTreeSet};
use std::io::{Cursor, Error, Write};
use std::path::{MAIN_SEPARATOR_STR, Path};
use trackfail_dataset::archive::{Archive, Packing};
use trackfail_dataset::fetch::{Caps, unpack};
use trackfail_dataset::{file_digest, leftover::TemporaryFolder, text};
use trackfail_engine::store::StoreError;
use walkdir::{DirEntry, WalkDir};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, System, ZipWriter};

/// Bytes that results unpack to at most.
const MAX_RESULTS: u64 = 16 << 30;
/// Folders with files that the manifest of a run does not name.
const UNNAMED: [&str; 3] = [TABLES, models::FOLDER, STILLS];
/// Most characters of a list of faults.
const MAX_FAULTS: usize = 500;
/// Start of the names of temporary folders, and the folder inside.
const UNPACKING: &str = ".trackfail-results-";
const INSIDE: &str = "results";

/// Results whose files are those that their manifest names.
pub struct Verified {
    /// The results.
    pub results: Results,
    /// Files that runs and reports leave beside them. The manifest does not name these, so nothing is known of them.
    pub unnamed: BTreeSet<String>,
}

impl Verified {
    /// Reads the folder of an experiment after comparing all files in it with the manifest.
    ///
    /// # Errors
    /// A file that is changed, missing or does not belong there, and the errors of [`Results::read`].
    pub fn read(folder: &Path) -> Result<Self, ResultsError> {
        Self::read_with(folder, true)
    }

    /// Reads a folder; one of runs may have unnamed files, and below it other experiments.
    fn read_with(folder: &Path, is_of_runs: bool) -> Result<Self, ResultsError> {
        let path = folder.join(manifest::FILE);
        if !path.exists() {
            return Err(ResultsError::Unfinished(folder.to_path_buf()));
        }
        let not_as_named = |faults: &str| {
            let faults = text::shorten_to(&text::visible(faults), MAX_FAULTS);
            let what = format!(
                "not the results that manifest.json names: {faults}; delete what does not belong there, and get the rest \
                 again or run the experiment again"
            );
            StoreError::new(folder, what)
        };
        let manifest = manifest::parse(&path, &read_file(&path, MAX_MANIFEST)?)?;
        let named = with_copy(folder, &manifest)?;
        let mut missing: BTreeSet<&String> = named.keys().collect();
        let (mut faults, mut unnamed, known) = (Vec::new(), BTreeSet::new(), names());
        let is_mine = |entry: &DirEntry| !(is_of_runs && entry.path().join(manifest::FILE).exists());
        let is_unnamed = |name: &str| name.split_once('/').is_some_and(|(first, _)| UNNAMED.contains(&first));
        let walk = WalkDir::new(folder).min_depth(1).sort_by_file_name().into_iter();
        for entry in walk.filter_entry(is_mine) {
            let entry = entry.map_err(|e| StoreError::new(folder, Error::from(e)))?;
            if entry.file_type().is_dir() || entry.path() == path {
                continue;
            }
            let below = entry.path().strip_prefix(folder).unwrap_or(entry.path());
            let name = below.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/");
            missing.remove(&name);
            let digest = named.get(&name).filter(|_| is_of_runs || is_of_results(&name, &known));
            if let Some(digest) = digest {
                if file_digest(entry.path())? != *digest {
                    faults.push(format!("{name} is changed"));
                }
            } else if is_of_runs && (name == run::FILE || is_unnamed(&name)) {
                unnamed.insert(name);
            } else {
                faults.push(format!("{name} does not belong there"));
            }
        }
        faults.extend(missing.iter().map(|name| format!("{name} is missing")));
        if !faults.is_empty() {
            return Err(not_as_named(&faults.join(", ")).into());
        }
        let results = Results::read(folder)?;
        let Manifest { experiment, spec_digest, files, .. } = &results.manifest;
        if *experiment != results.experiment.name || files.get(SPEC) != Some(spec_digest) {
            return Err(not_as_named(&format!("{SPEC} is of another experiment")).into());
        }
        Ok(Self { results, unnamed })
    }

    /// The results as a zip file: the same bytes on every machine.
    ///
    /// # Errors
    /// When a file cannot be read, or is changed meanwhile.
    pub fn pack(&self) -> Result<Vec<u8>, ResultsError> {
        let folder = &self.results.folder;
        let mut manifest = Manifest { format: manifest::FORMAT, ..self.results.manifest.clone() };
        for name in self.unnamed.iter().filter(|name| is_of_results(name, &[])) {
            manifest.files.insert(name.clone(), sha256(&read_file(&folder.join(name), MAX_FILE)?));
        }
        let all = Manifest { files: with_copy(folder, &manifest)?, ..manifest.clone() };
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        // Nothing is compressed: Parquet is already, and the bytes would change with the compressor.
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(DateTime::default())
            .system(System::Unix)
            .unix_permissions(0o644);
        let failed = |e: Error| StoreError::new(folder, format!("cannot be packed: {e}"));
        let mut put = |name: &str, bytes: &[u8]| -> Result<(), StoreError> {
            zip.start_file(name, options).map_err(|e| failed(e.into()))?;
            zip.write_all(bytes).map_err(failed)
        };
        put(manifest::FILE, &to_json(&folder.join(manifest::FILE), &manifest)?)?;
        for name in all.files.keys() {
            put(name, &read_whole(folder, &all, name, MAX_FILE)?)?;
        }
        Ok(zip.finish().map_err(|e| failed(e.into()))?.into_inner())
    }
}

/// The files that a manifest names, with those of the copy of kept results, and their SHA-256.
fn with_copy(folder: &Path, manifest: &Manifest) -> Result<BTreeMap<String, String>, ResultsError> {
    let mut named = manifest.files.clone();
    let path = folder.join(beside::FILE);
    if named.contains_key(beside::FILE) && path.exists() {
        let copy = manifest::parse(&path, &read_whole(folder, manifest, beside::FILE, MAX_MANIFEST)?)?;
        for (name, digest) in copy.files {
            named.entry(format!("{}/{name}", beside::FOLDER)).or_insert(digest);
        }
    }
    Ok(named)
}

/// True if a run gives a file this name; `known` are the names of files that are in no folder, beside those of the experiment.
fn is_of_results(name: &str, known: &[String]) -> bool {
    let is_numbered =
        |file: &str, end: &str| file.ends_with(end) && file.starts_with(|c: char| c.is_ascii_digit());
    let is_known =
        |file: &str| [SPEC, USER_SUITES].contains(&file) || known.iter().any(|known| known == file);
    match name.split('/').collect::<Vec<_>>().as_slice() {
        [models::FOLDER, file] => is_numbered(file, ".json"),
        [STILLS, _, file] => is_numbered(file, ".png"),
        [beside::FOLDER, file] => name == beside::FILE || is_known(file),
        [file] => is_known(file),
        _ => false,
    }
}

/// Results that came as one file, in a temporary folder.
pub struct Received {
    /// The results.
    pub verified: Verified,
    temporary: TemporaryFolder,
}

impl Received {
    /// Unpacks a file of [`Verified::pack`] into a temporary folder below `parent`, and checks that it holds the files that
    /// its manifest names and no other.
    ///
    /// # Errors
    /// An archive that is refused, and the errors of [`Verified::read`]; all that are no fault of the disk name the file.
    pub fn open(file: &Path, parent: &Path) -> Result<Self, ResultsError> {
        let failed = |e| StoreError::new(parent, e);
        let temporary = TemporaryFolder::new_in(parent, UNPACKING).map_err(failed)?;
        let folder = temporary.within(INSIDE).map_err(failed)?;
        let (name, url, into) = (file.display().to_string(), String::new(), String::new());
        let archive =
            Archive { name, url, packing: Packing::Zip, size: None, sha256: None, into, below: None };
        let caps = Caps { total: MAX_RESULTS, ..Caps::default() };
        unpack(file, &archive, &[String::new()], &caps, &folder)?;
        if !folder.join(manifest::FILE).is_file() {
            let fault = format!("no results: it has no {}; name a file of `pack`", manifest::FILE);
            return Err(StoreError::new(file, fault).into());
        }
        let verified = Verified::read_with(&folder, false).map_err(|e| {
            if e.is_io() {
                return e;
            }
            // The temporary folder is gone when the message is read.
            let path = folder.display();
            let told = e.to_string().replace(&format!("{path}{MAIN_SEPARATOR_STR}"), "");
            StoreError::new(file, told.replace(&format!("{path}: "), "")).into()
        })?;
        Ok(Self { verified, temporary })
    }

    /// Moves the results to their place, where nothing may be yet.
    ///
    /// # Errors
    /// When they cannot be moved.
    pub fn publish(self, place: &Path) -> Result<(), StoreError> {
        let failed = |e| StoreError::new(place, e);
        std::fs::create_dir_all(place.parent().unwrap_or(place)).map_err(failed)?;
        std::fs::rename(self.temporary.path().join(INSIDE), place).map_err(failed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::ErrorKind;
    use trackfail_dataset::DatasetError;

    #[test]
    fn what_the_disk_refuses_is_no_fault_of_the_results() {
        let path = Path::new("scores.csv");
        let of = |kind: ErrorKind| -> [ResultsError; 2] {
            let read = DatasetError::Io { path: path.to_path_buf(), source: kind.into() };
            [StoreError::new(path, Error::from(kind)).into(), read.into()]
        };
        assert!(of(ErrorKind::StorageFull).iter().all(ResultsError::is_io));
        // A file that an archive should have, and has not.
        assert!(!of(ErrorKind::NotFound).iter().any(ResultsError::is_io));
        assert!(!ResultsError::from(StoreError::new(path, "not a file")).is_io());
    }

    #[test]
    fn only_names_that_runs_give_are_of_results() {
        let of = |name: &str| is_of_results(name, &names());
        let right = "experiment.toml suites.lock scores.csv scores.parquet analyses.json models/001-avu-pf.json \
                     stills/changes/000043.png beside/kept.json beside/frame_measures.parquet";
        assert!(right.split(' ').all(of));
        let wrong = "manifest.json kept.json other/scores.csv other/manifest.json models/manifest.json \
                     stills/manifest.json stills/a/manifest.json beside/manifest.json beside/../scores.csv \
                     tables/table1.csv";
        assert!(!wrong.split(' ').any(of) && !of(""));
    }
}
