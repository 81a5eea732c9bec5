//! Renders the page over all reports as HTML.

use super::LEADERBOARD;
use super::collect::Site;
use super::summary::{Best, Summary};
use crate::report::claims::ClaimCounts;
use crate::report::files::MARKDOWN;
use crate::report::html::Parts;
use crate::report::page::ReportError;
use serde::Serialize;
use trackfail_engine::observe::progress::ObservedRun;

#[derive(Serialize)]
struct View<'s> {
    reports: Vec<Report<'s>>,
    total: ClaimCounts,
    unreadable: &'s [(String, String)],
    live: bool,
    running: Vec<Run<'s>>,
    markdown: &'s str,
    leaderboard: Option<&'s str>,
}

#[derive(Serialize)]
struct Report<'s> {
    folder: &'s str,
    summary: &'s Summary,
    best: Vec<Group<'s>>,
}

/// The best methods by one metric.
#[derive(Serialize)]
struct Group<'s> {
    metric: &'s str,
    best: Vec<&'s Best>,
}

#[derive(Serialize)]
struct Run<'s> {
    run: &'s ObservedRun,
    elapsed: String,
    silent: String,
}

/// Renders `index.html`; the same reports give the same bytes.
///
/// # Errors
/// When the template does not fit, which would be a bug.
pub fn render(site: &Site) -> Result<String, ReportError> {
    page(site, &[], None)
}

/// Renders the page that `trackfail serve` shows, with the runs on top, which a script keeps up to date; `now` is in
/// seconds since 1970.
///
/// # Errors
/// As [`render`].
pub fn render_live(site: &Site, running: &[ObservedRun], now: u64) -> Result<String, ReportError> {
    page(site, running, Some(now))
}

fn page(site: &Site, running: &[ObservedRun], now: Option<u64>) -> Result<String, ReportError> {
    let parts = Parts {
        template: include_str!("../templates/site.html"),
        style: concat!(include_str!("../templates/page.css"), include_str!("../templates/site.css")),
        script: include_str!("../templates/site.js"),
    };
    parts.fill(&view(site, running, now))
}

fn view<'s>(site: &'s Site, running: &'s [ObservedRun], now: Option<u64>) -> View<'s> {
    let mut total = ClaimCounts::default();
    for (_, summary) in &site.reports {
        let ClaimCounts { hold, undecided, do_not_hold, cannot_be_tested } = summary.claims;
        let add = |sum: &mut u64, n: u64| *sum = sum.saturating_add(n);
        add(&mut total.hold, hold);
        add(&mut total.undecided, undecided);
        add(&mut total.do_not_hold, do_not_hold);
        add(&mut total.cannot_be_tested, cannot_be_tested);
    }
    let report = |(folder, summary): &'s (String, Summary)| {
        let mut best: Vec<Group<'s>> = Vec::new();
        for b in &summary.best {
            match best.iter_mut().find(|group| group.metric == b.metric) {
                Some(group) => group.best.push(b),
                None => best.push(Group { metric: &b.metric, best: vec![b] }),
            }
        }
        Report { folder, summary, best }
    };
    let clock = now.unwrap_or_default();
    let run = |run: &'s ObservedRun| {
        let end = if run.alive { clock } else { run.snapshot.updated };
        Run {
            run,
            elapsed: duration(end.saturating_sub(run.snapshot.started)),
            silent: duration(clock.saturating_sub(run.snapshot.updated)),
        }
    };
    View {
        reports: site.reports.iter().map(report).collect(),
        total,
        unreadable: &site.unreadable,
        live: now.is_some(),
        running: running.iter().map(run).collect(),
        markdown: MARKDOWN,
        leaderboard: site.reports.iter().any(|(_, s)| !s.standings.is_empty()).then_some(LEADERBOARD),
    }
}

/// `42 s`, `3 min 5 s`, `2 h 10 min`, `3 d 4 h`.
fn duration(seconds: u64) -> String {
    let (minutes, hours, days) = (seconds / 60, seconds / 3600, seconds / 86_400);
    match (days, hours, minutes) {
        (0, 0, 0) => format!("{seconds} s"),
        (0, 0, _) => format!("{minutes} min {} s", seconds % 60),
        (0, _, _) => format!("{hours} h {} min", minutes % 60),
        _ => format!("{days} d {} h", hours % 24),
    }
}

#[cfg(test)]
mod tests {
    use super::duration;

    #[test]
    fn durations_are_short() {
        let shown = [0, 59, 61, 7_800, 90_000].map(duration);
        assert_eq!(shown, ["0 s", "59 s", "1 min 1 s", "2 h 10 min", "1 d 1 h"]);
        assert!(duration(u64::MAX).ends_with(" h"));
    }
}
