//! The downloads that the wanted sequences need.

use super::address::Address;
use crate::archive::{Archive, Packing};
use crate::lock::{below, pinned_suite, pinned_suite_names};
use crate::suite::{Missing, Suite};
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
    /// Sequences that are there but cannot be read, and why. They are left as they are.
    pub broken: Vec<(String, String)>,
}

/// Plans the downloads into the first of `data_roots`, of the wanted sequences that are missing under all of them.
pub fn plan(wanted: &[WantedSequences], data_roots: &[PathBuf]) -> FetchPlan {
    let folders = folders_by_archive();
    let mut plan = FetchPlan::default();
    let Some(root) = data_roots.first() else { return plan };
    for wanted in wanted {
        let loaded = wanted.suite.load(data_roots);
        for entry in wanted.suite.entries().iter().filter(|e| wanted.has(&e.name)) {
            let name = format!("{}/{}", wanted.suite.name(), entry.name);
            let missing = loaded.missing.iter().find(|m| m.name == entry.name);
            if let Some(broken) = loaded.broken.iter().find(|b| b.name == entry.name) {
                plan.broken.push((name, broken.error.to_string()));
            } else if let Some(missing) = missing {
                let archives: Vec<&Archive> = entry.archives().collect();
                let packed = archives.iter().any(|a| a.packing != Packing::File);
                if archives.is_empty() {
                    plan.by_hand.push((name, by_hand(missing)));
                } else if packed && below(root, &missing.folder).exists() {
                    let what = format!("{}; remove the folder to have it fetched anew", missing.how_to_get);
                    plan.broken.push((name, what));
                } else {
                    for archive in archives.into_iter().filter(|a| !is_here(a, root)) {
                        plan.add(&name, archive, folders.get(archive.name.as_str()));
                    }
                }
            } else {
                plan.here.push(name);
            }
        }
    }
    plan
}

impl FetchPlan {
    fn add(&mut self, name: &str, archive: &Archive, folders: Option<&BTreeSet<&str>>) {
        if let Some(job) = self.jobs.iter_mut().find(|job| job.archive.name == archive.name) {
            job.sequences.push(name.to_owned());
            return;
        }
        let folders = folders.into_iter().flatten().map(|f| String::from(*f)).collect();
        self.jobs.push(FetchJob { archive: archive.clone(), folders, sequences: vec![name.to_owned()] });
    }
}

/// Whether an archive that is a single file is there already.
fn is_here(archive: &Archive, root: &Path) -> bool {
    let name = Address::parse(&archive.url).map(|address| address.file_name().to_owned());
    archive.packing == Packing::File && name.is_ok_and(|name| below(root, &archive.into).join(name).exists())
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
