//! Results shown by another experiment file. It may change presentation: captions, titles, order, selection,
//! widths and claims.

use super::manifest::{self, sha256};
use super::{Results, ResultsError, SPEC, beside, json::write_json, readings};
use std::path::Path;
use trackfail_engine::spec::presentation::other_keys;
use trackfail_engine::spec::read_file;
use trackfail_engine::store;

impl Results {
    /// Reads an experiment file that changes the presentation of these results. [`Results::keep`] saves it
    /// beside them.
    ///
    /// # Errors
    /// When the file is wrong, or has suites, trackers, methods or parameters other than those of the run.
    pub fn present(&mut self, path: &Path) -> Result<(), ResultsError> {
        let experiment = read_file(path, &self.experiment.catalog, None)?;
        let mut keys = other_keys(&self.experiment.source, &experiment.source);
        // Readings were compared with the published numbers when they were run.
        keys.retain(|key| key != "published" || readings::has_readings(&experiment));
        if !keys.is_empty() {
            return Err(ResultsError::Unfit(format!(
                "{}: not what the results in {} were run with; other: {} (captions, titles, order and selection may \
                 differ); run it",
                path.display(),
                self.folder.display(),
                keys.join(", ")
            )));
        }
        self.manifest.format = manifest::FORMAT;
        self.manifest.spec_digest = sha256(experiment.source.as_bytes());
        self.manifest.files.insert(SPEC.to_string(), self.manifest.spec_digest.clone());
        self.experiment = experiment;
        if let Some(kept) = self.kept()? {
            beside::extend(&mut self.experiment, kept.experiment);
        }
        self.put_in_order();
        Ok(())
    }

    /// Writes the changed experiment file and the manifest with its digest, replacing the earlier ones.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn keep(&self) -> Result<(), ResultsError> {
        store::write(&self.folder.join(SPEC), self.experiment.source.as_bytes())?;
        Ok(write_json(&self.folder.join(manifest::FILE), &self.manifest)?)
    }

    /// Sorts the pooled numbers by the experiment's trackers and methods.
    pub(super) fn put_in_order(&mut self) {
        let Self { experiment, measures, .. } = self;
        let tracker = |label: &str| experiment.trackers.iter().position(|t| t.label == label);
        let method = |name: &str| experiment.methods.iter().position(|m| m.name == name);
        measures.sort_by_cached_key(|m| (tracker(&m.tracker), method(&m.method)));
    }
}
