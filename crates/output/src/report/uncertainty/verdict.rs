//! The best method or tracker in a sentence and as a figure, with how sure that is.

use super::{Competitor, DRAWS, Direction, Drawn, Field, LEVEL, MIN_SEQUENCES, Measured, duel};
use crate::figure::{Dot, DotPanel, Dots};
use crate::num::seed;
use crate::table::layout::{Group, TableLayout};

/// Most trackers that are named one by one.
const MAX_NAMED: usize = 4;

/// The best of a field, and what tells it from the next.
struct Best<'a> {
    field: &'a str,
    label: &'a str,
    value: String,
    /// With its bounds: `0.31 (95 %: 0.22 to 0.41)`.
    shown: String,
    /// The next one, with the difference and its bounds, and whether that is more than chance.
    next: Option<(&'a str, String, bool)>,
}

/// `Largest F1 score on KCF: DTEF, 0.31 (95 %: 0.22 to 0.41)...`; `None` where nothing has a value.
pub(super) fn verdict(fields: &[Field], measured: &Measured, seed: u64, drawn: &mut Drawn) -> Option<String> {
    // A best one needs another one to be better than.
    let all: Vec<Best<'_>> = fields.iter().filter_map(|f| best(f, measured, seed, drawn)).collect();
    let best: Vec<Best<'_>> = all.into_iter().filter(|b| b.next.is_some()).collect();
    let most = if measured.direction() == Direction::LowerIsBetter { "Smallest" } else { "Largest" };
    let title = measured.title();
    if let [one] = best.as_slice() {
        let on = if one.field.is_empty() { String::new() } else { format!(" on {}", one.field) };
        let mut text = format!("{most} {title}{on}: {}, {}.", one.label, one.shown);
        if let Some((next, difference, apart)) = &one.next {
            let apart =
                if *apart { "more than chance" } else { "which these sequences cannot tell from chance" };
            text.push_str(&format!(" The next is {next}, behind by {difference}, {apart}."));
        }
        return Some(text);
    }
    let mut winners: Vec<(&str, Vec<String>)> = Vec::new();
    for b in &best {
        let on = format!("{} {}", b.field, b.value);
        match winners.iter_mut().find(|(label, _)| *label == b.label) {
            Some((_, fields)) => fields.push(on),
            None => winners.push((b.label, vec![on])),
        }
    }
    winners.sort_by_key(|(_, fields)| std::cmp::Reverse(fields.len()));
    let won = |(label, fields): &(&str, Vec<String>)| {
        let named = fields.iter().take(MAX_NAMED).cloned().collect::<Vec<_>>().join(", ");
        let more = if fields.len() > MAX_NAMED { ", ..." } else { "" };
        format!("{label} on {} ({named}{more})", fields.len())
    };
    let won: Vec<String> = winners.iter().map(won).collect();
    let apart = best.iter().filter(|b| b.next.as_ref().is_some_and(|n| n.2)).count();
    let told = match apart {
        0 => "on none of them is the lead more than chance".to_string(),
        n => format!("on {n} of them the lead is more than chance"),
    };
    // A tracker whose methods have several protocols is there for each of them.
    let what = if best.iter().any(|b| b.field.contains(", ")) { "comparisons" } else { "trackers" };
    (!best.is_empty())
        .then(|| format!("{most} {title}, of {} {what}: {}; {told}.", best.len(), won.join(", ")))
}

fn best<'a>(field: &'a Field, measured: &Measured, seed: u64, drawn: &mut Drawn) -> Option<Best<'a>> {
    let of = |c: &[i64; 4]| measured.value(field.chance, c);
    let signed = |v: f64| if measured.direction() == Direction::LowerIsBetter { -v } else { v };
    let competing = field.competitors.iter().filter(|c| c.competes);
    let mut all: Vec<(&Competitor, f64)> = competing.filter_map(|c| Some((c, of(&c.total())?))).collect();
    // Equal ones stay in the order of the experiment.
    all.sort_by(|a, b| signed(b.1).total_cmp(&signed(a.1)));
    let (first, value) = *all.first()?;
    let style = measured.style();
    let seed = seed::seed(seed, &[&field.label]);
    let counts: Vec<[i64; 4]> = first.counts.values().copied().collect();
    let enough = counts.len() >= MIN_SEQUENCES;
    let bounds = enough.then(|| drawn.of(counts.len(), DRAWS, seed).interval(&counts, of, LEVEL)).flatten();
    let bounds =
        bounds.map(|(low, high)| format!(" (95 %: {} to {})", style.format(low), style.format(high)));
    let next = all.get(1).map(|(second, other)| {
        let duel = duel((first, second), of, seed);
        // The one behind has the smaller number of what is to be large, and the difference is shown as a distance.
        let distance = |v: f64| if value >= *other { v } else { -v };
        let bounds = duel.bounds.map(|(a, b)| {
            let (a, b) = (distance(a), distance(b));
            (a.min(b), a.max(b))
        });
        let shown =
            bounds.map(|(a, b)| format!(" ({} to {})", style.format_signed(a), style.format_signed(b)));
        let difference = style.format(style.round(value) - style.round(*other));
        let difference = difference.trim_start_matches('-').to_string() + &shown.unwrap_or_default();
        (second.label.as_str(), difference, bounds.is_some_and(|(low, _)| low > 0.0))
    });
    let value = style.format(value);
    let shown = format!("{value}{}", bounds.unwrap_or_default());
    Some(Best { field: &field.label, label: &first.label, value, shown, next })
}

/// Most methods of the figure.
const MAX_ROWS: usize = 16;

/// Those that compete with their intervals, the best at the top, a panel for each tracker; `table` holds the numbers.
pub(super) fn dots(
    fields: &[Field],
    table: &TableLayout,
    measured: &Measured,
    suite: &str,
) -> Option<(Dots, String)> {
    let sign = if measured.direction() == Direction::LowerIsBetter { 1.0 } else { -1.0 };
    let number = |group: &Group, label: &str, k: usize| {
        group.rows.iter().find(|r| r.label.name == label)?.cells.get(k)?.value
    };
    let mut rows: Vec<(&str, f64)> = Vec::new();
    for (field, group) in fields.iter().zip(&table.groups) {
        for label in field.competitors.iter().filter(|c| c.competes).map(|c| c.label.as_str()) {
            if let Some(value) = number(group, label, 0)
                && rows.iter().all(|known| known.0 != label)
            {
                rows.push((label, sign * value));
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
        let dot = |label: &&str| {
            let bounds = number(group, label, 1).zip(number(group, label, 2));
            Some(Dot { value: number(group, label, 0)?, bounds })
        };
        let values = rows.iter().map(|(label, _)| dot(label)).collect();
        DotPanel { label: field.label.clone(), mark: None, values }
    };
    let panels: Vec<DotPanel> = fields.iter().zip(&table.groups).map(panel).collect();
    let which = if measured.direction() == Direction::LowerIsBetter { "smaller" } else { "larger" };
    let note = format!("{}, {which} is better, with 95 % intervals over sequences", measured.title());
    let left_out = if more > 0 { format!(" {more} more are in the tables.") } else { String::new() };
    let caption = format!(
        "{} with 95 % bootstrap intervals over sequences, those that overlap by much are not told apart.{left_out} {suite}",
        measured.title()
    );
    let rows = rows.into_iter().map(|(label, _)| label.to_string()).collect();
    Some((Dots { title: String::new(), note, rows, panels }, caption))
}
