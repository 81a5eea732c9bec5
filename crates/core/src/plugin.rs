//! Lists of plugins: an entry per kind, parameters that are checked once, and errors that know which part of
//! the experiment file they are about.

use crate::num::readable;
use serde::de::DeserializeOwned;
use std::ops::Range;

/// Unchecked parameters.
pub enum RawParams<'i> {
    /// A JSON value.
    Json(&'i serde_json::Value),
    /// A TOML value that still knows its place in the file.
    #[cfg(feature = "toml")]
    Toml(toml::de::ValueDeserializer<'i>),
}

/// Why parameters are refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct ParamError {
    /// The fault and the remedy, for people.
    pub message: String,
    /// The parameter at fault, unless several are.
    pub key: Option<&'static str>,
    /// Byte range in the text that was read, where the reader knows it.
    pub span: Option<Range<usize>>,
}

impl ParamError {
    /// The error for a value out of its range; `rule` completes "must be ...".
    pub fn out_of_range(key: &'static str, rule: &str, got: impl std::fmt::Display) -> Self {
        let message = format!("`{key}` must be {rule}, not {}", readable(got));
        Self { message, key: Some(key), span: None }
    }
}

/// Reads a plugin's parameters; unknown keys and wrong types are errors with their place.
///
/// # Errors
/// The message of the parser, with the byte range in a text of TOML.
pub fn read_params<P: DeserializeOwned>(raw: RawParams<'_>) -> Result<P, ParamError> {
    match raw {
        RawParams::Json(value) => serde_path_to_error::deserialize(value).map_err(|e| {
            let (at, fault) = (e.path().to_string(), e.inner().to_string());
            let message = if at == "." { fault } else { format!("`{at}`: {fault}") };
            ParamError { message, key: None, span: None }
        }),
        #[cfg(feature = "toml")]
        RawParams::Toml(value) => P::deserialize(value).map_err(|e| of_toml(&e)),
    }
}

#[cfg(feature = "toml")]
fn of_toml(fault: &toml::de::Error) -> ParamError {
    ParamError { message: fault.message().to_string(), key: None, span: fault.span() }
}

/// Checks parameters against closed ranges, each given as key, value, minimum and maximum.
///
/// # Errors
/// For the first one outside its range; NaN is outside every range.
pub fn check_ranges<T: PartialOrd + std::fmt::Display>(
    ranges: &[(&'static str, T, T, T)],
) -> Result<(), ParamError> {
    ranges.iter().try_for_each(|(key, value, low, high)| {
        if (low..=high).contains(&value) {
            return Ok(());
        }
        Err(ParamError::out_of_range(key, &format!("from {low} to {high}"), value))
    })
}

/// Parameters as JSON, with defaults filled in, as they enter addresses and manifests.
pub fn show_params<P: serde::Serialize>(params: &P) -> serde_json::Value {
    serde_json::to_value(params).unwrap_or(serde_json::Value::Null)
}

/// One line of a plugin list.
pub struct Entry<T: ?Sized + 'static> {
    /// The word an experiment file uses.
    pub kind: &'static str,
    /// Raised whenever the plugin's output changes for any input.
    pub version: u32,
    /// One line for `trackfail list`.
    pub summary: &'static str,
    /// Smallest complete parameters as an inline TOML table, for tests and help.
    pub example: &'static str,
    /// Further parameters, so that every branch is under the laws that tests check.
    pub more: &'static [&'static str],
    /// Checks the parameters and builds the plugin.
    pub build: fn(RawParams<'_>) -> Result<Box<T>, ParamError>,
    /// JSON Schema of the parameters.
    pub schema: fn() -> schemars::Schema,
}

impl<T: ?Sized> Clone for Entry<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T: ?Sized> Copy for Entry<T> {}

/// Two lists as one; `N` is the sum of their lengths.
pub const fn joined<T: ?Sized, const N: usize>(list: &[Entry<T>], more: &[Entry<T>]) -> [Entry<T>; N] {
    assert!(list.len() + more.len() == N);
    let mut all = [list[0]; N];
    let mut k = 0;
    while k < N {
        all[k] = if k < list.len() { list[k] } else { more[k - list.len()] };
        k += 1;
    }
    all
}

impl<T: ?Sized> Entry<T> {
    /// Builds from an inline TOML table such as `{ below = 0.039 }`.
    ///
    /// # Errors
    /// As `build`, and for text that is not a TOML value.
    #[cfg(feature = "toml")]
    pub fn build_from_text(&self, text: &str) -> Result<Box<T>, ParamError> {
        let value = toml::de::ValueDeserializer::parse(text).map_err(|e| of_toml(&e))?;
        (self.build)(RawParams::Toml(value))
    }
}

/// The entry of a kind, if the list has one.
pub fn find<T: ?Sized>(list: &'static [Entry<T>], kind: &str) -> Option<&'static Entry<T>> {
    list.iter().find(|e| e.kind == kind)
}

/// The word of `known` that is nearest to `word`, if it is near enough for a misspelling: with more than one letter and
/// more than half of the letters wrong it is another word.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let most = (word.chars().count() / 2).max(1);
    known
        .into_iter()
        .map(|k| (strsim::damerau_levenshtein(&word.to_lowercase(), &k.to_lowercase()), k))
        .filter(|(d, k)| *d <= most.min(2.max(k.chars().count() / 3)))
        .min_by_key(|(d, _)| *d)
        .map(|(_, k)| k)
}

/// Words of `known` that have `part` in them, or a part that is near to it; it is three letters long or longer.
fn with_part<'a>(part: &str, known: &[&'a str]) -> Vec<&'a str> {
    if part.chars().count() < 3 {
        return Vec::new();
    }
    let part = part.to_lowercase();
    let has =
        |k: &&&str| k.to_lowercase().contains(&part) || nearest(&part, k.split([' ', '-', '_'])).is_some();
    known.iter().filter(has).copied().collect()
}

