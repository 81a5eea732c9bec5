//! Everything that a run found out.

use super::analyse::{Analysed, NotAnalysed};
use super::detector_outputs::{CachedDetectorOutput, StoredDetectorOutput};
use super::judge::Judged;
use super::track::Tracks;
use super::train::Model;
use crate::dataset::Sequence;
use crate::dataset::suite::Missing;
use crate::detector::DetectorOutput;
use crate::error::CellError;
use crate::observe::tally::Tally;
use crate::plan::Job;
use crate::store::{Store, StoreError};
use std::collections::BTreeMap;
use std::sync::Arc;

/// One cell: a method's variant on a tracker's run over a sequence.
pub struct Cell {
    /// Index into [`Outcome::sequences`].
    pub sequence: usize,
    /// Label of the tracker.
    pub tracker: String,
    /// Repetition, from 0.
    pub run: u32,
    /// Method.
    pub method: String,
    /// Grid point, empty without a grid.
    pub params: String,
    /// Index of the track in [`Outcome::tracks`]`[sequence]`.
    pub job: usize,
    /// Which of the track's signals the method reads.
    pub signal: Option<usize>,
    /// Threshold of the detector, for figures.
    pub threshold: Option<f64>,
    /// The result.
    pub result: Result<Judged, CellError>,
}

/// Everything that a run found out about the test suite.
pub struct Outcome<'a> {
    /// Name of the suite.
    pub suite: String,
    /// Sequences that are there, in suite order.
    pub sequences: Vec<Arc<Sequence>>,
    /// Sequences that are not.
    pub missing: Vec<Missing>,
    /// How many the suite has.
    pub wanted: usize,
    /// Tracks, sequences x jobs.
    pub tracks: Vec<Tracks>,
    /// The jobs.
    pub jobs: Vec<Job>,
    /// Cells, sequence by sequence, in the experiment's order.
    pub cells: Vec<Cell>,
    /// What was trained or learned.
    pub models: Vec<Model>,
    /// Analyses.
    pub analyses: Vec<Analysed>,
    /// Analyses that could not be made, by name, with the reason.
    pub not_analysed: Vec<NotAnalysed>,
    /// Digests of all sequences used, by suite.
    pub digests: BTreeMap<String, Vec<(String, String)>>,
    /// Rules that stood in for missing values, with how often.
    pub rules: BTreeMap<String, u64>,
    /// Sequences whose digest is not the pinned one, as `suite/name`.
    pub differing: Vec<String>,
    /// What was computed and what was there.
    pub tally: Tally,
    pub(super) store: &'a Store,
}

impl Outcome<'_> {
    /// What the detector of a cell said.
    ///
    /// # Errors
    /// When it was to be read from the store and has gone.
    pub fn verdict(&self, cell: &Cell, judged: &Judged) -> Result<Arc<DetectorOutput>, StoreError> {
        let address = match &judged.verdict {
            CachedDetectorOutput::Here(verdict) => return Ok(verdict.clone()),
            CachedDetectorOutput::Stored(address) => address,
        };
        let track =
            self.tracks.get(cell.sequence).and_then(|t| t.get(cell.job)).and_then(|t| t.as_ref().ok());
        let verdict = track.and_then(|track| {
            let signal = track.signal(cell.signal);
            self.store.get::<StoredDetectorOutput>(address, signal.len())?.on(&signal)
        });
        let gone =
            || StoreError::new(self.store.folder(), "a record has gone while it was needed; run again");
        verdict.map(Arc::new).ok_or_else(gone)
    }
}
