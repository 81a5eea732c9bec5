//! Decoding of JPEG and PNG images that are complete.
//!
//! The structure of the file is checked first, up to the end-of-image marker (JPEG) or the `IEND` chunk
//! (PNG); bytes after that are tolerated. A truncated file is an error, even if an end marker was added, as
//! is a file with damaged codes. Gray, palette, CMYK, 16-bit and alpha images become 8-bit RGB; alpha is
//! dropped, not blended. A frame is turned and mirrored by the Exif orientation of the file, as in OpenCV and
//! browsers.
//!
//! A few bytes can claim to be an image of any size. So before memory is allocated, the size in the header is checked
//! against [`MAX_SIDE`] and [`MAX_PIXELS`], against the fewest bytes that so many pixels can be packed into, and against
//! [`MAX_MEMORY`].

mod jpeg;
mod png;

use super::{Frame, ImageError};
use ::image::metadata::Orientation;
use std::io::Cursor;
use std::ops::Range;
use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;

/// Longest side of a frame that is read, in pixels.
pub const MAX_SIDE: u32 = 16_384;
/// Most pixels of a frame that is read: one and a half times those of 8K video.
pub const MAX_PIXELS: u64 = 50_000_000;
/// Largest image file that is read, in bytes.
pub const MAX_FILE_BYTES: u64 = 64 << 20;
/// Most memory for decoding a frame, in bytes: the file, its copy for the decoder, memory of the decoder, and
/// the frame.
pub const MAX_MEMORY: u64 = 200_000_000;
/// Memory of the PNG decoder for rows, in bytes, beside the pixels.
const PNG_ROWS: u64 = 4 << 20;

/// Decodes a JPEG or PNG image.
///
/// # Errors
/// Bytes of another format, a truncated or damaged image, sizes above [`MAX_SIDE`] or [`MAX_PIXELS`], more
/// pixels than the bytes can hold, and images that need more than [`MAX_MEMORY`].
pub fn decode(bytes: &[u8]) -> Result<Frame, ImageError> {
    let header = header(bytes)?;
    let rgb = if jpeg::is_jpeg(bytes) { decode_jpeg(bytes, &header)? } else { decode_png(bytes)? };
    let stored = ::image::RgbImage::from_raw(header.width, header.height, rgb)
        .filter(|image| image.as_raw().len() as u64 == 3 * u64::from(header.width) * u64::from(header.height))
        .ok_or_else(|| ImageError::Decode("it has another size than its header says".into()))?;
    let mut upright = ::image::DynamicImage::from(stored);
    upright.apply_orientation(header.orientation);
    let (width, height) = header.size();
    Ok(Frame::new(width, height, upright.into_rgb8().into_raw()))
}

/// Width and height in pixels, from the structure of the file, without decoding.
///
/// # Errors
/// As [`decode`], except that the pixels are not checked.
pub fn size(bytes: &[u8]) -> Result<(usize, usize), ImageError> {
    Ok(header(bytes)?.size())
}

/// Facts about a file that are known before it is decoded.
struct Header {
    /// True if the scans of a JPEG file refine earlier ones.
    is_progressive: bool,
    /// Scans of a JPEG file, each from its marker to the end of its data.
    scans: Vec<Range<usize>>,
    /// Size of the image as it is stored, before it is turned.
    width: u32,
    height: u32,
    /// Rotation and mirroring that make the stored image upright.
    orientation: Orientation,
    /// Number of bytes that hold the pixels, and the fewest that could.
    packed: u64,
    least: u64,
    /// Memory for the pixels in bytes, in the decoder and as a frame.
    memory: u64,
}

impl Header {
    /// Width and height of the upright frame.
    fn size(&self) -> (usize, usize) {
        let (width, height) = (self.width as usize, self.height as usize);
        match self.orientation {
            Orientation::Rotate90
            | Orientation::Rotate270
            | Orientation::Rotate90FlipH
            | Orientation::Rotate270FlipH => (height, width),
            _ => (width, height),
        }
    }

