//! Frames from disk: the image files of a folder, and the decoding of one of them.
//!
//! Links to images and to folders of them are followed; what they lead to must be a file of at most
//! [`image::MAX_FILE_BYTES`] bytes, so that reading never waits for a device or a pipe.

use super::{DatasetError, Frames, Sequence, text};
use crate::frame_order::file_name;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use trackfail_core::image::{self, Frame};

impl Sequence {
    /// Frame `t`, 0-based, decoded or rendered anew at each call.
    ///
    /// # Errors
    /// An index beyond the last frame, an unreadable or truncated file, or a size other than that of the
    /// first frame.
    pub fn frame(&self, t: usize) -> Result<Frame, DatasetError> {
        let absent = || {
            let (name, frames) = (&self.name, self.len());
            let message =
                format!("sequence {name} has {frames} frames, numbered here from 0; there is no frame {t}");
            DatasetError::Unknown(message)
        };
        let files: &[PathBuf] = match &self.frames {
            Frames::Rendered(render, n) if t < *n => return Ok(render(t)),
            Frames::Rendered(..) => return Err(absent()),
            Frames::Stream(stream) => return stream.frame(t)?.ok_or_else(absent),
            Frames::Absent => {
                let message = format!("sequence {} has no frames here, only boxes", self.name);
                return Err(DatasetError::Unknown(message));
            }
            Frames::Files(files) => files,
            Frames::Video(video) => video.files()?,
        };
        let path = files.get(t).ok_or_else(absent)?;
        let frame = image::decode(&read(path)?).map_err(|e| bad_image(path, e))?;
        let got = (frame.width(), frame.height());
        let expected = match t {
            0 => *self.size.get_or_init(|| got),
            _ => self.size_of_first(files)?.unwrap_or(got),
        };
        of_size(frame, expected, path)
    }

    /// Width and height of all frames in pixels, taken from the first one.
    ///
    /// # Errors
    /// As [`Sequence::frame`].
    pub fn size(&self) -> Result<(usize, usize), DatasetError> {
        let known = match &self.frames {
            Frames::Files(files) => self.size_of_first(files)?,
            Frames::Video(video) => self.size_of_first(video.files()?)?,
            Frames::Stream(stream) => stream.size(),
            Frames::Rendered(..) => self.size.get().copied(),
            Frames::Absent => None,
        };
        known.map_or_else(|| self.frame(0).map(|f| (f.width(), f.height())), Ok)
    }

    /// Width and height of the first image file; `None` if there are no files. Read at the first call.
    fn size_of_first(&self, files: &[PathBuf]) -> Result<Option<(usize, usize)>, DatasetError> {
        if let Some(known) = self.size.get() {
            return Ok(Some(*known));
        }
        let Some(path) = files.first() else { return Ok(None) };
        let size = image::size(&read(path)?).map_err(|e| bad_image(path, e))?;
        Ok(Some(*self.size.get_or_init(|| size)))
    }
}

fn read(path: &Path) -> Result<Vec<u8>, DatasetError> {
    text::read_at_most(path, image::MAX_FILE_BYTES)
}

/// The error for a frame that cannot be decoded.
pub(crate) fn bad_image(path: &Path, e: image::ImageError) -> DatasetError {
    DatasetError::content(path, format!("{e}; fetch the file again"))
}

/// The frame of a file, if it has the size that is expected.
///
/// # Errors
/// A frame of another size than the sequence's first.
pub fn of_size(frame: Frame, (width, height): (usize, usize), path: &Path) -> Result<Frame, DatasetError> {
    let (w, h) = (frame.width(), frame.height());
    if (w, h) == (width, height) {
        return Ok(frame);
    }
    let message = format!(
        "{w}x{h} pixels, but the sequence starts with {width}x{height}; all frames of a sequence must have one \
         size"
    );
    Err(DatasetError::content(path, message))
}

/// Paths of all entries of a folder, in any order.
pub(crate) fn entries(folder: &Path) -> Result<Vec<PathBuf>, DatasetError> {
    let list = || -> std::io::Result<Vec<PathBuf>> {
        std::fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path())).collect()
    };
    list().map_err(|e| DatasetError::io(folder, e))
}

