//! Standings as the tables `uncertainty` and `pairs`, and mean ranks as a diagram.

use super::{Field, Pair, Standing, Standings};
use crate::figure::{Color, Dot, DotPanel, Dots, Figure};
use crate::report::{colors, sentences::say};
use crate::sampling::LEVEL;
use crate::table::build::{cell, group, number, table};
use crate::table::layout::{Cell, Group, Row, TableLayout};
use crate::table::leaderboard::better_first;
use crate::table::number::{Style, p_value};
use serde_json::json;
use trackfail_core::num::ranks::{Friedman, critical_difference};

fn count(n: usize) -> Cell {
    number(Some(n as f64), Style::COUNT)
}

/// Critical difference of mean ranks, above which two methods differ beyond chance.
fn critical(friedman: &Friedman) -> f64 {
    let methods = friedman.mean_ranks.len();
    critical_difference(LEVEL, methods, friedman.blocks).unwrap_or(f64::INFINITY)
}

/// Table `uncertainty`: each number with its interval and its mean rank.
pub fn intervals(of: &Standings) -> TableLayout {
    let measured = &of.measured;
    let of_field = |field: &Field| {
        let p = field.friedman.as_ref().and_then(|friedman| friedman.test).map(|(_, p)| p);
        let ranked = field.friedman.as_ref().map(|friedman| {
            let critical = format!("{:.2}", critical(friedman));
            json!({ "blocks": friedman.blocks, "p": p.map(p_value), "critical": critical })
        });
        let of_standing = |s: &Standing| {
            let rank = cell(s.mean_rank, |v| format!("{v:.2}"));
            let more = [count(s.counts.len()), rank, cell(s.mean_rank.and(p), p_value)];
            (s.label.clone(), [s.estimate.cells(|v| measured.style.format(v)), more].concat())
        };
        let heading = say("ranks heading", json!({ "label": field.label, "ranked": ranked }));
        group(&field.label, heading, field.standings.iter().map(of_standing))
    };
    let who = if measured.metric.is_some() { "method" } else { "tracker" };
    let columns = [measured.title.as_str(), "95 % from", "95 % to", "sequences", "mean rank", "Friedman's p"];
    let groups = of.fields.iter().map(of_field).collect();
    table("uncertainty", say("uncertainty", measured.told()), who, columns, groups)
}

/// Ranked rows of the table `uncertainty`, the best of each field first.
pub fn ranked(of: &Standings) -> TableLayout {
    let mut table = intervals(of);
    let of_field = |(group, field): (Group, &Field)| {
        let rows = group.rows.into_iter().zip(&field.standings);
        let mut rows: Vec<(Row, &Standing)> = rows.filter(|(_, s)| s.competes).collect();
        let value = |row: &(Row, &Standing)| row.1.estimate.value;
        rows.sort_by(|a, b| better_first(value(a), value(b), of.measured.direction));
        rows.iter_mut().for_each(|(row, s)| row.label.shown = s.spoken());
        Group { rows: rows.into_iter().map(|(row, _)| row).collect(), ..group }
    };
    table.groups = table.groups.into_iter().zip(&of.fields).map(of_field).collect();
    table.groups.retain(|group| !group.rows.is_empty());
    table.caption.push_str(" Here are those that are ranked; the table below has all.");
    table
}

/// Table `pairs`: differences between two standings of a field, with tests; `None` without any.
pub fn pairs(of: &Standings) -> Option<TableLayout> {
    let of_pair = |pair: &Pair| {
        let more = [cell(pair.p, p_value), cell(pair.corrected, p_value), count(pair.sequences)];
        let difference = pair.difference.cells(|v| of.measured.style.format_signed(v));
        (pair.labels.join(" against "), [difference, more].concat())
    };
    let of_field = |field: &Field| group(&field.label, field.label.clone(), field.pairs.iter().map(of_pair));
    let columns = ["difference", "95 % from", "95 % to", "p", "p (Holm)", "sequences"];
    let groups: Vec<Group> = of.fields.iter().filter(|f| !f.pairs.is_empty()).map(of_field).collect();
    let caption = || say("pairs", of.measured.told());
    (!groups.is_empty()).then(|| table("pairs", caption(), "pair", columns, groups))
}

/// Most methods of a ranking, and most rankings, in a readable figure.
const MAX: (usize, usize) = (12, 8);

/// Mean ranks of a field as dots, with bars of half the critical difference of Nemenyi's test (Demsar,
/// Journal of Machine Learning Research 7, 2006) to each side. Two methods differ if their bars do not touch.
fn ranking(field: &Field) -> Option<(Vec<&str>, DotPanel)> {
    let friedman = field.friedman.as_ref()?;
    let half = critical(friedman) / 2.0;
    let dot = |rank: f64| Dot { value: rank, bounds: Some((rank - half, rank + half)) };
    let ranked = field.standings.iter().filter_map(|s| Some((s.name.as_str(), Some(dot(s.mean_rank?)))));
    let (names, values) = ranked.unzip();
    let label = format!("{} ({} sequences)", field.label, friedman.blocks);
    Some((names, DotPanel { label, values, ..DotPanel::default() }))
}

/// Mean ranks of all fields as a figure with its caption, or the reason why there is no figure; `None`
/// without ranks.
pub fn diagram(of: &Standings, suite: &str) -> Option<Result<(Figure, String), String>> {
    let title = &of.measured.title;
    let rankings: Vec<(Vec<&str>, DotPanel)> = of.fields.iter().filter_map(ranking).collect();
    let most = rankings.iter().map(|(names, _)| names.len()).max()?;
    if most > MAX.0 || rankings.len() > MAX.1 {
        let (n, what) = if most > MAX.0 { (most, "methods") } else { (rankings.len(), "rankings") };
        return Some(Err(say("no ranks", json!({ "title": title, "n": n, "what": what }))));
    }
    let mut all = of.fields.iter().flat_map(|f| &f.standings);
    let has_grid = all.any(|s| s.competes && s.label != s.name);
    let at = if has_grid { "; a method with a grid is at its published parameters" } else { "" };
    let color = |name: &&str| if of.measured.metric.is_some() { colors::of_name(name) } else { Color::BLUE };
    let mut figure = Figure::default();
    // Trackers with the same methods stand beside each other.
    for same in rankings.chunk_by(|a, b| a.0 == b.0) {
        let dots = Dots {
            note: format!("Mean rank by {title}, 1 the best{at}"),
            rows: same[0].0.iter().map(ToString::to_string).collect(),
            panels: same.iter().map(|(_, panel)| panel.clone()).collect(),
            shared_axis: true,
            colors: same[0].0.iter().map(color).collect(),
            ..Dots::default()
        };
        let below = dots.figure();
        figure = Figure { rows: [figure.rows, below.rows].concat(), ..below };
    }
    Some(Ok((figure, say("ranks", json!({ "title": title, "suite": suite })))))
}
