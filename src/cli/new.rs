//! `trackfail new NAME`: writes a commented minimal experiment that runs, and the schema with which editors
//! check it.

use super::{Failure, output, schema};
use crate::spec::{builtin, check_experiment_name};
use crate::user_file;
use std::path::Path;

/// Arguments of `new`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Name of the experiment, such as `first` or `mine/first`; the file in this folder has its last part and `.toml`
    name: String,
    /// Replace the file, and the schema beside it, if they are there
    #[arg(long)]
    force: bool,
}

/// Text of the experiment, with placeholders for its name and its file.
const TEMPLATE: &str = include_str!("new.toml");
/// Name of the schema beside the experiment. A `schema.json` may belong to the user.
const SCHEMA: &str = "trackfail.schema.json";

/// Runs the verb.
///
/// # Errors
/// `Usage` for an invalid name, the name of a built-in experiment, or an existing file; `Io` for errors of
/// the file system.
pub fn run(args: &Args) -> Result<(), Failure> {
    let name = args.name.strip_suffix(".toml").unwrap_or(&args.name);
    check_experiment_name(name).map_err(Failure::usage)?;
    if builtin::EXPERIMENTS.iter().any(|(known, _)| *known == name) {
        let message = format!(
            "`{name}` is a built-in experiment, whose results these would replace; take another name"
        );
        return Err(Failure::usage(message));
    }
    let file = format!("{}.toml", name.rsplit('/').next().unwrap_or(name));
    let files = [(SCHEMA, schema::text()?), (file.as_str(), text(name, &file))];
    // A schema that is the same is the program's own.
    let is_own =
        |path: &str, text: &str| path == SCHEMA && std::fs::read(path).is_ok_and(|b| b == text.as_bytes());
    let is_taken = |path: &str, text: &str| Path::new(path).symlink_metadata().is_ok() && !is_own(path, text);
    if let Some((name, _)) = files.iter().rev().find(|(path, text)| !args.force && is_taken(path, text)) {
        return Err(Failure::usage(format!("{name} is there already; --force replaces it")));
    }
    for (path, text) in &files {
        user_file::write(Path::new(path), text.as_bytes()).map_err(Failure::io)?;
    }
    output::write(&format!("experiment: {file}\nschema:     {SCHEMA}\nrun it:     trackfail run {file}\n"))
}

/// Text of the experiment, with its name and file filled in.
fn text(name: &str, file: &str) -> String {
    TEMPLATE.replace("SCHEMA", SCHEMA).replace("NAME", name).replace("FILE", file)
}
