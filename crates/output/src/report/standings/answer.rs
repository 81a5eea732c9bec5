//! The best method or tracker, in a sentence and as a figure, with the certainty.

use super::frames::CHANCE;
use super::{Field, Standing, Standings};
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

/// Anchors drawn as lines through all rows. `random` is drawn only if the level of chance is unknown.
const ANCHORS: [(&str, Dash); 2] = [("random", Dash::DASHED), ("oracle", Dash::DOTTED)];

/// Best standing of each field that has at least two, with the values for the templates of sentences.
fn best(of: &Standings) -> Vec<(&Standing, Value)> {
    let style = of.measured.style;
    let range = |bounds: Option<(f64, f64)>, shown: fn(Style, f64) -> String| {
        bounds.map(|(low, high)| format!("{} to {}", shown(style, low), shown(style, high)))
    };
    let best = |field| {
        let all = of.best_first(field);
        let [(first, value), (next, other), ref rest @ ..] = *all.as_slice() else { return None };
        // The lead is reversed if smaller values are better.
        let lead = match of.measured.direction {
            Direction::LowerIsBetter => field.difference(next, first),
            _ => field.difference(first, next),
        };
        let lead = lead.unwrap_or_default();
        let [own, others] = [value, other].map(|v| style.round(v));
        let told = json!({
            "field": field.label,
            "first": first.spoken(),
            "next": next.spoken(),
            "value": style.format(value),
            "interval": range(first.estimate.bounds, Style::format),
            "behind": style.format((own - others).abs()),
            "lead": lead.value.map(|v| style.format_signed(v)),
            "lead_interval": range(lead.bounds, Style::format_signed),
            // The whole interval of the lead is above 0.
            "is_sure": lead.bounds.is_some_and(|(low, _)| low > 0.0),
            "ties": own == others,
            // Further competitors that are equal to the first, as printed.
            "more": rest.iter().filter(|(_, v)| style.round(*v) == own).count(),
        });
        Some((first, told))
    };
    of.fields.iter().filter_map(best).collect()
}

/// Name of the best method in each field.
pub fn best_names(of: &Standings) -> Vec<String> {
    best(of).iter().map(|(first, _)| first.name.clone()).collect()
}

/// Sentence like `Largest F1 score on KCF: DTEF, 0.31 (95 %: 0.22 to 0.41)...`; `None` if no field has two
/// standings with a value.
pub fn verdict(of: &Standings) -> Option<String> {
    let best = best(of);
    // A tracker whose methods have several protocols is there for each of them.
    let is_of_protocol = |told: &Value| told["field"].as_str().is_some_and(|field| field.contains(", "));
    let is_compared = best.iter().any(|(_, told)| is_of_protocol(told));
    // Trackers with several equal methods at the top, as printed, are won by none.
    let mut won = grouped(best.iter().filter(|(_, told)| told["ties"] == false), |(first, _)| &first.label);
    won.sort_by_key(|(_, on)| std::cmp::Reverse(on.len()));
    let told = |best: &[&(&Standing, Value)]| best.iter().map(|(_, told)| told.clone()).collect::<Vec<_>>();
    let about = json!({
        "measured": of.measured.told(),
        "best": told(&best.iter().collect::<Vec<_>>()),
        "what": if is_compared { "comparisons" } else { "trackers" },
        "won": won.iter().map(|(_, on)| told(on)).collect::<Vec<_>>(),
    });
    (!best.is_empty()).then(|| say("verdict", about))
}

/// Sentence that names the best method frame by frame, with the certainty.
pub fn frames_verdict(of: &Standings) -> Option<String> {
    Some(say("frames verdict", best(of).pop()?.1))
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
