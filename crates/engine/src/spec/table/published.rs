//! Numbers that a paper prints, beside the table they belong to.

use super::{Published, Side, Table};
use crate::spec::Tracker;
use crate::spec::error::{Errors, Source, SpecError};
use crate::spec::method::Method;
use crate::spec::wire;

/// The published numbers, with those that readings and tables take over: a method or tracker that is
/// [like](crate::spec::method::Method::like) another has that one's, and so has a table that names another one, unless it has
/// numbers of its own.
pub fn inherit_published(
    published: Vec<Published>,
    tables: &[Table],
    methods: &[Method],
    trackers: &[Tracker],
) -> Vec<Published> {
    let mut all = published;
    for table in tables.iter().filter(|t| t.published.is_some()) {
        let of_table = |p: &&Published| Some(&p.table) == table.published.as_ref();
        let taken = all.iter().filter(of_table).map(|p| Published { table: table.name.clone(), ..p.clone() });
        let taken: Vec<Published> = taken.collect();
        all.extend(taken);
    }
    for tracker in trackers {
        let Some(like) = &tracker.like else { continue };
        let taken = all.iter().filter(|p| p.tracker == *like);
        let taken = taken.map(|p| Published { tracker: tracker.label.clone(), ..p.clone() });
        let taken: Vec<Published> = taken.collect();
        all.extend(taken);
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

/// Checks a `[[published]]` against the table it belongs to.
///
/// # Errors
/// All that is wrong with it.
pub fn read_published(
    source: Source<'_>,
    wire: &wire::Published,
    tables: &[Table],
) -> Result<Published, SpecError> {
    let name = wire.table.get_ref();
    let Some(table) = tables.iter().find(|t| t.name == *name) else {
        let known: Vec<&str> = tables.iter().map(|t| t.name.as_str()).collect();
        return Err(source.unknown(wire.table.span(), "table", name, known));
    };
    let mut errors = Errors::default();
    if table.ranked.is_some() {
        let message = "a table with a `rank` has no published numbers beside it";
        errors.push(source.error(wire.table.span(), message));
    }
    if table.shows.is_none()
        && table.ranked.is_none()
        && let Side::Metrics(metrics) = &table.rows
        && !metrics.iter().any(|m| m.name() == wire.row.get_ref())
    {
        let known: Vec<&str> = metrics.iter().map(|m| m.name()).collect();
        errors.push(source.unknown(wire.row.span(), "row", wire.row.get_ref(), known));
    }
    let mut values = Vec::new();
    for (column, text) in &wire.values {
        if table.columns == Side::Method && !table.methods.contains(column) {
            let known = table.methods.iter().map(String::as_str);
            errors.push(source.unknown(text.span(), "column", column, known));
        }
        let numbers: Vec<&str> = text.get_ref().split('±').collect();
        let is_number = |n: &&str| n.trim().parse::<f64>().is_ok_and(f64::is_finite);
        if numbers.len() > 2 || !numbers.iter().all(is_number) {
            errors.push(source.error(text.span(), format!("`{}` is not a printed number", text.get_ref())));
        }
        values.push((column.clone(), text.get_ref().clone()));
    }
    errors.check()?;
    let row = wire.row.get_ref().clone();
    Ok(Published { table: name.clone(), tracker: wire.tracker.get_ref().clone(), row, values })
}
