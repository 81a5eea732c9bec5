//! The reports below a folder.

use super::summary::{Summary, read_summary};
use crate::report::files::{INDEX, OWNED, SUMMARY};
use std::path::Path;
use trackfail_engine::spec::check_experiment_name;

/// All reports below a folder.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Site {
    /// Folder, such as `sanmiguel2015/table4`, and summary of each report, in order of folders.
    pub reports: Vec<(String, Summary)>,
    /// Folders with a page whose summary cannot be read, with the reason.
    pub unreadable: Vec<(String, String)>,
}

/// All reports below a folder, in order of names; hidden folders and links are skipped.
pub fn collect(reports: &Path) -> Site {
    let mut site = Site::default();
    let hidden = |e: &walkdir::DirEntry| e.file_name().as_encoded_bytes().starts_with(b".");
    // The folders inside a report are not reports.
    let inside = |e: &walkdir::DirEntry| {
        e.depth() > 1
            && OWNED.iter().any(|owned| e.file_name() == *owned)
            && e.path().parent().is_some_and(|parent| parent.join(INDEX).is_file())
            && !e.path().join(INDEX).exists()
            && !e.path().join(SUMMARY).exists()
    };
    let entries = walkdir::WalkDir::new(reports).sort_by_file_name().into_iter();
    // A folder that disappears during the walk is skipped.
    for entry in entries.filter_entry(|e| e.depth() == 0 || !(hidden(e) || inside(e))).filter_map(Result::ok)
    {
        if entry.depth() < 2 || entry.file_name() != INDEX || !entry.file_type().is_file() {
            continue;
        }
        let Some(folder) = entry.path().parent() else { continue };
        let name = folder.strip_prefix(reports).ok().and_then(Path::to_str).map(|n| n.replace('\\', "/"));
        let Some(name) = name.filter(|name| check_experiment_name(name).is_ok()) else { continue };
        match read_summary(&folder.join(SUMMARY), &name) {
            Ok(summary) => site.reports.push((name, summary)),
            Err(why) => site.unreadable.push((name, why.to_string())),
        }
    }
    site.reports.sort_by(|a, b| a.0.cmp(&b.0));
    site.unreadable.sort();
    site
}