    /// Checks that the image may be decoded, and returns the header.
    fn check(self, bytes: &[u8]) -> Result<Self, ImageError> {
        let Self { width, height, packed, .. } = self;
        check_size(width, height)?;
        if packed < self.least {
            return Err(ImageError::TooFewBytes { width, height, bytes: packed });
        }
        // Turning makes a copy.
        let turned = if self.size() == (width as usize, height as usize) { 0 } else { 3 };
        let turned = u64::from(width) * u64::from(height) * turned;
        let memory = self.memory + turned + 2 * bytes.len() as u64;
        if memory > MAX_MEMORY {
            return Err(ImageError::TooMuchMemory { width, height, memory });
        }
        Ok(self)
    }
}

/// Checks that an image has pixels, and not too many.
pub(super) fn check_size(width: u32, height: u32) -> Result<(), ImageError> {
    if width == 0 || height == 0 {
        return Err(ImageError::Decode("the image has no pixels".into()));
    }
    if width.max(height) > MAX_SIDE || u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Err(ImageError::TooLarge { width, height });
    }
    Ok(())
}

/// Orientation in an Exif block. A missing or invalid number means upright.
fn orientation(exif: Option<&[u8]>) -> Orientation {
    exif.and_then(Orientation::from_exif_chunk).unwrap_or(Orientation::NoTransforms)
}

fn header(bytes: &[u8]) -> Result<Header, ImageError> {
    if bytes.starts_with(png::SIGNATURE) {
        png::header(bytes)
    } else if jpeg::is_jpeg(bytes) {
        jpeg::header(bytes)
    } else if bytes.is_empty() {
        Err(ImageError::Decode("the file is empty".into()))
    } else {
        Err(ImageError::Decode("the bytes start like neither format".into()))
    }
}

/// Decodes a JPEG file to RGB.
fn decode_jpeg(bytes: &[u8], header: &Header) -> Result<Vec<u8>, ImageError> {
    let end = header.scans.last().map_or(bytes.len(), |scan| scan.end);
    if !header.is_progressive && header.scans.len() > 1 {
        for scan in 0..header.scans.len() {
            decode_scans(&jpeg::alone(bytes, &header.scans, scan))?;
        }
    }
    decode_scans(&[&bytes[..end], jpeg::STOP.as_flattened(), &jpeg::END].concat())
}

/// Decodes a JPEG file with [`jpeg::STOP`] after its last scan to RGB.
fn decode_scans(bytes: &[u8]) -> Result<Vec<u8>, ImageError> {
    let fail = |e: zune_jpeg::errors::DecodeErrors| ImageError::Decode(e.to_string());
    let options = DecoderOptions::default().set_strict_mode(true);
    let options = options.set_max_width(MAX_SIDE as usize).set_max_height(MAX_SIDE as usize);
    let mut decoder = zune_jpeg::JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(fail)?;
    let gray = decoder.input_colorspace() == Some(ColorSpace::Luma);
    let made = if gray { ColorSpace::Luma } else { ColorSpace::RGB };
    decoder.set_options(options.jpeg_set_out_colorspace(made));
    let pixels = decoder.decode().map_err(fail)?;
    Ok(if gray { pixels.into_iter().flat_map(|value| [value; 3]).collect() } else { pixels })
}

