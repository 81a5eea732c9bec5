//! Methods written out: keys taken from a published method, or from the one that they are like.

use super::builtin::method_tables;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Completes methods: one without `signal` and `detector` gets those of the published method of its name, and
/// a reading gets those of the method that it is like. Methods without such a model stay unchanged.
pub(super) fn complete_methods<'i>(document: &mut DeTable<'i>) {
    let Some(DeValue::Array(list)) = document.get_mut("method").map(Spanned::get_mut) else { return };
    let mut known: Vec<(String, DeTable<'i>)> = Vec::new();
    for item in list.iter_mut() {
        let span = item.span();
        let DeValue::Table(table) = item.get_mut() else { continue };
        let text = |key: &str| Some(table.get(key)?.get_ref().as_str()?.to_string());
        let Some(name) = text("name") else { continue };
        let published = |name: &str| method_tables().iter().find(|t| t.0 == name).map(|t| t.1.get_ref());
        let like = text("like");
        let base = match &like {
            Some(like) => known.iter().find(|t| t.0 == *like).map(|t| &t.1).or_else(|| published(like)),
            None if table.contains_key("signal") || table.contains_key("detector") => None,
            None => published(&name),
        };
        for (key, value) in base.into_iter().flatten() {
            let key: &str = key.get_ref();
            let is_taken = ["signal", "detector", "grid"].contains(&key);
            match (table.get_mut(key).map(Spanned::get_mut), value.get_ref()) {
                (None, _) if is_taken => {
                    table.insert(Spanned::new(span.clone(), key.to_string().into()), value.clone());
                }
                (Some(DeValue::Table(mine)), DeValue::Table(its))
                    if !mine.contains_key("kind") && is_taken =>
                {
                    for (key, value) in its {
                        if !mine.contains_key(&**key.get_ref()) {
                            mine.insert(key.clone(), value.clone());
                        }
                    }
                }
                _ => {}
            }
        }
        known.push((name, table.clone()));
    }
}