/// The JPEG and PNG files of a folder by frame number, see [`FormatEntry::images`](crate::format::FormatEntry::images).
#[derive(Debug)]
pub(crate) struct NumberedImages {
    pub folder: PathBuf,
    pub files: BTreeMap<u32, PathBuf>,
}

impl NumberedImages {
    /// Image files of frames `first..=last`, in order.
    ///
    /// # Errors
    /// The first number that has no file.
    pub fn range(&self, (first, last): (u32, u32)) -> Result<Vec<PathBuf>, DatasetError> {
        let missing = |n: u32| {
            // Numbers may be counted from the first file, but names are the user's.
            let between = match (self.files.range(..n).next_back(), self.files.range(n..).next()) {
                (Some((_, a)), Some((_, b))) => format!(", between {} and {}", file_name(a), file_name(b)),
                _ => String::new(),
            };
            let message = format!(
                "frame {n} is missing{between}; frames {first} to {last} are needed: add it, or number the files \
                 without a gap"
            );
            DatasetError::content(&self.folder, message)
        };
        (first..=last).map(|n| self.files.get(&n).cloned().ok_or_else(|| missing(n))).collect()
    }
}

/// Last part of a path, also for `.` and `..`.
pub(crate) fn folder_name(folder: &Path) -> String {
    let whole = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
    whole.file_name().map_or_else(|| "sequence".into(), |n| n.to_string_lossy().into_owned())
}

/// True if the name is that of a JPEG or PNG file.
pub fn is_image(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    extension == "jpg" || extension == "jpeg" || extension == "png"
}

