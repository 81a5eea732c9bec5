//! `reports/leaderboard.html`: every method on every experiment that asks for it (`leaderboard = true`), with all trackers
//! of an experiment pooled. It answers which detector to use with what is at hand.
//!
//! The first table has, for each thing that a method may need, the method with the largest AUROC of each experiment. The
//! second has all methods, anchors last, in the order of their mean AUROC over the experiments on real video (over all, without any). A
//! mean is over the experiments in which a method was run, and says over how many.

use super::collect::Site;
use super::standing::Standing;
use super::summary::Summary;
use crate::report::html::Parts;
use crate::report::page::ReportError;
use serde::Serialize;
use std::collections::BTreeMap;

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

#[derive(Serialize)]
struct View<'s> {
    experiments: Vec<Experiment<'s>>,
    answers: Vec<Answer<'s>>,
    rows: Vec<Row<'s>>,
    mean_over: &'static str,
}

/// A column of the page.
#[derive(Serialize)]
struct Experiment<'s> {
    folder: &'s str,
    title: &'s str,
    data: &'s str,
    suite: &'s str,
    synthetic: bool,
    trackers: u64,
}

/// The best method of each experiment among those that need one thing.
#[derive(Serialize)]
struct Answer<'s> {
    needs: &'s str,
    best: Vec<Option<&'s Standing>>,
}

/// A method with its standing in each experiment.
#[derive(Serialize)]
struct Row<'s> {
    method: &'s str,
    needs: &'s str,
    anchor: bool,
    cost: &'s str,
    mean: String,
    of: usize,
    standings: Vec<Option<&'s Standing>>,
}

fn auroc(standing: &Standing) -> Option<f64> {
    standing.auroc.value.parse().ok()
}

/// The best method with this need by AUROC, anchors aside; the first among equals.
fn best<'s>(summary: &'s Summary, needs: &str) -> Option<&'s Standing> {
    let competing = summary.standings.iter().filter(|s| !s.anchor && s.needs == needs);
    let valued = competing.filter_map(|s| Some((auroc(s)?, s)));
    valued.reduce(|best, next| if next.0 > best.0 { next } else { best }).map(|(_, standing)| standing)
}

fn view(site: &Site) -> View<'_> {
    let reports = site.reports.iter().map(|(folder, summary)| (folder.as_str(), summary));
    let with: Vec<(&str, &Summary)> = reports.filter(|(_, s)| !s.standings.is_empty()).collect();
    let any_real = with.iter().any(|(_, s)| !s.synthetic);
    let answer = |needs: &'static str| {
        let best: Vec<Option<&Standing>> = with.iter().map(|(_, s)| best(s, needs)).collect();
        best.iter().any(Option::is_some).then_some(Answer { needs, best })
    };
    // The standing of each method that says most of its cost.
    let mut methods: BTreeMap<&str, &Standing> = BTreeMap::new();
    for standing in with.iter().flat_map(|(_, s)| &s.standings) {
        let known = methods.entry(&standing.method).or_insert(standing);
        if known.cost.is_empty() {
            *known = standing;
        }
    }
    let mut rows: Vec<Row<'_>> = methods.into_values().map(|first| row(first, &with, any_real)).collect();
    // Texts of three digits compare as their numbers do; a method without a mean comes last.
    rows.sort_by(|a, b| a.anchor.cmp(&b.anchor).then(b.mean.cmp(&a.mean)).then(a.method.cmp(b.method)));
    let experiments = with.iter().map(|(folder, s)| Experiment {
        folder,
        title: &s.title,
        data: &s.data,
        suite: &s.suite,
        synthetic: s.synthetic,
        trackers: s.standings.iter().map(|s| s.trackers).max().unwrap_or(0),
    });
    View {
        experiments: experiments.collect(),
        answers: NEEDS.into_iter().filter_map(answer).collect(),
        rows,
        mean_over: if any_real {
            "experiments on real video"
        } else {
            "experiments, none of them on real video"
        },
    }
}

/// A method's row; `real` leaves synthetic experiments out of its mean.
fn row<'s>(first: &'s Standing, with: &[(&'s str, &'s Summary)], real: bool) -> Row<'s> {
    let mine = |summary: &'s Summary| summary.standings.iter().find(|s| s.method == first.method);
    let counted = with.iter().filter(|(_, s)| !(real && s.synthetic));
    let values: Vec<f64> = counted.filter_map(|(_, s)| auroc(mine(s)?)).collect();
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    Row {
        method: &first.method,
        needs: &first.needs,
        anchor: first.anchor,
        cost: &first.cost,
        mean: if values.is_empty() { String::new() } else { format!("{mean:.3}") },
        of: values.len(),
        standings: with.iter().map(|(_, s)| mine(s)).collect(),
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
