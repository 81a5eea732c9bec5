//! The downloads that the wanted sequences need.

use super::download::{address, file_name};
use super::place::was_fetched;
use crate::archive::{Archive, Packing};
use crate::lock::{Entry, below, pinned_suite, pinned_suite_names};
use crate::suite::{Checked, Finding, Missing, Suite};
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
    let folders = folders_by_archive();
    let mut plan = FetchPlan::default();
    let Some(root) = data_roots.first() else { return plan };
    for wanted in wanted {
        let checked = wanted.suite.verify_some(data_roots, |name| wanted.has(name));
        for (entry, Checked { finding, .. }) in
            wanted.suite.entries().iter().filter(|e| wanted.has(&e.name)).zip(checked)
        {
            let name = format!("{}/{}", wanted.suite.name(), entry.name);
            let archives: Vec<&Archive> = entry.archives().collect();
            let folder = below(root, &entry.folder);
            let is_packed = archives.iter().any(|a| a.packing != Packing::File);
            let wrong = match finding {
                Finding::Same | Finding::NoDigestPinned => {
                    plan.here.push(name);
                    continue;
                }
                Finding::Missing(missing) if archives.is_empty() => {
                    plan.by_hand.push((name, by_hand(&missing)));
                    continue;
                }
                Finding::Missing(missing) if is_packed && folder.exists() => missing.how_to_get,
                Finding::Missing(_) => {
                    for archive in archives.into_iter().filter(|a| !is_here(a, root)) {
                        plan.add(&name, archive, folders.get(archive.name.as_str()));
                    }
                    continue;
                }
                Finding::Differs(fact) => fact,
            };
            let replaceable = is_packed && was_fetched(&folder);
            if replaceable && again {
                for archive in archives {
                    let job = plan.add(&name, archive, folders.get(archive.name.as_str()));
                    job.again.push(entry.folder.clone());
                }
            } else {
                plan.broken.push((name, format!("{wrong}; {}", remedy(entry, &folder, replaceable))));
            }
        }
    }
    plan
}

/// What to do about a sequence that is there but not as pinned.
fn remedy(entry: &Entry, folder: &Path, replaceable: bool) -> String {
    if replaceable {
        "it was fetched, so the same command with --again replaces it by a new download".into()
    } else if entry.archives().next().is_none() {
        "it was not fetched: get it anew by hand".into()
    } else if folder.exists() {
        format!("it was not fetched: move {} away to have it fetched", folder.display())
    } else {
        "it is in another data root than the first one: move it away to have it fetched".into()
    }
}

impl FetchPlan {
    /// The job of an archive, with one more sequence.
    fn add(&mut self, name: &str, archive: &Archive, folders: Option<&BTreeSet<&str>>) -> &mut FetchJob {
        let known = self.jobs.iter().position(|job| job.archive.name == archive.name);
        let place = known.unwrap_or_else(|| {
            let folders = folders.into_iter().flatten().map(|f| String::from(*f)).collect();
            let (sequences, again) = (Vec::new(), Vec::new());
            self.jobs.push(FetchJob { archive: archive.clone(), folders, sequences, again });
            self.jobs.len() - 1
        });
        let job = &mut self.jobs[place];
        job.sequences.push(name.to_owned());
        job
    }
}

/// Whether an archive that is a single file is there already.
fn is_here(archive: &Archive, root: &Path) -> bool {
    let folder = below(root, &archive.into);
    archive.packing == Packing::File
        && address(&archive.url).is_ok_and(|address| folder.join(file_name(&address)).exists())
}

fn by_hand(missing: &Missing) -> String {
    format!("{}; its folder is {}", missing.how_to_get, missing.folder)
}

/// The folders of all sequences by the archive they come in; those of user suites come in none.
fn folders_by_archive() -> BTreeMap<&'static str, BTreeSet<&'static str>> {
    let mut folders: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for suite in pinned_suite_names().filter_map(pinned_suite) {
        for entry in &suite.sequence {
            for archive in entry.archives() {
                folders.entry(&archive.name).or_default().insert(&entry.folder);
            }
        }
    }
    folders
}
