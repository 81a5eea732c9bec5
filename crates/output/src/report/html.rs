//! The page as one HTML file.
//!
//! minijinja escapes every text; the only markup that passes unescaped are figures that [`Page::check`] has checked,
//! and series from [`super::sequences::json`]. The content security policy of the page lets it load only files beside
//! it and run only its own script.

use super::page::{Page, ReportError};
use base64::Engine;
use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{Environment, UndefinedBehavior};
use serde::Serialize;
use sha2::{Digest, Sha256};
use trackfail_dataset::text::visible;
use trackfail_methods::score::tracker_metric::TRACKER_METRICS;

/// Renders `index.html`.
///
/// # Errors
/// See [`ReportError`].
pub fn render(page: &Page) -> Result<String, ReportError> {
    page.check()?;
    let script = concat!(include_str!("templates/page.js"), include_str!("templates/viewer.js"));
    fill(include_str!("templates/page.html"), include_str!("templates/page.css"), script, page)
}

/// Fills the template of an HTML file, whose content security policy allows only its script.
///
/// # Errors
/// When the template does not fit the data, which would be a bug.
pub(super) fn fill(
    template: &'static str,
    style: &'static str,
    script: &'static str,
    about: &impl Serialize,
) -> Result<String, ReportError> {
    // minijinja escapes because the name ends in .html.
    let mut environment = environment("page.html", template)?;
    let digest = base64::engine::general_purpose::STANDARD.encode(Sha256::digest(script.as_bytes()));
    environment.add_global("script", script);
    environment.add_global("script_digest", format!("sha256-{digest}"));
    environment.add_global("style", style);
    environment.add_filter("visible", |text: String| visible(&text));
    environment.add_filter("in_words", |name: String| in_words(&name));
    environment.add_filter("address", |path: String| address(&path));
    Ok(environment.get_template("page.html")?.render(Serde(about))?)
}

/// An environment with one template.
pub(super) fn environment(
    name: &'static str,
    template: &'static str,
) -> Result<Environment<'static>, ReportError> {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.set_syntax(SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build()?);
    environment.add_template(name, template)?;
    Ok(environment)
}

/// A name of a table or a figure as a heading: a metric of trackers that it ends with is in words, as in
/// `uncertainty, success AUC` of `uncertainty-success_auc`.
fn in_words(name: &str) -> String {
    let metric = |(what, metric): (&str, &str)| {
        let known = TRACKER_METRICS.iter().find(|m| m.name == metric)?;
        Some(format!("{what}, {}", known.heading))
    };
    name.split_once('-').and_then(metric).unwrap_or_else(|| name.to_string())
}

/// A path below the page's folder as a URL, with all other characters percent-encoded.
fn address(path: &str) -> String {
    let plain = |b: u8| b.is_ascii_alphanumeric() || b"-_./".contains(&b);
    path.bytes().map(|b| if plain(b) { char::from(b).to_string() } else { format!("%{b:02X}") }).collect()
}

#[cfg(test)]
mod tests {
    use super::in_words;

    #[test]
    fn a_metric_in_a_heading_is_in_words() {
        assert_eq!(in_words("uncertainty-success_auc"), "uncertainty, success AUC");
        assert_eq!((in_words("f-score"), in_words("table1")), ("f-score".into(), "table1".into()));
    }
}
