//! Long lists whose fields repeat: a field is made ready once for all rows that have it, and rows are written one after
//! the other. A list of a million rows needs no more memory than its columns.

use super::{Format, for_terminal, json, text, write_bytes};
use crate::cli::Failure;
use crate::results;
use comfy_table::{Table, presets};

/// Bytes that are written at once, about.
const AT_ONCE: usize = 1 << 16;

/// A column: its heading, and the values from which every row has one. Values may be the same.
pub struct Column {
    /// The heading.
    pub heading: &'static str,
    /// The values.
    pub values: Vec<String>,
}

/// Prints rows, each the indices of its values, as [`print`](super::print) prints their texts.
///
/// # Errors
/// When stdout cannot be written to.
pub fn print<const N: usize>(
    format: Format,
    columns: &[Column; N],
    rows: impl Iterator<Item = [usize; N]> + Clone,
) -> Result<(), Failure> {
    render(format, columns, rows, |part| write_bytes(part.as_bytes()))
}

/// Gives `write` the printed rows, part by part.
fn render<const N: usize>(
    format: Format,
    columns: &[Column; N],
    rows: impl Iterator<Item = [usize; N]> + Clone,
    mut write: impl FnMut(&str) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let used = used(columns, rows.clone());
    let Some(fields) = fields(format, columns, &used)? else {
        let row = |row: [usize; N]| {
            row.iter().zip(columns).map(|(k, column)| column.values[*k].clone()).collect::<Vec<_>>()
        };
        let headings: Vec<&str> = columns.iter().map(|c| c.heading).collect();
        return write(&for_terminal(&text(format, &headings, &rows.map(row).collect::<Vec<_>>())?));
    };
    let mut part = start(format, &fields);
    let mut order: [usize; N] = std::array::from_fn(|k| k);
    if format == Format::Json {
        // The keys of objects are in alphabetical order.
        order.sort_by_key(|k| columns[*k].heading);
    }
    let mut is_first = true;
    for row in rows {
        let row: [&str; N] = order.map(|k| fields[k].values[row[k]].as_str());
        push_row(format, &mut part, row, is_first);
        is_first = false;
        if part.len() >= AT_ONCE {
            write(&part)?;
            part.clear();
        }
    }
    if format == Format::Json {
        part.push_str(if is_first { "]\n" } else { "\n]\n" });
    }
    write(&part)
}

/// Which values of each column stand in any row.
fn used<const N: usize>(columns: &[Column; N], rows: impl Iterator<Item = [usize; N]>) -> [Vec<bool>; N] {
    let mut used = std::array::from_fn(|k| vec![false; columns[k].values.len()]);
    rows.for_each(|row| {
        used.iter_mut().zip(row).for_each(|(used, k): (&mut Vec<bool>, usize)| used[k] = true)
    });
    used
}

/// A column's heading and values as they are printed.
struct Fields {
    heading: String,
    values: Vec<String>,
}

/// The columns as they are printed; `None` where a value fills several lines of a table.
fn fields<const N: usize>(
    format: Format,
    columns: &[Column; N],
    used: &[Vec<bool>; N],
) -> Result<Option<Vec<Fields>>, Failure> {
    let mut all = Vec::with_capacity(N);
    for (column, used) in columns.iter().zip(used) {
        let fields = match format {
            Format::Table => padded(column, used),
            Format::Csv => Some(quoted(column)?),
            Format::Json => Some(keyed(column)?),
        };
        let Some(mut fields) = fields else { return Ok(None) };
        fields.values.iter_mut().for_each(|value| *value = for_terminal(value));
        all.push(fields);
    }
    Ok(Some(all))
}

/// The values of a column of an aligned table, as wide as the widest that is used.
fn padded(column: &Column, used: &[bool]) -> Option<Fields> {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING).set_header([column.heading]);
    let is_used = |k: &usize| used[*k];
    let places: Vec<usize> = (0..used.len()).filter(is_used).collect();
    places.iter().for_each(|k| {
        table.add_row([&column.values[*k]]);
    });
    let mut lines = table.lines();
    let heading = lines.next()?;
    let mut values = vec![String::new(); column.values.len()];
    for k in places {
        values[k] = lines.next()?;
    }
    lines.next().is_none().then_some(Fields { heading, values })
}

