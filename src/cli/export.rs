//! Tracks as result files, for `trackfail run --export-tracks DIR`: one folder per tracker. `replay` reads it
//! from `results/` of a data root.
//!
//! | protocol | file of run r |
//! |---|---|
//! | resets | `<tracker>/<Seq>/<Seq>_00{r+1}.txt`, VOT |
//! | one pass, one run | `<tracker>/<Seq>.txt`, OTB |
//! | one pass or spatial, several runs | `<tracker>/<Seq>_00{r+1}.txt`, OTB |
//!
//! OTB files have lines `x,y,w,h`; of a polygon, that is the upright bounding box. VOT files keep polygons.
//!
//! A confidence is written beside them, `<name>_confidence.value`, and absence as a line of NaN, which `replay` reads with
//! `without_area = "absent"`.
//!
//! Runs of the temporal protocol start within a sequence, which neither format can express. They are left
//! out, as are tracks that failed.

use super::{Failure, output};
use crate::engine::Outcome;
use crate::engine::store;
use crate::spec::Experiment;
use crate::tracker::protocol::RunProtocol;
use crate::tracker::results::write;
use std::path::{Path, PathBuf};

/// Folder name of a tracker.
fn folder_name(label: &str) -> String {
    let safe = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '-' };
    label.chars().map(safe).collect()
}

/// Checks that each tracker has its own folder, and that no folder has results that a data root uses.
///
/// # Errors
/// `Usage` if two trackers would share a folder, or one would replace results.
pub fn check(folder: &Path, experiment: &Experiment, data_roots: &[PathBuf]) -> Result<(), Failure> {
    let names: Vec<String> = experiment.trackers.iter().map(|t| folder_name(&t.label)).collect();
    for (k, name) in names.iter().enumerate() {
        if let Some(twin) = names[..k].iter().position(|n| n == name) {
            let [a, b] = [twin, k].map(|t| experiment.trackers[t].label.as_str());
            return Err(Failure::usage(format!("trackers `{a}` and `{b}` would share the folder {name}")));
        }
        let own = folder.join(name);
        let Ok(there) = own.canonicalize() else { continue };
        let is_in =
            |root: &PathBuf| root.join("results").canonicalize().is_ok_and(|root| there.starts_with(root));
        if data_roots.iter().any(is_in) {
            return Err(Failure::usage(format!(
                "--export-tracks {} would replace results in {}, which a data root has; name another folder, or delete \
                 that one first",
                folder.display(),
                own.display()
            )));
        }
    }
    Ok(())
}

/// Writes all tracks of the test suite below `folder`.
///
/// # Errors
/// When a file cannot be written.
pub fn write(folder: &Path, experiment: &Experiment, outcome: &Outcome<'_>) -> Result<(), Failure> {
    let names: Vec<String> = experiment.trackers.iter().map(|t| folder_name(&t.label)).collect();
    let (mut written, mut left_out) = (0, 0);
    for (sequence, tracks) in outcome.sequences().zip(&outcome.tracks) {
        for (job, track) in outcome.plan.jobs.iter().zip(tracks) {
            let tracker = &experiment.trackers[job.tracker];
            let Some(track) = track.as_ref().ok().filter(|_| tracker.protocol != RunProtocol::OtbTemporal)
            else {
                left_out += 1;
                continue;
            };
            let (own, name) = (folder.join(&names[job.tracker]), &sequence.name);
            let numbered = format!("{name}_{:03}.txt", job.run + 1);
            let (path, text) = match tracker.protocol {
                RunProtocol::VotReset | RunProtocol::VotReset2014 | RunProtocol::VotRegionNoise => {
                    (own.join(name).join(numbered), write::vot(&track.regions, &track.status))
                }
                _ => {
                    let file = if tracker.runs == 1 { format!("{name}.txt") } else { numbered };
                    (own.join(file), write::otb(&track.regions, &track.status))
                }
            };
            store::write(&path, text.as_bytes()).map_err(Failure::io)?;
            written += 1;
            if !track.confidence.is_empty() {
                let text = write::confidence(&track.confidence);
                store::write(&write::confidence_path(&path), text.as_bytes()).map_err(Failure::io)?;
                written += 1;
            }
        }
    }
    let rest = if left_out > 0 { format!(", {left_out} tracks left out") } else { String::new() };
    output::note(&format!("{written} result files below {}{rest}", folder.display()));
    Ok(())
}
