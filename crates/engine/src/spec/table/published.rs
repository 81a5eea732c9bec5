//! Numbers that a paper prints, beside the table to which they belong.

use super::{Published, Side, Table, Words};
use crate::spec::Tracker;
use crate::spec::error::At;
use crate::spec::method::Method;
use crate::spec::name::check_label;
use crate::spec::wire;

/// All published numbers, including inherited ones. A method or tracker that is
/// [like](crate::spec::method::Method::like) another inherits that one's numbers, unless it has its own; so
/// does a table that names another one.
pub(in crate::spec) fn inherit_published(
    published: Vec<Published>,
    tables: &[Table],
    methods: &[Method],
    trackers: &[Tracker],
) -> Vec<Published> {
    let mut all = published;
    for (table, like) in tables.iter().filter_map(|t| Some((&t.name, t.published.as_ref()?))) {
        let taken: Vec<Published> = all.iter().filter(|p| p.table == *like).cloned().collect();
        all.extend(taken.into_iter().map(|p| Published { table: table.clone(), ..p }));
    }
    for (label, like) in trackers.iter().filter_map(|t| Some((&t.label, t.like.as_ref()?))) {
        let taken: Vec<Published> = all.iter().filter(|p| p.tracker == *like).cloned().collect();
        all.extend(taken.into_iter().map(|p| Published { tracker: label.clone(), ..p }));
    }
    for Published { values, .. } in &mut all {
        for method in methods {
            let text = |name: &str| values.iter().find(|(m, _)| m == name).map(|(_, text)| text.clone());
            let taken = method.like.as_deref().and_then(text);
            if let (Some(taken), None) = (taken, text(&method.name)) {
                values.push((method.name.clone(), taken));
            }
        }
    }
    all
}

/// Checks a `[[published]]` against its table; `None` if that table is wrong.
pub(in crate::spec) fn read_published(
    at: At<'_>,
    wire: &wire::Published,
    tables: &[Table],
    words: &Words,
) -> Option<Published> {
    check_label(at.key("tracker"), &wire.tracker, false);
    let Some(table) = tables.iter().find(|t| t.name == wire.table) else {
        at.key("table").knows("table", &wire.table, words.tables.iter().map(String::as_str));
        return None;
    };
    if table.ranked.is_some() {
        at.key("table").tell("a table with a `rank` has no published numbers beside it");
    } else if let (Side::Metrics(metrics), None) = (&table.rows, &table.shows) {
        at.key("row").knows("row", &wire.row, metrics.iter().map(|m| m.name()));
    }
    for (column, text) in &wire.values {
        let at = at.key("values").key(column);
        if table.columns == Side::Method {
            at.knows("column", column, table.methods.iter().map(String::as_str));
        }
        let numbers: Vec<&str> = text.split('±').collect();
        let is_number = |n: &&str| n.trim().parse::<f64>().is_ok_and(f64::is_finite);
        if numbers.len() > 2 || !numbers.iter().all(is_number) {
            at.tell(format!("`{text}` is not a printed number"));
        }
    }
    let (table, tracker, row) = (wire.table.clone(), wire.tracker.clone(), wire.row.clone());
    Some(Published { table, tracker, row, values: wire.values.clone().into_iter().collect() })
}