/// The values of a column of a CSV file.
fn quoted(column: &Column) -> Result<Fields, Failure> {
    // A second column, since a missing value that stands alone is written in another way.
    let field = |value: &String| {
        let bytes = results::texts_to_csv(&["v", "end"], &[vec![value.clone(), "end".to_string()]]);
        let text = String::from_utf8_lossy(&bytes.map_err(Failure::io)?).into_owned();
        let field = text.strip_prefix("v,end\n").and_then(|text| text.strip_suffix(",end\n"));
        Ok(field.unwrap_or_default().to_string())
    };
    let values = column.values.iter().map(field).collect::<Result<_, Failure>>()?;
    Ok(Fields { heading: column.heading.to_string(), values })
}

/// The values of a column as entries of JSON objects.
fn keyed(column: &Column) -> Result<Fields, Failure> {
    let heading = serde_json::to_string(column.heading).map_err(Failure::io)?;
    let entry = |value: &String| format!("    {heading}: {}", json(column.heading, value));
    Ok(Fields { values: column.values.iter().map(entry).collect(), heading })
}

/// The text before the first row.
fn start(format: Format, columns: &[Fields]) -> String {
    let headings: Vec<&str> = columns.iter().map(|c| c.heading.as_str()).collect();
    match format {
        Format::Table => headings.concat().trim_end().to_string() + "\n",
        Format::Csv => headings.join(",") + "\n",
        Format::Json => "[".to_string(),
    }
}

fn push_row<const N: usize>(format: Format, part: &mut String, row: [&str; N], is_first: bool) {
    match format {
        Format::Table => {
            let start = part.len();
            row.iter().for_each(|field| part.push_str(field));
            let end = start + part[start..].trim_end().len();
            part.truncate(end);
        }
        Format::Csv => {
            for (k, field) in row.iter().enumerate() {
                part.push_str(if k > 0 { "," } else { "" });
                part.push_str(field);
            }
        }
        Format::Json => {
            part.push_str(if is_first { "\n  {\n" } else { ",\n  {\n" });
            for (k, field) in row.iter().enumerate() {
                part.push_str(if k > 0 { ",\n" } else { "" });
                part.push_str(field);
            }
            part.push_str("\n  }");
            return;
        }
    }
    part.push('\n');
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn whole(format: Format, columns: &[Column; 3], rows: &[[usize; 3]]) -> String {
        let row = |row: &[usize; 3]| (0..3).map(|k| columns[k].values[row[k]].clone()).collect::<Vec<_>>();
        let rows: Vec<_> = rows.iter().map(row).collect();
        for_terminal(&text(format, &columns.each_ref().map(|c| c.heading), &rows).unwrap())
    }

    fn values() -> impl Strategy<Value = Vec<String>> {
        let value =
            prop_oneof!["[a-z0-9.;= ]{0,12}", "\\PC{0,6}", "[\",\\n\\ta]{0,3}", "-?[0-9]{1,3}(\\.[0-9])?"];
        prop::collection::vec(value, 1..6)
    }

    proptest! {
        #[test]
        fn rows_are_printed_as_in_short_lists(
            lists in (values(), values(), values()),
            picks in prop::collection::vec((any::<u16>(), any::<u16>(), any::<u16>()), 0..20),
        ) {
            let column = |heading, values| Column { heading, values };
            let columns = [column("method", lists.0), column("a", lists.1), column("state", lists.2)];
            let row = |p: &(u16, u16, u16)| {
                let at = |k: usize, p: u16| usize::from(p) % columns[k].values.len();
                [at(0, p.0), at(1, p.1), at(2, p.2)]
            };
            let rows: Vec<_> = picks.iter().map(row).collect();
            for format in [Format::Table, Format::Csv, Format::Json] {
                let mut printed = String::new();
                let write = |part: &str| {
                    printed.push_str(part);
                    Ok(())
                };
                render(format, &columns, rows.iter().copied(), write).unwrap();
                prop_assert_eq!(&printed, &whole(format, &columns, &rows), "{:?}", format);
            }
        }
    }
}
