//! Frames from bytes without a header, as cameras and other programs produce them.

use super::decode::check_size;
use super::{Frame, ImageError};
use base64::Engine as _;
use serde::{Deserialize, Serialize};

/// Order of the bytes in a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PixelFormat {
    /// Red, green, blue.
    Rgb,
    /// Blue, green, red, as in OpenCV.
    Bgr,
    /// One gray value.
    Gray,
}

impl PixelFormat {
    /// Number of bytes per pixel.
    pub fn bytes(self) -> usize {
        match self {
            Self::Rgb | Self::Bgr => 3,
            Self::Gray => 1,
        }
    }
}

impl Frame {
    /// Creates a frame from its pixels, rows from the top without gaps.
    ///
    /// # Errors
    /// Sides of 0 or beyond the limits of [`decode`](super::decode), or a number of bytes that does not match
    /// the size.
    pub fn from_raw(
        width: u32,
        height: u32,
        format: PixelFormat,
        mut bytes: Vec<u8>,
    ) -> Result<Self, ImageError> {
        check_size(width, height)?;
        let expected = width as usize * height as usize * format.bytes();
        if bytes.len() != expected {
            return Err(ImageError::RawBytes { width, height, expected, got: bytes.len() });
        }
        match format {
            PixelFormat::Rgb => {}
            PixelFormat::Bgr => bytes.as_chunks_mut::<3>().0.iter_mut().for_each(|pixel| pixel.swap(0, 2)),
            PixelFormat::Gray => bytes = bytes.iter().flat_map(|gray| [*gray; 3]).collect(),
        }
        Ok(Self::new(width as usize, height as usize, bytes))
    }

    /// Like [`Frame::from_raw`], for bytes in standard base64.
    ///
    /// # Errors
    /// The errors of [`Frame::from_raw`], and text that is not base64.
    pub fn from_base64(width: u32, height: u32, format: PixelFormat, text: &str) -> Result<Self, ImageError> {
        check_size(width, height)?;
        let bytes = base64::engine::general_purpose::STANDARD.decode(text);
        Self::from_raw(width, height, format, bytes.map_err(|e| ImageError::Base64(e.to_string()))?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_orders_give_the_same_frame() {
        let rgb = Frame::from_raw(2, 1, PixelFormat::Rgb, vec![1, 2, 3, 4, 5, 6]).unwrap();
        assert_eq!(rgb.pixel(1, 0), [4, 5, 6]);
        assert_eq!(Frame::from_raw(2, 1, PixelFormat::Bgr, vec![3, 2, 1, 6, 5, 4]).unwrap(), rgb);
        // python3: base64.b64encode(bytes([1, 2, 3, 4, 5, 6]))
        assert_eq!(Frame::from_base64(2, 1, PixelFormat::Rgb, "AQIDBAUG").unwrap(), rgb);
        let gray = Frame::from_raw(1, 2, PixelFormat::Gray, vec![7, 9]).unwrap();
        assert_eq!((gray.pixel(0, 0), gray.pixel(0, 1)), ([7; 3], [9; 3]));
    }

    #[test]
    fn sizes_are_checked_before_memory_is_taken() {
        let error = |width, height, bytes| {
            Frame::from_raw(width, height, PixelFormat::Bgr, vec![0; bytes]).unwrap_err().to_string()
        };
        assert_eq!(error(4, 2, 23), "4x2 pixels of this format are 24 bytes, not 23");
        assert!(error(0, 2, 0).contains("no pixels"));
        assert!(error(u32::MAX, u32::MAX, 0).contains("16384"));
        assert!(Frame::from_base64(1, 1, PixelFormat::Gray, "not base64").is_err());
    }
}
