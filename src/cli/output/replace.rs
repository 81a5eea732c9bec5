//! Outputs replace files that the user names, but no file that the same command reads, or writes under another option,
//! whatever it is called there.

use crate::cli::Failure;
use crate::dataset::files::is_image;
use crate::engine::store;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A file or a folder, the same for every path and link that leads to it.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Place {
    #[cfg(unix)]
    Known(u64, u64),
    New(PathBuf),
}

impl Place {
    /// The place of what is there, or is to be made in a folder; `None` for devices and pipes, which nothing replaces.
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

    fn of_folder_of(path: &Path) -> Option<Self> {
        Self::of(store::folder_of(path))
    }
}

/// An option with the file or folder that it names.
pub type Named<'a> = (&'static str, &'a Path);

/// Checks outputs before anything is computed.
///
/// # Errors
/// `Io` for a file in no folder; `Usage` for the name `-`, and for two options that name one file.
pub fn check_outputs(outputs: &[Named<'_>]) -> Result<(), Failure> {
    let mut places: Vec<(Place, &Named<'_>)> = Vec::new();
    for output in outputs {
        let (option, path) = *output;
        if path == Path::new("-") {
            return Err(Failure::usage(format!(
                "{option} -: an output is a file; write ./- for a file of that name"
            )));
        }
        store::check_output(path).map_err(Failure::io)?;
        let Some(place) = Place::of(path) else { continue };
        // Images in a folder of images have the names of these.
        let clash = |(known, (_, other)): &&(Place, &Named<'_>)| {
            let is_in = |file: &Path, folder: &Place| {
                is_image(file) && Place::of_folder_of(file).as_ref() == Some(folder)
            };
            *known == place || is_in(path, known) || is_in(other, &place)
        };
        if let Some((_, (other, named))) = places.iter().find(clash) {
            return Err(Failure::usage(format!(
                "{option} {} would replace what {other} {} writes; name another one",
                path.display(),
                named.display()
            )));
        }
        places.push((place, output));
    }
    Ok(())
}

/// Checks that outputs leave what the command reads as it is: a file, a folder, and the files in an output that is a folder.
///
/// # Errors
/// `Usage` for the first output that would not.
pub fn check_inputs<'a>(
    outputs: &[Named<'_>],
    inputs: impl IntoIterator<Item = Named<'a>>,
) -> Result<(), Failure> {
    let places: BTreeMap<Place, &Named<'_>> =
        outputs.iter().filter_map(|output| Some((Place::of(output.1)?, output))).collect();
    if places.is_empty() {
        return Ok(());
    }
    for (input, path) in inputs {
        let folder = Place::of_folder_of(path).filter(|_| is_image(path));
        let found = [Place::of(path), folder].into_iter().flatten().find_map(|place| places.get(&place));
        if let Some((option, output)) = found {
            return Err(Failure::usage(format!(
                "{option} {} would replace what {input} {} reads; name another one",
                output.display(),
                path.display()
            )));
        }
    }
    Ok(())
}
