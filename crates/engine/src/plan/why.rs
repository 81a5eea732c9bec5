//! Why a cell is or is not in the store: the first ingredient, in data-flow order, that has changed.

use super::experiment::ExperimentPlan;
use crate::store::Store;
use crate::store::address::{Address, Recipe, Stage};
use std::collections::BTreeMap;

/// Why each cell is stale, missing or absent, in one sentence, in the order of [`ExperimentPlan::cells`]; nothing is said of
/// cached ones.
pub fn why(plan: &ExperimentPlan<'_>, store: &Store) -> Vec<String> {
    let now = current(plan);
    let cached = plan.cached_tracks(store);
    plan.map_labels(|labels| match labels.recipe() {
        Err(e) => e.to_string(),
        Ok(recipe) if store.contains(&recipe.address()) => {
            let is_cached = cached[labels.cell.sequence][labels.cell.job];
            let why = "its track or a signal on it was never computed here, or has been removed";
            if is_cached { String::new() } else { why.to_string() }
        }
        Ok(recipe) => {
            let before = store.heads(Stage::Labels, &plan.stored_name(&labels.name()));
            // The record with most ingredients in common explains most.
            match before.iter().max_by_key(|head| common(&head.recipe, &recipe)) {
                None => "it was never computed here".to_string(),
                Some(head) => difference(&head.recipe, &recipe, store, &now),
            }
        }
    })
}

/// Every recipe of the plan except those of labels, by address.
fn current(plan: &ExperimentPlan<'_>) -> BTreeMap<Address, Recipe> {
    let mut all = BTreeMap::new();
    for suite in &plan.suites {
        for planned in &suite.sequences {
            let recipe = |(j, k)| plan.signal_recipe(planned, j, k).ok();
            let pairs = (0..plan.jobs.len()).flat_map(|j| (0..plan.signals.len()).map(move |k| (j, k)));
            let recipes = planned.tracks.iter().flatten().cloned().chain(pairs.filter_map(recipe));
            all.extend(recipes.map(|recipe| (recipe.address(), recipe)));
        }
    }
    all.extend(plan.models().into_iter().flatten().flatten().flatten().map(|model| (model.address(), model)));
    all
}

/// Number of common ingredients of two recipes.
fn common(a: &Recipe, b: &Recipe) -> usize {
    a.ingredients.iter().filter(|i| b.ingredients.contains(i)).count()
}

/// Whether an ingredient is the address of another result.
fn is_parent(name: &str) -> bool {
    ["track", "companion", "signal", "model"].contains(&name)
}

/// Plugin that makes the result of a recipe, in words.
fn subject(recipe: &Recipe) -> String {
    let what = match recipe.stage {
        Stage::Track => "tracker",
        Stage::Signal => "signal",
        Stage::Model => "training of",
        Stage::Labels => "detector",
    };
    let kind = match recipe.stage {
        Stage::Model => recipe.value("parameter").or_else(|| recipe.value("learner")),
        _ => recipe.value(what),
    };
    kind.map_or_else(|| recipe.stage.word().to_string(), |kind| format!("{what} {kind}"))
}

/// Name of the first parameter that differs, with its values before and now.
fn parameter_difference(before: &str, now: &str) -> Option<String> {
    let read = |text: &str| serde_json::from_str::<BTreeMap<String, serde_json::Value>>(text).ok();
    let (before, now) = (read(before)?, read(now)?);
    let names = now.keys().chain(before.keys());
    let name = names.into_iter().find(|name| before.get(*name) != now.get(*name))?;
    let show = |value: Option<&serde_json::Value>| value.map_or("not there".to_string(), |v| v.to_string());
    Some(format!("{name} was {}, is {}", show(before.get(name)), show(now.get(name))))
}

/// The first difference between a stored recipe and the current one.
fn difference(before: &Recipe, now: &Recipe, store: &Store, current: &BTreeMap<Address, Recipe>) -> String {
    let plugin = subject(now);
    for (k, (name, value)) in now.ingredients.iter().enumerate() {
        let was = match before.ingredients.get(k) {
            Some((n, v)) if n == name => v,
            Some((n, _)) => return format!("{plugin}: made from {n} before, from {name} now"),
            None => return format!("{plugin}: {name} is new"),
        };
        if was == value {
            continue;
        }
        let is_address = is_parent(name) && was.len() == 64;
        if is_address {
            let parent = |text: &str, recipe: fn(&Store, &Address) -> Option<Recipe>| {
                parse(text).and_then(|a| current.get(&a).cloned().or_else(|| recipe(store, &a)))
            };
            let kept = |store: &Store, address: &Address| store.head(address).map(|head| head.recipe);
            return match (parent(was, kept), parent(value, kept)) {
                (Some(before), Some(now)) => difference(&before, &now, store, current),
                _ => format!("{plugin}: another {name}, whose record has been removed"),
            };
        }
        if name == "parameters"
            && let Some(difference) = parameter_difference(was, value)
        {
            return format!("{plugin}: {difference}");
        }
        return format!("{plugin}: {name} was {was}, is {value}");
    }
    match before.ingredients.get(now.ingredients.len()) {
        Some((name, _)) => format!("{plugin}: {name} is no longer used"),
        None => format!("{plugin}: the same, but its record has been removed"),
    }
}

fn parse(text: &str) -> Option<Address> {
    let mut bytes = [0; 32];
    for (k, byte) in bytes.iter_mut().enumerate() {
        *byte = u8::from_str_radix(text.get(2 * k..2 * k + 2)?, 16).ok()?;
    }
    Some(Address(bytes))
}
