//! `reports/leaderboard.html`: every method on every experiment that asks for it (`leaderboard = true`), with all trackers
//! of an experiment pooled. It answers which detector to use with what is at hand.
//!
//! Methods are ranked on the same data: by their AUROC in the one experiment of at least [`MIN_SEQUENCES`] sequences that ran
//! most methods of the program, on real video where there is any. All methods of that experiment are, also those that it makes
//! for itself; methods that were not run there have their place in an experiment that ran them; anchors have none. A best one
//! is named only where its interval is above chance.

use super::collect::Site;
use super::standing::Standing;
use crate::report::differences::CHANCE;
use crate::report::html::Parts;
use crate::report::page::ReportError;
use serde::Serialize;
use std::cmp::Ordering;
use trackfail_judge::method::names;
use trackfail_methods::score::frames::bootstrap::MIN_SEQUENCES;

/// Name of the page.
pub const LEADERBOARD: &str = "leaderboard.html";

/// The order in which needs are shown: what comes with any tracker first.
const NEEDS: [&str; 6] = [
    "boxes alone",
    "frames",
    "other trackers' boxes",
    "the tracker's confidence",
    "the tracker's response map",
    "the tracker's posterior",
];

/// How many of these are at hand for most trackers; the verdict names their methods.
const MOST_HAVE: usize = 3;

#[derive(Serialize)]
struct View<'s> {
    verdict: Vec<String>,
    /// All experiments, that of the ranks first.
    experiments: Vec<Experiment<'s>>,
    /// Those of them that are asked for the best method.
    asked: Vec<Experiment<'s>>,
    answers: Vec<Answer<'s>>,
    rows: Vec<Row<'s>>,
    has_cost: bool,
}

/// A column of the page.
#[derive(Serialize, Clone)]
struct Experiment<'s> {
    folder: &'s str,
    title: &'s str,
    data: &'s str,
    suite: &'s str,
    synthetic: bool,
    sequences: u64,
    trackers: u64,
    /// Its methods, the best first.
    standings: Vec<&'s Standing>,
    /// The rank of each of them there, see [`rank_in`].
    ranks: Vec<String>,
}

/// The best method of each experiment among those that need one thing.
#[derive(Serialize)]
struct Answer<'s> {
    needs: &'s str,
    best: Vec<Best<'s>>,
}

/// The best method of an experiment with some needs.
#[derive(Serialize)]
struct Best<'s> {
    standings: Vec<&'s Standing>,
    /// Whether its interval is above chance.
    is_better: bool,
}

/// A method with its standing in each experiment.
#[derive(Serialize)]
struct Row<'s> {
    /// `3`, or `3=` where another one has it too; empty where it is not ranked.
    rank: String,
    /// Why it is not.
    reason: String,
    method: &'s str,
    needs: &'s str,
    anchor: bool,
    cost: &'s str,
    standings: Vec<Option<&'s Standing>>,
}

fn auroc(standing: &Standing) -> Option<f64> {
    standing.auroc.value.parse().ok()
}

/// Whether a method can be the best: it is no anchor.
fn competes(standing: &Standing) -> bool {
    !standing.anchor
}

/// Rank of a method among those of an experiment, `3`, or `3=` where another one has it too; empty for anchors, without a value,
/// and with too few sequences.
fn rank_in(standings: &[&Standing], sequences: u64, standing: &Standing) -> String {
    let value = |s: &Standing| auroc(s).filter(|_| competes(s) && sequences >= MIN_SEQUENCES as u64);
    let Some(mine) = value(standing) else { return String::new() };
    let all = || standings.iter().filter_map(|s| value(s));
    let above = all().filter(|v| *v > mine).count();
    format!("{}{}", 1 + above, if all().filter(|v| *v == mine).count() > 1 { "=" } else { "" })
}

/// Larger values first, as they are printed; what has none comes last.
fn better_first(a: Option<f64>, b: Option<f64>) -> Ordering {
    let key = |v: Option<f64>| v.unwrap_or(f64::NEG_INFINITY);
    key(b).total_cmp(&key(a))
}

