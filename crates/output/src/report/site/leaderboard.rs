//! `reports/leaderboard.html`: all methods of all experiments with `leaderboard = true`, with the trackers of
//! an experiment pooled. The page tells which detector to use with the inputs at hand.
//!
//! All methods are ranked on the same data: by AUROC in the experiment with at least [`MIN_SEQUENCES`]
//! sequences that ran most of the program's methods, on real video if there is any. Methods that only this
//! experiment defines are ranked, too. Methods that it did not run are listed with their rank in another
//! experiment. Anchors have no rank. A best method is named only if its interval is above chance.

use super::{Site, Standing, Summary};
use crate::report::figures::lines::distinct;
use crate::report::page::{ReportError, fill};
use crate::report::standings::CHANCE;
use crate::results::grouped;
use crate::table::leaderboard::better_first;
use serde::Serialize;
use serde_json::{Value, json};
use trackfail_core::direction::Direction::HigherIsBetter;
use trackfail_judge::method::names;
use trackfail_methods::score::frames::bootstrap::MIN_SEQUENCES;

/// Name of the page.
pub const LEADERBOARD: &str = "leaderboard.html";

/// Order in which needs are shown. Inputs that any tracker provides come first.
const NEEDS: [&str; 6] = [
    "boxes alone",
    "frames",
    "other trackers' boxes",
    "the tracker's confidence",
    "the tracker's response map",
    "the tracker's posterior",
];

/// An experiment: a column of the page.
#[derive(Serialize)]
struct Experiment<'s> {
    folder: &'s str,
    summary: &'s Summary,
    /// Methods of the experiment, the best first.
    standings: Vec<&'s Standing>,
    /// Rank of each method: `3`, or `3=` if shared. Empty for anchors, methods without a value, and with too
    /// few sequences.
    ranks: Vec<String>,
}

/// A method with its standing in each experiment.
#[derive(Serialize)]
struct Row<'s> {
    /// Rank in the first experiment; empty for an unranked method.
    rank: &'s str,
    /// Reason why the method is unranked; else empty.
    reason: String,
    /// Standing from which the cost is shown.
    method: &'s Standing,
    standings: Vec<Option<&'s Standing>>,
}

fn auroc(standing: &Standing) -> Option<f64> {
    standing.auroc.value.parse().ok().filter(|value: &f64| value.is_finite())
}

/// True if an experiment has enough sequences for ranks.
fn is_large(summary: &Summary) -> bool {
    summary.present >= MIN_SEQUENCES as u64
}

/// Methods with these needs that have the largest AUROC, as printed, and true if their intervals are above
/// chance.
fn best(experiment: &Experiment<'_>, needs: Option<&str>) -> Option<Value> {
    let fits = |s: &&&Standing| !s.anchor && auroc(s).is_some() && needs.is_none_or(|n| s.needs == n);
    let first = experiment.standings.iter().find(fits)?;
    let ties = experiment.standings.iter().filter(fits).filter(|s| auroc(s) == auroc(first));
    let is_above = |s: &&Standing| s.auroc.low.parse::<f64>().is_ok_and(|low| low > CHANCE);
    let standings: Vec<&Standing> = ties.copied().collect();
    Some(json!({ "standings": standings, "is_better": standings.iter().all(is_above) }))
}

/// All experiments with standings, the ranking one first: among those on real video with enough sequences,
/// the one with most of the program's methods.
fn experiments<'s>(site: &'s Site) -> Vec<Experiment<'s>> {
    let experiment = |(folder, summary): &'s (String, Summary)| {
        let mut standings: Vec<&Standing> = summary.standings.iter().collect();
        standings
            .sort_by(|a, b| a.anchor.cmp(&b.anchor).then(better_first(auroc(a), auroc(b), HigherIsBetter)));
        let value = |s: &Standing| auroc(s).filter(|_| !s.anchor && is_large(summary));
        let rank = |one: &&Standing| {
            let Some(mine) = value(one) else { return String::new() };
            let all = || standings.iter().filter_map(|s| value(s));
            let above = all().filter(|v| *v > mine).count();
            format!("{}{}", 1 + above, if all().filter(|v| *v == mine).count() > 1 { "=" } else { "" })
        };
        let ranks = standings.iter().map(rank).collect();
        Experiment { folder, summary, standings, ranks }
    };
    let ranked = site.reports.iter().filter(|(_, summary)| !summary.standings.is_empty());
    let mut all: Vec<Experiment<'s>> = ranked.map(experiment).collect();
    let key = |e: &Experiment<'_>| {
        let methods = e.standings.iter().filter(|s| names().contains(&s.method.as_str())).count();
        (is_large(e.summary), !e.summary.synthetic, methods, e.summary.present)
    };
    // The first of equal ones.
    if let Some(k) = (0..all.len()).rev().max_by_key(|k| key(&all[*k])) {
        all[..=k].rotate_right(1);
    }
    all
}

