//! `reports/index.html`: one offline page over all experiments that have a report.
//!
//! Every report has a `summary.json` beside its page, made of results alone. The site is made of all of these, by a
//! walk over the folder in the order of names: it does not depend on which report was written when, and a report that
//! is removed by hand is gone from the next site. Reports without a summary that can be read are listed as such.
//!
//! The same page with the runs that go on above is what `trackfail serve` shows. A page over nothing but reports has
//! no script.

mod collect;
mod error;
mod summary;
mod view;

pub use collect::{Site, collect};
pub use error::SiteError;
pub use summary::{Best, ClaimCounts, FORMAT, Summary, summary, write_summary};
pub use view::{render, render_live};

use super::files::INDEX;
use crate::dataset::text;
use crate::engine::store::staging::Staging;
use crate::engine::store::{self, StoreError};
use std::fs::File;
use std::path::Path;

/// What a page of ours has in its head; another one is not replaced.
const OURS: &str = "<meta name=\"generator\" content=\"trackfail\">";

/// Writes `index.html` over all reports below a folder. Whoever calls it after a report has taken its place has it in
/// the site, whatever other processes do: of two that write at once the later one looks when the earlier is done.
///
/// # Errors
/// When the page cannot be written.
pub fn write_index(reports: &Path) -> Result<Vec<String>, SiteError> {
    // A folder can be locked where the system lets it be opened; elsewhere the lock of the results has to do.
    let lock = File::open(reports).ok();
    if let Some(lock) = &lock {
        let _ = lock.lock();
    }
    let path = reports.join(INDEX);
    let mut warnings = Vec::new();
    if is_foreign(&path) {
        warnings.push(format!(
            "{}: left as it is, because it is no page of this program; use another --reports for a page over all reports",
            path.display()
        ));
        return Ok(warnings);
    }
    let site = collect(reports);
    for (name, why) in &site.unreadable {
        warnings.push(format!("{}: {why}", reports.join(name).display()));
    }
    // Put together aside: temporary files beside reports are swept by other runs.
    let aside = Staging::new(reports)?;
    let made = aside.path().join(INDEX);
    store::write(&made, render(&site)?.as_bytes())?;
    std::fs::rename(made, &path).map_err(|e| StoreError::new(&path, e))?;
    Ok(warnings)
}

/// Whether a file is there that somebody else has written.
fn is_foreign(path: &Path) -> bool {
    if path.is_symlink() || !path.is_file() {
        // A link is replaced, not what it leads to; a folder cannot be.
        return false;
    }
    text::read_capped(path).is_ok_and(|bytes| {
        let head = String::from_utf8_lossy(&bytes[..bytes.len().min(4096)]);
        !bytes.is_empty() && !head.contains(OURS)
    })
}

#[cfg(test)]
mod tests;
