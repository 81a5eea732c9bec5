//! The digest of a sequence: 64 hexadecimal digits made from its frames and its ground truth.
//!
//! Two digests, both SHA-256 over the following, integers as 64-bit little-endian, numbers as the 64-bit
//! little-endian bits of an `f64`, text and bytes preceded by their length:
//!
//! - **files digest** ([`Sequence::digest`]): the text `trackfail-files/1`; number of the first frame used,
//!   official first, official last; number of frames; per frame its file name (without folders) and the
//!   file's bytes; the truth. It pins what was downloaded, byte for byte, without decoding. Where the frames
//!   are in a video the text is `trackfail-video/1`, and the video file's name and bytes stand in the place
//!   of the frames'.
//! - **content digest** ([`content_digest`]): the text `trackfail-content/1`; number of frames; per frame its
//!   number, width, height and RGB bytes; the truth; the number of attributes and each of them; the number of
//!   frame attributes and per attribute its name and one byte a frame. It is the same for a sequence rendered
//!   in memory and for the same sequence written as PNG files and loaded again.
//!
//! The truth is, per frame, a tag byte and what belongs to it: 0, not annotated; 1, rectangle, `x y w h`;
//! 2, polygon, number of corners, then `x y` of each. Coordinates are 0-based, as they are kept in memory.

use super::{DatasetError, Frames, Sequence, text};
use rayon::prelude::*;
use sha2::{Digest as _, Sha256};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use trackfail_core::region::Region;

/// A sequence's files digest, computed when it is first asked for.
#[derive(Debug, Clone, Default)]
pub struct Digest(OnceLock<String>);

impl<T: Into<String>> From<T> for Digest {
    /// A digest that is known already.
    fn from(hexadecimal: T) -> Self {
        Self(OnceLock::from(hexadecimal.into()))
    }
}

impl Sequence {
    /// SHA-256 in hexadecimal of the frames' files and the ground truth in the range used; of the content
    /// where the frames are rendered and no digest came with them. Reads the files once, then remembers.
    ///
    /// # Errors
    /// When a file cannot be read.
    pub fn digest(&self) -> Result<&str, DatasetError> {
        if let Some(known) = self.digest.0.get() {
            return Ok(known);
        }
        let fresh = self.compute_digest()?;
        Ok(self.digest.0.get_or_init(|| fresh))
    }

    /// SHA-256 in hexadecimal of the frames that a video was decoded into, since another decoder may make other
    /// pixels of it; `None` for frames that are files themselves.
    ///
    /// # Errors
    /// When the video cannot be decoded.
    pub fn decoded_digest(&self) -> Result<Option<String>, DatasetError> {
        let Frames::Video(video) = &self.frames else { return Ok(None) };
        let mut hash = Hash::new("trackfail-decoded/1");
        hash.files_in_turn(video.files()?)?;
        Ok(Some(hash.hexadecimal()))
    }

    fn compute_digest(&self) -> Result<String, DatasetError> {
        match &self.frames {
            Frames::Files(files) => files_digest(self, FILES, files, Hash::files),
            Frames::Video(video) => files_digest(self, VIDEO, &[video.path().to_path_buf()], Hash::files),
            Frames::Stream(stream) => files_digest(self, VIDEO, &[stream.path().to_path_buf()], Hash::files),
            Frames::Rendered(..) => content_digest(self),
            Frames::Absent => files_digest(self, BOXES, &[], Hash::files),
        }
    }

    /// The digest once more, from the files as they are now; rendered frames cannot change.
    ///
    /// # Errors
    /// When a file cannot be read.
    pub fn digest_anew(&self) -> Result<String, DatasetError> {
        match &self.frames {
            Frames::Rendered(..) | Frames::Absent => self.digest().map(str::to_string),
            // One file after the other: who waits for help of other threads may be given their work.
            Frames::Files(files) => files_digest(self, FILES, files, Hash::files_in_turn),
            Frames::Video(video) => {
                files_digest(self, VIDEO, &[video.path().to_path_buf()], Hash::files_in_turn)
            }
            Frames::Stream(stream) => {
                files_digest(self, VIDEO, &[stream.path().to_path_buf()], Hash::files_in_turn)
            }
        }
    }
}

/// Layouts of the digests.
const FILES: &str = "trackfail-files/1";
const VIDEO: &str = "trackfail-video/1";
const BOXES: &str = "trackfail-boxes/1";

