//! The digest of a sequence: 64 hexadecimal digits made from its frames and its ground truth.
//!
//! Two digests, both SHA-256 over the following, integers as 64-bit little-endian, numbers as the 64-bit
//! little-endian bits of an `f64`, text and bytes preceded by their length:
//!
//! - **files digest** ([`Sequence::digest`]): the text `trackfail-files/1`; number of the first frame used,
//!   official first, official last; number of frames; per frame its file name (without folders) and the
//!   file's bytes; the truth. It pins what was downloaded, byte for byte, without decoding. Where the frames
//!   are in a video the text is `trackfail-video/1`, and the video file's name and bytes stand in
//!   the place of those of the frames.
//! - **content digest** ([`content_digest`]): the text `trackfail-content/1`; number of frames; per frame its
//!   number, width, height and RGB bytes; the truth; the number of attributes and each of them; the number of
//!   frame attributes and per attribute its name and one byte per frame. It is the same for a sequence rendered
//!   in memory and for the same sequence written as PNG files and loaded again.
//!
//! The truth has for each frame a tag byte and its values: 0, not annotated; 1, rectangle, `x y w h`; 2,
//! polygon, number of corners, then `x y` of each. Coordinates are 0-based, as they are kept in memory.

use super::{DatasetError, Frames, Sequence, text};
use sha2::{Digest as _, Sha256};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use trackfail_core::region::Region;

/// Files digest of a sequence, computed at the first request and then kept.
pub type Digest = OnceLock<String>;

impl Sequence {
    /// Files digest: SHA-256 in hexadecimal of the frame files and the ground truth in the range used. A
    /// rendered sequence without a known digest gets its content digest. The files are read at the first
    /// call; later calls return the stored digest.
    ///
    /// # Errors
    /// When a file cannot be read.
    pub fn digest(&self) -> Result<&str, DatasetError> {
        if let Some(known) = self.digest.get() {
            return Ok(known);
        }
        let fresh = self.compute_digest()?;
        Ok(self.digest.get_or_init(|| fresh))
    }

    /// SHA-256 in hexadecimal of the image files that the video was decoded into, which differ between
    /// decoders; `None` if the frames are not from a suite's video.
    ///
    /// # Errors
    /// When the video cannot be decoded.
    pub fn decoded_digest(&self) -> Result<Option<String>, DatasetError> {
        let Frames::Video(video) = &self.frames else { return Ok(None) };
        let mut hash = Hash::new("trackfail-decoded/1");
        hash.files(&video.files()?.iter().map(PathBuf::as_path).collect::<Vec<_>>())?;
        Ok(Some(hash.hexadecimal()))
    }

    /// Computes the digest again from the files as they are now. Rendered frames cannot change, so theirs is
    /// returned as stored.
    ///
    /// # Errors
    /// When a file cannot be read.
    pub fn digest_anew(&self) -> Result<String, DatasetError> {
        match &self.frames {
            Frames::Rendered(..) => self.digest().map(str::to_string),
            _ => self.compute_digest(),
        }
    }

    fn compute_digest(&self) -> Result<String, DatasetError> {
        let (layout, files): (_, Vec<&Path>) = match &self.frames {
            Frames::Files(files) => ("trackfail-files/1", files.iter().map(PathBuf::as_path).collect()),
            Frames::Video(video) => ("trackfail-video/1", vec![video.path()]),
            Frames::Stream(stream) => ("trackfail-video/1", vec![stream.path()]),
            Frames::Rendered(..) => return content_digest(self),
            Frames::Absent => ("trackfail-boxes/1", Vec::new()),
        };
        let mut hash = Hash::new(layout);
        let n = self.numbering;
        for number in [n.first, n.official.0, n.official.1] {
            hash.integer(number.into());
        }
        hash.integer(self.len() as u64);
        hash.files(&files)?;
        hash.truth(&self.truth);
        Ok(hash.hexadecimal())
    }
}

/// SHA-256 in hexadecimal of a file's bytes.
///
/// # Errors
/// When the file cannot be read.
pub fn file_digest(path: &Path) -> Result<String, DatasetError> {
    let mut file = BufReader::with_capacity(1 << 20, text::open(path)?.0);
    let mut hash = Hash(Sha256::new());
    loop {
        let bytes = file.fill_buf().map_err(|e| DatasetError::io(path, e))?;
        if bytes.is_empty() {
            return Ok(hash.hexadecimal());
        }
        hash.0.update(bytes);
        let n = bytes.len();
        file.consume(n);
    }
}

/// Content digest: SHA-256 in hexadecimal of pixels, frame numbers, truth and attributes. The kind of file
/// that they came in makes no difference.
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

/// Largest frame or video file that is hashed, in bytes.
const MAX_FILE_BYTES: u64 = 1 << 30;

/// Number of files that the reading thread may be ahead of the hashing.
const READ_AHEAD: usize = 32;

/// Digest being computed.
pub(crate) struct Hash(Sha256);

impl Hash {
    pub fn new(layout: &str) -> Self {
        let mut hash = Self(Sha256::new());
        hash.bytes(layout.as_bytes());
        hash
    }

    fn integer(&mut self, value: u64) {
        self.0.update(value.to_le_bytes());
    }

    pub fn bytes(&mut self, bytes: &[u8]) {
        self.integer(bytes.len() as u64);
        self.0.update(bytes);
    }

    /// Hashes the names and bytes of the files in order, while a thread of its own reads ahead. A thread of
    /// the pool would not do: a pool thread that waits may be given the waiting task itself.
    fn files(&mut self, files: &[&Path]) -> Result<(), DatasetError> {
        std::thread::scope(|scope| {
            let (sender, arrived) = std::sync::mpsc::sync_channel(READ_AHEAD);
            scope.spawn(move || {
                let mut read = files.iter().map(|path| (path, text::read_at_most(path, MAX_FILE_BYTES)));
                // Nobody waits for the rest after a file that cannot be read.
                read.try_for_each(|read| sender.send(read))
            });
            for (path, bytes) in arrived {
                self.bytes(path.file_name().unwrap_or_default().as_encoded_bytes());
                self.bytes(&bytes?);
            }
            Ok(())
        })
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

    pub fn hexadecimal(self) -> String {
        trackfail_core::num::hexadecimal(&self.0.finalize())
    }
}
