//! Writing a results folder.

use super::column::TableFile;
use super::frame::{to_csv, to_parquet};
use super::manifest::{self, Hashed, Manifest};
use super::run::RunRecord;
use super::{
    Results, ResultsError, SPEC, USER_SUITES, analyses, checks, conditions, frame_measures, frame_pairs,
    frames, json::to_json, measures, models, pieces, readings, run, scores, signals, truth,
};
use polars::prelude::DataFrame;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use trackfail_engine::Outcome;
use trackfail_engine::spec::Experiment;
use trackfail_engine::store::{self, StoreError};

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
        self.files.insert(name.to_string(), manifest::sha256(bytes));
        Ok(store::write(&self.folder.join(name), bytes)?)
    }

    /// A file that is Parquet in compact results, and CSV in others.
    fn put_rows(&mut self, file: &TableFile, rows: DataFrame, detail: Detail) -> Result<(), ResultsError> {
        match detail {
            Detail::Frames => self.put(file.name, &to_csv(rows)?),
            Detail::Sequences => self.put(&file.packed(), &to_parquet(rows)?),
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
    written.put_rows(&scores::FILE, scores::frame(experiment, outcome, detail)?, detail)?;
    written.put(measures::FILE.name, &measures::write(outcome)?)?;
    if !outcome.cells.is_empty() {
        let rows = frame_measures::measure(experiment, outcome)?;
        let frame = frame_measures::frame(&outcome.suite, &rows)?;
        written.put_rows(&frame_measures::FILE, frame, detail)?;
        if experiment.leaderboard {
            written.put(frame_pairs::FILE.name, &frame_pairs::write(&outcome.suite, &rows)?)?;
        }
    }
    if readings::has_readings(experiment) {
        let rows = readings::rows(experiment, outcome)?;
        written.put(readings::FILE.name, &readings::write(&outcome.suite, &rows)?)?;
    }
    if detail == Detail::Frames {
        write_frames(&mut written, experiment, outcome)?;
        models::write(folder, outcome)?;
    }
    if let Some(bytes) = analyses::write(folder, &outcome.analyses)? {
        written.put(analyses::FILE, &bytes)?;
    }
    let path = folder.join(run::FILE);
    store::write(&path, &to_json(&path, record)?)?;
    let manifest = Manifest { files: written.files, ..Manifest::new(experiment, outcome) };
    let path = folder.join(manifest::FILE);
    store::write(&path, &to_json(&path, &manifest)?)?;
    Ok(())
}

/// Writes the files that tell of single frames.
fn write_frames(
    written: &mut Written<'_>,
    experiment: &Experiment,
    outcome: &Outcome<'_>,
) -> Result<(), ResultsError> {
    let folder = written.folder;
    type WriteTo = fn(&Outcome<'_>, &mut dyn Write) -> Result<(), ResultsError>;
    let streamed: [(&str, WriteTo); 2] =
        [(frames::FILE.name, frames::write), (signals::FILE.name, signals::write)];
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
    written.put(truth::FILE.name, &truth::write(outcome)?)?;
    if let Some(bytes) = pieces::write(experiment, outcome)? {
        written.put(pieces::FILE.name, &bytes)?;
    }
    let followed = conditions::followed(outcome)?;
    if !followed.is_empty() {
        written.put(conditions::FILE.name, &conditions::write(outcome, &followed)?)?;
        written.put(checks::FILE.name, &checks::write(outcome, &followed)?)?;
    }
    Ok(())
}

/// Files that only some results have.
const OPTIONAL: [&str; 11] = [
    scores::FILE.name,
    frame_measures::FILE.name,
    frame_pairs::FILE.name,
    frames::FILE.name,
    signals::FILE.name,
    truth::FILE.name,
    pieces::FILE.name,
    readings::FILE.name,
    conditions::FILE.name,
    checks::FILE.name,
    analyses::FILE,
];

/// Removes what an earlier run left in the folder of results that have no such file.
///
/// # Errors
/// When a file cannot be removed.
pub fn remove_others(results: &Results) -> Result<(), ResultsError> {
    let packed = [&scores::FILE, &frame_measures::FILE].map(TableFile::packed);
    let all = OPTIONAL.into_iter().chain(packed.iter().map(String::as_str));
    for name in all.filter(|name| !results.has(name)) {
        let path = results.folder.join(name);
        match std::fs::remove_file(&path) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
                return Err(StoreError::new(&path, e).into());
            }
            _ => {}
        }
    }
    Ok(())
}
