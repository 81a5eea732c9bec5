//! Lists of plugins: an entry per kind, parameters that are checked once, and errors that know their place in
//! the experiment file.

use crate::num::readable;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::ops::{self, Bound, RangeBounds};
use std::sync::Arc;

/// Unchecked parameters.
pub enum RawParams<'i> {
    /// A JSON value.
    Json(&'i Value),
    /// A TOML value that knows its place in the file.
    #[cfg(feature = "toml")]
    Toml(toml::de::ValueDeserializer<'i>),
}

/// Reason why parameters are refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct ParamError {
    /// Sentence for people: the fault and its mend.
    pub message: String,
    /// Name of the wrong parameter, unless several are involved.
    pub key: Option<&'static str>,
    /// Byte range in the text; `None` if the reader does not know it.
    pub span: Option<ops::Range<usize>>,
}

impl ParamError {
    /// Error for a value out of its range; `rule` completes "must be ...".
    pub fn out_of_range(key: &'static str, rule: &str, got: impl std::fmt::Display) -> Self {
        let message = format!("`{key}` must be {rule}, not {}", readable(got));
        Self { message, key: Some(key), span: None }
    }

    /// Refuses a value that is not fine; the rest as in [`Self::out_of_range`].
    ///
    /// # Errors
    /// When `is_fine` is false.
    pub fn unless(
        is_fine: bool,
        key: &'static str,
        rule: &str,
        got: impl std::fmt::Display,
    ) -> Result<(), Self> {
        if is_fine { Ok(()) } else { Err(Self::out_of_range(key, rule, got)) }
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

/// Parameters as JSON with defaults filled in, as used in addresses and manifests.
pub fn show_params<P: serde::Serialize>(params: &P) -> Value {
    serde_json::to_value(params).unwrap_or(Value::Null)
}

/// Range of numbers for a parameter; for a list, for each of its numbers. Only finite numbers are in range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Name of the parameter.
    pub key: &'static str,
    /// Lower end.
    pub low: Bound<f64>,
    /// Upper end.
    pub high: Bound<f64>,
}

impl Range {
    /// Range of all finite numbers.
    pub const fn of(key: &'static str) -> Self {
        Self { key, low: Bound::Unbounded, high: Bound::Unbounded }
    }

    /// Range from `low` to `high`, both included.
    pub const fn within(key: &'static str, low: f64, high: f64) -> Self {
        Self { key, low: Bound::Included(low), high: Bound::Included(high) }
    }

    /// The range without numbers below `low`.
    pub const fn at_least(self, low: f64) -> Self {
        Self { low: Bound::Included(low), ..self }
    }

    /// The range without `low` and the numbers below it.
    pub const fn above(self, low: f64) -> Self {
        Self { low: Bound::Excluded(low), ..self }
    }

    /// The range without numbers above `high`.
    pub const fn at_most(self, high: f64) -> Self {
        Self { high: Bound::Included(high), ..self }
    }

    /// The range without `high` and the numbers above it.
    pub const fn below(self, high: f64) -> Self {
        Self { high: Bound::Excluded(high), ..self }
    }

    /// The range in words that complete "must be ...".
    pub fn rule(&self) -> String {
        let in_words = |end: Bound<f64>, included: &str, excluded: &str| match end {
            Bound::Included(end) => Some(format!("{included} {}", readable(end))),
            Bound::Excluded(end) => Some(format!("{excluded} {}", readable(end))),
            Bound::Unbounded => None,
        };
        if let (Bound::Included(low), Bound::Included(high)) = (self.low, self.high) {
            return format!("from {} to {}", readable(low), readable(high));
        }
        let ends = [in_words(self.low, "at least", "above"), in_words(self.high, "at most", "below")];
        let ends: Vec<String> = ends.into_iter().flatten().collect();
        if ends.is_empty() { "finite".to_string() } else { ends.join(" and ") }
    }