/// The methods with these needs that have the largest AUROC as printed.
fn best<'s>(experiment: &Experiment<'s>, needs: Option<&str>) -> Option<Best<'s>> {
    let fits = |s: &&&Standing| competes(s) && auroc(s).is_some() && needs.is_none_or(|n| s.needs == n);
    let first = experiment.standings.iter().find(fits)?;
    let ties = experiment.standings.iter().filter(fits).filter(|s| auroc(s) == auroc(first));
    let is_above = |s: &&Standing| s.auroc.low.parse::<f64>().is_ok_and(|low| low > CHANCE);
    let standings: Vec<&Standing> = ties.copied().collect();
    let is_better = standings.iter().all(is_above);
    Some(Best { standings, is_better })
}

/// All experiments with standings, the one that the ranks are of first: of those on real video and of enough sequences it
/// has most methods of the program.
fn experiments(site: &Site) -> Vec<Experiment<'_>> {
    let mut all: Vec<Experiment<'_>> = Vec::new();
    for (folder, s) in site.reports.iter().filter(|(_, s)| !s.standings.is_empty()) {
        let mut standings: Vec<&Standing> = s.standings.iter().collect();
        standings.sort_by(|a, b| a.anchor.cmp(&b.anchor).then(better_first(auroc(a), auroc(b))));
        let ranks = standings.iter().map(|one| rank_in(&standings, s.present, one)).collect();
        all.push(Experiment {
            folder,
            title: &s.title,
            data: &s.data,
            suite: &s.suite,
            synthetic: s.synthetic,
            sequences: s.present,
            trackers: s.standings.iter().map(|s| s.trackers).max().unwrap_or(0),
            standings,
            ranks,
        });
    }
    let key = |e: &Experiment<'_>| {
        let methods = e.standings.iter().filter(|s| names().contains(&s.method.as_str())).count();
        (e.sequences >= MIN_SEQUENCES as u64, !e.synthetic, methods, e.sequences)
    };
    // The first of equal ones.
    if let Some(k) = (0..all.len()).rev().max_by_key(|k| key(&all[*k])) {
        all[..=k].rotate_right(1);
    }
    all
}

/// All methods: those that are ranked in their order, then the others with the reason, anchors last.
fn rows<'s>(experiments: &[Experiment<'s>]) -> Vec<Row<'s>> {
    let mut methods: Vec<&Standing> = Vec::new();
    for standing in experiments.iter().flat_map(|e| &e.standings) {
        match methods.iter_mut().find(|known| known.method == standing.method) {
            None => methods.push(standing),
            // The one that says its cost.
            Some(known) if known.cost.is_empty() => *known = standing,
            Some(_) => {}
        }
    }
    let Some(base) = experiments.first() else { return Vec::new() };
    let of = |e: &Experiment<'s>, method: &str| e.standings.iter().find(|s| s.method == method).copied();
    let rank = |e: &Experiment<'s>, method: &str| {
        let place = e.standings.iter().position(|s| s.method == method)?;
        e.ranks.get(place).cloned().filter(|rank| !rank.is_empty())
    };
    let row = |s: &&'s Standing| {
        let elsewhere = || experiments.iter().find_map(|e| Some((e, rank(e, &s.method)?)));
        let rank = rank(base, &s.method).unwrap_or_default();
        let reason = match (rank.as_str(), elsewhere()) {
            ("", _) if s.anchor => "anchor".to_string(),
            ("", None) => format!("tested on fewer than {MIN_SEQUENCES} sequences"),
            ("", Some((e, rank))) => {
                let of = e.standings.iter().filter(|s| competes(s)).count();
                format!("rank {rank} of {of} in {}", e.folder)
            }
            _ => String::new(),
        };
        let standings = experiments.iter().map(|e| of(e, &s.method)).collect();
        let value = of(base, &s.method).filter(|_| !rank.is_empty()).and_then(auroc);
        (
            value,
            Row {
                rank,
                reason,
                method: &s.method,
                needs: &s.needs,
                anchor: s.anchor,
                cost: &s.cost,
                standings,
            },
        )
    };
    let mut rows: Vec<(Option<f64>, Row<'s>)> = methods.iter().map(row).collect();
    rows.sort_by(|a, b| {
        a.1.anchor.cmp(&b.1.anchor).then(better_first(a.0, b.0)).then(a.1.method.cmp(b.1.method))
    });
    rows.into_iter().map(|(_, row)| row).collect()
}

