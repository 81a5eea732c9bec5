//! `reports/index.html`: one offline page over all experiments that have a report.
//!
//! Every report has a `summary.json` beside its page, made from results alone. The site is made from all summaries, which
//! are collected by a walk over the folder in order of names: it does not depend on the order in which reports were
//! written, and a report that is removed by hand is missing from the next site. Reports without a readable summary are
//! listed as such.
//!
//! The page has no script.

mod collect;
mod error;
mod leaderboard;
mod standing;
mod summary;
mod view;

pub use collect::{Site, collect};
pub use error::SiteError;
pub use leaderboard::LEADERBOARD;
pub use standing::{Estimate, Standing};
pub use summary::{FORMAT, Summary, summary, write_summary};
pub use view::render;

use super::files::INDEX;
use std::fs::File;
use std::path::Path;
use trackfail_dataset::text;
use trackfail_engine::store::staging::Staging;
use trackfail_engine::store::{self, StoreError};

/// A line in the head of our pages; a page without it is not replaced.
const OURS: &str = "<meta name=\"generator\" content=\"trackfail\">";

/// Writes `index.html` over all reports below a folder; returns warnings about reports that it cannot list. The site has
/// every report that is in its place when this is called, even when several processes call it: they take turns, and each
/// walks the folder anew.
///
/// # Errors
/// When the page cannot be written.
pub fn write_index(reports: &Path) -> Result<Vec<String>, SiteError> {
    // Some systems do not let a folder be opened and locked; there only the lock of the results protects the site.
    let lock = File::open(reports).ok();
    if let Some(lock) = &lock {
        let _ = lock.lock();
    }
    let mut warnings = Vec::new();
    let site = collect(reports);
    for (name, why) in &site.unreadable {
        warnings.push(format!("{}: {why}", reports.join(name).display()));
    }
    // Written in a folder of its own, because other runs sweep temporary files beside reports.
    let aside = Staging::new(reports)?;
    let pages = [(INDEX, Some(render(&site)?)), (LEADERBOARD, leaderboard::render(&site)?)];
    for (name, page) in pages {
        let (path, made) = (reports.join(name), aside.path().join(name));
        match page {
            _ if is_foreign(&path) => warnings.push(format!(
                "{}: left as it is, because it is no page of this program; use another --reports for a page over all reports",
                path.display()
            )),
            None if path.is_file() => std::fs::remove_file(&path).map_err(|e| StoreError::new(&path, e))?,
            None => {}
            Some(page) => {
                store::write_derived(&made, page.as_bytes())?;
                std::fs::rename(made, &path).map_err(|e| StoreError::new(&path, e))?;
            }
        }
    }
    Ok(warnings)
}

/// Whether there is a file that this program has not written.
fn is_foreign(path: &Path) -> bool {
    if path.is_symlink() || !path.is_file() {
        // Replacing a link does not touch what it leads to, and a folder cannot be replaced.
        return false;
    }
    text::read_capped(path).is_ok_and(|bytes| {
        let head = String::from_utf8_lossy(&bytes[..bytes.len().min(4096)]);
        !bytes.is_empty() && !head.contains(OURS)
    })
}

#[cfg(test)]
mod tests;
