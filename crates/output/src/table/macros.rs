//! `macros.tex`: a LaTeX command for every number of an experiment's tables and of the text around them, so that none is
//! typed by hand.
//!
//! The name of a command says which number it is and nothing else, so it stays the same when other numbers come
//! and go: `\tf`, then experiment, table, group, row and column with an `X` between them, then `published` or
//! `difference` where it is not our own number. Numbers of the text ([`Fact`]) have fewer parts than a cell's four and
//! the experiment, so the two are never confused. Letters are written as they are, but for `X` and `Z`; see
//! [`name`] for everything else. Different numbers have different names, and those of different experiments
//! may be read into one document.

use super::latex::latex_escape;
use super::layout::TableLayout;
use crate::dataset::text::visible;
use std::collections::BTreeMap;

/// The file's name; no table may be called like it.
pub const FILE: &str = "macros.tex";

/// How the digits are written, behind a `Z`. None is the beginning of another.
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
    /// What it is, in one to three parts.
    pub parts: Vec<String>,
    /// The number as it is printed.
    pub shown: String,
}

/// All commands, those of the text first, then table by table in their order, each below a comment that says what it
/// is.
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
    // Tables that analyses make can have rows of the same name; the second one's says so.
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

/// What a number is, in words on one line.
fn about(table: &str, group: &str, row: &str, column: &str, kind: &str) -> String {
    let parts = [table, group, row, column, kind];
    let told: Vec<String> = parts.into_iter().filter(|p| !p.is_empty()).map(visible).collect();
    told.join(", ")
}

/// A printed number in text or formulas; a minus is a minus.
fn number(shown: &str) -> String {
    let parts: Vec<String> = shown.split('±').map(latex_escape).collect();
    let text = parts.join("\\ensuremath{\\pm}");
    match text.strip_prefix('-') {
        Some(rest) => format!("\\ensuremath{{-}}{rest}"),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::super::render::tests::sample;
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn every_number_has_a_command() {
        let text = macros("khalid2016/table1", &[], &[sample()]);
        let first = "tfkhalidZtwoZzeroZoneZsixZVtableZoneXtableZoneXStruckXprecisionXDTZOaaaahmEF";
        let expected = format!(
            "% table1, Struck, precision, DT|EF\n\\newcommand{{\\{first}}}{{.120}}\n\
             % table1, Struck, precision, DT|EF, published\n\\newcommand{{\\{first}Xpublished}}{{.110}}\n\
             % table1, Struck, precision, DT|EF, difference\n\\newcommand{{\\{first}Xdifference}}{{+.010}}\n"
        );
        assert!(text.contains(&expected), "{text}");
        assert_eq!(text.matches("\\newcommand").count(), 6);
        assert_eq!(number("-0.17±0.18"), "\\ensuremath{-}0.17\\ensuremath{\\pm}0.18");
        // Two tables of one name, which only analyses can have rows like, are told apart.
        let twice = macros("a", &[], &[sample(), sample()]);
        let names: Vec<&str> =
            twice.split("\\newcommand{").skip(1).filter_map(|t| t.split('}').next()).collect();
        let different: std::collections::BTreeSet<&&str> = names.iter().collect();
        assert_eq!((names.len(), different.len()), (12, 12));
    }

    #[test]
    fn numbers_of_the_text_have_commands_too() {
        let fact = Fact { parts: vec!["targets".into(), "present".into()], shown: "12".into() };
        let text = macros("a", &[fact], &[]);
        assert!(text.ends_with("% targets, present\n\\newcommand{\\tfaXtargetsXpresent}{12}\n"), "{text}");
    }

    /// What [`name`] wrote; nothing for a text it never writes.
    fn read(name: &str) -> Option<Vec<String>> {
        let mut parts = vec![String::new()];
        let mut rest = name.strip_prefix("tf")?;
        while let Some(c) = rest.chars().next() {
            rest = &rest[1..];
            let last = parts.last_mut()?;
            match c {
                'X' => parts.push(String::new()),
                'Z' => {
                    let single =
                        [("ZU", '_'), ("ZH", '-'), ("ZS", ' '), ("ZP", '.'), ("ZV", '/'), ("ZE", '=')];
                    let single = single.iter().chain(&[("ZX", 'X'), ("ZZ", 'Z')]);
                    let digit = DIGITS.iter().position(|d| rest.starts_with(d));
                    if let Some(d) = digit {
                        last.push_str(&d.to_string());
                        rest = &rest[DIGITS[d].len()..];
                    } else if let Some((_, c)) =
                        single.into_iter().find(|(code, _)| rest.starts_with(&code[1..]))
                    {
                        last.push(*c);
                        rest = &rest[1..];
                    } else {
                        let code = rest.strip_prefix('O')?.get(..6)?;
                        let number = code.bytes().fold(0, |n, b| n * 16 + u32::from(b - b'a'));
                        last.push(char::from_u32(number)?);
                        rest = &rest[7..];
                    }
                }
                c => last.push(c),
            }
        }
        Some(parts)
    }

    proptest! {
        // Names can be read back, so no two lists have the same one.
        #[test]
        fn names_are_letters_and_never_confused(
            parts in prop::collection::vec("[a-zA-Z0-9_ XZO.=\\[\\];\u{5d0}\u{1f600}-]{0,12}|\\PC{0,5}", 1..6)
        ) {
            let list: Vec<&str> = parts.iter().map(String::as_str).collect();
            let name = name(&list);
            prop_assert!(name.bytes().all(|b| b.is_ascii_alphabetic()));
            prop_assert_eq!(read(&name), Some(parts));
        }
    }
}
