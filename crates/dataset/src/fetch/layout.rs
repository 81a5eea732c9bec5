//! Places under the data root of the members of an archive.

use super::address::Address;
use super::error::FetchError;
use super::member::{MemberFault, parts};
use crate::archive::Archive;
use std::path::{Path, PathBuf};

/// Most parts of a path.
pub(super) const MAX_DEPTH: usize = 16;

/// The wanted members of an archive, and their places under the data root.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct ArchiveLayout {
    into: Vec<String>,
    below: Vec<String>,
    folders: Vec<Vec<String>>,
}

impl ArchiveLayout {
    /// For the folders under the data root that an archive fills.
    ///
    /// # Errors
    /// [`FetchError::Entry`] for names that lead elsewhere.
    pub fn new(archive: &Archive, folders: &[String]) -> Result<Self, FetchError> {
        let path = |name: &str| match name {
            "" => Ok(Vec::new()),
            name => entry_parts(archive, name),
        };
        let folders: Vec<_> = folders.iter().map(|f| entry_parts(archive, f)).collect::<Result<_, _>>()?;
        let below = archive.below.as_deref().unwrap_or_default();
        Ok(Self { into: path(&archive.into)?, below: path(below)?, folders })
    }

    /// The parts of the folder under the data root that the archive's paths start from.
    pub fn into(&self) -> &[String] {
        &self.into
    }

    /// The parts of the folder of the archive that is left out of the paths.
    pub fn below(&self) -> &[String] {
        &self.below
    }

    /// The folders under the data root.
    pub fn folders(&self) -> &[Vec<String>] {
        &self.folders
    }

    /// Path under the data root of a file that is no archive.
    ///
    /// # Errors
    /// As [`ArchiveLayout::new`].
    pub fn file(&self, archive: &Archive) -> Result<Vec<String>, FetchError> {
        let name = Address::parse(&archive.url)?.file_name().to_owned();
        let name = entry_parts(archive, &name)?;
        Ok(self.into.iter().cloned().chain(name).collect())
    }

    /// Path under the data root of a member that is wanted.
    pub fn target(&self, member: &[String]) -> Option<Vec<String>> {
        let rest = member.strip_prefix(self.below.as_slice())?;
        let path: Vec<String> = self.into.iter().chain(rest).cloned().collect();
        self.folders.iter().any(|f| path.starts_with(f)).then_some(path)
    }
}

/// The parts of a path that `datasets.lock` names.
pub(super) fn entry_parts(archive: &Archive, name: &str) -> Result<Vec<String>, FetchError> {
    let fail = |reason| FetchError::Entry { archive: archive.name.clone(), name: name.into(), reason };
    match parts(name.as_bytes(), MAX_DEPTH) {
        Ok(parts) if parts.is_empty() => Err(fail(MemberFault::Empty)),
        Ok(parts) => Ok(parts),
        Err(reason) => Err(fail(reason)),
    }
}

/// A path under `root`.
pub(super) fn join(root: &Path, parts: &[String]) -> PathBuf {
    parts.iter().fold(root.to_path_buf(), |path, part| path.join(part))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::archive::Packing;

    pub fn archive() -> Archive {
        Archive {
            name: "try".into(),
            url: "http://h/try.zip".into(),
            packing: Packing::Zip,
            size: None,
            sha256: None,
            into: "otb".into(),
            below: Some("all/of".into()),
        }
    }

    pub fn parts(text: &str) -> Vec<String> {
        text.split('/').map(String::from).collect()
    }

    #[test]
    fn members_go_where_the_list_says() {
        let layout = ArchiveLayout::new(&archive(), &["otb/a".into(), "otb/b/c".into()]).unwrap();
        for (member, wanted) in [
            ("all/of/a/1", Some("otb/a/1")),
            ("all/of/a", Some("otb/a")),
            ("all/of/b/c/1", Some("otb/b/c/1")),
            ("all/of/b/1", None),
            ("all/of/aa/1", None),
            ("all/a/1", None),
            ("a/1", None),
        ] {
            assert_eq!(layout.target(&parts(member)), wanted.map(parts), "{member}");
        }
        assert_eq!(layout.file(&archive()).unwrap(), ["otb", "try.zip"]);
        for bad in ["../otb", "/otb", "", "."] {
            assert!(
                matches!(ArchiveLayout::new(&archive(), &[bad.into()]), Err(FetchError::Entry { .. })),
                "{bad}"
            );
        }
    }
}
