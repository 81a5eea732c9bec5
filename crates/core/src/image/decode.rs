//! Decoding of JPEG and PNG images that are complete.
//!
//! The JPEG decoder fills the missing part of a cut file with gray and reports success. So the
//! structure of the bytes is walked first, up to the end-of-image marker (JPEG) or the `IEND` chunk
//! (PNG); bytes after it are tolerated. Gray, palette, CMYK, 16-bit and alpha images become 8-bit RGB;
//! alpha is dropped, not blended.
//!
//! A few bytes can claim to be an image of any size, so the size in the header is checked against
//! [`MAX_SIDE`] and [`MAX_PIXELS`] before memory is allocated.

use super::{Frame, ImageError};
use std::io::Cursor;

/// Longest side of a frame that is read, in pixels.
pub const MAX_SIDE: u32 = 16_384;
/// Most pixels of a frame that is read: twice those of 8K video.
pub const MAX_PIXELS: u64 = 1 << 26;
/// Largest image file that is read, in bytes.
pub const MAX_FILE_BYTES: u64 = 128 << 20;
/// Memory that the PNG decoder may use: [`MAX_PIXELS`] in 16-bit RGBA, and half as much for itself.
const MAX_DECODER_BYTES: u64 = MAX_PIXELS * 12;

const PNG_SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Decodes a JPEG or PNG image.
///
/// # Errors
/// Bytes of another format, a cut or damaged image, and sizes above [`MAX_SIDE`] or [`MAX_PIXELS`].
pub fn decode(bytes: &[u8]) -> Result<Frame, ImageError> {
    check_complete(bytes)?;
    let decoder = open(bytes)?;
    check_size(&*decoder)?;
    let picture = ::image::DynamicImage::from_decoder(decoder).map_err(decode_error)?.into_rgb8();
    Ok(Frame::new(picture.width() as usize, picture.height() as usize, picture.into_raw()))
}

/// Width and height in pixels, from the header alone.
///
/// # Errors
/// As [`decode`], except that the pixels are not checked.
pub fn size(bytes: &[u8]) -> Result<(usize, usize), ImageError> {
    let (width, height) = check_size(&*open(bytes)?)?;
    Ok((width as usize, height as usize))
}

fn open(bytes: &[u8]) -> Result<Box<dyn ::image::ImageDecoder + '_>, ImageError> {
    if bytes.starts_with(PNG_SIGNATURE) {
        let mut limits = ::image::Limits::no_limits();
        limits.max_alloc = Some(MAX_DECODER_BYTES);
        let decoder = ::image::codecs::png::PngDecoder::with_limits(Cursor::new(bytes), limits);
        Ok(Box::new(decoder.map_err(decode_error)?))
    } else {
        let decoder = ::image::codecs::jpeg::JpegDecoder::new(Cursor::new(bytes)).map_err(decode_error)?;
        Ok(Box::new(decoder))
    }
}

fn decode_error(e: ::image::ImageError) -> ImageError {
    ImageError::Decode(e.to_string())
}

fn check_size(decoder: &dyn ::image::ImageDecoder) -> Result<(u32, u32), ImageError> {
    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 {
        return Err(ImageError::Decode("the image has no pixels".into()));
    }
    if width.max(height) > MAX_SIDE || u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Err(ImageError::TooLarge { width, height });
    }
    Ok((width, height))
}

fn check_complete(bytes: &[u8]) -> Result<(), ImageError> {
    let whole = if bytes.starts_with(PNG_SIGNATURE) {
        png_ends(&bytes[PNG_SIGNATURE.len()..])
    } else if bytes.starts_with(&[0xFF, 0xD8]) {
        jpeg_ends(&bytes[2..])
    } else if bytes.is_empty() {
        return Err(ImageError::Decode("the file is empty".into()));
    } else {
        return Err(ImageError::Decode("the bytes start like neither format".into()));
    };
    whole.ok_or(ImageError::Truncated)
}

/// Walks length, type, data and checksum of each chunk; `None` when `IEND` is not reached.
fn png_ends(mut rest: &[u8]) -> Option<()> {
    loop {
        let head = rest.first_chunk::<8>()?;
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        rest = rest.get(length.checked_add(12)?..)?;
        if &head[4..] == b"IEND" {
            return Some(());
        }
    }
}

