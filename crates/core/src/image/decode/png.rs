//! Structure of a PNG file (ISO/IEC 15948), checked before it is decoded.
//!
//! - The chunks up to `IEND` are there.
//! - The pixels are at most [`MAX_RATIO`] times the compressed bytes, the most that deflate can do, so that a few
//!   bytes cannot claim to be a large image.
//! - The decoder gets only the chunks needed for pixels. Color profiles, texts and similar chunks are dropped,
//!   since their packed bytes could fill the memory. Transparency is one of them: alpha is dropped, not blended.

use super::Header;
use crate::image::ImageError;

pub(super) const SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Chunks that are needed for pixels.
const NEEDED: [&[u8; 4]; 4] = [b"IHDR", b"PLTE", b"IDAT", b"IEND"];

/// Most bytes that a byte of deflated data can produce: 258 for two codes of one bit each (RFC 1951).
const MAX_RATIO: u64 = 258 * 8 / 2;

/// Calls `visit` for each chunk up to `IEND`, with its type and all its bytes from the length to the
/// checksum.
fn walk<'a>(bytes: &'a [u8], mut visit: impl FnMut(&'a [u8; 4], &'a [u8])) -> Result<(), ImageError> {
    let mut rest = bytes.get(SIGNATURE.len()..).ok_or(ImageError::Truncated)?;
    loop {
        let head = rest.first_chunk::<8>().ok_or(ImageError::Truncated)?;
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let whole = length.checked_add(12).and_then(|whole| rest.split_at_checked(whole));
        let (chunk, others) = whole.ok_or(ImageError::Truncated)?;
        let Some(kind) = chunk[4..].first_chunk::<4>() else { return Err(ImageError::Truncated) };
        visit(kind, chunk);
        rest = others;
        if kind == b"IEND" {
            return Ok(());
        }
    }
}

/// Size and memory needs of an image.
///
/// # Errors
/// Violations of the rules at the head of this file.
pub(super) fn header(bytes: &[u8]) -> Result<Header, ImageError> {
    let (mut packed, mut first, mut exif) = (0, None, None);
    walk(bytes, |kind, chunk| {
        first = first.or(Some((kind, chunk)));
        if kind == b"IDAT" {
            packed += chunk.len() as u64 - 12;
        }
        if kind == b"eXIf" {
            exif = exif.or(chunk.get(8..chunk.len() - 4));
        }
    })?;
    let Some((b"IHDR", &[_, _, _, _, _, _, _, _, w3, w2, w1, w0, h3, h2, h1, h0, depth, color, ..])) = first
    else {
        return Err(ImageError::Decode("it does not begin with a header".into()));
    };
    let (width, height) = (u32::from_be_bytes([w3, w2, w1, w0]), u32::from_be_bytes([h3, h2, h1, h0]));
    let channels = match color {
        2 => 3,
        4 => 2,
        6 => 4,
        _ => 1,
    };
    // What the decoder makes of a pixel, and the frame's three bytes where that is not one of them.
    let made = match (color, depth) {
        (2 | 3, ..=8) => 3,
        (_, depth) => channels * u64::from(depth.div_ceil(8)) + 3,
    };
    let pixels = u64::from(width) * u64::from(height);
    let header = Header {
        is_progressive: false,
        scans: Vec::new(),
        width,
        height,
        orientation: super::orientation(exif),
        packed,
        least: pixels.saturating_mul(channels * u64::from(depth)) / 8 / MAX_RATIO,
        memory: pixels.saturating_mul(made),
    };
    header.check(bytes)
}

/// The file with only the needed chunks.
///
/// # Errors
/// When there is no `IEND`.
pub(super) fn stripped(bytes: &[u8]) -> Result<Vec<u8>, ImageError> {
    let mut kept = SIGNATURE.to_vec();
    walk(bytes, |kind, chunk| {
        if NEEDED.contains(&kind) {
            kept.extend_from_slice(chunk);
        }
    })?;
    Ok(kept)
}
