//! The downloads that the wanted sequences need.

use super::place::was_fetched;
use super::single_file;
use crate::archive::{Archive, Packing};
use crate::lock::{below, pinned_suites};
use crate::suite::{Finding, Missing, Suite};
use std::cell::LazyCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Sequences of a suite that are wanted.
#[derive(Clone)]
pub struct WantedSequences {
    /// The suite.
    pub suite: Suite,
    /// Their names; empty for all.
    pub sequences: BTreeSet<String>,
}

impl WantedSequences {
    fn has(&self, name: &str) -> bool {
        self.sequences.is_empty() || self.sequences.contains(name)
    }
}

/// One archive and what it is fetched for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FetchJob {
    /// The archive.
    pub archive: Archive,
    /// Every folder under the data root that comes in it, wanted or not, so that none needs a second download.
    pub folders: Vec<String>,
    /// The wanted sequences that are missing and come in it, as `suite/sequence`.
    pub sequences: Vec<String>,
    /// Those of the folders that take the place of what was fetched before.
    pub again: Vec<String>,
}

/// The work for the wanted sequences, in their order.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FetchPlan {
    /// Downloads.
    pub jobs: Vec<FetchJob>,
    /// Sequences that cannot be downloaded, with the way to get them.
    pub by_hand: Vec<(String, String)>,
    /// Sequences that are there.
    pub here: Vec<String>,
    /// Sequences that are there but are not as pinned or cannot be read: why, and what to do. They are left as they are.
    pub broken: Vec<(String, String)>,
}

/// Plans the downloads into the first of `data_roots`, of the wanted sequences that are missing under all of them.
/// Those that are there are compared with what is pinned, which reads their files. With `again`, folders that a fetch has
/// placed and that are not as pinned are downloaded once more.
pub fn plan(wanted: &[WantedSequences], data_roots: &[PathBuf], again: bool) -> FetchPlan {
    // Parses the files of all suites, for which there may be no need.
    let folders = LazyCell::new(folders_by_archive);
    let mut plan = FetchPlan::default();
    let Some(root) = data_roots.first() else { return plan };
    for wanted in wanted {
        let entries = wanted.suite.entries().iter().filter(|e| wanted.has(&e.name));
        for (entry, checked) in entries.zip(wanted.suite.verify(data_roots, |name| wanted.has(name))) {
            let name = format!("{}/{}", wanted.suite.name(), entry.name);
            let archives: Vec<&Archive> = entry.archives().collect();
            let folder = entry.path(root);
            let is_packed = archives.iter().any(|a| a.packing != Packing::File);
            let wrong = match checked.finding {
                Finding::Same | Finding::NoDigestPinned => {
                    plan.here.push(name);
                    continue;
                }
                Finding::Missing(Missing { how_to_get, folder, .. }) if archives.is_empty() => {
                    plan.by_hand.push((name, format!("{how_to_get}; its folder is {folder}")));
                    continue;
                }
                Finding::Missing(missing) if is_packed && folder.exists() => missing.how_to_get,
                Finding::Missing(_) => {
                    for archive in archives.into_iter().filter(|a| !is_here(a, root)) {
                        plan.job(archive, &folders).sequences.push(name.clone());
                    }
                    continue;
                }
                Finding::Differs(fact) => fact,
            };
            let replaceable = is_packed && was_fetched(&folder);
            if replaceable && again {
                for archive in archives {
                    let job = plan.job(archive, &folders);
                    job.sequences.push(name.clone());
                    job.again.push(entry.folder.clone());
                }
                continue;
            }
            let remedy = if replaceable {
                "it was fetched, so the same command with --again replaces it by a new download".into()
            } else if archives.is_empty() {
                "it was not fetched: get it anew by hand".into()
            } else if folder.exists() {
                format!("it was not fetched: move {} away to have it fetched", folder.display())
            } else {
                "it is in another data root than the first one: move it away to have it fetched".into()
            };
            plan.broken.push((name, format!("{wrong}; {remedy}")));
        }
    }
    plan
}

impl FetchPlan {
    /// The job of an archive.
    fn job(&mut self, archive: &Archive, folders: &BTreeMap<&str, BTreeSet<&str>>) -> &mut FetchJob {
        let known = self.jobs.iter().position(|job| job.archive.name == archive.name);
        let place = known.unwrap_or_else(|| {
            let folders = folders.get(archive.name.as_str()).into_iter().flatten().map(ToString::to_string);
            let (folders, archive) = (folders.collect(), archive.clone());
            self.jobs.push(FetchJob { archive, folders, sequences: Vec::new(), again: Vec::new() });
            self.jobs.len() - 1
        });
        &mut self.jobs[place]
    }
}

/// Whether an archive that is a single file is there already.
fn is_here(archive: &Archive, root: &Path) -> bool {
    archive.packing == Packing::File && single_file(archive).is_ok_and(|file| below(root, &file).exists())
}

/// The folders of all sequences by the archive they come in; those of user suites come in none.
fn folders_by_archive() -> BTreeMap<&'static str, BTreeSet<&'static str>> {
    let mut folders: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for entry in pinned_suites().flat_map(|suite| &suite.sequence) {
        for archive in entry.archives() {
            folders.entry(&archive.name).or_default().insert(&entry.folder);
        }
    }
    folders
}