/// Walks the segments and the entropy-coded data between them; `None` when the end-of-image marker is
/// not reached. Segment lengths are honored because thumbnails inside EXIF have end markers too.
fn jpeg_ends(mut rest: &[u8]) -> Option<()> {
    loop {
        // Entropy-coded data never holds FF followed by anything but 00, a restart or a fill byte.
        let at = rest
            .windows(2)
            .position(|w| w[0] == 0xFF && !matches!(w[1], 0x00 | 0x01 | 0xD0..=0xD7 | 0xFF))?;
        let marker = rest[at + 1];
        rest = &rest[at + 2..];
        if marker == 0xD9 {
            return Some(());
        }
        let length = usize::from(u16::from_be_bytes(*rest.first_chunk::<2>()?));
        rest = rest.get(length.max(2)..)?;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::image::{DynamicImage, GrayImage, ImageFormat, Rgb, RgbImage, RgbaImage};
    use proptest::prelude::*;

    fn encode(picture: &DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut out = Cursor::new(Vec::new());
        picture.write_to(&mut out, format).unwrap();
        out.into_inner()
    }

    fn picture() -> DynamicImage {
        DynamicImage::from(RgbImage::from_fn(37, 23, |x, y| {
            Rgb([(x * 7) as u8, (y * 11) as u8, ((x * y) % 251) as u8])
        }))
    }

    #[test]
    fn png_is_exact_and_rows_come_from_the_top() {
        let frame = decode(&encode(&picture(), ImageFormat::Png)).unwrap();
        assert_eq!((frame.width(), frame.height()), (37, 23));
        assert_eq!(frame.pixel(5, 2), [35, 22, 10]);
        assert_eq!(size(&encode(&picture(), ImageFormat::Png)).unwrap(), (37, 23));
    }

    #[test]
    fn every_cut_is_an_error() {
        for format in [ImageFormat::Png, ImageFormat::Jpeg] {
            let whole = encode(&picture(), format);
            assert!(decode(&whole).is_ok());
            for n in 0..whole.len() {
                assert!(decode(&whole[..n]).is_err(), "{format:?} cut to {n} of {} bytes", whole.len());
            }
        }
    }

    #[test]
    fn bytes_after_the_end_are_tolerated() {
        for format in [ImageFormat::Png, ImageFormat::Jpeg] {
            let mut bytes = encode(&picture(), format);
            let whole = decode(&bytes).unwrap();
            bytes.extend_from_slice(b"\0\0trailing\xFF");
            assert_eq!(decode(&bytes).unwrap(), whole);
        }
    }

    #[test]
    fn the_end_marker_of_a_thumbnail_is_not_the_end() {
        // SOI, then an APP1 segment that holds a whole tiny image, then nothing.
        let mut bytes = vec![0xFF, 0xD8, 0xFF, 0xE1, 0x00, 0x06, 0xFF, 0xD8, 0xFF, 0xD9];
        assert!(matches!(decode(&bytes), Err(ImageError::Truncated)));
        bytes.extend_from_slice(&[0xFF, 0xD9]);
        // Complete now, but without pixels.
        assert!(matches!(decode(&bytes), Err(ImageError::Decode(_))));
    }

    #[test]
    fn gray_alpha_and_sixteen_bits_become_rgb() {
        let gray = DynamicImage::from(GrayImage::from_fn(9, 4, |x, y| ::image::Luma([(x * 20 + y) as u8])));
        for format in [ImageFormat::Png, ImageFormat::Jpeg] {
            let frame = decode(&encode(&gray, format)).unwrap();
            let [r, g, b] = frame.pixel(3, 2);
            assert!(r == g && g == b && r.abs_diff(62) <= 3, "{format:?} {r}");
        }
        let alpha =
            DynamicImage::from(RgbaImage::from_fn(9, 4, |x, _| ::image::Rgba([x as u8, 200, 7, x as u8])));
        assert_eq!(decode(&encode(&alpha, ImageFormat::Png)).unwrap().pixel(3, 0), [3, 200, 7]);
        let deep = DynamicImage::from(picture().into_rgb16());
        assert_eq!(decode(&encode(&deep, ImageFormat::Png)).unwrap().pixel(5, 2), [35, 22, 10]);
    }

    // Pillow 13: Image.new('CMYK', (8, 8), (0, 255, 255, 0)).save(f, 'JPEG', quality=95);
    // reading it back with .convert('RGB') gives (255, 0, 0) for every pixel.
    #[test]
    fn cmyk_becomes_rgb() {
        let [r, g, b] = decode(CMYK_RED).unwrap().pixel(4, 4);
        assert!(r > 245 && g < 10 && b < 10, "{r} {g} {b}");
    }
    const CMYK_RED: &[u8] = include_bytes!("cmyk-red.jpg");

    #[test]
    fn sides_are_limited() {
        let wide = DynamicImage::from(GrayImage::new(MAX_SIDE + 1, 1));
        let bytes = encode(&wide, ImageFormat::Png);
        assert!(matches!(decode(&bytes), Err(ImageError::TooLarge { width: 16_385, .. })));
    }

    /// A PNG without pixels: signature, header, `IEND`.
    fn empty_png(width: u32, height: u32) -> Vec<u8> {
        let mut crc = flate2::Crc::new();
        let mut chunk = |kind: &[u8], data: &[u8]| {
            let body = [kind, data].concat();
            crc.reset();
            crc.update(&body);
            [&(data.len() as u32).to_be_bytes(), &body[..], &crc.sum().to_be_bytes()].concat()
        };
        let header = [&width.to_be_bytes(), &height.to_be_bytes(), &[8, 2, 0, 0, 0][..]].concat();
        [PNG_SIGNATURE, &chunk(b"IHDR", &header), &chunk(b"IDAT", &[]), &chunk(b"IEND", &[])].concat()
    }

    #[test]
    fn a_few_bytes_that_claim_to_be_huge_are_refused_unread() {
        let claims = |width, height| size(&empty_png(width, height));
        assert_eq!(claims(8192, 8192).unwrap(), (8192, 8192));
        assert_eq!(claims(16_384, 4096).unwrap(), (16_384, 4096));
        for (width, height) in [(8193, 8192), (16_384, 16_384), (1, 16_385), (u32::MAX >> 1, u32::MAX >> 1)] {
            let error = claims(width, height).unwrap_err();
            assert!(decode(&empty_png(width, height)).is_err());
            assert!(matches!(error, ImageError::TooLarge { .. } | ImageError::Decode(_)), "{error}");
        }
        // The same in a JPEG: a frame header (8 bits, 65535x65535, one component) and the end marker.
        let jpeg = [0xFF, 0xD8, 0xFF, 0xC0, 0, 11, 8, 0xFF, 0xFF, 0xFF, 0xFF, 1, 1, 0x11, 0, 0xFF, 0xD9];
        assert!(size(&jpeg).is_err() && decode(&jpeg).is_err());
    }

    #[test]
    fn damage_inside_a_png_is_an_error() {
        let mut bytes = encode(&picture(), ImageFormat::Png);
        let middle = bytes.len() / 2;
        bytes[middle] ^= 0x55;
        assert!(decode(&bytes).is_err());
    }

    proptest! {
        #[test]
        fn never_panics(
            bytes in prop::collection::vec(any::<u8>(), 0..200), start in 0..3_usize, at in 0..400_usize,
        ) {
            let prefix: &[u8] = [&[][..], PNG_SIGNATURE, &[0xFF, 0xD8, 0xFF]][start];
            let _ = decode(&[prefix, &bytes].concat());
            for format in [ImageFormat::Jpeg, ImageFormat::Png] {
                let mut damaged = encode(&picture(), format);
                let at = at.min(damaged.len());
                let end = damaged.len().min(at + bytes.len());
                damaged[at..end].copy_from_slice(&bytes[..end - at]);
                if let Ok(frame) = decode(&damaged) {
                    prop_assert_eq!(size(&damaged).unwrap(), (frame.width(), frame.height()));
                }
            }
        }
    }
}