fn files_digest(
    sequence: &Sequence,
    layout: &str,
    files: &[PathBuf],
    enter: fn(&mut Hash, &[PathBuf]) -> Result<(), DatasetError>,
) -> Result<String, DatasetError> {
    let mut hash = Hash::new(layout);
    let n = sequence.numbering;
    for number in [n.first, n.official.0, n.official.1] {
        hash.integer(number.into());
    }
    hash.integer(sequence.len() as u64);
    enter(&mut hash, files)?;
    hash.truth(&sequence.truth);
    Ok(hash.hexadecimal())
}

/// SHA-256 in hexadecimal of a file's bytes.
///
/// # Errors
/// When the file cannot be read.
pub fn file_digest(path: &Path) -> Result<String, DatasetError> {
    let mut hash = Hash(Sha256::new());
    hash.0.update(read(path)?);
    Ok(hash.hexadecimal())
}

/// No frame, text or video is larger.
const MAX_FILE_BYTES: u64 = 1 << 30;

fn read(path: &Path) -> Result<Vec<u8>, DatasetError> {
    text::read_at_most(path, MAX_FILE_BYTES)
}

/// SHA-256 in hexadecimal of pixels, frame numbers, truth and attributes, whatever files they came in.
///
/// # Errors
/// When a frame cannot be read.
pub fn content_digest(sequence: &Sequence) -> Result<String, DatasetError> {
    let mut hash = Hash::new("trackfail-content/1");
    hash.integer(sequence.len() as u64);
    for t in 0..sequence.len() {
        let frame = sequence.frame(t)?;
        hash.integer(sequence.number(t).into());
        hash.integer(frame.width() as u64);
        hash.integer(frame.height() as u64);
        hash.bytes(frame.bytes());
    }
    hash.truth(&sequence.truth);
    hash.integer(sequence.attributes.len() as u64);
    for word in &sequence.attributes {
        hash.bytes(word.as_bytes());
    }
    hash.integer(sequence.frame_attributes.len() as u64);
    for (name, flags) in &sequence.frame_attributes {
        hash.bytes(name.as_bytes());
        hash.bytes(&flags.iter().map(|&f| u8::from(f)).collect::<Vec<_>>());
    }
    Ok(hash.hexadecimal())
}

/// Files that are read at once.
const READ_AHEAD: usize = 32;

fn read_all(files: &[PathBuf]) -> Result<Vec<(&PathBuf, Vec<u8>)>, DatasetError> {
    files.par_iter().map(|path| Ok((path, read(path)?))).collect()
}

struct Hash(Sha256);

impl Hash {
    fn new(layout: &str) -> Self {
        let mut hash = Self(Sha256::new());
        hash.bytes(layout.as_bytes());
        hash
    }

    fn integer(&mut self, value: u64) {
        self.0.update(value.to_le_bytes());
    }

    fn bytes(&mut self, bytes: &[u8]) {
        self.integer(bytes.len() as u64);
        self.0.update(bytes);
    }

    /// Names and bytes in order. A digest has one order, so the hashing has one thread; the others read
    /// ahead, a block of files while the block before it is hashed.
    fn files(&mut self, files: &[PathBuf]) -> Result<(), DatasetError> {
        let mut blocks = files.chunks(READ_AHEAD);
        let mut next = blocks.next().map(read_all).transpose()?;
        while let Some(block) = next {
            let ((), ahead) = rayon::join(
                || block.iter().for_each(|(path, bytes)| self.file(path, bytes)),
                || blocks.next().map(read_all).transpose(),
            );
            next = ahead?;
        }
        Ok(())
    }

    fn files_in_turn(&mut self, files: &[PathBuf]) -> Result<(), DatasetError> {
        files.iter().try_for_each(|path| {
            self.file(path, &read(path)?);
            Ok(())
        })
    }

    fn file(&mut self, path: &Path, bytes: &[u8]) {
        self.bytes(path.file_name().unwrap_or_default().as_encoded_bytes());
        self.bytes(bytes);
    }

    fn truth(&mut self, truth: &[Option<Region>]) {
        for region in truth {
            match region {
                None => self.0.update([0]),
                Some(Region::Rect(r)) => {
                    self.0.update([1]);
                    [r.x, r.y, r.w, r.h].iter().for_each(|v| self.integer(v.to_bits()));
                }
                Some(Region::Polygon(corners)) => {
                    self.0.update([2]);
                    self.integer(corners.len() as u64);
                    corners.iter().flat_map(|c| [c.0, c.1]).for_each(|v| self.integer(v.to_bits()));
                }
            }
        }
    }

    fn hexadecimal(self) -> String {
        trackfail_core::num::hexadecimal(&self.0.finalize())
    }
}
