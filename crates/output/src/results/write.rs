//! Writing a results folder.

use super::manifest::{self, Hashed, Manifest};
use super::run::RunRecord;
use super::{
    ResultsError, SPEC, USER_SUITES, analyses, checks, conditions, frame_measures, frames, json::to_json,
    measures, models, run, scores, signals, truth,
};
use crate::engine::Outcome;
use crate::engine::store;
use crate::spec::Experiment;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

/// Writes everything that a run found out into an empty folder; the tables are made from it by the report.
///
/// # Errors
/// When a file cannot be written.
pub fn write(
    folder: &Path,
    experiment: &Experiment,
    outcome: &Outcome<'_>,
    record: &RunRecord,
) -> Result<(), ResultsError> {
    let mut files = BTreeMap::new();
    let mut put = |name: &str, bytes: &[u8]| -> Result<(), ResultsError> {
        files.insert(name.to_string(), manifest::sha256(bytes));
        Ok(store::write(&folder.join(name), bytes)?)
    };
    put(SPEC, experiment.source.as_bytes())?;
    if let Some(suites) = experiment.catalog.user_text(experiment.suites.values().map(String::as_str)) {
        put(USER_SUITES, suites.as_bytes())?;
    }
    put(scores::FILE.name, &scores::write(experiment, outcome)?)?;
    put(measures::FILE.name, &measures::write(outcome)?)?;
    if let Some(bytes) = frame_measures::write(experiment, outcome)? {
        put(frame_measures::FILE.name, &bytes)?;
    }
    type WriteTo = fn(&Outcome<'_>, &mut dyn Write) -> Result<(), ResultsError>;
    let streamed: [(&str, WriteTo); 2] =
        [(frames::FILE.name, frames::write), (signals::FILE.name, signals::write)];
    let stream = |&(name, write): &(&str, WriteTo)| {
        let mut digest = String::new();
        store::write_with(&folder.join(name), |file| {
            let mut file = Hashed::new(file);
            write(outcome, &mut file)?;
            digest = file.hexadecimal();
            Ok::<_, ResultsError>(())
        })?;
        Ok((name.to_string(), digest))
    };
    let digests = streamed.par_iter().map(stream).collect::<Result<Vec<_>, ResultsError>>()?;
    put(truth::FILE.name, &truth::write(outcome)?)?;
    let followed = conditions::followed(outcome)?;
    if !followed.is_empty() {
        put(conditions::FILE.name, &conditions::write(outcome, &followed)?)?;
        put(checks::FILE.name, &checks::write(outcome, &followed)?)?;
    }
    if let Some(bytes) = analyses::write(folder, &outcome.analyses)? {
        put(analyses::FILE, &bytes)?;
    }
    files.extend(digests);
    models::write(folder, outcome)?;
    let path = folder.join(run::FILE);
    store::write(&path, &to_json(&path, record)?)?;
    let manifest = Manifest { files, ..Manifest::new(experiment, outcome) };
    let path = folder.join(manifest::FILE);
    store::write(&path, &to_json(&path, &manifest)?)?;
    Ok(())
}