    /// Checks the parameter in JSON. A missing parameter counts as in range.
    fn check(&self, shown: &Value) -> Result<(), ParamError> {
        // A key with a dot is one of a table in the table.
        let mut path = self.key.split('.');
        let numbers: &[Value] = match path.try_fold(shown, |table, key| table.get(key)) {
            None => &[],
            Some(Value::Array(list)) => list.as_slice(),
            Some(one) => std::slice::from_ref(one),
        };
        numbers.iter().try_for_each(|number| match number.as_f64() {
            Some(number) if (self.low, self.high).contains(&number) => Ok(()),
            Some(number) => Err(ParamError::out_of_range(self.key, &self.rule(), number)),
            // JSON has no other numbers than finite ones.
            None => Err(ParamError::out_of_range(self.key, &self.rule(), "NaN or infinite")),
        })
    }
}

/// A plugin that is built from checked parameters.
pub trait Plugin: Sized {
    /// Type of the parameters.
    type Params: DeserializeOwned + serde::Serialize + schemars::JsonSchema;

    /// Ranges of the parameters, checked in this order.
    const RANGES: &'static [Range] = &[];

    /// Builds the plugin from parameters that are in their [ranges](Self::RANGES).
    ///
    /// # Errors
    /// Parameters that contradict each other, and other errors beyond ranges.
    fn make(params: Self::Params) -> Result<Self, ParamError>;

    /// Parameters as JSON with defaults filled in.
    fn shown(params: &Self::Params) -> Value {
        show_params(params)
    }

    /// Checks the parameters and builds the plugin.
    ///
    /// # Errors
    /// The errors of [`make`](Self::make), and a parameter out of its range.
    fn new(params: Self::Params) -> Result<Self, ParamError> {
        Self::checked(params).map(|(_, plugin)| plugin)
    }

    /// Checks the parameters and builds the plugin; also returns the parameters as [shown](Self::shown).
    ///
    /// # Errors
    /// The errors of [`new`](Self::new).
    fn checked(params: Self::Params) -> Result<(Value, Self), ParamError> {
        let shown = Self::shown(&params);
        Self::RANGES.iter().try_for_each(|range| range.check(&shown))?;
        Ok((shown, Self::make(params)?))
    }
}

/// Parameters that are the plugin itself.
pub trait PlainParams: DeserializeOwned + serde::Serialize + schemars::JsonSchema {
    /// Ranges of the parameters, checked in this order.
    const RANGES: &'static [Range] = &[];

    /// Checks what ranges of single numbers cannot say, after them.
    ///
    /// # Errors
    /// Values that are not valid, or not together.
    fn check(&self) -> Result<(), ParamError> {
        Ok(())
    }

    /// Parameters as JSON with defaults filled in.
    fn shown(&self) -> Value {
        show_params(self)
    }
}

impl<P: PlainParams> Plugin for P {
    type Params = P;

    const RANGES: &'static [Range] = <P as PlainParams>::RANGES;

    fn make(params: P) -> Result<P, ParamError> {
        params.check()?;
        Ok(params)
    }

    fn shown(params: &P) -> Value {
        params.shown()
    }
}

/// Trait object of a list, such as `dyn Detector`, to which a plugin of type `P` can be converted.
pub trait Role<P> {
    /// Converts the plugin to the trait object.
    fn hold(plugin: P) -> Arc<Self>;
}

/// A plugin with its checked parameters. It dereferences to the plugin.
pub struct Configured<T: ?Sized> {
    params: Value,
    /// The plugin itself.
    pub plugin: Arc<T>,
}

impl<T: ?Sized> Configured<T> {
    /// Combines a plugin with its checked parameters.
    pub fn new(params: Value, plugin: Arc<T>) -> Self {
        Self { params, plugin }
    }

    /// Checked parameters with defaults filled in, as used in addresses and manifests.
    pub fn params(&self) -> Value {
        self.params.clone()
    }

    /// Adds a value to the shown parameters, such as the version of a program.
    pub fn show(&mut self, key: &str, value: impl Into<Value>) {
        if let Some(params) = self.params.as_object_mut() {
            params.insert(key.to_string(), value.into());
        }
    }
}

impl<T: ?Sized> Clone for Configured<T> {
    fn clone(&self) -> Self {
        Self { params: self.params.clone(), plugin: self.plugin.clone() }
    }
}

impl<T: ?Sized> ops::Deref for Configured<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.plugin
    }
}

impl<T: ?Sized> AsRef<T> for Configured<T> {
    fn as_ref(&self) -> &T {
        &self.plugin
    }
}

