//! Links of a page's numbers: the formula of each, and the command that explains it.

use super::formula;
use crate::report::sequences::Tallies;
use crate::results::{Results, grouped};
use crate::table::layout::{Cell, Link, Origin, TableLayout};
use std::collections::BTreeMap;

/// Adds a link to each cell that shows a pooled number. `trackers` and `shown` are those of the page's table
/// of sequences.
pub fn link(results: &Results, layouts: &mut [TableLayout], trackers: &[String], shown: &Tallies) {
    let experiment = &results.experiment;
    let place = |of: &[String], name: &str| of.iter().position(|known| known == name);
    for layout in layouts {
        let table = format!("{}/{}", experiment.name, layout.name);
        let origins: Vec<Origin> = layout.cells().filter_map(|(.., cell)| cell.of.clone()).collect();
        let alike = grouped(&origins, |of| (of.row.as_str(), of.column.as_str()));
        let alike: BTreeMap<(&str, &str), Vec<&Origin>> = alike.into_iter().collect();
        let explain = |cell: &Cell, of: &Origin| {
            let method = of.label();
            let only = of.attribute.as_ref().map_or_else(String::new, |a| format!(", only {a},"));
            let ours = cell.ours.as_deref().unwrap_or("without a value");
            Link {
                number: format!("{} of {method} on {}{only} is {ours}", of.metric.title(), of.tracker),
                formula: formula(of.metric, of.counts, experiment.protocol_of(&of.method)),
                command: command(&table, of, &alike[&(of.row.as_str(), of.column.as_str())]),
                tracker: place(trackers, &of.tracker),
                method: place(&shown.methods, &method),
                attribute: of.attribute.as_ref().and_then(|a| place(&shown.attributes, a)),
            }
        };
        for cell in layout.groups.iter_mut().flat_map(|g| &mut g.rows).flat_map(|row| &mut row.cells) {
            cell.link = cell.of.as_ref().map(|of| explain(cell, of));
        }
    }
}

/// Command line that explains a cell. `alike` are all cells of the table in the same row and column.
fn command(table: &str, of: &Origin, alike: &[&Origin]) -> String {
    let mut words = vec!["trackfail".to_string(), "explain".to_string()];
    words.extend([table, &of.row, &of.column].map(quoted));
    if alike.iter().any(|other| other.tracker != of.tracker) {
        words.extend(["--tracker".to_string(), quoted(&of.tracker)]);
    }
    if alike.iter().any(|other| other.label() != of.label()) {
        words.extend(["--method".to_string(), quoted(&of.label())]);
    }
    words.join(" ")
}

/// Quotes a word for a shell, if needed.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_./@%+=:,-".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_string();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_methods::score::{Counts, Metric};

    #[test]
    fn commands_name_what_they_must_and_can_be_typed() {
        let of = |tracker: &str, params: &str| {
            let [row, column, tracker, method, params] =
                ["f_score", "M", tracker, "M", params].map(String::from);
            let (metric, counts) = (Metric::F_SCORE, Counts::default());
            Origin { row, column, tracker, method, params, attribute: None, metric, counts }
        };
        let (a, b, c) = (of("A", "x=1"), of("B's", "x=1"), of("B's", "x=2"));
        assert_eq!(command("q/t", &a, &[&a]), "trackfail explain q/t f_score M");
        assert_eq!(command("q/t", &a, &[&a, &b]), "trackfail explain q/t f_score M --tracker A");
        let quoted_words = r"trackfail explain 'q t' f_score M --tracker 'B'\''s' --method 'M[x=2]'";
        assert_eq!(command("q t", &c, &[&a, &b, &c]), quoted_words);
        assert_eq!(quoted(""), "''");
    }
}