/// Decodes a PNG file to RGB.
fn decode_png(bytes: &[u8]) -> Result<Vec<u8>, ImageError> {
    let fail = |e: ::image::ImageError| ImageError::Decode(e.to_string());
    let mut limits = ::image::Limits::no_limits();
    limits.max_alloc = Some(PNG_ROWS);
    let bytes = png::stripped(bytes)?;
    let decoder = ::image::codecs::png::PngDecoder::with_limits(Cursor::new(bytes), limits).map_err(fail)?;
    Ok(::image::DynamicImage::from_decoder(decoder).map_err(fail)?.into_rgb8().into_raw())
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::image::{DynamicImage, GrayImage, ImageFormat, Rgb, RgbImage, RgbaImage};
    use proptest::prelude::*;
    use std::io::Read;

    fn encode(picture: &DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut out = Cursor::new(Vec::new());
        picture.write_to(&mut out, format).unwrap();
        out.into_inner()
    }

    fn picture() -> DynamicImage {
        picture_of(37, 23)
    }

    fn picture_of(width: u32, height: u32) -> DynamicImage {
        let color = |x: u32, y: u32| Rgb([(x * 7) as u8, (y * 11) as u8, ((x * y) % 251) as u8]);
        DynamicImage::from(RgbImage::from_fn(width, height, color))
    }

    #[test]
    fn png_is_exact_and_rows_come_from_the_top() {
        let mut file = encode(&picture(), ImageFormat::Png);
        let frame = decode(&file).unwrap();
        assert_eq!((frame.width(), frame.height(), frame.pixel(5, 2)), (37, 23, [35, 22, 10]));
        assert_eq!(size(&file).unwrap(), (37, 23));
        // Damage inside.
        let middle = file.len() / 2;
        file[middle] ^= 0x55;
        assert!(decode(&file).is_err());
    }

    /// Exif block with an orientation, in either byte order.
    fn exif(orientation: u8, big_endian: bool) -> Vec<u8> {
        if big_endian {
            [b"MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0", &[orientation][..], &[0; 6]].concat()
        } else {
            [b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0", &[orientation][..], &[0; 7]].concat()
        }
    }

    /// File with an Exif block: after the start of a JPEG, before the end of a PNG.
    fn with_exif(file: &[u8], block: &[u8]) -> Vec<u8> {
        if jpeg::is_jpeg(file) {
            let body = [b"Exif\0\0", block].concat();
            let length = (body.len() as u16 + 2).to_be_bytes();
            [&file[..2], &[0xFF, 0xE1], &length, &body, &file[2..]].concat()
        } else {
            let end = file.len() - 12;
            [&file[..end], &chunk(b"eXIf", block), &file[end..]].concat()
        }
    }

    // python3, OpenCV 5.0: a = np.array([[1, 2, 3], [4, 5, 6]]), written as 8-bit PNG with an eXIf chunk of this orientation,
    // and read by cv2.imread(f): the same as the table of Exif 2.3, 4.6.4.
    #[test]
    fn frames_are_upright_as_their_file_says() {
        let stored = GrayImage::from_raw(3, 2, vec![1, 2, 3, 4, 5, 6]).unwrap();
        let stored = encode(&stored.into(), ImageFormat::Png);
        for (orientation, width, pixels) in [
            (1, 3, [1, 2, 3, 4, 5, 6]),
            (2, 3, [3, 2, 1, 6, 5, 4]),
            (3, 3, [6, 5, 4, 3, 2, 1]),
            (4, 3, [4, 5, 6, 1, 2, 3]),
            (5, 2, [1, 4, 2, 5, 3, 6]),
            (6, 2, [4, 1, 5, 2, 6, 3]),
            (7, 2, [6, 3, 5, 2, 4, 1]),
            (8, 2, [3, 6, 2, 5, 1, 4]),
            (0, 3, [1, 2, 3, 4, 5, 6]),
        ] {
            for big_endian in [true, false] {
                let file = with_exif(&stored, &exif(orientation, big_endian));
                let frame = decode(&file).unwrap();
                assert_eq!((frame.width(), frame.height()), (width, 6 / width), "{orientation}");
                assert_eq!(size(&file).unwrap(), (width, 6 / width), "{orientation}");
                let values: Vec<u8> = frame.bytes().chunks(3).map(|rgb| rgb[0]).collect();
                assert_eq!(values, pixels, "{orientation}");
            }
        }
    }

    #[test]
    fn jpeg_files_are_turned_as_png_files_are() {
        let file = encode(&picture(), ImageFormat::Jpeg);
        let pixels = decode(&file).unwrap().bytes().to_vec();
        let png = encode(&RgbImage::from_raw(37, 23, pixels).unwrap().into(), ImageFormat::Png);
        for orientation in 1..=8 {
            let block = exif(orientation, orientation % 2 == 0);
            let turned = decode(&with_exif(&file, &block)).unwrap();
            assert_eq!(turned, decode(&with_exif(&png, &block)).unwrap(), "{orientation}");
        }
        // A second block, as of a thumbnail, counts for nothing, and neither does a damaged one.
        let twice = with_exif(&with_exif(&file, &exif(6, true)), &exif(1, true));
        let damaged = with_exif(&file, &exif(6, true)[..12]);
        assert_eq!([twice, damaged].map(|file| size(&file).unwrap()), [(37, 23); 2]);
    }

    #[test]
    fn every_cut_is_an_error_and_more_bytes_are_none() {
        let own = [ImageFormat::Png, ImageFormat::Jpeg].map(|format| encode(&picture(), format));
        for whole in own.iter().map(Vec::as_slice).chain(SAMPLES.map(|sample| sample.1)) {
            let frame = decode(whole).unwrap();
            for n in 0..whole.len() {
                assert!(decode(&whole[..n]).is_err(), "cut to {n} of {} bytes", whole.len());
            }
            assert_eq!(decode(&[whole, b"\0\0trailing\xFF"].concat()).unwrap(), frame);
        }
    }

    // python3, Pillow 13: y, x = np.mgrid[:30, :52]; im = Image.fromarray(np.stack([x * 5 % 256, y * 8 % 256,
    // x * y % 251], -1).astype(np.uint8)); im.save(f, 'JPEG', quality=80, progressive=True), restart_marker_blocks=2 and
    // optimize=True, subsampling=0 instead of progressive
    const SAMPLES: [(&str, &[u8]); 3] = [
        ("progressive", include_bytes!("decode/samples/progressive.jpg")),
        ("restarts", include_bytes!("decode/samples/restarts.jpg")),
        ("optimized", include_bytes!("decode/samples/optimized.jpg")),
    ];

    // A file that is cut and given an end marker is refused, or has the same pixels.
    #[test]
    fn an_end_marker_does_not_hide_a_cut() {
        let large = encode(&picture_of(120, 90), ImageFormat::Jpeg);
        for bytes in [SAMPLES[0].1, SAMPLES[1].1, SAMPLES[2].1, CMYK_RED, &large] {
            let whole = decode(bytes).unwrap();
            for n in 2..bytes.len() - 2 {
                let ended = decode(&[&bytes[..n], &jpeg::END].concat());
                let is_fine = ended.is_err() || ended.is_ok_and(|frame| frame == whole);
                assert!(is_fine, "cut to {n} of {} bytes", bytes.len());
            }
        }
    }

    #[test]
    fn another_marker_before_the_end_does_not_hide_a_cut() {
        let whole = encode(&picture(), ImageFormat::Jpeg);
        let at = |marker: u8| whole.windows(2).position(|w| w == [0xFF, marker]).unwrap();
        let segment = |marker: u8| {
            let at = at(marker);
            whole[at..at + 2 + usize::from(whole[at + 2]) * 256 + usize::from(whole[at + 3])].to_vec()
        };
        let data = at(0xDA) + segment(0xDA).len();
        let strays = [
            ("a comment", vec![0xFF, 0xFE, 0, 4, b'a', b'b']),
            ("a restart", vec![0xFF, 0xD0]),
            ("a temporary marker", vec![0xFF, 0x01]),
            ("an application's segment", segment(0xE0)),
            ("Huffman codes", segment(0xC4)),
            ("the scan once more", segment(0xDA)),
            ("the whole scan once more", whole[at(0xDA)..whole.len() - 2].to_vec()),
        ];
        for (name, stray) in strays {
            for cut in (data..whole.len() - 8).step_by(5) {
                let ended = [&whole[..cut], &stray, &jpeg::END].concat();
                assert!(decode(&ended).is_err(), "{name} behind {cut} of {} bytes", whole.len());
            }
        }
        let commented = [&whole[..whole.len() - 2], &[0xFF, 0xFE, 0, 4, b'a', b'b'], &jpeg::END].concat();
        assert_eq!(decode(&commented).unwrap(), decode(&whole).unwrap());
    }

    /// Sequential JPEG file of 64x64 pixels of one color, with one scan for each of three components, and the
    /// ends of the scans' data. `sampling` is the number of samples of the first component per sample of the
    /// others.
    fn a_scan_a_component(sampling: u8) -> (Vec<u8>, Vec<usize>) {
        let flat = encode(&DynamicImage::from(RgbImage::new(64, 64)), ImageFormat::Jpeg);
        let scan = flat.windows(2).position(|w| w == [0xFF, 0xDA]).unwrap();
        let mut bytes = flat[..scan].to_vec();
        let frame = bytes.windows(2).position(|w| w == [0xFF, 0xC0]).unwrap();
        [(11, sampling), (14, 0x11), (17, 0x11)].iter().for_each(|(at, value)| bytes[frame + at] = *value);
        let ids = [10, 13, 16].map(|at| bytes[frame + at]);
        let ends = ids.map(|id| {
            bytes.extend([0xFF, 0xDA, 0, 8, 1, id, 0, 0, 63, 0]);
            // By the codes of T.81, K.3: 00 for the mean of the block before, 1010 for no more. 64 blocks, 6 bits each.
            bytes.extend([0b0010_1000, 0b1010_0010, 0b1000_1010].repeat(16));
            bytes.len()
        });
        bytes.extend(jpeg::END);
        (bytes, ends.to_vec())
    }

    #[test]
    fn each_scan_of_a_sequential_file_is_whole() {
        let (bytes, ends) = a_scan_a_component(0x11);
        assert_eq!(decode(&bytes).unwrap().pixel(60, 60), [128; 3]);
        for end in ends {
            for missing in [1, 9, 40] {
                let cut = [&bytes[..end - missing], &bytes[end..]].concat();
                assert!(decode(&cut).is_err(), "{missing} bytes before {end}");
            }
        }
        // Of such a file the decoder makes wrong pixels.
        let error = decode(&a_scan_a_component(0x21).0).unwrap_err().to_string();
        assert!(error.contains("scans of their own"), "{error}");
    }

    #[test]
    fn all_kinds_of_jpeg_files_are_read() {
        for (name, bytes) in SAMPLES {
            let frame = decode(bytes).unwrap();
            assert_eq!((frame.width(), frame.height()), (52, 30), "{name}");
            let [r, g, _] = frame.pixel(20, 12);
            assert!(r.abs_diff(100) < 24 && g.abs_diff(96) < 24, "{name} {r} {g}");
        }
    }

    /// A JPEG file with another size in its header.
    fn resized(bytes: &[u8], width: u16, height: u16) -> Vec<u8> {
        let at = bytes.windows(2).position(|w| w[0] == 0xFF && matches!(w[1], 0xC0 | 0xC2)).unwrap();
        let mut bytes = bytes.to_vec();
        bytes[at + 5..at + 7].copy_from_slice(&height.to_be_bytes());
        bytes[at + 7..at + 9].copy_from_slice(&width.to_be_bytes());
        bytes
    }

    #[test]
    fn bytes_that_cannot_hold_the_pixels_are_refused_unread() {
        for (name, bytes) in SAMPLES {
            let error = decode(&resized(bytes, 7000, 7000)).unwrap_err();
            assert!(matches!(error, ImageError::TooFewBytes { width: 7000, .. }), "{name}: {error}");
            assert!(size(&resized(bytes, 7000, 7000)).is_err());
        }
        let error = size(&empty_png(5000, 5000)).unwrap_err();
        assert!(matches!(error, ImageError::TooFewBytes { bytes: 0, .. }), "{error}");
        // Images of one color are as small as files get.
        let flat = DynamicImage::from(RgbImage::from_pixel(3000, 2000, Rgb([9, 9, 9])));
        for format in [ImageFormat::Png, ImageFormat::Jpeg] {
            assert_eq!(decode(&encode(&flat, format)).unwrap().pixel(2999, 1999), [9, 9, 9]);
        }
    }

    #[test]
    fn a_frame_takes_no_more_memory_than_is_allowed() {
        // Its bytes could hold the pixels, but the decoder keeps a progressive file as a whole: 2 bytes for each of
        // its three colors, two of them halved both ways, beside the frame.
        let mut bytes = resized(SAMPLES[0].1, 6500, 6500);
        let mut from = 0;
        while let Some(at) = bytes[from..].windows(2).position(|w| w == [0xFF, 0xDA]) {
            let data = from + at + 2 + usize::from(bytes[from + at + 3]);
            bytes.splice(data..data, std::iter::repeat_n(0, 130_000));
            from = data;
        }
        let error = size(&bytes).unwrap_err();
        let is_that_much =
            matches!(error, ImageError::TooMuchMemory { memory: 250_000_000..260_000_000, .. });
        assert!(is_that_much, "{error}");
        let deep = DynamicImage::new_rgba16(5000, 4000);
        let error = size(&encode(&deep, ImageFormat::Png)).unwrap_err();
        assert!(matches!(error, ImageError::TooMuchMemory { .. }), "{error}");
    }

    #[test]
    fn color_profiles_are_not_unpacked() {
        // 64 MB of zeros, packed.
        let mut packed = flate2::write::ZlibEncoder::new(b"p\0\0".to_vec(), flate2::Compression::best());
        std::io::copy(&mut std::io::repeat(0).take(64 << 20), &mut packed).unwrap();
        let plain = encode(&picture(), ImageFormat::Png);
        // Behind the signature and the header.
        let bombs = [&plain[..33], &chunk(b"iCCP", &packed.finish().unwrap()), &plain[33..]].concat();
        assert_eq!(png::stripped(&bombs).unwrap(), plain);
        assert_eq!(decode(&bombs).unwrap(), decode(&plain).unwrap());
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
        let alpha = RgbaImage::from_fn(9, 4, |x, _| ::image::Rgba([x as u8, 200, 7, x as u8]));
        assert_eq!(decode(&encode(&alpha.into(), ImageFormat::Png)).unwrap().pixel(3, 0), [3, 200, 7]);
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

    /// A chunk of a PNG file.
    fn chunk(kind: &[u8], data: &[u8]) -> Vec<u8> {
        let body = [kind, data].concat();
        let mut crc = flate2::Crc::new();
        crc.update(&body);
        [&(data.len() as u32).to_be_bytes(), &body[..], &crc.sum().to_be_bytes()].concat()
    }

    /// A PNG without pixels: signature, header, `IEND`.
    fn empty_png(width: u32, height: u32) -> Vec<u8> {
        let header = [&width.to_be_bytes(), &height.to_be_bytes(), &[8, 2, 0, 0, 0][..]].concat();
        [png::SIGNATURE, &chunk(b"IHDR", &header), &chunk(b"IDAT", &[]), &chunk(b"IEND", &[])].concat()
    }

    #[test]
    fn a_few_bytes_that_claim_to_be_huge_are_refused_unread() {
        let most = u32::MAX >> 1;
        for (w, h) in [(8192, 8192), (16_384, 16_384), (1, 16_385), (MAX_SIDE + 1, 1), (most, most)] {
            let empty = empty_png(w, h);
            for error in [size(&empty).unwrap_err(), decode(&empty).unwrap_err()] {
                assert!(matches!(error, ImageError::TooLarge { width, .. } if width == w), "{error}");
            }
        }
        // The same in a JPEG: a frame header (8 bits, 65535x65535, one component) and the end marker.
        let jpeg = [0xFF, 0xD8, 0xFF, 0xC0, 0, 11, 8, 0xFF, 0xFF, 0xFF, 0xFF, 1, 1, 0x11, 0, 0xFF, 0xD9];
        assert!(size(&jpeg).is_err() && decode(&jpeg).is_err());
    }

    proptest! {
        #[test]
        fn never_panics(
            bytes in prop::collection::vec(any::<u8>(), 0..200), start in 0..3_usize, at in 0..400_usize,
        ) {
            let prefix: &[u8] = [&[][..], png::SIGNATURE, &[0xFF, 0xD8, 0xFF]][start];
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