/// An entry of a plugin list.
pub struct Entry<T: ?Sized + 'static> {
    /// Name of the kind in experiment files.
    pub kind: &'static str,
    /// Version, raised whenever the output changes for some input.
    pub version: u32,
    /// One line for `trackfail list`.
    pub summary: &'static str,
    /// Smallest complete parameters as an inline TOML table, for tests and help.
    pub example: &'static str,
    /// Further parameters for tests of general properties, so that all branches are covered.
    pub more: &'static [&'static str],
    /// Ranges of the parameters.
    pub ranges: &'static [Range],
    /// Checks the parameters and builds the plugin.
    pub build: fn(RawParams<'_>) -> Result<Configured<T>, ParamError>,
    /// JSON Schema of the parameters.
    pub schema: fn() -> schemars::Schema,
}

impl<T: ?Sized> Clone for Entry<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T: ?Sized> Copy for Entry<T> {}

/// Joins two lists; `N` must be the sum of their lengths.
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
    /// Entry of a plugin whose parameters are all optional.
    pub const fn of<P: Plugin>(kind: &'static str, version: u32, summary: &'static str) -> Self
    where
        T: Role<P>,
    {
        Self {
            kind,
            version,
            summary,
            example: "{}",
            more: &[],
            ranges: P::RANGES,
            build: build::<T, P>,
            schema: || schemars::schema_for!(P::Params),
        }
    }

    /// The entry with another example.
    pub const fn example(self, example: &'static str) -> Self {
        Self { example, ..self }
    }

    /// The entry with further parameters for tests.
    pub const fn more(self, more: &'static [&'static str]) -> Self {
        Self { more, ..self }
    }

    /// Builds from an inline TOML table such as `{ below = 0.039 }`.
    ///
    /// # Errors
    /// The errors of `build`, and text that is not a TOML value.
    #[cfg(feature = "toml")]
    pub fn build_from_text(&self, text: &str) -> Result<Configured<T>, ParamError> {
        let value = toml::de::ValueDeserializer::parse(text).map_err(|e| of_toml(&e))?;
        (self.build)(RawParams::Toml(value))
    }
}

fn build<T: ?Sized + Role<P>, P: Plugin>(raw: RawParams<'_>) -> Result<Configured<T>, ParamError> {
    let (params, plugin) = P::checked(read_params::<P::Params>(raw)?)?;
    Ok(Configured::new(params, T::hold(plugin)))
}

/// Entry of a kind; `None` if the list lacks it.
pub fn find<T: ?Sized>(list: &'static [Entry<T>], kind: &str) -> Option<&'static Entry<T>> {
    list.iter().find(|e| e.kind == kind)
}

/// Word of `known` that is nearest to `word`; `None` if the difference is too large for a misspelling.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let most = (word.chars().count() / 2).max(1);
    known
        .into_iter()
        .map(|k| (strsim::damerau_levenshtein(&word.to_lowercase(), &k.to_lowercase()), k))
        .filter(|(d, k)| *d <= most.min(2.max(k.chars().count() / 3)))
        .min_by_key(|(d, _)| *d)
        .map(|(_, k)| k)
}

/// Words of `known` that contain `part`, or something similar. `part` must have at least three letters.
fn with_part<'a>(part: &str, known: &[&'a str]) -> Vec<&'a str> {
    if part.chars().count() < 3 {
        return Vec::new();
    }
    let part = part.to_lowercase();
    let has =
        |k: &&&str| k.to_lowercase().contains(&part) || nearest(&part, k.split([' ', '-', '_'])).is_some();
    known.iter().filter(has).copied().collect()
}

/// Message about an unknown word. It suggests the nearest known word or those that contain the word; else it
/// lists all known ones.
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

