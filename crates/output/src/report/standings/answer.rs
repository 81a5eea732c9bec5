//! The best method or tracker, in a sentence and as a figure, with the certainty.

use super::frames::CHANCE;
use super::{Estimate, Field, Standing, Standings};
use crate::figure::{Color, Dash, DotPanel, Dots};
use crate::report::figures::published;
use crate::report::{colors, sentences::say};
use crate::results::grouped;
use crate::table::leaderboard::better_first;
use crate::table::number::Style;
use serde_json::{Value, json};
use trackfail_core::direction::Direction;
use trackfail_engine::spec::Experiment;

/// Most rows of the figure.
const MAX_ROWS: usize = 16;
/// Most trackers that are named singly.
const MAX_NAMED: usize = 4;
/// Largest number of winners that the answer names, if there are more trackers than this.
const MAX_WINNERS: usize = 3;

/// Anchors drawn as lines through all rows. `random` is drawn only if the level of chance is unknown.
const ANCHORS: [(&str, Dash); 2] = [("random", Dash::DASHED), ("oracle", Dash::DOTTED)];

/// Best standing of a field, and the next one.
struct Best<'a> {
    /// Label of the field.
    field: &'a str,
    first: &'a Standing,
    next: &'a Standing,
    /// Numbers of the best standing and of the next one.
    values: [f64; 2],
    /// Number of further competitors that are equal to the first, as printed.
    more: usize,
    /// True if the two are equal, as printed.
    ties: bool,
    /// Lead of the first over the next; the difference is reversed if smaller values are better.
    lead: Estimate,
}

impl Best<'_> {
    /// True if the whole interval of the lead is above 0.
    fn is_beyond_chance(&self) -> bool {
        self.lead.bounds.is_some_and(|(low, _)| low > 0.0)
    }

    /// Values for the templates of sentences.
    fn told(&self, style: Style) -> Value {
        let [value, other] = self.values;
        let range = |bounds: Option<(f64, f64)>, shown: fn(Style, f64) -> String| {
            bounds.map(|(low, high)| format!("{} to {}", shown(style, low), shown(style, high)))
        };
        json!({
            "field": self.field,
            "first": self.first.spoken(),
            "next": self.next.spoken(),
            "value": style.format(value),
            "interval": range(self.first.estimate.bounds, Style::format),
            "behind": style.format((style.round(value) - style.round(other)).abs()),
            "lead": self.lead.value.map(|v| style.format_signed(v)),
            "lead_interval": range(self.lead.bounds, Style::format_signed),
            "is_sure": self.is_beyond_chance(),
            "ties": self.ties,
            "more": self.more,
        })
    }
}

/// Best standing of each field that has at least two.
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

/// Name of the best method in each field.
pub fn best_names(of: &Standings) -> Vec<String> {
    best(of).iter().map(|best| best.first.name.clone()).collect()
}

/// Sentence like `Largest F1 score on KCF: DTEF, 0.31 (95 %: 0.22 to 0.41)...`; `None` if no field has two
/// standings with a value.
pub fn verdict(of: &Standings) -> Option<String> {
    let (best, style) = (best(of), of.measured.style);
    // A tracker whose methods have several protocols is there for each of them.
    let what = if best.iter().any(|b| b.field.contains(", ")) { "comparisons" } else { "trackers" };
    let told: Vec<Value> = best.iter().map(|b| b.told(style)).collect();
    let about = json!({
        "measured": of.measured.told(),
        "best": told,
        "what": what,
        "won": won(&best, style),
        "sure": best.iter().filter(|b| b.is_beyond_chance()).count(),
    });
    (!best.is_empty()).then(|| say("verdict", about))
}

/// For many trackers: how many trackers each of the top methods wins. Trackers with several equal methods at
/// the top, as printed, count for none.
fn won(best: &[Best<'_>], style: Style) -> Vec<String> {
    let most = if best.len() <= MAX_NAMED { MAX_NAMED } else { MAX_WINNERS };
    let mut winners = grouped(best.iter().filter(|b| !b.ties), |b| b.first.label.as_str());
    winners.sort_by_key(|(_, fields)| std::cmp::Reverse(fields.len()));
    let (first, others) = winners.split_at(winners.len().min(most));
    let of_winner = |(_, fields): &(&str, Vec<&Best<'_>>)| {
        let on = |b: &&Best<'_>| format!("{} {}", b.field, style.format(b.values[0]));
        let named: Vec<String> = fields.iter().filter(|_| best.len() <= MAX_NAMED).map(on).collect();
        let named = if named.is_empty() { String::new() } else { format!(" ({})", named.join(", ")) };
        format!("{} on {}{named}", fields[0].first.spoken(), fields.len())
    };
    let mut won: Vec<String> = first.iter().map(of_winner).collect();
    if !others.is_empty() {
        let on: usize = others.iter().map(|(_, fields)| fields.len()).sum();
        let methods = if others.len() == 1 { "method" } else { "methods" };
        won.push(format!("{} more {methods} on {on}", others.len()));
    }
    let ties = best.iter().filter(|b| b.ties).count();
    won.extend((ties > 0).then(|| format!("two or more equal at the top on {ties}")));
    won
}

/// Sentence that names the best method frame by frame, with the certainty.
pub fn frames_verdict(of: &Standings) -> Option<String> {
    Some(say("frames verdict", best(of).pop()?.told(of.measured.style)))
}

/// Figure `headline` with its caption: possible best standings with their intervals, the best at the top, one
/// panel per field.
pub fn dots(of: &Standings, experiment: &Experiment, suite: &str) -> Option<(Dots, String)> {
    let Standings { measured, fields } = of;
    let rows = grouped(fields.iter().flat_map(|field| of.best_first(field)), |(s, _)| s.label.as_str());
    let mut rows: Vec<(&Standing, f64)> = rows.into_iter().map(|(_, same)| same[0]).collect();
    rows.sort_by(|a, b| better_first(Some(a.1), Some(b.1), measured.direction));
    let all = rows.len();
    let rows: Vec<&Standing> = rows.into_iter().take(MAX_ROWS).map(|(standing, _)| standing).collect();
    if rows.len() < 2 {
        return None;
    }
    let chance = measured.metric.filter(|metric| metric.is_of_frames()).map(|_| CHANCE);
    let panel = |field: &Field| {
        let dot = |row: &&Standing| field.standings.iter().find(|s| s.label == row.label)?.estimate.dot();
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
    let has = |dash: Dash| panels.iter().flat_map(|panel| &panel.levels).any(|level| level.1 == dash);
    let about = json!({
        "measured": measured.told(),
        "printed": panels.iter().flat_map(|p| &p.published).any(Option::is_some),
        "chance": chance.is_some(),
        "dashed": has(Dash::DASHED),
        "dotted": has(Dash::DOTTED),
        "shown": rows.len(),
        "all": all,
        "suite": suite,
    });
    // Trackers are no methods: all have one color.
    let color = |row: &&Standing| match measured.metric {
        Some(_) => colors::color(experiment, &row.name),
        None => Color::BLUE,
    };
    let (colors, note) = (rows.iter().map(color).collect(), say("headline note", &about));
    let rows = rows.iter().map(|row| row.spoken()).collect();
    let dots = Dots { title: String::new(), note, rows, panels, shared_axis: true, colors, chance };
    Some((dots, say("headline", &about)))
}
