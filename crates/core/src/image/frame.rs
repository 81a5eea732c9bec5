//! One decoded frame.

use std::any::Any;
use std::sync::OnceLock;

/// A frame of 8-bit RGB: rows from the top, pixels from the left, three bytes each.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Frame {
    width: usize,
    height: usize,
    rgb: Vec<u8>,
    notes: Notes,
}

/// Value that readers of a frame cache with it. It is ignored by comparisons and not copied.
#[derive(Debug, Default)]
struct Notes(OnceLock<Box<dyn Any + Send + Sync>>);

impl Clone for Notes {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl PartialEq for Notes {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for Notes {}

/// Reason why an image cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The decoder refused the bytes.
    #[error("not a readable JPEG or PNG image: {0}")]
    Decode(String),
    /// The encoder refused the frame.
    #[error("cannot be written as PNG: {0}")]
    Encode(String),
    /// The bytes of a raw image are too few or too many.
    #[error("{width}x{height} pixels of this format are {expected} bytes, not {got}")]
    RawBytes {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// Number of bytes required.
        expected: usize,
        /// Number of bytes given.
        got: usize,
    },
    /// The text of a raw image is not base64.
    #[error("the data of the image are not base64: {0}")]
    Base64(String),
    /// The image ends before its end marker, or has one in place of a missing part.
    #[error("the image is cut short")]
    Truncated,
    /// The file has too few bytes for its pixels.
    #[error(
        "the header says {width}x{height} pixels, which {bytes} bytes cannot hold: the image is cut short, or made to \
         fill the memory"
    )]
    TooFewBytes {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// Number of bytes for the pixels.
        bytes: u64,
    },
    /// Decoding takes more memory than one frame may take.
    #[error(
        "decoding its {width}x{height} pixels takes {} MB of memory, of which a frame may take {}; store it smaller, \
         with 8 bits a color, and not progressive",
        memory / 1_000_000,
        super::MAX_MEMORY / 1_000_000
    )]
    TooMuchMemory {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// Number of bytes needed.
        memory: u64,
    },
    /// The image is larger than frames may be.
    #[error(
        "the image is {width}x{height} pixels; at most {} in either direction and {} altogether are read",
        super::MAX_SIDE,
        super::MAX_PIXELS
    )]
    TooLarge {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
    },
}

impl Frame {
    /// Creates a frame from its bytes.
    ///
    /// # Panics
    /// When `rgb` is not `3 * width * height` long or the frame is empty: a mistake in the caller.
    pub fn new(width: usize, height: usize, rgb: Vec<u8>) -> Self {
        assert!(width > 0 && height > 0 && rgb.len() == 3 * width * height, "frame size");
        Self { width, height, rgb, notes: Notes::default() }
    }

    /// Value of type `T` cached with the frame, at first the default; `None` if a value of another type is
    /// cached.
    pub fn notes<T: Any + Default + Send + Sync>(&self) -> Option<&T> {
        self.notes.0.get_or_init(|| Box::<T>::default()).downcast_ref()
    }

    /// A frame whose pixel at column `x`, row `y` is `f(x, y)`.
    pub fn from_fn(width: usize, height: usize, f: impl Fn(usize, usize) -> [u8; 3]) -> Self {
        let mut rgb = Vec::with_capacity(3 * width * height);
        for y in 0..height {
            for x in 0..width {
                rgb.extend_from_slice(&f(x, y));
            }
        }
        Self::new(width, height, rgb)
    }

    /// Width in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All bytes, `3 * width * height`.
    pub fn bytes(&self) -> &[u8] {
        &self.rgb
    }

    /// Row `y`, `3 * width` bytes.
    pub fn row(&self, y: usize) -> &[u8] {
        &self.rgb[3 * self.width * y..3 * self.width * (y + 1)]
    }

    /// The pixel at column `x`, row `y`.
    pub fn pixel(&self, x: usize, y: usize) -> [u8; 3] {
        let i = 3 * (y * self.width + x);
        [self.rgb[i], self.rgb[i + 1], self.rgb[i + 2]]
    }

    /// The pixel at `(x, y)`; outside the frame, the nearest border pixel.
    pub fn pixel_clamped(&self, x: i64, y: i64) -> [u8; 3] {
        let cx = x.clamp(0, self.width as i64 - 1) as usize;
        let cy = y.clamp(0, self.height as i64 - 1) as usize;
        self.pixel(cx, cy)
    }
}
