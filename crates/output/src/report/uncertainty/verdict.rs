//! The best method or tracker in a sentence and as a figure, with how sure that is. Both read the tables `uncertainty` and
//! `pairs`, so that a page says one thing of a number.

use super::{Competitor, Direction, Field, Measured};
use crate::figure::{Color, Dot, Dots};
use crate::report::colors;
use crate::report::figures::published;
use crate::report::headline::{self, MAX_ROWS, by_chance, estimate, is_beyond_chance, signed_bounds};
use crate::table::layout::{Group, TableLayout};
use crate::table::number::Style;
use trackfail_engine::spec::Experiment;

/// Most trackers that are named one by one.
const MAX_NAMED: usize = 4;
/// Most winners that are named where there are more trackers than that.
const MAX_WINNERS: usize = 3;

/// The best of a field, and the next one.
struct Best<'a> {
    field: &'a str,
    competitor: &'a Competitor,
    value: f64,
    bounds: Option<(f64, f64)>,
    /// It and the next one, as sentences have them.
    spoken: [String; 2],
    /// Value of the next one.
    next_value: f64,
    /// Competitors behind these two that are as good, as printed.
    more: usize,
    /// Bounds of how far the best one is ahead.
    lead: Option<(f64, f64)>,
}

impl Best<'_> {
    /// Whether the next one is as good as it is printed.
    fn ties(&self, style: Style) -> bool {
        style.round(self.value) == style.round(self.next_value)
    }
}

/// A number of a row, from the table's columns in their order.
fn number(group: &Group, row: &str, column: usize) -> Option<f64> {
    group.rows.iter().find(|r| r.label.name == row)?.cells.get(column)?.value
}

/// The bounds of a row, which stand behind its value.
fn bounds(group: &Group, row: &str) -> Option<(f64, f64)> {
    number(group, row, 1).zip(number(group, row, 2))
}

/// `Largest F1 score on KCF: DTEF, 0.31 (95 %: 0.22 to 0.41)...`; `None` where nothing has a value and a rival. The
/// tables are `uncertainty` and `pairs`.
pub(super) fn verdict(
    fields: &[Field],
    [values, pairs]: [&TableLayout; 2],
    measured: &Measured,
) -> Option<String> {
    let best: Vec<Best<'_>> = fields
        .iter()
        .zip(&values.groups)
        .filter_map(|(f, values)| best(f, values, pairs, measured))
        .collect();
    let most = if measured.direction() == Direction::LowerIsBetter { "Smallest" } else { "Largest" };
    // An analysis may have another number of that name, weighted by frames.
    let way = if matches!(measured, Measured::Mean(_)) { ", mean over sequences" } else { "" };
    let (title, style) = (format!("{}{way}", measured.title()), measured.style());
    if let [one] = best.as_slice() {
        let on = if one.field.is_empty() { String::new() } else { format!(" on {}", one.field) };
        if one.ties(style) {
            let bounds = one.lead.map(|lead| signed_bounds(style, lead));
            let bounds = bounds.filter(|_| one.more == 0);
            let bounds = bounds.map_or_else(String::new, |b| format!(" (95 % of their difference: {b})"));
            let ([label, next], value) = (&one.spoken, style.format(one.value));
            let equal = match one.more {
                0 => format!("{label} and {next}"),
                more => format!("{label}, {next} and {more} more"),
            };
            return Some(format!("{most} {title}{on}: {equal} are equal, {value}{bounds}."));
        }
        let shown = estimate(style, one.value, one.bounds);
        let behind = style.format((style.round(one.value) - style.round(one.next_value)).abs());
        let interval = one.lead.map(|lead| format!(" ({})", signed_bounds(style, lead))).unwrap_or_default();
        return Some(format!(
            "{most} {title}{on}: {}, {shown}. The next is {}, behind by {behind}{interval}, {}.",
            one.spoken[0],
            one.spoken[1],
            by_chance(one.lead)
        ));
    }
    // Of many trackers only how many each of the first ones wins; those at the top that are equal as printed win none.
    let by_name = best.len() <= MAX_NAMED;
    let (equal, ahead): (Vec<_>, Vec<_>) = best.iter().partition(|b| b.ties(style));
    let mut winners: Vec<(&str, Vec<String>)> = Vec::new();
    for b in ahead {
        let on = format!("{} {}", b.field, style.format(b.value));
        match winners.iter_mut().find(|(label, _)| *label == b.spoken[0]) {
            Some((_, fields)) => fields.push(on),
            None => winners.push((&b.spoken[0], vec![on])),
        }
    }
    winners.sort_by_key(|(_, fields)| std::cmp::Reverse(fields.len()));
    let (first, others) = winners.split_at(winners.len().min(if by_name { MAX_NAMED } else { MAX_WINNERS }));
    let won = |(label, fields): &(&str, Vec<String>)| match by_name {
        true => format!("{label} on {} ({})", fields.len(), fields.join(", ")),
        false => format!("{label} on {}", fields.len()),
    };
    let mut won: Vec<String> = first.iter().map(won).collect();
    if !others.is_empty() {
        let on: usize = others.iter().map(|(_, fields)| fields.len()).sum();
        let methods = if others.len() == 1 { "method" } else { "methods" };
        won.push(format!("{} more {methods} on {on}", others.len()));
    }
    if !equal.is_empty() {
        won.push(format!("two or more equal at the top on {}", equal.len()));
    }
    let apart = best.iter().filter(|b| is_beyond_chance(b.lead)).count();
    let told = match apart {
        0 => "on none of them is the lead more than chance".to_string(),
        n => format!("on {n} of them the lead is more than chance"),
    };
    // A tracker whose methods have several protocols is there for each of them.
    let what = if best.iter().any(|b| b.field.contains(", ")) { "comparisons" } else { "trackers" };
    (!best.is_empty())
        .then(|| format!("{most} {title}, of {} {what}: {}; {told}.", best.len(), won.join(", ")))
}

