//! The best method or tracker in a sentence and as a figure, with how sure that is.

use super::{Estimate, Field, Standing, Standings};
use crate::figure::{Color, Dash, Dot, DotPanel, Dots};
use crate::report::colors;
use crate::report::differences::CHANCE;
use crate::report::figures::published;
use crate::table::leaderboard::better_first;
use crate::table::number::Style;
use trackfail_core::direction::Direction;
use trackfail_engine::spec::Experiment;

/// Most rows of the figure.
const MAX_ROWS: usize = 16;
/// Most trackers that are named one by one.
const MAX_NAMED: usize = 4;
/// Most winners that are named where there are more trackers than that.
const MAX_WINNERS: usize = 3;

/// Anchors that are drawn as lines through all rows; the first one where it is not known what chance gives.
const ANCHORS: [(&str, Dash); 2] = [("random", Dash::Dashed), ("oracle", Dash::Dotted)];

/// The best of a field, and the next one.
struct Best<'a> {
    /// Label of the field.
    field: &'a str,
    first: &'a Standing,
    next: &'a Standing,
    /// Their numbers.
    values: [f64; 2],
    /// Competitors behind these two that are as good as the first, as printed.
    more: usize,
    /// Whether the two are equal as printed.
    ties: bool,
    /// How far the first is above the next, the other way round where smaller is better.
    lead: Estimate,
}

impl Best<'_> {
    /// Whether all of the interval of the lead is on its side.
    fn is_beyond_chance(&self) -> bool {
        self.lead.bounds.is_some_and(|(low, _)| low > 0.0)
    }

    fn by_chance(&self) -> &'static str {
        if self.is_beyond_chance() {
            "more than chance"
        } else {
            "which these sequences cannot tell from chance"
        }
    }

    /// `0.31 (95 %: 0.22 to 0.41)`.
    fn estimate(&self, style: Style) -> String {
        let shown = |(low, high)| format!(" (95 %: {} to {})", style.format(low), style.format(high));
        style.format(self.values[0]) + &self.first.estimate.bounds.map_or_else(String::new, shown)
    }

    /// Bounds of the lead in brackets behind some words: ` (-0.020 to +0.110)`.
    fn bounds(&self, style: Style, words: &str) -> String {
        let signed = |v| style.format_signed(v);
        let shown = |(low, high)| format!(" ({words}{} to {})", signed(low), signed(high));
        self.lead.bounds.map_or_else(String::new, shown)
    }
}

/// The best of each field that has another one to be better than.
fn best(of: &Standings) -> Vec<Best<'_>> {
    let round = |v: f64| of.measured.style.round(v);
    let best = |field| {
        let all = of.best_first(field);
        let [(first, value), (next, other), ref rest @ ..] = *all.as_slice() else { return None };
        let lead = match of.measured.direction {
            Direction::LowerIsBetter => field.difference(next, first),
            _ => field.difference(first, next),
        };
        Some(Best {
            field: field.label.as_str(),
            first,
            next,
            values: [value, other],
            more: rest.iter().filter(|(_, v)| round(*v) == round(value)).count(),
            ties: round(value) == round(other),
            lead: lead.unwrap_or_default(),
        })
    };
    of.fields.iter().filter_map(best).collect()
}

/// The name of the best method of each field.
pub fn best_names(of: &Standings) -> Vec<String> {
    best(of).iter().map(|best| best.first.name.clone()).collect()
}

/// `Largest F1 score on KCF: DTEF, 0.31 (95 %: 0.22 to 0.41)...`; `None` where nothing has a value and a rival.
pub fn verdict(of: &Standings) -> Option<String> {
    let style = of.measured.style;
    let told = match best(of).as_slice() {
        [] => return None,
        [one] => single(one, style),
        many => counted(many, style),
    };
    let most = if of.measured.direction == Direction::LowerIsBetter { "Smallest" } else { "Largest" };
    // An analysis may have another number of that name, weighted by frames.
    let way = if of.measured.metric.is_none() { ", mean over sequences" } else { "" };
    Some(format!("{most} {}{way}{told}.", of.measured.title))
}

fn single(one: &Best<'_>, style: Style) -> String {
    let on = if one.field.is_empty() { String::new() } else { format!(" on {}", one.field) };
    let ([first, next], [value, other]) = ([one.first, one.next].map(Standing::spoken), one.values);
    let equal = match one.more {
        _ if !one.ties => {
            let behind = style.format((style.round(value) - style.round(other)).abs());
            let (shown, bounds, chance) = (one.estimate(style), one.bounds(style, ""), one.by_chance());
            return format!(
                "{on}: {first}, {shown}. The next is {next}, behind by {behind}{bounds}, {chance}"
            );
        }
        0 => format!("{first} and {next}"),
        more => format!("{first}, {next} and {more} more"),
    };
    let bounds = if one.more == 0 { one.bounds(style, "95 % of their difference: ") } else { String::new() };
    format!("{on}: {equal} are equal, {}{bounds}", style.format(value))
}

