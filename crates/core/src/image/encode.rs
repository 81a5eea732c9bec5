//! Frames as PNG files.

use super::{Frame, ImageError};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

/// A frame as a lossless PNG file; the same frame gives the same bytes.
///
/// # Errors
/// An error of the encoder.
pub fn encode_png(frame: &Frame) -> Result<Vec<u8>, ImageError> {
    let mut bytes = Vec::new();
    let size = |v: usize| u32::try_from(v).unwrap_or(u32::MAX);
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Adaptive)
        .write_image(frame.bytes(), size(frame.width()), size(frame.height()), ExtendedColorType::Rgb8)
        .map_err(|e| ImageError::Encode(e.to_string()))?;
    Ok(bytes)
}
