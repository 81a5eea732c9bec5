//! Standings as the tables `uncertainty` and `pairs`, and mean ranks as a diagram.

use super::{Estimate, Field, Measured, Pair, Standing, Standings};
use crate::figure::{Color, Dot, DotPanel, Dots, Figure};
use crate::report::colors;
use crate::report::layouts::{cell, group, table};
use crate::sampling::LEVEL;
use crate::table::layout::{Cell, Group, Row, TableLayout};
use crate::table::leaderboard::better_first;
use trackfail_core::direction::Direction;
use trackfail_core::num::ranks::{Friedman, critical_difference};

/// A p-value as a table has it.
fn p_cell(p: Option<f64>) -> Cell {
    cell(p, p_text)
}

fn p_text(p: f64) -> String {
    if p < 0.0001 { "<0.0001".to_string() } else { format!("{p:.4}") }
}

/// A row with a number and its bounds, and three further cells.
fn row(
    label: String,
    estimate: Estimate,
    shown: impl Fn(f64) -> String,
    more: [Cell; 3],
) -> (String, Vec<Cell>) {
    (label, estimate.cells(shown).into_iter().chain(more).collect())
}

fn count(n: usize) -> Cell {
    cell(Some(n as f64), |_| n.to_string())
}

/// The difference of mean ranks that is more than chance.
fn critical(friedman: &Friedman) -> f64 {
    let methods = friedman.mean_ranks.len();
    critical_difference(LEVEL, methods, friedman.blocks).unwrap_or(f64::INFINITY)
}

/// A measure with its better end, and how it is computed.
fn words(measured: &Measured) -> (String, &'static str) {
    let better = match measured.direction {
        Direction::HigherIsBetter => "larger is better",
        Direction::LowerIsBetter => "smaller is better",
        Direction::Neither => "neither large nor small is better",
    };
    let way = match measured.metric {
        Some(_) => "from the summed counts of all sequences",
        None => "the mean over sequences",
    };
    (format!("{} ({better})", measured.title), way)
}

/// The table `uncertainty`: every number with its interval and its mean rank.
pub fn intervals(of: &Standings) -> TableLayout {
    let measured = &of.measured;
    let of_field = |field: &Field| {
        let p = field.friedman.as_ref().and_then(|friedman| friedman.test).map(|(_, p)| p);
        let tested = field.friedman.as_ref().map(|f| {
            let p = p.map_or_else(|| "no differences".to_string(), |p| format!("Friedman's p {}", p_text(p)));
            format!("ranks over {} sequences, {p}, critical difference {:.2}", f.blocks, critical(f))
        });
        let heading = match (field.label.as_str(), tested) {
            (label, None) => label.to_string(),
            ("", Some(tested)) => tested,
            (label, Some(tested)) => format!("{label} ({tested})"),
        };
        let of_standing = |s: &Standing| {
            let rank = cell(s.mean_rank, |v| format!("{v:.2}"));
            let more = [count(s.counts.len()), rank, p_cell(s.mean_rank.and(p))];
            row(s.label.clone(), s.estimate, |v| measured.style.format(v), more)
        };
        group(&field.label, heading, field.standings.iter().map(of_standing).collect())
    };
    let (who, not_ranked) = match measured.metric {
        Some(_) => ("method", " Anchors are not ranked, and of a grid only the published point."),
        None => ("tracker", ""),
    };
    let (what, way) = words(measured);
    let caption =
        format!("{what}, {way}, with 95 % intervals over sequences, and mean rank, 1 the best.{not_ranked}");
    let columns = [measured.title.as_str(), "95 % from", "95 % to", "sequences", "mean rank", "Friedman's p"];
    table("uncertainty", caption, who, &columns, of.fields.iter().map(of_field).collect())
}

