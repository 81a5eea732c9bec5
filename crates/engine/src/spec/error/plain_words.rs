//! Faults of values in words for people: serde speaks of types of Rust.

use trackfail_dataset::text::shorten_to;

/// Smallest value of the file's own numbers that do not begin with 0.
pub(in crate::spec) const FIRST_NUMBER: [(&str, u64); 4] =
    [("schema", 1), ("runs", 1), ("training_runs", 1), ("quantiles", 2)];

/// Longest text of the file that is repeated, in characters.
const MAX_TEXT: usize = 40;

/// The message about a value of a wrong type or size, such as "`runs` must be a whole number from 1 on, not \"ten\"";
/// `None` for messages about something else. `first` gives the first of the whole numbers that cannot be negative.
pub(in crate::spec) fn in_plain_words(
    message: &str,
    key: Option<&str>,
    first: impl FnOnce() -> u64,
) -> Option<String> {
    let rest = message.strip_prefix("invalid type: ").or_else(|| message.strip_prefix("invalid value: "))?;
    let (found, expected) = rest.rsplit_once(", expected ")?;
    let subject = key.map_or_else(|| "this".to_string(), |key| format!("`{key}`"));
    Some(format!("{subject} must be {}, not {}", wanted(expected, first), given(found)))
}

/// A type of Rust or serde, in words.
fn wanted(expected: &str, first: impl FnOnce() -> u64) -> String {
    match expected {
        "u8" | "u16" | "u32" | "u64" | "u128" | "usize" => format!("a whole number from {} on", first()),
        "a nonzero u8" | "a nonzero u16" | "a nonzero u32" | "a nonzero u64" | "a nonzero usize" => {
            "a whole number from 1 on".to_string()
        }
        "i8" | "i16" | "i32" | "i64" | "i128" | "isize" => "a whole number".to_string(),
        "f32" | "f64" => "a number".to_string(),
        "a string" | "string" | "str" | "a borrowed string" => "text in quotes".to_string(),
        "a boolean" => "true or false".to_string(),
        "a sequence" => "a list".to_string(),
        "a map" => "a table".to_string(),
        _ if expected.starts_with("struct ") => "a table".to_string(),
        _ if expected.starts_with("enum ") || expected.starts_with("string or") => {
            "one of its words".to_string()
        }
        _ => expected.replace("an array of length", "a list of length"),
    }
}

/// The value that was found, in words.
fn given(found: &str) -> String {
    let quoted = |prefix: &str| found.strip_prefix(prefix).map(|text| text.trim_matches('`').to_string());
    let plain = ["integer ", "floating point ", "boolean "].into_iter().find_map(quoted);
    if let Some(plain) = plain {
        return plain;
    }
    match found {
        "sequence" => "a list".to_string(),
        "map" => "a table".to_string(),
        _ => shorten_to(found.strip_prefix("string ").unwrap_or(found), MAX_TEXT),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_are_told_in_words() {
        let told = |message: &str| in_plain_words(message, Some("runs"), || 1);
        let rows = [
            (
                "invalid type: string \"ten\", expected u32",
                "`runs` must be a whole number from 1 on, not \"ten\"",
            ),
            (
                "invalid value: integer `-3`, expected usize",
                "`runs` must be a whole number from 1 on, not -3",
            ),
            (
                "invalid type: floating point `0.5`, expected u64",
                "`runs` must be a whole number from 1 on, not 0.5",
            ),
            ("invalid type: boolean `true`, expected f64", "`runs` must be a number, not true"),
            ("invalid type: sequence, expected a string", "`runs` must be text in quotes, not a list"),
            ("invalid type: map, expected a sequence", "`runs` must be a list, not a table"),
            ("invalid type: integer `1`, expected struct Train", "`runs` must be a table, not 1"),
        ];
        for (message, expected) in rows {
            assert_eq!(told(message).as_deref(), Some(expected));
        }
        assert_eq!(told("unknown field `a`, expected `b`"), None);
        let without = in_plain_words("invalid type: integer `3`, expected a string", None, || 0);
        assert_eq!(without.as_deref(), Some("this must be text in quotes, not 3"));
    }
}
