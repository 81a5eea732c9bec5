//! Archives: what `trackfail data fetch` downloads, as `datasets/archives.toml` names it.

use serde::Deserialize;

/// How an archive is packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Packing {
    /// A zip file.
    Zip,
    /// No archive: one file, kept as it is.
    File,
}

/// One download.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Archive {
    /// Name, unique among all; entries refer to it.
    pub name: String,
    /// Public address, http or https.
    pub url: String,
    /// How it is packed.
    pub packing: Packing,
    /// Size in bytes, where it is known.
    pub size: Option<u64>,
    /// SHA-256 in hexadecimal, where it is known.
    pub sha256: Option<String>,
    /// Folder under the data root that the archive's paths start from, parts separated by `/`.
    pub into: String,
    /// Only members below this folder of the archive are unpacked, and it itself is left out.
    pub below: Option<String>,
}
