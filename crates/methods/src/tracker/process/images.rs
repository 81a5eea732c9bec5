//! Image files of frames, for programs that read images by path.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use trackfail_core::image::{Frame, encode_png};
use trackfail_dataset::leftover::TemporaryFolder;

/// Number of written image files that are kept, the newest included.
const MAX_WRITTEN: usize = 2;

/// Image files of frames: a temporary folder for frames that have no file.
pub struct Images {
    folder: TemporaryFolder,
    written: VecDeque<PathBuf>,
    count: u64,
}

impl Images {
    /// Creates the folder, which is empty.
    pub fn new() -> Result<Self, String> {
        let fault = |e: std::io::Error| format!("no temporary folder for its images: {e}");
        let folder = TemporaryFolder::new_in(&std::env::temp_dir(), "trackfail-frames-").map_err(fault)?;
        Ok(Self { folder, written: VecDeque::new(), count: 0 })
    }

    /// Path of the folder.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Path of an image file of the frame: the frame's own file if its path has no control characters, else a
    /// new PNG file.
    pub fn path(&mut self, file: Option<&Path>, frame: &Frame) -> Result<PathBuf, String> {
        let file = file.and_then(|file| std::path::absolute(file).ok());
        if let Some(file) = file.filter(|f| f.to_str().is_some_and(|t| !t.contains(char::is_control))) {
            return Ok(file);
        }
        while self.written.len() >= MAX_WRITTEN {
            // A file that cannot be removed now is deleted with the folder.
            let _ = self.written.pop_front().map(std::fs::remove_file);
        }
        let path = self.folder.path().join(format!("{:08}.png", self.count));
        let fault = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
        let bytes = encode_png(frame).map_err(|e| fault(&e))?;
        std::fs::write(&path, bytes).map_err(|e| fault(&e))?;
        self.count += 1;
        self.written.push_back(path.clone());
        Ok(path)
    }
}