/// The rows of the table `uncertainty` that are ranked, the best of each field first.
pub fn ranked(of: &Standings, mut table: TableLayout) -> TableLayout {
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

/// The table `pairs`: differences of two of a field, with their test.
pub fn pairs(of: &Standings) -> TableLayout {
    let of_pair = |pair: &Pair| {
        let more = [p_cell(pair.p), p_cell(pair.corrected), count(pair.sequences)];
        row(pair.labels.join(" against "), pair.difference, |v| of.measured.style.format_signed(v), more)
    };
    let of_field =
        |field: &Field| group(&field.label, field.label.clone(), field.pairs.iter().map(of_pair).collect());
    let (what, way) = words(&of.measured);
    let caption = format!(
        "Difference of {what} on the same sequences, {way}, with 95 % intervals and p of a permutation test, by itself and \
         after Holm's correction."
    );
    let columns = ["difference", "95 % from", "95 % to", "p", "p (Holm)", "sequences"];
    let fields = of.fields.iter().filter(|field| !field.pairs.is_empty());
    table("pairs", caption, "pair", &columns, fields.map(of_field).collect())
}

/// Most methods of a ranking, and most rankings, that a figure can be read with.
const MAX: (usize, usize) = (12, 8);

/// The mean ranks of a field as dots with bars as long as the critical difference of Nemenyi's test (Demsar, Journal of
/// Machine Learning Research 7, 2006), so that two methods differ where their bars do not touch.
fn ranking(field: &Field) -> Option<(Vec<&str>, DotPanel)> {
    let friedman = field.friedman.as_ref()?;
    let half = critical(friedman) / 2.0;
    let rank = |s: &'_ Standing| s.mean_rank;
    let ranked = || field.standings.iter().filter(|s| rank(s).is_some());
    let dot = |rank: f64| Dot { value: rank, bounds: Some((rank - half, rank + half)) };
    let label = format!("{} ({} sequences)", field.label, friedman.blocks);
    let values = ranked().map(|s| rank(s).map(dot)).collect();
    Some((ranked().map(|s| s.name.as_str()).collect(), DotPanel { label, values, ..DotPanel::default() }))
}

/// The mean ranks of all fields as a figure with its caption, or the reason why there is none; `None` without ranks.
pub fn diagram(of: &Standings, suite: &str) -> Option<Result<(Figure, String), String>> {
    let title = &of.measured.title;
    let rankings: Vec<(Vec<&str>, DotPanel)> = of.fields.iter().filter_map(ranking).collect();
    let most = rankings.iter().map(|(names, _)| names.len()).max()?;
    if most > MAX.0 || rankings.len() > MAX.1 {
        let (n, what) = if most > MAX.0 { (most, "methods") } else { (rankings.len(), "rankings") };
        return Some(Err(format!(
            "Mean ranks by {title} are in the table `uncertainty` alone: {n} {what} are more than a diagram can show."
        )));
    }
    let caption = format!(
        "Mean ranks by {title}, 1 the best, with half the critical difference of Nemenyi's test at 5 % on either side: \
         methods whose bars touch cannot be told apart. {suite}"
    );
    let mut all = of.fields.iter().flat_map(|f| &f.standings);
    let has_grid = all.any(|s| s.competes && s.label != s.name);
    let at = if has_grid { "; a method with a grid is at its published parameters" } else { "" };
    let color = |name: &&str| if of.measured.metric.is_some() { colors::of_name(name) } else { Color::Blue };
    let mut figure = Figure::default();
    // Trackers with the same methods stand beside each other.
    for same in rankings.chunk_by(|a, b| a.0 == b.0) {
        let dots = Dots {
            title: String::new(),
            note: format!("Mean rank by {title}, 1 the best{at}"),
            rows: same[0].0.iter().map(ToString::to_string).collect(),
            panels: same.iter().map(|(_, panel)| panel.clone()).collect(),
            shared_axis: true,
            colors: same[0].0.iter().map(color).collect(),
            chance: None,
        };
        let Figure { rows, note, form, .. } = dots.figure();
        figure = Figure { note, form, ..figure };
        figure.rows.extend(rows);
    }
    Some(Ok((figure, caption)))
}
