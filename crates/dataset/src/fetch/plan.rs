//! The downloads that the wanted sequences need.

use super::place::was_fetched;
use super::unpack::single_file;
use crate::archive::{Archive, Packing};
use crate::lock::{below, pinned_suites};
use crate::suite::{Finding, Missing, Suite};
use std::cell::LazyCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The wanted sequences of one suite.
#[derive(Clone)]
pub struct WantedSequences {
    /// Suite with the sequences.
    pub suite: Suite,
    /// Names of the wanted sequences.
    pub sequences: BTreeSet<String>,
}

/// One archive to download, and the folders and sequences that need it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FetchJob {
    /// The archive to download.
    pub archive: Archive,
    /// All folders under the data root that come in the archive, wanted or not, so that none needs a second
    /// download.
    pub folders: Vec<String>,
    /// Missing wanted sequences that come in the archive, as `suite/sequence`.
    pub sequences: Vec<String>,
    /// Folders that replace those of an earlier fetch.
    pub again: Vec<String>,
}

/// Plan of a fetch: an action for each wanted sequence, in the order given.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FetchPlan {
    /// Archives to download.
    pub jobs: Vec<FetchJob>,
    /// Sequences that cannot be downloaded, each with the way to get it.
    pub by_hand: Vec<(String, String)>,
    /// Sequences that are present and as pinned.
    pub here: Vec<String>,
    /// Sequences that are present but not as pinned or not readable, each with the reason and the remedy.
    /// They are left as they are.
    pub broken: Vec<(String, String)>,
}

/// Plans the downloads into the first of `data_roots`. Wanted sequences that are missing under all roots are
/// downloaded; present ones are compared with what is pinned, which reads their files. With `again`, fetched
/// folders that are not as pinned are downloaded once more.
pub fn plan(wanted: &[WantedSequences], data_roots: &[PathBuf], again: bool) -> FetchPlan {
    // Parses the files of all suites, for which there may be no need.
    let folders = LazyCell::new(folders_by_archive);
    let mut plan = FetchPlan::default();
    let Some(root) = data_roots.first() else { return plan };
    for wanted in wanted {
        for (entry, finding) in wanted.suite.verify(data_roots, |name| wanted.sequences.contains(name)) {
            let name = format!("{}/{}", wanted.suite.name(), entry.name);
            let archives: Vec<&Archive> = entry.archives().collect();
            let folder = entry.path(root);
            let is_packed = archives.iter().any(|a| a.packing != Packing::File);
            let wrong = match finding {
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
    /// Returns the job of an archive, adding one if there is none yet.
    fn job(&mut self, archive: &Archive, folders: &BTreeMap<&str, BTreeSet<&str>>) -> &mut FetchJob {
        let known = self.jobs.iter().position(|job| job.archive.name == archive.name);
        let place = known.unwrap_or_else(|| {
            let folders = folders.get(archive.name.as_str()).into_iter().flatten().map(ToString::to_string);
            let (folders, archive) = (folders.collect(), archive.clone());
            self.jobs.push(FetchJob { archive, folders, ..FetchJob::default() });
            self.jobs.len() - 1
        });
        &mut self.jobs[place]
    }
}

/// True if an archive that is a single file is already under the root.
fn is_here(archive: &Archive, root: &Path) -> bool {
    archive.packing == Packing::File && single_file(archive).is_ok_and(|file| below(root, &file).exists())
}

/// Folders of all built-in sequences, by the name of their archive.
fn folders_by_archive() -> BTreeMap<&'static str, BTreeSet<&'static str>> {
    let mut folders: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for entry in pinned_suites().flat_map(|suite| &suite.sequence) {
        for archive in entry.archives() {
            folders.entry(&archive.name).or_default().insert(&entry.folder);
        }
    }
    folders
}
