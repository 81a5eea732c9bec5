//! Protection of files: an output may replace the file that the user names, but not a file that the same
//! command reads or writes under another option, even by another name.

use crate::cli::Failure;
use crate::dataset::files::is_image;
use crate::engine::store;
use crate::user_file;
use std::path::{Path, PathBuf};

/// A file or a folder, identified independently of the path or link that leads to it.
#[derive(Debug, PartialEq, Eq)]
enum Place {
    #[cfg(unix)]
    Known(u64, u64),
    New(PathBuf),
}

impl Place {
    /// Identifies a file that exists or would be created; `None` for devices and pipes, which are never
    /// replaced.
    fn of(path: &Path) -> Option<Self> {
        match path.metadata() {
            Ok(about) if !about.is_file() && !about.is_dir() => None,
            #[cfg(unix)]
            Ok(about) => {
                use std::os::unix::fs::MetadataExt;
                Some(Self::Known(about.dev(), about.ino()))
            }
            #[cfg(not(unix))]
            Ok(_) => path.canonicalize().ok().map(Self::New),
            Err(_) => {
                let folder = store::folder_of(path).canonicalize().ok()?;
                Some(Self::New(folder.join(path.file_name()?)))
            }
        }
    }

    /// Folder of an image, since annotated images get the names of the frames.
    fn around(image: &Path) -> Option<Self> {
        Some(image).filter(|image| is_image(image)).and_then(|image| Self::of(store::folder_of(image)))
    }
}

/// An option with the file or folder that it writes.
pub type Output = (&'static str, PathBuf);

/// Checks outputs before anything is computed.
///
/// # Errors
/// `Io` for a file whose folder does not exist; `Usage` for the name `-`, and for two options that name one
/// file.
pub fn check_outputs(outputs: &[Output]) -> Result<(), Failure> {
    let mut places: Vec<(Place, &Output)> = Vec::new();
    for output in outputs {
        let (option, path) = output;
        if path == Path::new("-") {
            return Err(Failure::usage(format!(
                "{option} -: an output is a file; write ./- for a file of that name"
            )));
        }
        user_file::check_folder(path).map_err(Failure::io)?;
        let Some(place) = Place::of(path) else { continue };
        let is_in = |path: &Path, folder: &Place| Place::around(path).as_ref() == Some(folder);
        let clash = |(known, (_, other)): &&(Place, &Output)| {
            *known == place || is_in(path, known) || is_in(other, &place)
        };
        if let Some((_, (option, other))) = places.iter().find(clash) {
            return Err(replaces(output, format_args!("{option} {} writes", other.display())));
        }
        places.push((place, output));
    }
    Ok(())
}

/// Checks that outputs do not replace inputs of the command: a file, a folder, or the files in an output
/// folder.
///
/// # Errors
/// `Usage` for the first output that would replace an input.
pub fn check_inputs<'o, 'a>(
    outputs: &'o [Output],
    inputs: impl IntoIterator<Item = (&'static str, &'a Path)>,
) -> Result<(), Failure> {
    let of = |output: &'o Output| Some((Place::of(&output.1)?, output));
    let places: Vec<(Place, &Output)> = outputs.iter().filter_map(of).collect();
    if places.is_empty() {
        return Ok(());
    }
    for (input, path) in inputs {
        let (own, around) = (Place::of(path), Place::around(path));
        let is_hit = |place: &Place| own.as_ref() == Some(place) || around.as_ref() == Some(place);
        if let Some((_, output)) = places.iter().find(|(place, _)| is_hit(place)) {
            return Err(replaces(output, format_args!("{input} {} reads", path.display())));
        }
    }
    Ok(())
}

fn replaces((option, path): &Output, what: std::fmt::Arguments<'_>) -> Failure {
    Failure::usage(format!("{option} {} would replace what {what}; name another one", path.display()))
}