/// Message about an unknown word that suggests the words `near`.
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
        let negative = message(serde_json::json!({ "below": 0.5, "windows": [1, -2] }));
        assert_eq!(negative, "`windows[1]`: invalid value: integer `-2`, expected u32");
        assert_eq!(message(serde_json::json!({})), "missing field `below`");
        assert!(message(serde_json::json!({ "above": 1 })).contains("unknown field `above`"));
    }

    #[test]
    fn an_unknown_word_leads_to_the_known_ones() {
        let message = |known: &[&str]| unknown("signal", "histgram", known.iter().copied());
        for (known, end) in [
            (&["posterior", "histogram"][..], "; did you mean `histogram`?"),
            (&["a", "b"], "; there is: a, b"),
            (&[], ": there is none yet"),
        ] {
            assert_eq!(message(known), format!("unknown signal `histgram`{end}"));
        }
        let fused = unknown("method", "Fusd", ["DTEF", "Fused boxes", "Fused deep", "RAW"]);
        assert_eq!(fused, "unknown method `Fusd`; did you mean `Fused boxes` or `Fused deep`?");
    }

    #[test]
    fn a_suggestion_has_something_of_the_word() {
        let suggested = |word: &str, known: &[&str]| {
            let message = unknown("row", word, known.iter().copied());
            let suggestion = message.strip_suffix("`?").and_then(|text| text.rsplit('`').next());
            suggestion.map(str::to_string)
        };
        let rows = ["tp", "fpr", "f_score", "delay_median", "recall"];
        for (words, near) in [
            (&["f1", "foo", "xx", "fn", "re"][..], None),
            (&["fp"], Some("tp")),
            (&["frp"], Some("fpr")),
            (&["Delay", "median", "medain"], Some("delay_median")),
            (&["score"], Some("f_score")),
            (&["rcal"], Some("recall")),
        ] {
            words.iter().for_each(|word| assert_eq!(suggested(word, &rows).as_deref(), near, "{word}"));
        }
        // Of two that have the word in them none is meant more than the other; a letter alone is a slip.
        let both = "unknown row `table`; did you mean `a/table1` or `b/table2`?";
        assert_eq!(unknown("row", "table", ["a/table1", "b/table2"]), both);
        assert_eq!(suggested("u", &["t"]).as_deref(), Some("t"));
        assert_eq!(suggested("", &["t"]).as_deref(), Some("t"));
    }

    #[test]
    fn the_first_value_outside_its_range_is_refused() {
        #[derive(Debug)]
        struct Made;

        #[derive(serde::Deserialize, serde::Serialize, schemars::JsonSchema)]
        struct Params {
            a: f64,
            b: Vec<f64>,
            #[serde(skip_serializing_if = "Option::is_none")]
            c: Option<usize>,
        }

        impl Plugin for Made {
            type Params = Params;

            const RANGES: &'static [Range] = &[
                Range::within("a", 0.5, 1.0),
                Range::of("b").above(0.0).at_most(1.0),
                Range::of("c").at_least(3.0),
            ];

            fn make(_: Params) -> Result<Self, ParamError> {
                Ok(Self)
            }
        }

        let message =
            |a: f64, b: &[f64], c| Made::new(Params { a, b: b.to_vec(), c }).err().map(|e| e.message);
        assert_eq!(message(0.5, &[1e-300, 1.0], Some(3)), None);
        for (a, b, c, want) in [
            (1.5, 9.0, 0, "`a` must be from 0.5 to 1, not 1.5"),
            (f64::NAN, 1.0, 3, "`a` must be from 0.5 to 1, not NaN or infinite"),
            (1.0, 0.0, 3, "`b` must be above 0 and at most 1, not 0"),
            (1.0, f64::INFINITY, 3, "`b` must be above 0 and at most 1, not NaN or infinite"),
            (1.0, 1.0, 2, "`c` must be at least 3, not 2"),
        ] {
            assert_eq!(message(a, &[0.5, b], Some(c)).as_deref(), Some(want));
        }
        assert_eq!(message(1.0, &[], None), None);
    }

    #[test]
    fn a_range_in_a_table_is_found_by_its_path() {
        let range = Range::of("response.threshold").below(2.0);
        let check = |value: f64| range.check(&serde_json::json!({ "response": { "threshold": value } }));
        assert_eq!(check(1.9), Ok(()));
        let error = check(2.0).unwrap_err();
        assert_eq!(error.key, Some("response.threshold"));
        assert_eq!(error.message, "`response.threshold` must be below 2, not 2");
        assert_eq!(Range::of("x").rule(), "finite");
        assert_eq!(range.check(&serde_json::json!({})), Ok(()));
    }
}