/// All methods: the ranked ones in order, then the others with the reason, anchors last.
fn rows<'s>(experiments: &'s [Experiment<'s>]) -> Vec<Row<'s>> {
    let standings = experiments.iter().flat_map(|e| e.standings.iter().copied());
    let methods = grouped(standings, |standing| standing.method.as_str());
    let place = |e: &Experiment<'s>, s: &Standing| e.standings.iter().position(|of| of.method == s.method);
    let row = |(_, same): (&str, Vec<&'s Standing>)| {
        // The first with a cost, else the last.
        let method = same.iter().copied().find(|s| !s.cost.is_empty()).unwrap_or(same[same.len() - 1]);
        let standings: Vec<Option<&Standing>> =
            experiments.iter().map(|e| Some(e.standings[place(e, method)?])).collect();
        let rank = |e: &'s Experiment<'s>| place(e, method).map_or("", |k| e.ranks[k].as_str());
        let own = experiments.first().map_or("", rank);
        let reason = match experiments.iter().find(|e| !rank(e).is_empty()) {
            _ if !own.is_empty() => String::new(),
            _ if method.anchor => "anchor".to_string(),
            None => format!("tested on fewer than {MIN_SEQUENCES} sequences"),
            Some(e) => {
                let of = e.standings.iter().filter(|s| !s.anchor).count();
                format!("rank {} of {of} in {}", rank(e), e.folder)
            }
        };
        Row { rank: own, reason, method, standings }
    };
    let mut rows: Vec<Row<'s>> = methods.into_iter().map(row).collect();
    let value =
        |row: &Row<'s>| row.standings.first().filter(|_| !row.rank.is_empty()).and_then(|s| auroc((*s)?));
    rows.sort_by(|a, b| {
        let by_value = better_first(value(a), value(b), HigherIsBetter);
        a.method.anchor.cmp(&b.method.anchor).then(by_value).then(a.method.method.cmp(&b.method.method))
    });
    rows
}

/// Renders the page; `None` if no experiment has `leaderboard = true`.
///
/// # Errors
/// When the template does not fit, which would be a bug.
pub fn render(site: &Site) -> Result<Option<String>, ReportError> {
    let experiments = experiments(site);
    if experiments.is_empty() {
        return Ok(None);
    }
    let competing = |e: &Experiment<'_>| e.standings.iter().filter(|s| !s.anchor).count();
    let asked: Vec<&Experiment<'_>> =
        experiments.iter().filter(|e| is_large(e.summary) && competing(e) > 1).collect();
    let compared = asked.iter().flat_map(|e| &e.standings).filter(|s| !s.anchor);
    let needs = distinct(NEEDS.into_iter().chain(compared.map(|s| s.needs.as_str())));
    let answer = |needs: &str| asked.iter().map(|e| best(e, Some(needs))).collect::<Vec<_>>();
    let answers = needs.into_iter().map(|needs| (needs, answer(needs)));
    let answers = answers.filter(|(_, best)| best.iter().any(Option::is_some));
    let about = json!({
        // The best method in the ranking experiment.
        "best": asked.first().and_then(|base| best(base, None)),
        // For each kind of need, the best method in each experiment that is asked.
        "answers": answers.collect::<Vec<_>>(),
        "rows": rows(&experiments),
        "asked": asked,
        "experiments": experiments,
    });
    let style = concat!(include_str!("../templates/page.css"), include_str!("../templates/leaderboard.css"));
    fill(include_str!("../templates/leaderboard.html"), style, "", &about).map(Some)
}
