//! Archives: what `trackfail data fetch` downloads, as `datasets/archives.toml` names it.

use serde::Deserialize;

/// How an archive is packed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Packing {
    /// A zip file.
    #[default]
    Zip,
    /// A single file without an archive around it, kept as downloaded.
    File,
}

/// A file that `trackfail data fetch` downloads.
#[derive(Debug, Clone, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Archive {
    /// Name of the archive, unique among all. Entries of suites refer to it.
    pub name: String,
    /// Public address of the file, http or https.
    pub url: String,
    /// Packing of the file, which decides how it is unpacked.
    pub packing: Packing,
    /// Size in bytes; `None` if it is not pinned.
    pub size: Option<u64>,
    /// SHA-256 in hexadecimal; `None` if it is not pinned.
    pub sha256: Option<String>,
    /// Folder under the data root that the archive's paths start from, parts separated by `/`.
    pub into: String,
    /// Folder of the archive whose members are unpacked, without the folder itself; `None` for all members.
    pub below: Option<String>,
}
