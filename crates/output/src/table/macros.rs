//! `macros.tex`: every number of an experiment's tables and of the text around them, so that nobody types a number by
//! hand.
//!
//! One command gives them all: `\tf{khalid2016/table1/SP/recall/DTEF}` is the cell of the table `table1` of the
//! experiment `khalid2016/table1`. The name says which number it is and nothing else, so it stays the same when other
//! numbers come and go: experiment, table, group, row and column with `/` between them, then `published` or `difference`
//! where it is not our own number; a group without a name is left out, and so is a table that is called like the last
//! word of its experiment. Numbers of the text are behind `about`: `\tf{quickstart/about/targets/present}`. Those of
//! several experiments may be read into one document; a name that is not known stops LaTeX with a message. See
//! [`name`] for other characters.

use super::latex::latex_escape;
use super::layout::TableLayout;
use std::collections::BTreeMap;

/// The file's name; no table may be called like it.
pub const FILE: &str = "macros.tex";

/// The name of a number for a list of names. Letters of ASCII, digits, blanks and `_-.=+*:[]` are themselves; everything
/// else is its number in hexadecimal digits: `(7c)`. A part can be read back, so no two lists have the same name.
pub fn name(parts: &[&str]) -> String {
    let escape = |part: &&str| -> String {
        let plain = |c: char| c.is_ascii_alphanumeric() || " _-.=+*:[]".contains(c);
        part.chars().map(|c| if plain(c) { c.to_string() } else { format!("({:x})", c as u32) }).collect()
    };
    parts.iter().map(escape).collect::<Vec<_>>().join("/")
}

/// A number of the text around tables: how many targets there are, how many claims hold, what an analysis found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fact {
    /// Name of the number, in one to three parts: `targets`, `present`.
    pub parts: Vec<String>,
    /// The number as it is printed.
    pub shown: String,
}

/// What stands before the numbers: the command that gives one, and the one that stores it.
const HEAD: &str = "% Every number of the tables, for \\input{macros} and \\tf{NAME}, where NAME stands in this file.\n\
                    \\providecommand{\\tf}[1]{\\ifcsname tf/#1\\endcsname\\csname tf/#1\\endcsname\\else\\errmessage{no \
                    number of trackfail has the name #1}\\fi}\n\\providecommand{\\tfset}[2]{\\expandafter\\gdef\\csname \
                    tf/#1\\endcsname{#2}}\n";

/// All numbers: first those of the text, then table by table.
pub fn macros(experiment: &str, facts: &[Fact], layouts: &[TableLayout]) -> String {
    let of_experiment: Vec<&str> = experiment.split('/').collect();
    let mut numbers: Vec<(Vec<&str>, &str)> = Vec::new();
    for Fact { parts, shown } in facts {
        numbers.push((
            std::iter::once("about").chain(parts.iter().map(String::as_str)).collect(),
            shown.as_str(),
        ));
    }
    for layout in layouts {
        let is_named = of_experiment.last() != Some(&layout.name.as_str());
        let table = if is_named { layout.name.as_str() } else { "" };
        for (group, row, column, cell) in layout.cells() {
            let place = [table, group.key.as_str(), row.label.name.as_str(), column.name.as_str()];
            let kinds = [("", &cell.ours), ("published", &cell.published), ("difference", &cell.difference)];
            for (kind, shown) in kinds {
                let parts = place.into_iter().chain([kind]).filter(|part| !part.is_empty());
                numbers.extend(shown.as_deref().map(|shown| (parts.collect(), shown)));
            }
        }
    }
    let mut text = HEAD.to_string();
    // Tables of analyses can have several rows of one name; names of the later ones end in a number.
    let mut times: BTreeMap<String, usize> = BTreeMap::new();
    for (parts, shown) in numbers {
        let plain = name(&[of_experiment.as_slice(), &parts].concat());
        let time = times.entry(plain.clone()).or_default();
        *time += 1;
        let again = if *time > 1 { format!("/{time}") } else { String::new() };
        text.push_str(&format!("\\tfset{{{plain}{again}}}{{{}}}\n", number(shown)));
    }
    text
}

/// A printed number for text and formulas; its minus is not a hyphen.
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
