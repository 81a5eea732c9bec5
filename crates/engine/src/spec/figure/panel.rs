//! Panels of strip figures: `score:DTEF+RAW`.

use crate::spec::error::{Errors, Source, SpecError};
use crate::spec::table::Words;
use toml::Spanned;

/// Content of one panel of a strip figure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Panel {
    /// O_t.
    Error,
    /// A method's signal.
    Signal(String),
    /// A method's signal with its forecast.
    Forecast(String),
    /// One or more methods' scores with their thresholds.
    Score(Vec<String>),
    /// One or more methods' labels, a lane each.
    Labels(Vec<String>),
    /// The tracker's condition as one or more methods follow it.
    Condition(Vec<String>),
}

/// Checks a panel of a figure.
pub(super) fn read_panel(
    source: Source<'_>,
    word: &Spanned<String>,
    words: &Words,
) -> Result<Panel, SpecError> {
    let text = word.get_ref().as_str();
    let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
    let method = |name: &str| {
        if !words.methods.iter().any(|m| m == name) {
            return Err(source.unknown(
                word.span(),
                "method",
                name,
                words.methods.iter().map(String::as_str),
            ));
        }
        if !words.drawn.iter().any(|m| m == name) {
            let message = format!("`{name}` has a grid; only methods without one can be drawn over frames");
            return Err(source.error(word.span(), message));
        }
        Ok(name.to_string())
    };
    let signal = |name: &str| {
        let name = method(name)?;
        if words.with_signal.contains(&name) {
            return Ok(name);
        }
        Err(source.error(word.span(), format!("`{name}` reads no signal that could be drawn")))
    };
    match kind {
        "error" if rest.is_empty() => Ok(Panel::Error),
        "signal" => Ok(Panel::Signal(signal(rest)?)),
        "forecast" => Ok(Panel::Forecast(signal(rest)?)),
        "score" => Ok(Panel::Score(Errors::collect(rest.split('+').map(method))?)),
        "labels" => Ok(Panel::Labels(Errors::collect(rest.split('+').map(method))?)),
        "condition" => Ok(Panel::Condition(Errors::collect(rest.split('+').map(method))?)),
        _ => {
            let known = ["error", "signal", "forecast", "score", "labels", "condition"];
            Err(source.unknown(word.span(), "panel", kind, known))
        }
    }
}
