//! Panels of strip figures: `score:DTEF+RAW`.

use crate::spec::error::At;
use crate::spec::table::Words;

/// Content of one panel of a strip figure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Panel {
    /// Overlap error O_t.
    Error,
    /// Signal of a method.
    Signal(String),
    /// Signal of a method, with its forecast.
    Forecast(String),
    /// Scores of one or more methods, with their thresholds.
    Score(Vec<String>),
    /// Labels of one or more methods, one lane each.
    Labels(Vec<String>),
    /// Condition of the tracker, as one or more methods estimate it.
    Condition(Vec<String>),
}

/// Checks a panel of a figure.
pub(super) fn read_panel(at: At<'_>, text: &str, words: &Words) -> Option<Panel> {
    let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
    let is_in = |list: &[String], name: &str| list.iter().any(|known| known == name);
    let method = |name: &str| {
        if !is_in(&words.methods, name) {
            at.tell_unknown("method", name, words.methods.iter().map(String::as_str));
        } else if !is_in(&words.drawn, name) {
            at.tell(format!("`{name}` has a grid; only methods without one can be drawn over frames"));
        }
        name.to_string()
    };
    let signal = |name: &str| {
        if is_in(&words.drawn, name) && !is_in(&words.with_signal, name) {
            at.tell(format!("`{name}` reads no signal that could be drawn"));
        }
        method(name)
    };
    let methods = || rest.split('+').map(method).collect();
    Some(match kind {
        "error" if rest.is_empty() => Panel::Error,
        "signal" => Panel::Signal(signal(rest)),
        "forecast" => Panel::Forecast(signal(rest)),
        "score" => Panel::Score(methods()),
        "labels" => Panel::Labels(methods()),
        "condition" => Panel::Condition(methods()),
        _ => {
            let known = ["error", "signal", "forecast", "score", "labels", "condition"];
            at.tell_unknown("panel", kind, known);
            return None;
        }
    })
}