/// The message about an unknown word: it suggests the nearest known word or those that have it as a part, or lists all
/// known ones.
pub fn unknown<'k>(what: &str, word: &str, known: impl IntoIterator<Item = &'k str>) -> String {
    let known: Vec<&str> = known.into_iter().collect();
    let near =
        nearest(word, known.iter().copied()).map_or_else(|| with_part(word, &known), |near| vec![near]);
    match near.as_slice() {
        [] if known.is_empty() => format!("unknown {what} `{word}`: there is none yet"),
        [] => format!("unknown {what} `{word}`; there is: {}", known.join(", ")),
        near => suggest(what, word, near),
    }
}

/// The message about an unknown word that may be one of `near`.
pub fn suggest(what: &str, word: &str, near: &[&str]) -> String {
    format!("unknown {what} `{word}`; did you mean `{}`?", near.join("` or `"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Params {
        below: f64,
        #[serde(default)]
        windows: Vec<u32>,
    }

    #[test]
    fn parameters_are_read_from_json() {
        let read = |value| read_params::<Params>(RawParams::Json(&value));
        let message = |value| read(value).unwrap_err().message;
        let want = Params { below: 2.0, windows: vec![3] };
        assert_eq!(read(serde_json::json!({ "below": 2, "windows": [3] })), Ok(want));
        assert_eq!(
            message(serde_json::json!({ "below": 0.5, "windows": [1, -2] })),
            "`windows[1]`: invalid value: integer `-2`, expected u32"
        );
        assert_eq!(message(serde_json::json!({})), "missing field `below`");
        assert!(message(serde_json::json!({ "above": 1 })).contains("unknown field `above`"));
    }

    #[test]
    fn an_unknown_word_leads_to_the_known_ones() {
        let message = |known: &[&str]| unknown("signal", "histgram", known.iter().copied());
        assert_eq!(
            message(&["posterior", "histogram"]),
            "unknown signal `histgram`; did you mean `histogram`?"
        );
        assert_eq!(message(&["a", "b"]), "unknown signal `histgram`; there is: a, b");
        assert_eq!(message(&[]), "unknown signal `histgram`: there is none yet");
    }

    #[test]
    fn several_words_with_one_part_are_suggested() {
        let known = ["DTEF", "Fused boxes", "Fused deep", "RAW"];
        assert_eq!(
            unknown("method", "Fusd", known),
            "unknown method `Fusd`; did you mean `Fused boxes` or `Fused deep`?"
        );
    }

    #[test]
    fn a_suggestion_has_something_of_the_word() {
        let suggested = |word: &str, known: &[&str]| {
            let message = unknown("row", word, known.iter().copied());
            let suggestion = message.strip_suffix("`?").and_then(|text| text.rsplit('`').next());
            suggestion.map(str::to_string)
        };
        let rows = ["tp", "fpr", "f_score", "delay_median", "recall"];
        for (word, near) in [
            ("f1", None),
            ("foo", None),
            ("xx", None),
            ("fn", None),
            ("fp", Some("tp")),
            ("frp", Some("fpr")),
            ("Delay", Some("delay_median")),
            ("median", Some("delay_median")),
            ("score", Some("f_score")),
            ("rcal", Some("recall")),
            ("medain", Some("delay_median")),
            ("re", None),
        ] {
            assert_eq!(suggested(word, &rows).as_deref(), near, "{word}");
        }
        // Of two that have the word in them none is meant more than the other; a letter alone is a slip.
        let both = "unknown row `table`; did you mean `a/table1` or `b/table2`?";
        assert_eq!(unknown("row", "table", ["a/table1", "b/table2"]), both);
        assert_eq!(suggested("u", &["t"]).as_deref(), Some("t"));
        assert_eq!(suggested("", &["t"]).as_deref(), Some("t"));
    }

    #[test]
    fn the_first_value_outside_its_range_is_refused() {
        assert_eq!(check_ranges(&[("a", 0.5, 0.5, 1.0), ("b", 1.0, 0.5, 1.0)]), Ok(()));
        let error =
            check_ranges(&[("a", 0.7, 0.5, 1.0), ("b", 1.5, 0.5, 1.0), ("c", 9.0, 0.0, 1.0)]).unwrap_err();
        assert_eq!(error, ParamError::out_of_range("b", "from 0.5 to 1", 1.5));
        assert_eq!((error.key, error.message.as_str()), (Some("b"), "`b` must be from 0.5 to 1, not 1.5"));
        for bad in [f64::NAN, f64::NEG_INFINITY, 0.499] {
            assert!(check_ranges(&[("a", bad, 0.5, 1.0)]).is_err(), "{bad}");
        }
        assert_eq!(check_ranges(&[("n", 3_usize, 3, 3)]), Ok(()));
        assert!(check_ranges(&[("n", 4_usize, 1, 3)]).is_err());
    }
}
