//! `reports/index.html`: one offline page over all experiments that have a report.
//!
//! Each report has a `summary.json` beside its page, made from results alone. The site is made from all
//! summaries, collected by a walk over the folder in order of names. So the order in which reports were
//! written has no effect, and a report that was removed by hand is missing from the next site. Reports
//! without a readable summary are listed as such.
//!
//! The page has no script.

mod leaderboard;
mod summary;

pub use leaderboard::LEADERBOARD;
pub use summary::{Estimate, FORMAT, Standing, Summary, summary};

use super::claims::ClaimCounts;
use super::finished;
use super::page::{ReportError, fill};
use super::write::{INDEX, SUMMARY};
use serde_json::json;
use std::fs::File;
use std::path::Path;
use trackfail_dataset::text;
use trackfail_engine::store::staging::Staging;
use trackfail_engine::store::{self, StoreError};

/// Line in the head of pages that this program writes. Other pages are never replaced.
const OURS: &str = "<meta name=\"generator\" content=\"trackfail\">";

/// Writes `index.html` over all reports below a folder; returns warnings about reports that it cannot list.
/// All reports in place at the time of the call are listed, even if several processes call it: they take
/// turns, and each walks the folder anew.
///
/// # Errors
/// When the page cannot be written.
pub fn write_index(reports: &Path) -> Result<Vec<String>, ReportError> {
    // Some systems do not let a folder be opened and locked; there only the lock of the results protects the site.
    let lock = File::open(reports).ok();
    if let Some(lock) = &lock {
        let _ = lock.lock();
    }
    let site = collect(reports);
    let warning = |(name, why): &(String, String)| format!("{}: {why}", reports.join(name).display());
    let mut warnings: Vec<String> = site.unreadable.iter().map(warning).collect();
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

/// True if there is a file that this program has not written.
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

/// All reports below a folder.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Site {
    /// Folder, such as `sanmiguel2015/table4`, and summary of each report, sorted by folder.
    pub reports: Vec<(String, Summary)>,
    /// Folders with a page whose summary cannot be read, each with the reason.
    pub unreadable: Vec<(String, String)>,
}

/// Finds all reports below a folder, sorted by name. Hidden folders and links are skipped.
pub fn collect(reports: &Path) -> Site {
    let mut site = Site::default();
    let is_page = |name: &String| {
        let page = reports.join(name).join(INDEX).symlink_metadata();
        page.is_ok_and(|page| page.is_file())
    };
    for name in finished::named(reports, INDEX).into_iter().filter(is_page) {
        match summary::read_summary(&reports.join(&name).join(SUMMARY), &name) {
            Ok(summary) => site.reports.push((name, summary)),
            Err(why) => site.unreadable.push((name, why)),
        }
    }
    site.reports.sort_by(|a, b| a.0.cmp(&b.0));
    site.unreadable.sort();
    site
}

/// Renders `index.html`; the same reports give the same bytes.
fn render(site: &Site) -> Result<String, ReportError> {
    let claims = || site.reports.iter().map(|(_, summary)| summary.claims);
    let sum = |number: fn(ClaimCounts) -> u64| claims().map(number).fold(0, u64::saturating_add);
    let total = ClaimCounts {
        hold: sum(|claims| claims.hold),
        undecided: sum(|claims| claims.undecided),
        do_not_hold: sum(|claims| claims.do_not_hold),
        cannot_be_tested: sum(|claims| claims.cannot_be_tested),
    };
    let is_ranked = site.reports.iter().any(|(_, summary)| !summary.standings.is_empty());
    let style = concat!(include_str!("templates/page.css"), include_str!("templates/site.css"));
    let about = json!({
        "reports": site.reports,
        "unreadable": site.unreadable,
        "total": total,
        "leaderboard": is_ranked.then_some(LEADERBOARD),
    });
    fill(include_str!("templates/site.html"), style, "", &about)
}

#[cfg(test)]
mod tests;
