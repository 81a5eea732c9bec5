//! A report that is rendered aside and then takes its place as a whole.

use super::files::{INDEX, OWNED};
use super::site;
use super::write::{WriteError, WrittenReport, write};
use crate::results::Results;
use std::path::{Path, PathBuf};
use trackfail_engine::store::staging::{self, Staging};

/// A report in a temporary folder beside its place.
pub struct StagedReport {
    name: String,
    aside: Staging,
    written: WrittenReport,
}

impl StagedReport {
    /// Renders a report aside, and its tables beside the results.
    ///
    /// # Errors
    /// See [`WriteError`].
    pub fn render(results: &Results, reports: &Path) -> Result<Self, WriteError> {
        staging::sweep(reports);
        let aside = Staging::new(reports)?;
        let written = write(results, aside.path())?;
        site::write_summary(results, &written, aside.path())?;
        Ok(Self { name: results.experiment.name.clone(), aside, written })
    }

    /// Puts the report in its place below `reports`; returns the path of its page, and what it says.
    ///
    /// # Errors
    /// When the folder cannot be replaced.
    pub fn publish(self, reports: &Path) -> Result<(PathBuf, WrittenReport), WriteError> {
        let target = reports.join(&self.name);
        self.aside.publish(&target, INDEX, &OWNED)?;
        Ok((target.join(INDEX), self.written))
    }
}