/// The verdict of the page in a sentence or two: the best method of all, and with each thing that most trackers have.
fn verdict(base: &Experiment<'_>) -> Vec<String> {
    let names = |best: &Best<'_>| {
        let names: Vec<&str> = best.standings.iter().map(|s| s.method.as_str()).collect();
        names.join(" and ")
    };
    let Some(first) = best(base, None) else { return Vec::new() };
    let auroc = &first.standings[0].auroc;
    let interval = if auroc.low.is_empty() {
        String::new()
    } else {
        format!(" (95 %: {} to {})", auroc.low, auroc.high)
    };
    let is_better = if first.is_better { "" } else { ", which is not beyond chance" };
    let overall = format!(
        "{} {} lost frames from good ones best: AUROC {}{interval}{is_better}, on {} sequences of {}.",
        names(&first),
        if first.standings.len() == 1 { "tells" } else { "tell" },
        auroc.value,
        base.sequences,
        base.folder
    );
    let with = |needs: &&str| {
        let best = best(base, Some(needs))?;
        Some(match best.is_better {
            true => format!("with {needs} it is {} ({})", names(&best), best.standings[0].auroc.value),
            false => format!("with {needs} none is better than chance"),
        })
    };
    let by_need: Vec<String> = NEEDS[..MOST_HAVE].iter().filter_map(with).collect();
    if by_need.is_empty() {
        return vec![overall];
    }
    // The sentence begins with its first `with`.
    let by_need = by_need.join("; ").replacen('w', "W", 1);
    vec![format!("{overall} {by_need}.")]
}

fn view(site: &Site) -> View<'_> {
    let experiments = experiments(site);
    let competing = |e: &Experiment<'_>| e.standings.iter().filter(|s| competes(s)).count();
    let is_asked = |e: &&Experiment<'_>| e.sequences >= MIN_SEQUENCES as u64 && competing(e) > 1;
    let asked: Vec<Experiment<'_>> = experiments.iter().filter(is_asked).cloned().collect();
    let mut needs: Vec<&str> = NEEDS.into();
    for standing in asked.iter().flat_map(|e| &e.standings).filter(|s| competes(s)) {
        if !needs.contains(&standing.needs.as_str()) {
            needs.push(&standing.needs);
        }
    }
    let mut answers: Vec<Answer<'_>> = Vec::new();
    for needs in &needs {
        let best: Vec<Option<Best<'_>>> = asked.iter().map(|e| best(e, Some(needs))).collect();
        if best.iter().any(Option::is_some) {
            let none = || Best { standings: Vec::new(), is_better: false };
            answers.push(Answer { needs, best: best.into_iter().map(|b| b.unwrap_or_else(none)).collect() });
        }
    }
    let rows = rows(&experiments);
    View {
        verdict: asked.first().map_or_else(Vec::new, |base| verdict(base)),
        has_cost: rows.iter().any(|row| !row.cost.is_empty()),
        asked,
        answers,
        rows,
        experiments,
    }
}

/// Renders the page; `None` if no experiment asks for it.
///
/// # Errors
/// When the template does not fit, which would be a bug.
pub fn render(site: &Site) -> Result<Option<String>, ReportError> {
    let view = view(site);
    if view.experiments.is_empty() {
        return Ok(None);
    }
    let parts = Parts {
        template: include_str!("../templates/leaderboard.html"),
        style: concat!(include_str!("../templates/page.css"), include_str!("../templates/leaderboard.css")),
        script: "",
    };
    parts.fill(&view).map(Some)
}
