//! Sentences and captions: the templates of `templates/sentences.txt`, each under its name.

use super::page::environment;
use minijinja::Environment;
use minijinja::value::Serde;
use serde::Serialize;
use std::sync::LazyLock;

static TEMPLATES: LazyLock<Environment<'static>> = LazyLock::new(|| {
    let mut templates = environment("", "").expect("an empty template");
    for template in include_str!("templates/sentences.txt").split("\n## ").skip(1) {
        let (name, text) = template.split_once('\n').expect("a name above a template");
        templates.add_template(name, text.trim_end()).expect("a template");
    }
    templates
});

/// Renders the template `name` with the values `about`.
pub fn say(name: &str, about: impl Serialize) -> String {
    let template = TEMPLATES.get_template(name).expect("a template of that name");
    template.render(Serde(about)).expect("a template that fits its values")
}
