//! The suites that a command knows: built-in, rendered, and the user's own.

use super::user::{self, USER_LOCK};
use super::{Suite, SuiteContent};
use crate::lock::{PinnedSuite, pinned_suite, pinned_suite_names};
use crate::{DatasetError, synthetic, text};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trackfail_core::plugin::unknown;

/// The built-in suites, the rendered suites, and the user suites that were added.
///
/// The default has no user suites. A copy is cheap.
#[derive(Debug, Clone, Default)]
pub struct Catalog {
    /// User suites, each with the file that defines it.
    user: Vec<(PathBuf, Arc<PinnedSuite>)>,
}

impl Catalog {
    /// Adds the user suites of a data root from its `datasets.lock`. Does nothing if the root has no such
    /// file.
    ///
    /// # Errors
    /// A file that cannot be read or is wrong, or a suite that another file defines differently.
    pub fn add_root(&mut self, data_root: &Path) -> Result<(), DatasetError> {
        let path = data_root.join(USER_LOCK);
        if text::is_absent(&path) { Ok(()) } else { self.add_file(&path, &text::read_capped(&path)?) }
    }

    /// Adds the user suites of a file with these contents, as [`Catalog::add_root`] does; `path` is for
    /// messages.
    ///
    /// # Errors
    /// Wrong contents, or a suite that another file defines differently.
    pub fn add_file(&mut self, path: &Path, bytes: &[u8]) -> Result<(), DatasetError> {
        for suite in user::parse(path, bytes)? {
            match self.user.iter().find(|(_, known)| known.name == suite.name) {
                Some((file, known)) if user::section(known) != user::section(&suite) => {
                    let message = format!(
                        "suite `{}` is another one in {}; rename one of the two, or give both the same section",
                        suite.name,
                        file.display()
                    );
                    return Err(DatasetError::content(path, message));
                }
                Some(_) => {}
                None => self.user.push((path.to_path_buf(), Arc::new(suite))),
            }
        }
        Ok(())
    }

    /// Names of all suites: built-in ones on disk, rendered ones, then user suites.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        let built_in = pinned_suite_names().chain(synthetic::SUITES.iter().map(|s| s.name));
        built_in.map(|name| -> &str { name }).chain(self.user.iter().map(|(_, s)| s.name.as_str()))
    }

    /// All suites, in the order of [`Catalog::names`].
    pub fn suites(&self) -> impl Iterator<Item = Suite> {
        self.names().filter_map(|name| self.find(name))
    }

    /// Returns the suite called `name`.
    ///
    /// # Errors
    /// [`DatasetError::Unknown`], which suggests the nearest name.
    pub fn suite(&self, name: &str) -> Result<Suite, DatasetError> {
        self.find(name).ok_or_else(|| DatasetError::Unknown(unknown("suite", name, self.names())))
    }

    fn find(&self, name: &str) -> Option<Suite> {
        let on_disk = pinned_suite(name).or_else(|| self.user_suite(name)).cloned();
        let rendered = || synthetic::SUITES.iter().find(|s| s.name == name).map(SuiteContent::Rendered);
        on_disk.map(SuiteContent::OnDisk).or_else(rendered).map(Suite)
    }

    fn user_suite(&self, name: &str) -> Option<&Arc<PinnedSuite>> {
        self.user.iter().map(|(_, suite)| suite).find(|suite| suite.name == name)
    }

    /// Text of a user file with those of the named suites that are user suites, once each and sorted by name;
    /// `None` if there are none.
    pub fn user_text<'n>(&self, names: impl IntoIterator<Item = &'n str>) -> Option<String> {
        let names: BTreeSet<&str> = names.into_iter().collect();
        let suites = names.into_iter().filter_map(|name| self.user_suite(name));
        let sections: Vec<String> = suites.map(|suite| user::section(suite)).collect();
        (!sections.is_empty()).then(|| user::with_sections("", &sections.join("\n")))
    }
}

#[cfg(test)]
mod tests {
    use super::super::user::tests::USER_FILE;
    use super::*;
    use trackfail_testing::assert_says;

    #[test]
    fn user_suites_are_found_by_name() {
        let mut catalog = Catalog::default();
        let built_in = catalog.names().count();
        let mut add = |path: &str, text: &str| catalog.add_file(Path::new(path), text.as_bytes());
        add("a/datasets.lock", USER_FILE).unwrap();
        add("b/datasets.lock", USER_FILE).unwrap();
        // Either of two definitions may be meant, whichever root is given first.
        for words in ["b/datasets.lock: suite `user-a` is another one in ", "a/datasets.lock; rename"] {
            assert_says(add("b/datasets.lock", &USER_FILE.replace("\"S\"", "\"R\"")).unwrap_err(), words);
        }
        assert!(add("b/datasets.lock", &USER_FILE.replace("[3, 4]", "[4, 5]")).is_err());
        add("b/datasets.lock", &USER_FILE.replace("user-a", "user-b")).unwrap();
        assert_eq!(catalog.names().skip(built_in).collect::<Vec<_>>(), ["user-a", "user-b"]);
        assert_eq!(catalog.suite("user-a").unwrap().entries()[0].name, "S");
        assert!(catalog.suite("user-c").is_err());
        assert_eq!(catalog.suites().count(), built_in + 2);
        // Each catalog has its own.
        assert!(Catalog::default().suite("user-a").is_err());
        let text = catalog.user_text(["user-b", "otb-100", "user-b"]).unwrap();
        let section = user::section(catalog.user_suite("user-b").unwrap());
        assert_eq!(text, user::with_sections("", &section));
        assert_eq!(catalog.user_text(["otb-100"]), None);
    }

    #[test]
    fn unknown_suites_name_the_nearest() {
        for (name, words) in [("otb-dtef2O", "did you mean `otb-dtef20`"), ("zzz", "vot2014")] {
            assert_says(Catalog::default().suite(name).unwrap_err(), words);
        }
    }
}
