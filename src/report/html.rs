//! The page as one HTML file.
//!
//! minijinja escapes every text; the only markup passed through are figures that [`Page::check`] has
//! looked at. The page forbids itself, by its content security policy, to load or run anything.

use super::{Page, ReportError};
use crate::dataset::text::visible;
use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{Environment, UndefinedBehavior};

/// Renders `index.html`.
///
/// # Errors
/// See [`ReportError`].
pub fn render(page: &Page) -> Result<String, ReportError> {
    page.check()?;
    let failed = |e: minijinja::Error| ReportError::Template(e.to_string());
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    let syntax = SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build().map_err(failed)?;
    environment.set_syntax(syntax);
    // The name ends in .html, which turns escaping on.
    environment.add_template("page.html", include_str!("templates/page.html")).map_err(failed)?;
    environment.add_filter("visible", |text: String| visible(&text));
    let template = environment.get_template("page.html").map_err(failed)?;
    template.render(Serde(page)).map_err(failed)
}