/// Of many trackers only how many each of the first ones wins; those at the top that are equal as printed win none.
fn counted(best: &[Best<'_>], style: Style) -> String {
    let most = if best.len() <= MAX_NAMED { MAX_NAMED } else { MAX_WINNERS };
    let mut winners: Vec<(String, Vec<String>)> = Vec::new();
    for b in best.iter().filter(|b| !b.ties) {
        let (winner, on) = (b.first.spoken(), format!("{} {}", b.field, style.format(b.values[0])));
        match winners.iter_mut().find(|(label, _)| *label == winner) {
            Some((_, fields)) => fields.push(on),
            None => winners.push((winner, vec![on])),
        }
    }
    winners.sort_by_key(|(_, fields)| std::cmp::Reverse(fields.len()));
    let (first, others) = winners.split_at(winners.len().min(most));
    let won = |(label, fields): &(String, Vec<String>)| match best.len() <= MAX_NAMED {
        true => format!("{label} on {} ({})", fields.len(), fields.join(", ")),
        false => format!("{label} on {}", fields.len()),
    };
    let mut won: Vec<String> = first.iter().map(won).collect();
    if !others.is_empty() {
        let on: usize = others.iter().map(|(_, fields)| fields.len()).sum();
        let methods = if others.len() == 1 { "method" } else { "methods" };
        won.push(format!("{} more {methods} on {on}", others.len()));
    }
    let ties = best.iter().filter(|b| b.ties).count();
    won.extend((ties > 0).then(|| format!("two or more equal at the top on {ties}")));
    let told = match best.iter().filter(|b| b.is_beyond_chance()).count() {
        0 => "on none of them is the lead more than chance".to_string(),
        n => format!("on {n} of them the lead is more than chance"),
    };
    // A tracker whose methods have several protocols is there for each of them.
    let what = if best.iter().any(|b| b.field.contains(", ")) { "comparisons" } else { "trackers" };
    format!(", of {} {what}: {}; {told}", best.len(), won.join(", "))
}

/// The best method frame by frame in a sentence, with how sure that is.
pub fn frames_verdict(of: &Standings) -> Option<String> {
    let (best, style) = (best(of).pop()?, of.measured.style);
    let (first, next, shown) = (&best.first.name, &best.next.name, best.estimate(style));
    let lead = best.lead.value.filter(|_| best.lead.bounds.is_some()).map_or_else(String::new, |value| {
        let (value, bounds) = (style.format_signed(value), best.bounds(style, ""));
        format!(" It leads {next} by {value}{bounds}, {}.", best.by_chance())
    });
    Some(format!(
        "{first} tells lost frames from good ones best: area under the ROC curve {shown} over all trackers together.{lead}"
    ))
}

/// The figure `headline` with its caption: those that can be the best with their intervals, the best at the top, a panel for
/// each field.
pub fn dots(of: &Standings, experiment: &Experiment, suite: &str) -> Option<(Dots, String)> {
    let Standings { measured, fields } = of;
    let mut rows: Vec<(&Standing, f64)> = Vec::new();
    for (standing, value) in fields.iter().flat_map(|field| of.best_first(field)) {
        if rows.iter().all(|(known, _)| known.label != standing.label) {
            rows.push((standing, value));
        }
    }
    rows.sort_by(|a, b| better_first(Some(a.1), Some(b.1), measured.direction));
    let all = rows.len();
    let rows: Vec<&Standing> = rows.into_iter().take(MAX_ROWS).map(|(standing, _)| standing).collect();
    if rows.len() < 2 {
        return None;
    }
    let chance = measured.metric.filter(|metric| metric.is_of_frames()).map(|_| CHANCE);
    let panel = |field: &Field| {
        let dot = |row: &&Standing| {
            let estimate = field.standings.iter().find(|s| s.label == row.label)?.estimate;
            Some(Dot { value: estimate.value?, bounds: estimate.bounds })
        };
        let printed =
            |row: &&Standing| published::of_metric(experiment, &field.tracker, &row.name, measured.metric?);
        let anchor = |(name, dash): (&str, Dash)| {
            let anchor = field.standings.iter().find(|s| !s.competes && s.name == name)?;
            Some((anchor.estimate.value?, dash))
        };
        DotPanel {
            label: field.label.clone(),
            levels: ANCHORS.into_iter().skip(usize::from(chance.is_some())).filter_map(anchor).collect(),
            published: rows.iter().map(printed).collect(),
            values: rows.iter().map(dot).collect(),
            ..DotPanel::default()
        }
    };
    let panels: Vec<DotPanel> = fields.iter().map(panel).collect();
    let is_printed = panels.iter().flat_map(|p| &p.published).any(Option::is_some);
    let printed = if is_printed { "; a diamond is the published value" } else { "" };
    let has = |dash: Dash| panels.iter().flat_map(|panel| &panel.levels).any(|level| level.1 == dash);
    let dashed = match chance {
        Some(_) => "; dashed: chance",
        None if has(Dash::Dashed) => "; dashed: alarms at random",
        None => "",
    };
    let dotted = if has(Dash::Dotted) { "; dotted: the oracle" } else { "" };
    let way = if measured.direction == Direction::LowerIsBetter { "smaller" } else { "larger" };
    let title = &measured.title;
    let note =
        format!("{title}, {way} is better, with 95 % intervals over sequences{printed}{dashed}{dotted}");
    let caption = match (chance, all - rows.len()) {
        (Some(_), _) => format!(
            "{title} of lost frames against good ones, all trackers together, with 95 % bootstrap intervals over sequences; \
             the best {} of {all} methods. {suite}",
            rows.len()
        ),
        (None, more) => {
            let left_out = if more > 0 { format!(" {more} more are in the tables.") } else { String::new() };
            format!(
                "{title} with 95 % bootstrap intervals over sequences; where these overlap by much, the methods cannot be told \
                 apart.{left_out} {suite}"
            )
        }
    };
    // Trackers are no methods: all have one color.
    let color = |row: &&Standing| match measured.metric {
        Some(_) => colors::color(experiment, &row.name),
        None => Color::Blue,
    };
    let (colors, title) = (rows.iter().map(color).collect(), String::new());
    let rows = rows.iter().map(|row| row.spoken()).collect();
    Some((Dots { title, note, rows, panels, shared_axis: true, colors, chance }, caption))
}
