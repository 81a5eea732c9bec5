//! `macros.tex`: a LaTeX command for every number of an experiment's tables and of the text around them, so that nobody
//! types a number by hand.
//!
//! The name of a command says which number it is and nothing else, so it stays the same when other numbers come
//! and go: `\tf`, then experiment, table, group, row and column with an `X` between them, then `published` or
//! `difference` where it is not our own number. Numbers of the text ([`Fact`]) have fewer parts than a cell, so the two
//! are never confused. Letters other than `X` and `Z` are written as they are; see [`name`] for everything else. Different numbers have different names, and those of different experiments
//! may be read into one document.

use super::latex::latex_escape;
use super::layout::TableLayout;
use crate::dataset::text::visible;
use std::collections::BTreeMap;

/// The file's name; no table may be called like it.
pub const FILE: &str = "macros.tex";

/// How digits are written behind a `Z`; no word is the beginning of another.
const DIGITS: [&str; 10] = ["zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine"];

/// The name of a command, without the backslash, for a list of names.
///
/// ASCII letters but `X` and `Z` are themselves, `X` stands between two parts. `Z` begins everything else:
/// `Zone` is 1, `ZU` `_`, `ZH` `-`, `ZS` a blank, `ZP` `.`, `ZV` `/`, `ZE` `=`, `ZX` `X`, `ZZ` `Z`, and `ZO`
/// with six letters from a (0) to p (15) the character of that number. No code is the beginning of another, so
/// a name can be read back and no two lists have the same one.
pub fn name(parts: &[&str]) -> String {
    let mut name = String::from("tf");
    for (k, part) in parts.iter().enumerate() {
        if k > 0 {
            name.push('X');
        }
        for c in part.chars() {
            match c {
                'X' => name.push_str("ZX"),
                'Z' => name.push_str("ZZ"),
                c if c.is_ascii_alphabetic() => name.push(c),
                '0'..='9' => {
                    name.push('Z');
                    name.push_str(DIGITS[(c as usize - '0' as usize).min(9)]);
                }
                '_' => name.push_str("ZU"),
                '-' => name.push_str("ZH"),
                ' ' => name.push_str("ZS"),
                '.' => name.push_str("ZP"),
                '/' => name.push_str("ZV"),
                '=' => name.push_str("ZE"),
                c => {
                    name.push_str("ZO");
                    let nibble = |shift: u32| char::from(b'a' + ((c as u32 >> shift) & 15) as u8);
                    name.extend([20, 16, 12, 8, 4, 0].map(nibble));
                }
            }
        }
    }
    name
}

/// A number of the text around tables: how many targets there are, how many claims hold, what an analysis found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fact {
    /// Name of the number, in one to three parts: `targets`, `present`.
    pub parts: Vec<String>,
    /// The number as it is printed.
    pub shown: String,
}

/// All commands, each below a comment that says what it is: first those of the text, then table by table.
pub fn macros(experiment: &str, facts: &[Fact], layouts: &[TableLayout]) -> String {
    let mut text = String::from(
        "% Every number of the tables as a command, for \\input{macros}; write {} after it where a blank follows.\n",
    );
    if !facts.is_empty() {
        text.push_str("\n% The text around the tables.\n");
    }
    for fact in facts {
        let parts: Vec<&str> = fact.parts.iter().map(String::as_str).collect();
        let whole = [&[experiment], parts.as_slice()].concat();
        let about: Vec<String> = parts.iter().map(|p| visible(p)).collect();
        text.push_str(&format!("% {}\n", about.join(", ")));
        text.push_str(&format!("\\newcommand{{\\{}}}{{{}}}\n", name(&whole), number(&fact.shown)));
    }
    // Tables of analyses can have several rows of one name; commands of the later ones end in a number.
    let mut times: BTreeMap<Vec<&str>, usize> = BTreeMap::new();
    for layout in layouts {
        text.push_str(&format!("\n% {}\n", visible(&layout.caption)));
        for group in &layout.groups {
            for row in &group.rows {
                for (cell, column) in row.cells.iter().zip(&layout.columns) {
                    let place = vec![experiment, &layout.name, &group.key, &row.label, column.as_str()];
                    let time = times.entry(place.clone()).or_default();
                    *time += 1;
                    let again = if *time > 1 { time.to_string() } else { String::new() };
                    let kinds =
                        [("", &cell.ours), ("published", &cell.published), ("difference", &cell.difference)];
                    for (kind, shown) in kinds {
                        let Some(shown) = shown else { continue };
                        let mut parts = place.clone();
                        parts.extend([kind, &again].into_iter().filter(|p| !p.is_empty()));
                        let about = about(&layout.name, &group.key, &row.label, column, kind);
                        text.push_str(&format!("% {about}\n"));
                        text.push_str(&format!("\\newcommand{{\\{}}}{{{}}}\n", name(&parts), number(shown)));
                    }
                }
            }
        }
    }
    text
}

/// Says on one line what a number is.
fn about(table: &str, group: &str, row: &str, column: &str, kind: &str) -> String {
    let parts = [table, group, row, column, kind];
    let words: Vec<String> = parts.into_iter().filter(|p| !p.is_empty()).map(visible).collect();
    words.join(", ")
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
