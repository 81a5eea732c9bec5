//! The files of a sequence and run: a file with boxes, and a file with a confidence if there is one.

use super::Params;
use crate::tracker::TrackerError;
use crate::tracker::results::{BINARY, confidence};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use trackfail_dataset::SequenceInfo;

/// Format of a file of boxes, as far as the name of the file tells it.
#[derive(Debug, Clone, Copy)]
pub enum Kind {
    /// JSON of OTB.
    Json,
    /// Lines of boxes (OTB text), or rows of MOT.
    Text,
    /// Lines of boxes on VOT's long-term sequences.
    LongTerm,
    /// CSV of OxUvA.
    Csv,
    /// VOT or GOT-10k: a file in a folder named after the sequence.
    OwnFolder,
}

/// The files of a sequence and run.
pub struct Source {
    /// Format of the boxes.
    pub kind: Kind,
    /// Path of the file of boxes.
    pub path: PathBuf,
    /// Path of the file with the confidence.
    pub confidence: Option<PathBuf>,
}

/// The files in the first data root that has a file of boxes.
pub fn find(
    params: &Params,
    sequence: &dyn SequenceInfo,
    run: u32,
    data_roots: &[PathBuf],
) -> Result<Source, TrackerError> {
    let mut first = None;
    for root in data_roots {
        match find_below(params, root, sequence, run) {
            Err(missing @ TrackerError::Missing(_)) => first = first.or(Some(missing)),
            Err(e) => return Err(e),
            Ok((kind, path)) => {
                let confidence = confidence_beside(params, &path)?;
                return Ok(Source { kind, path, confidence });
            }
        }
    }
    Err(first.unwrap_or_else(|| {
        TrackerError::Missing(format!(
            "results `{}` are files of a data root, and none is given; add --data-root DIR or set TRACKFAIL_DATA",
            params.results
        ))
    }))
}

fn find_below(
    Params { results, .. }: &Params,
    root: &Path,
    sequence: &dyn SequenceInfo,
    run: u32,
) -> Result<(Kind, PathBuf), TrackerError> {
    let below = |folder: &str| folder.split('/').fold(root.join("results"), |path, part| path.join(part));
    let (folder, of_run) = (below(results), format!("{results}_{run:03}"));
    let folder_of_run = below(&of_run);
    let mut wanted: Vec<(Kind, &Path, String)> = Vec::new();
    let mut looked_for = Vec::new();
    for name in spellings(sequence.name()) {
        let numbered = format!("{name}_{:03}.txt", run + 1);
        let mut look = |kind, shown: String| {
            wanted.push((kind, folder.as_path(), shown.clone()));
            looked_for.push(shown);
        };
        look(Kind::Json, format!("{name}.json"));
        if run == 0 {
            look(Kind::Text, format!("{name}.txt"));
            look(Kind::LongTerm, format!("{name}{}.txt", confidence::BOXES_END));
            look(Kind::Csv, format!("{name}.csv"));
        }
        look(Kind::Text, numbered.clone());
        look(Kind::OwnFolder, format!("{name}/{numbered}"));
        look(Kind::OwnFolder, format!("longterm/{name}/{numbered}"));
        wanted.push((Kind::Text, folder_of_run.as_path(), format!("{name}.txt")));
    }
    let exact = |(kind, folder, name): &(Kind, &Path, String)| {
        (*kind, name.split('/').fold(folder.to_path_buf(), |path, part| path.join(part)))
    };
    let mut found: Vec<(Kind, PathBuf)> = wanted.iter().map(exact).collect();
    // What is there and no file, such as a pipe, is refused when it is read.
    found.retain(|(_, path)| path.exists());
    if found.is_empty() {
        // One look at a folder tells of most results that they are not there in other letters either.
        let firsts: Vec<&str> = wanted.iter().filter_map(|(.., name)| name.split('/').next()).collect();
        let folders =
            [folder.as_path(), &folder_of_run].map(|folder| (folder, !alike(folder, &firsts).is_empty()));
        for (kind, folder, name) in wanted.iter().filter(|(_, folder, _)| folders.contains(&(*folder, true)))
        {
            found.extend(in_other_case(folder, name).into_iter().map(|path| (*kind, path)));
        }
    }
    match (found.pop(), found.pop()) {
        (Some(one), None) => return Ok(one),
        (Some((_, a)), Some((_, b))) => return Err(two_exist(&a, &b, "keep the one that is meant")),
        (None, _) => {}
    }
    let mut in_bytes = wanted.iter().map(|one| exact(one).1.with_extension("bin"));
    Err(match in_bytes.find(|path| path.is_file()) {
        Some(path) => TrackerError::Broken(format!("{}: {BINARY}", path.display())),
        None => TrackerError::Missing(format!(
            "no result of `{results}` for {}, run {run}: none of {}, and nothing in {of_run}",
            sequence.name(),
            looked_for.join(", ")
        )),
    })
}

