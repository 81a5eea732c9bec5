//! Frames as files that a program can be told of.

use crate::image::{Frame, encode_png};
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// So many written frames are kept, the one being asked about among them.
const KEPT: usize = 2;

/// A temporary folder for frames without a file.
pub struct Images {
    folder: TempDir,
    written: VecDeque<PathBuf>,
    count: u64,
}

impl Images {
    /// An empty folder.
    pub fn new() -> Result<Self, String> {
        let folder = tempfile::Builder::new().prefix("trackfail-frames-").tempdir();
        let folder = folder.map_err(|e| format!("no temporary folder for its images: {e}"))?;
        Ok(Self { folder, written: VecDeque::new(), count: 0 })
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// A path that stands for the frame: its file, where it has one whose path can be said on a line.
    pub fn path(&mut self, file: Option<&Path>, frame: &Frame) -> Result<PathBuf, String> {
        let file = file.and_then(|file| std::path::absolute(file).ok());
        if let Some(file) = file.filter(|f| f.to_str().is_some_and(|t| !t.contains(char::is_control))) {
            return Ok(file);
        }
        while self.written.len() >= KEPT {
            // What cannot be removed now goes with the folder.
            let _ = self.written.pop_front().map(std::fs::remove_file);
        }
        let path = self.folder.path().join(format!("{:08}.png", self.count));
        let told = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
        let bytes = encode_png(frame).map_err(|e| told(&e))?;
        std::fs::write(&path, bytes).map_err(|e| told(&e))?;
        self.count += 1;
        self.written.push_back(path.clone());
        Ok(path)
    }
}
