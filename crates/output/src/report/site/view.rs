//! Renders the page over all reports as HTML.

use super::LEADERBOARD;
use super::collect::Site;
use super::summary::Summary;
use crate::report::claims::ClaimCounts;
use crate::report::html::Parts;
use crate::report::page::ReportError;
use serde::Serialize;

#[derive(Serialize)]
struct View<'s> {
    reports: Vec<Report<'s>>,
    total: ClaimCounts,
    unreadable: &'s [(String, String)],
    leaderboard: Option<&'s str>,
}

#[derive(Serialize)]
struct Report<'s> {
    folder: &'s str,
    summary: &'s Summary,
}

/// Renders `index.html`; the same reports give the same bytes.
///
/// # Errors
/// When the template does not fit, which would be a bug.
pub fn render(site: &Site) -> Result<String, ReportError> {
    let parts = Parts {
        template: include_str!("../templates/site.html"),
        style: concat!(include_str!("../templates/page.css"), include_str!("../templates/site.css")),
        script: "",
    };
    parts.fill(&view(site))
}

fn view<'s>(site: &'s Site) -> View<'s> {
    let mut total = ClaimCounts::default();
    for (_, summary) in &site.reports {
        let ClaimCounts { hold, undecided, do_not_hold, cannot_be_tested } = summary.claims;
        let add = |sum: &mut u64, n: u64| *sum = sum.saturating_add(n);
        add(&mut total.hold, hold);
        add(&mut total.undecided, undecided);
        add(&mut total.do_not_hold, do_not_hold);
        add(&mut total.cannot_be_tested, cannot_be_tested);
    }
    let report = |(folder, summary): &'s (String, Summary)| Report { folder, summary };
    View {
        reports: site.reports.iter().map(report).collect(),
        total,
        unreadable: &site.unreadable,
        leaderboard: site.reports.iter().any(|(_, s)| !s.standings.is_empty()).then_some(LEADERBOARD),
    }
}
