//! Explanation of a cell's state: the first ingredient, in data-flow order, that has changed.

use super::cells::CellState;
use super::experiment::ExperimentPlan;
use crate::store::Store;
use crate::store::address::{Address, Recipe, Stage};
use std::collections::BTreeMap;

/// Reason why each cell is stale, missing or absent, in one sentence. In the order of
/// [`ExperimentPlan::cells_on`], without cached cells.
pub fn why(plan: &ExperimentPlan<'_>, store: &Store) -> Vec<String> {
    let now = current(plan);
    let recipe_at = |text: &str| {
        let address = parse(text)?;
        now.get(&address).cloned().or_else(|| store.head(&address).map(|head| head.recipe))
    };
    let because = plan.map_cells(store, |state, name, from| {
        if state == CellState::Cached {
            return String::new();
        }
        let recipe = match from {
            Ok((on, key, seed)) => key.labels(on.clone(), seed),
            Err(e) => return e.to_string(),
        };
        if store.contains(&recipe.address()) {
            return "its track or a signal on it was never computed here, or has been removed".to_string();
        }
        // The record with most ingredients in common explains most.
        let common = |before: &Recipe| {
            recipe.ingredients.iter().filter(|ingredient| before.ingredients.contains(ingredient)).count()
        };
        let before = store.heads(Stage::Labels, &name()).into_iter().map(|head| head.recipe);
        before.max_by_key(common).map_or_else(
            || "it was never computed here, or has been removed".to_string(),
            |before| difference(&before, &recipe, &recipe_at),
        )
    });
    because.into_iter().flatten().collect()
}

/// All recipes of the plan except those of labels, by address.
fn current(plan: &ExperimentPlan<'_>) -> BTreeMap<Address, Recipe> {
    let needs = plan.needs(|_, _| true).into_iter();
    let mut all: Vec<Recipe> = needs.filter_map(|(_, need)| Some(need.ok()?.recipe)).collect();
    for planned in plan.suites.iter().flat_map(|suite| &suite.sequences) {
        all.extend(planned.tracks.iter().flatten().cloned());
        let pairs = (0..plan.jobs.len()).flat_map(|j| (0..plan.signals.len()).map(move |k| (j, k)));
        all.extend(pairs.filter_map(|(j, k)| plan.signal_recipe(planned, j, k).ok()));
    }
    all.into_iter().map(|recipe| (recipe.address(), recipe)).collect()
}

/// Plugin that computes the result of a recipe, in words.
fn subject(recipe: &Recipe) -> String {
    let (what, kind) = match recipe.stage {
        Stage::Track => ("tracker", recipe.value("tracker")),
        Stage::Signal => ("signal", recipe.value("signal")),
        Stage::Model => ("training of", recipe.value("parameter").or_else(|| recipe.value("learner"))),
        Stage::Labels => ("detector", recipe.value("detector")),
    };
    kind.map_or_else(|| recipe.stage.word().to_string(), |kind| format!("{what} {kind}"))
}

/// First difference between a stored recipe and the current one. `recipe_at` returns the recipe of an
/// address.
fn difference(before: &Recipe, now: &Recipe, recipe_at: &dyn Fn(&str) -> Option<Recipe>) -> String {
    let pairs = (0_usize..).map(|k| (before.ingredients.get(k), now.ingredients.get(k)));
    let mut differing = pairs.skip_while(|(was, is)| was == is && is.is_some());
    let what = match differing.next() {
        Some((Some((was, _)), Some((is, _)))) if was != is => {
            format!("made from {was} before, from {is} now")
        }
        Some((Some((_, was)), Some((name, is)))) => {
            let is_address = ["track", "companion", "signal", "model"].contains(&name.as_str());
            if is_address && was.len() == 64 {
                match (recipe_at(was), recipe_at(is)) {
                    (Some(before), Some(now)) => return difference(&before, &now, recipe_at),
                    _ => format!("another {name}, whose record has been removed"),
                }
            } else if name == "sequence" {
                // A cell's own sequence stays what it is.
                "the tracks to learn from are others".to_string()
            } else {
                let parameter = (name == "parameters").then(|| parameter_difference(was, is)).flatten();
                parameter.unwrap_or_else(|| format!("{name} was {was}, is {is}"))
            }
        }
        Some((None, Some((name, _)))) => format!("{name} is new"),
        Some((Some((name, _)), None)) => format!("{name} is no longer used"),
        Some((None, None)) | None => "the same, but its record has been removed".to_string(),
    };
    format!("{}: {what}", subject(now))
}

/// Name of the first parameter that differs, with its values before and now.
fn parameter_difference(before: &str, now: &str) -> Option<String> {
    let read = |text: &str| serde_json::from_str::<BTreeMap<String, serde_json::Value>>(text).ok();
    let (before, now) = (read(before)?, read(now)?);
    let name = now.keys().chain(before.keys()).find(|name| before.get(*name) != now.get(*name))?;
    let [was, is] =
        [&before, &now].map(|all| all.get(name).map_or("not there".to_string(), |v| v.to_string()));
    Some(format!("{name} was {was}, is {is}"))
}

fn parse(address: &str) -> Option<Address> {
    let mut bytes = [0; 32];
    for (k, byte) in bytes.iter_mut().enumerate() {
        *byte = u8::from_str_radix(address.get(2 * k..2 * k + 2)?, 16).ok()?;
    }
    Some(Address(bytes))
}
