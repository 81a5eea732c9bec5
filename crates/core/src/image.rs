//! Frames in memory, windows on them, and their features.

pub mod color_names;
mod decode;
pub mod distribution;
mod encode;
pub mod flow;
mod frame;
mod gray;
pub mod hog;
pub mod integral;
pub mod patch;
mod raw;
pub mod warp;
mod window;

/// Version of everything between an image file and a [`Frame`]; part of every track's address.
///
/// Raised whenever a decoded pixel changes; a golden digest in the tests notices that.
/// - 1: first version.
/// - 2: frames are turned as their Exif orientation says.
pub const DECODER: u32 = 2;

pub use decode::{MAX_FILE_BYTES, MAX_MEMORY, MAX_PIXELS, MAX_SIDE, decode, size};
pub use encode::encode_png;
pub use frame::{Frame, ImageError};
pub use gray::{Gray, luma, luma_of};
pub use raw::PixelFormat;
pub use window::Window;

#[cfg(test)]
mod tests {
    use super::*;
    use base64::Engine as _;
    use sha2::{Digest, Sha256};

    // python3, Pillow: a = np.array([[[x*16 % 256, y*31 % 256, x*y*7 % 256] for x in range(16)]
    //   for y in range(16)], np.uint8); Image.fromarray(a).save(f, 'JPEG', quality=85)
    const JPEG: &str = "/9j/4AAQSkZJRgABAQAAAQABAAD/2wBDAAUDBAQEAwUEBAQFBQUGBwwIBwcHBw8LCwkMEQ8SEhEPERETFhwXExQaFRERGCEYGh0d\
     Hx8fExciJCIeJBweHx7/2wBDAQUFBQcGBw4ICA4eFBEUHh4eHh4eHh4eHh4eHh4eHh4eHh4eHh4eHh4eHh4eHh4eHh4eHh4eHh4e\
     Hh4eHh4eHh7/wAARCAAQABADASIAAhEBAxEB/8QAHwAAAQUBAQEBAQEAAAAAAAAAAAECAwQFBgcICQoL/8QAtRAAAgEDAwIEAwUF\
     BAQAAAF9AQIDAAQRBRIhMUEGE1FhByJxFDKBkaEII0KxwRVS0fAkM2JyggkKFhcYGRolJicoKSo0NTY3ODk6Q0RFRkdISUpTVFVW\
     V1hZWmNkZWZnaGlqc3R1dnd4eXqDhIWGh4iJipKTlJWWl5iZmqKjpKWmp6ipqrKztLW2t7i5usLDxMXGx8jJytLT1NXW19jZ2uHi\
     4+Tl5ufo6erx8vP09fb3+Pn6/8QAHwEAAwEBAQEBAQEBAQAAAAAAAAECAwQFBgcICQoL/8QAtREAAgECBAQDBAcFBAQAAQJ3AAEC\
     AxEEBSExBhJBUQdhcRMiMoEIFEKRobHBCSMzUvAVYnLRChYkNOEl8RcYGRomJygpKjU2Nzg5OkNERUZHSElKU1RVVldYWVpjZGVm\
     Z2hpanN0dXZ3eHl6goOEhYaHiImKkpOUlZaXmJmaoqOkpaanqKmqsrO0tba3uLm6wsPExcbHyMnK0tPU1dbX2Nna4uPk5ebn6Onq\
     8vP09fb3+Pn6/9oADAMBAAIRAxEAPwDgPC3wjSSMSSW4CgZJK16LoXwmhwu2wGeCAy5Y/gP55rmPDOgeMPs8C/8ACR68TjcAb+XB\
     J4H8X1r0HQdA8YOCT4n14g4JJvpfzPzfkOmMGuadqeGhGNSDk0m20tdL9dkttNU7tuw+B83xblH/AGuP4n//2Q==";
    /// Version of the decoder and the pixels it makes of [`JPEG`].
    const GOLDEN: (u32, &str) = (2, "eda0d12fc8baead3");

    #[test]
    fn pixels_are_those_of_the_version() {
        let bytes = base64::engine::general_purpose::STANDARD.decode(JPEG).unwrap();
        let frame = decode(&bytes).unwrap();
        let digest = crate::num::hexadecimal(&Sha256::digest(frame.bytes())[..8]);
        let remedy = "pixels have changed: raise DECODER, then put both here";
        assert_eq!((DECODER, digest.as_str()), GOLDEN, "{remedy}");
        let png = encode_png(&frame).unwrap();
        assert_eq!(decode(&png).unwrap(), frame, "and PNG files have the pixels they were given");
    }
}