/// Number at the end of a file name, without its extension.
pub(crate) fn number(path: &Path) -> Option<u32> {
    let stem = path.file_stem()?.to_str()?;
    let digits = stem.len() - stem.bytes().rev().take_while(u8::is_ascii_digit).count();
    stem[digits..].parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::content_digest;
    use crate::format::otb;
    use crate::user_frames::without_frames;
    use std::sync::Arc;
    use trackfail_core::region::{Rect, Region};
    use trackfail_testing::{assert_says, folder, put};

    fn ramp(t: usize) -> Frame {
        Frame::from_fn(12, 7, |x, y| [x as u8, y as u8, t as u8])
    }

    fn write_png(path: &Path, frame: &Frame) {
        let (w, h) = (frame.width() as u32, frame.height() as u32);
        ::image::RgbImage::from_raw(w, h, frame.bytes().to_vec()).unwrap().save(path).unwrap();
    }

    fn sequence(frames: Frames) -> Sequence {
        Sequence {
            truth: vec![Some(Region::Rect(Rect::new(1.0, 2.0, 3.0, 4.5))), None, None],
            attributes: vec!["occlusion".into()],
            frame_attributes: vec![("occlusion".into(), vec![false, true, false])],
            frames,
            ..without_frames("ramp", 3)
        }
    }

    /// Sequence of three image files, in the order given.
    fn named(folder: &Path) -> Sequence {
        sequence(Frames::Files((1..4).map(|t| folder.join(format!("{t:04}.png"))).collect()))
    }

    fn on_disk(folder: &Path) -> Sequence {
        (0..3).for_each(|t| write_png(&folder.join(format!("{:04}.png", t + 1)), &ramp(t)));
        named(folder)
    }

    fn rendered() -> Sequence {
        sequence(Frames::Rendered(Arc::new(ramp), 3))
    }

    #[test]
    fn rendered_and_written_sequences_have_one_content_digest() {
        let folder = tempfile::tempdir().unwrap();
        let files = on_disk(folder.path());
        let digest = content_digest(&files).unwrap();
        assert_eq!(digest, content_digest(&rendered()).unwrap());
        assert_eq!(digest, rendered().digest().unwrap());
        assert_ne!(digest, files.digest().unwrap());
        let (mut other, mut shifted) = (rendered(), rendered());
        other.truth[2] = other.truth[0].clone();
        shifted.numbering.first = 2;
        assert!([other, shifted].iter().all(|other| digest != content_digest(other).unwrap()));
    }

    // python3, on the same three files a, b, c:
    //   q = lambda v: struct.pack('<Q', v); s = lambda b: q(len(b)) + b
    //   h = s(b'trackfail-files/1') + q(1) + q(1) + q(3) + q(3)
    //   h += b''.join(s(n) + s(d) for n, d in [(b'0001.png', b'a'), (b'0002.png', b'b'), (b'0003.png', b'c')])
    //   h += b'\1' + struct.pack('<4d', 1, 2, 3, 4.5) + b'\0\0'; hashlib.sha256(h).hexdigest()
    #[test]
    fn the_files_digest_is_the_documented_one() {
        let folder = folder([("0001.png", "a"), ("0002.png", "b"), ("0003.png", "c")]);
        assert_eq!(named(folder.path()).digest().unwrap(), FILES_DIGEST);
    }
    const FILES_DIGEST: &str = "d41b977944f14091783ce55f5f7bfc3338620de2567e9935d4ddf6cd940683ad";

    #[test]
    fn a_changed_byte_changes_the_files_digest() {
        let folder = tempfile::tempdir().unwrap();
        let files = on_disk(folder.path());
        let before = files.digest().unwrap().to_owned();
        let mut bytes = std::fs::read(folder.path().join("0002.png")).unwrap();
        bytes.push(0);
        put(folder.path(), "0002.png", bytes);
        assert_eq!(files.digest().unwrap(), before, "remembered");
        assert_ne!(named(folder.path()).digest().unwrap(), before);
    }

    #[test]
    fn faults_name_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let files = on_disk(folder.path());
        assert_eq!(files.frame(2).unwrap(), ramp(2));
        assert_eq!(files.size().unwrap(), (12, 7));
        assert_says(files.frame(3).unwrap_err(), "there is no frame 3");
        write_png(&folder.path().join("0002.png"), &Frame::new(7, 12, vec![0; 252]));
        assert_says(files.frame(1).unwrap_err(), "0002.png: 7x12 pixels, but the sequence starts with 12x7");
        put(folder.path(), "0003.png", b"\x89PNG\r\n\x1a\n");
        assert_says(files.frame(2).unwrap_err(), "cut short");
        std::fs::remove_file(folder.path().join("0003.png")).unwrap();
        assert!(matches!(files.frame(2), Err(DatasetError::Io { .. })));
    }

    #[test]
    fn the_first_file_is_read_once_for_its_size() {
        let folder = tempfile::tempdir().unwrap();
        let files = on_disk(folder.path());
        assert_eq!(files.frame(1).unwrap(), ramp(1));
        // Later frames and the size no longer need it; the frame itself does.
        std::fs::remove_file(folder.path().join("0001.png")).unwrap();
        assert_eq!(files.frame(2).unwrap(), ramp(2));
        assert_eq!(files.size().unwrap(), (12, 7));
        assert!(matches!(files.frame(0), Err(DatasetError::Io { .. })));
        // A first frame of another size than the one remembered is as wrong as a later one.
        write_png(&folder.path().join("0001.png"), &Frame::new(7, 12, vec![0; 252]));
        assert_says(files.frame(0).unwrap_err(), "0001.png: 7x12 pixels");
        let empty = sequence(Frames::Files(Vec::new()));
        assert_says(empty.size().unwrap_err(), "there is no frame 0");
    }

    #[test]
    fn what_is_no_image_file_is_not_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let files = on_disk(folder.path());
        let second = folder.path().join("0002.png");
        std::fs::remove_file(&second).unwrap();
        std::fs::create_dir(&second).unwrap();
        assert!(matches!(files.frame(1), Err(DatasetError::Content { .. })));
        let third = std::fs::File::create(folder.path().join("0003.png")).unwrap();
        third.set_len(image::MAX_FILE_BYTES + 1).unwrap();
        assert_says(files.frame(2).unwrap_err(), "larger than 64 MiB");
    }

    #[cfg(unix)]
    #[test]
    fn links_to_images_are_followed() {
        let (folder, linked) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        on_disk(folder.path());
        std::os::unix::fs::symlink(folder.path().join("0003.png"), linked.path().join("0003.png")).unwrap();
        let paths = otb::FORMAT.images(linked.path()).unwrap().files.into_values().collect();
        assert_eq!(sequence(Frames::Files(paths)).frame(0).unwrap(), ramp(2));
    }
}
