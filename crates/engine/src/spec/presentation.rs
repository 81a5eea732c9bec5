//! Presentation: the parts of an experiment that can change without another run.

use super::error::{SourceFile, SpecError};
use super::limits;
use std::collections::BTreeMap;
use std::path::Path;
use toml::{Table, Value};

/// Keys that only affect what is shown, and how.
const SHOWN: [&str; 7] = ["title", "note", "paper", "object", "table", "figure", "claim"];

/// Names of the keys that differ between two complete experiment texts
/// ([`Experiment::source`](super::Experiment::source)), without keys of presentation. The order of trackers
/// and methods counts as presentation. Texts that are not TOML differ in everything.
pub fn other_keys(one: &str, other: &str) -> Vec<String> {
    let read = |text: &str| text.parse::<Table>().ok().map(numbers_rest_on);
    match (read(one), read(other)) {
        (Some(one), Some(other)) => {
            let keys = one.keys().chain(other.keys().filter(|key| !one.contains_key(*key)));
            keys.filter(|key| one.get(*key) != other.get(*key)).cloned().collect()
        }
        _ => vec!["everything".to_string()],
    }
}

/// Name of the experiment in a file. The rest of the file is not checked.
///
/// # Errors
/// When the file cannot be read, is not TOML, or has no name.
pub fn name_of(path: &Path) -> Result<String, SpecError> {
    let file = SourceFile::new(&path.display().to_string(), &limits::read_text(path)?);
    let document = file.syntax()?;
    let name = document.get_ref().get("name").and_then(|name| name.get_ref().as_str());
    name.map(str::to_string).ok_or_else(|| file.error(0..0, "there is no `name`"))
}

fn numbers_rest_on(table: Table) -> BTreeMap<String, Value> {
    let sorted = |(key, value): (String, Value)| match (key.as_str(), value) {
        ("tracker" | "method", Value::Array(mut all)) => {
            all.sort_by_cached_key(ToString::to_string);
            (key, Value::Array(all))
        }
        (_, value) => (key, value),
    };
    table.into_iter().filter(|(key, _)| !SHOWN.contains(&key.as_str())).map(sorted).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "title = 'a'\nseed = 1\n[[method]]\nname = 'm'\nw = 1\n[[method]]\nname = 'n'\n[[table]]\nname = 't'\n";

    #[test]
    fn captions_order_and_selection_are_presentation_and_parameters_are_not() {
        let other = |from: &str, to: &str| other_keys(TEXT, &TEXT.replace(from, to));
        assert!(other("'a'", "'b'").is_empty());
        assert!(other("[[table]]\nname = 't'", "[[figure]]\nname = 'u'").is_empty());
        let turned = "[[method]]\nname = 'n'\n[[method]]\nname = 'm'\nw = 1\n";
        assert!(other("[[method]]\nname = 'm'\nw = 1\n[[method]]\nname = 'n'\n", turned).is_empty());
        assert_eq!(other("w = 1", "w = 2"), ["method"]);
        assert_eq!(other("seed = 1", "runs = 2"), ["seed", "runs"]);
        assert_eq!(other("title = 'a'", "title = "), ["everything"]);
    }
}
