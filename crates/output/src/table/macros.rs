//! `macros.tex`: all numbers of an experiment's tables and of the text around them, so that nobody types a
//! number by hand.
//!
//! One command prints any number: `\tf{khalid2016/table1/SP/recall/DTEF}` is a cell of the table `table1` of
//! the experiment `khalid2016/table1`. A name stays the same when other numbers are added or removed. It
//! consists of experiment, table, group, row and column with `/` between them, then `published` or
//! `difference` for other than our own number. A group without a name is left out, as is a table named like
//! the last word of its experiment. Numbers of the text are under `about`:
//! `\tf{quickstart/about/targets/present}`. A document may load the numbers of several experiments. An
//! unknown name stops LaTeX with a message. See [`name`] for other characters.

use super::latex::latex_escape;
use super::layout::TableLayout;
use std::collections::BTreeMap;

/// Name of the file, which no table may have.
pub const FILE: &str = "macros.tex";

/// Joins a list of names into one. ASCII letters, digits, blanks and `_-.=+*:[]` are unchanged; other
/// characters become their hexadecimal code: `(7c)`. Names can be decoded, so different lists give different
/// names.
pub fn name(parts: &[&str]) -> String {
    let escape = |part: &&str| -> String {
        let plain = |c: char| c.is_ascii_alphanumeric() || " _-.=+*:[]".contains(c);
        part.chars().map(|c| if plain(c) { c.to_string() } else { format!("({:x})", c as u32) }).collect()
    };
    parts.iter().map(escape).collect::<Vec<_>>().join("/")
}

/// A number for the text around tables, such as a number of targets or claims, or a number of an analysis.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fact {
    /// Name in one to three parts: `targets`, `present`.
    pub parts: Vec<String>,
    /// The number as it is printed.
    pub shown: String,
}

/// Head of the file: the command that prints a number, and the one that stores it.
const HEAD: &str = "% Every number of the tables, for \\input{macros} and \\tf{NAME}, where NAME stands in this file.\n\
                    \\providecommand{\\tf}[1]{\\ifcsname tf/#1\\endcsname\\csname tf/#1\\endcsname\\else\\errmessage{no \
                    number of trackfail has the name #1}\\fi}\n\\providecommand{\\tfset}[2]{\\expandafter\\gdef\\csname \
                    tf/#1\\endcsname{#2}}\n";

/// All numbers: those of the text first, then table by table.
pub fn macros(experiment: &str, facts: &[Fact], layouts: &[TableLayout]) -> String {
    let of_experiment: Vec<&str> = experiment.split('/').collect();
    let mut text = HEAD.to_string();
    // Tables of analyses can have several rows of one name; names of the later ones end in a number.
    let mut times: BTreeMap<String, usize> = BTreeMap::new();
    let mut add = |parts: &[&str], shown: &str| {
        let plain = name(&[of_experiment.as_slice(), parts].concat());
        let time = times.entry(plain.clone()).or_default();
        *time += 1;
        let again = if *time > 1 { format!("/{time}") } else { String::new() };
        text.push_str(&format!("\\tfset{{{plain}{again}}}{{{}}}\n", number(shown)));
    };
    for Fact { parts, shown } in facts {
        let parts = parts.iter().map(String::as_str);
        add(&std::iter::once("about").chain(parts).collect::<Vec<_>>(), shown);
    }
    for layout in layouts {
        let is_named = of_experiment.last() != Some(&layout.name.as_str());
        let table = if is_named { layout.name.as_str() } else { "" };
        for (group, row, column, cell) in layout.cells() {
            let place = [table, group.key.as_str(), row.label.name.as_str(), column.name.as_str()];
            let kinds = [("", &cell.ours), ("published", &cell.published), ("difference", &cell.difference)];
            for (kind, shown) in kinds {
                let Some(shown) = shown else { continue };
                let parts = place.into_iter().chain([kind]).filter(|part| !part.is_empty());
                add(&parts.collect::<Vec<_>>(), shown);
            }
        }
    }
    text
}

/// A printed number with a proper minus sign, for text and formulas.
fn number(shown: &str) -> String {
    let parts: Vec<String> = shown.split('±').map(latex_escape).collect();
    let text = parts.join("\\ensuremath{\\pm}");
    match text.strip_prefix('-') {
        Some(rest) => format!("\\ensuremath{{-}}{rest}"),
        None => text,
    }
}

#[cfg(test)]
mod tests;