/// Paths below a folder that differ from `name` only in capital letters, such as `BasketBall.json` in OTB's
/// results of Struck.
fn in_other_case(folder: &Path, name: &str) -> Vec<PathBuf> {
    let mut found = vec![folder.to_path_buf()];
    for part in name.split('/') {
        found = found.iter().flat_map(|folder| alike(folder, &[Path::new(part)])).collect();
    }
    found
}

/// Entries of a folder whose names differ from one of `paths` at most in capital letters; sorted.
fn alike(folder: &Path, paths: &[impl AsRef<Path>]) -> Vec<PathBuf> {
    let is_name = |name: &OsStr| {
        paths.iter().filter_map(|path| path.as_ref().file_name()).any(|n| n.eq_ignore_ascii_case(name))
    };
    let entries = std::fs::read_dir(folder).into_iter().flatten();
    let paths_of = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let mut found: Vec<PathBuf> = paths_of.filter(|path| path.file_name().is_some_and(is_name)).collect();
    found.sort();
    found
}

/// The file with the confidence beside a file of boxes.
fn confidence_beside(params: &Params, boxes: &Path) -> Result<Option<PathBuf>, TrackerError> {
    let property = params.confidence.as_deref();
    let wanted = confidence::beside(boxes, property);
    let mut found: Vec<PathBuf> =
        wanted.iter().filter(|path| path.symlink_metadata().is_ok()).cloned().collect();
    if found.is_empty() {
        found = boxes.parent().map_or_else(Vec::new, |folder| alike(folder, &wanted));
    }
    match (found.pop(), found.pop(), property) {
        (Some(b), Some(a), _) => {
            let remedy = match property {
                None => "name the one that is meant, such as `confidence = \"all_scores\"`",
                Some(_) => "keep the one that is meant",
            };
            Err(two_exist(&a, &b, remedy))
        }
        (None, _, Some(property)) => {
            let name = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let (boxes, names) = (boxes.display(), wanted.iter().map(name).collect::<Vec<_>>().join(" or "));
            let message = format!("no confidence `{property}` beside {boxes}: it would be {names}");
            Err(TrackerError::Missing(message))
        }
        (one, ..) => Ok(one),
    }
}

fn two_exist(a: &Path, b: &Path, remedy: &str) -> TrackerError {
    TrackerError::Broken(format!("both {} and {} exist; {remedy}", a.display(), b.display()))
}

/// Spellings of the name of a sequence: the name itself, and others if it ends in the number of a target.
pub fn spellings(name: &str) -> Vec<String> {
    let mut all = vec![name.to_owned()];
    if let Some((head, number)) = name.rsplit_once('-') {
        // Three digits would be a run's number.
        let short = (1..=2).contains(&number.len()) && number.bytes().all(|b| b.is_ascii_digit());
        if short && !head.is_empty() {
            all.extend([format!("{head}_{number}"), format!("{head}.{number}")]);
        }
    }
    all
}
