//! Numbers that a paper prints, beside the table they belong to.

use super::{Published, Side, Table};
use crate::spec::error::{Source, SpecError};
use crate::spec::wire;

/// Checks a `[[published]]` against the table it belongs to.
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
    if table.ranked.is_some() {
        return Err(
            source.error(wire.table.span(), "a table with a `rank` has no published numbers beside it")
        );
    }
    if table.shows.is_none()
        && let Side::Metrics(metrics) = &table.rows
        && !metrics.iter().any(|m| m.name() == wire.row.get_ref())
    {
        let known: Vec<&str> = metrics.iter().map(|m| m.name()).collect();
        return Err(source.unknown(wire.row.span(), "row", wire.row.get_ref(), known));
    }
    let mut values = Vec::new();
    for (column, text) in &wire.values {
        if table.columns == Side::Method && !table.methods.contains(column) {
            let known = table.methods.iter().map(String::as_str);
            return Err(source.unknown(text.span(), "column", column, known));
        }
        let numbers: Vec<&str> = text.get_ref().split('±').collect();
        let is_number = |n: &&str| n.trim().parse::<f64>().is_ok_and(f64::is_finite);
        if numbers.len() > 2 || !numbers.iter().all(is_number) {
            return Err(source.error(text.span(), format!("`{}` is not a printed number", text.get_ref())));
        }
        values.push((column.clone(), text.get_ref().clone()));
    }
    let row = wire.row.get_ref().clone();
    Ok(Published { table: name.clone(), tracker: wire.tracker.get_ref().clone(), row, values })
}