/// The name of the best method of each field.
pub(super) fn best_names(
    fields: &[Field],
    [values, pairs]: [&TableLayout; 2],
    measured: &Measured,
) -> Vec<String> {
    let name = |(field, group): (&Field, &Group)| {
        best(field, group, pairs, measured).map(|best| best.competitor.name.clone())
    };
    fields.iter().zip(&values.groups).filter_map(name).collect()
}

/// The best of a field that has another one to be better than.
fn best<'a>(field: &'a Field, values: &Group, pairs: &TableLayout, measured: &Measured) -> Option<Best<'a>> {
    let sign = measured.sign();
    let mut all: Vec<(&Competitor, f64)> =
        field.whole().filter_map(|c| Some((c, number(values, &c.label, 0)?))).collect();
    // Equal ones stay in the order of the experiment.
    all.sort_by(|a, b| (sign * b.1).total_cmp(&(sign * a.1)));
    let [(competitor, value), (next, next_value), ref rest @ ..] = *all.as_slice() else { return None };
    let style = measured.style();
    let more = rest.iter().filter(|(_, other)| style.round(*other) == style.round(value)).count();
    // A difference is in the table once, in one of the two directions.
    let pair = |a: &Competitor, b: &Competitor| {
        let group = pairs.groups.iter().find(|g| g.key == field.label)?;
        bounds(group, &format!("{} against {}", a.label, b.label))
    };
    let ahead = pair(competitor, next).or_else(|| pair(next, competitor).map(|(low, high)| (-high, -low)));
    let lead = ahead.map(|(low, high)| if sign > 0.0 { (low, high) } else { (-high, -low) });
    let spoken = [competitor, next].map(Competitor::spoken);
    let (field, bounds) = (field.label.as_str(), bounds(values, &competitor.label));
    Some(Best { field, competitor, value, bounds, spoken, next_value, more, lead })
}

/// Those that compete with their intervals, the best at the top, a panel for each tracker; `table` holds the numbers.
pub(super) fn dots(
    fields: &[Field],
    table: &TableLayout,
    measured: &Measured,
    (experiment, suite): (&Experiment, &str),
) -> Option<(Dots, String)> {
    let sign = -measured.sign();
    let mut rows: Vec<(&Competitor, f64)> = Vec::new();
    for (field, group) in fields.iter().zip(&table.groups) {
        for competitor in field.whole() {
            if let Some(value) = number(group, &competitor.label, 0)
                && rows.iter().all(|known| known.0.label != competitor.label)
            {
                rows.push((competitor, sign * value));
            }
        }
    }
    rows.sort_by(|a, b| a.1.total_cmp(&b.1));
    let more = rows.len().saturating_sub(MAX_ROWS);
    rows.truncate(MAX_ROWS);
    if rows.len() < 2 {
        return None;
    }
    let panel = |(field, group): (&Field, &Group)| {
        let dot = |label: &str| Some(Dot { value: number(group, label, 0)?, bounds: bounds(group, label) });
        let printed = |name: &str| match measured {
            Measured::Counted(metric) => published::of_metric(experiment, &field.tracker, name, *metric),
            Measured::Mean(_) => None,
        };
        let values = rows.iter().map(|(c, _)| (dot(&c.label), printed(&c.name)));
        (field.label.clone(), values.collect())
    };
    let panels = fields.iter().zip(&table.groups).map(panel).collect();
    let which = if measured.direction() == Direction::LowerIsBetter { "smaller" } else { "larger" };
    let left_out = if more > 0 { format!(" {more} more are in the tables.") } else { String::new() };
    let caption = format!(
        "{} with 95 % bootstrap intervals over sequences; where these overlap by much, the methods cannot be told apart.{left_out} {suite}",
        measured.title()
    );
    let row = |c: &Competitor| (c.spoken(), colors::color(experiment, &c.name));
    let of_methods = matches!(measured, Measured::Counted(_));
    // Trackers are no methods: all have one color.
    let tracker = |c: &Competitor| (c.label.clone(), Color::Blue);
    let rows = rows.into_iter().map(|(c, _)| if of_methods { row(c) } else { tracker(c) }).collect();
    Some((headline::dots(&measured.title(), which, rows, panels), caption))
}
