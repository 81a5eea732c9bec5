//! Structure of a JPEG file (ITU-T T.81), checked before it is decoded.
//!
//! Decoders fill missing parts with gray and report success. These rules find truncated files, even if an end
//! marker, with or without another marker before it, was added after the cut:
//!
//! - A scan has at least as many bits as its blocks need: two a block in sequential files (no Huffman code is shorter
//!   than one bit, and a block has one for its mean and one for the rest), one a block in those scans of progressive
//!   files that hold means. So a few bytes cannot claim to be a large image.
//! - A scan has the restart markers that its interval asks for and no others, and every component has a scan.
//! - No scan comes a second time: those of a sequential file have components of their own, those of a progressive one
//!   coefficients, or the next bit of what earlier scans had.
//! - The scans of a progressive file have every coefficient of every component to its last bit. The standard does not ask
//!   for it, but encoders do it, and a file that ends between two scans is coarser than it was made.
//! - The decoder gets [`STOP`] behind the data of the last scan: ones, which no Huffman code consists of (T.81, C.2). It
//!   stops there with an error, unless it has all blocks already. Earlier scans of a sequential file are tried
//!   alone, because the decoder finds a scan only at once behind the data of the one before.

use super::Header;
use crate::image::ImageError;
use std::ops::{Range, RangeInclusive};

/// Bytes that stop any decoder: one bits, with the zero after each byte that distinguishes it from a marker.
pub(super) const STOP: [[u8; 2]; 16] = [[0xFF, 0]; 16];

const START: [u8; 2] = [0xFF, 0xD8];
pub(super) const END: [u8; 2] = [0xFF, 0xD9];
const RESTART: RangeInclusive<u8> = 0xD0..=0xD7;
/// Marker without a length, which only arithmetic coding uses.
const TEMPORARY: u8 = 0x01;
const DEFINE_RESTARTS: u8 = 0xDD;
const START_OF_SCAN: u8 = 0xDA;
/// Marker of the application segment in which cameras store the orientation; its first bytes follow.
const APPLICATION_1: u8 = 0xE1;
const EXIF: &[u8] = b"Exif\0\0";

/// Side of a block in samples.
const BLOCK: u64 = 8;
/// Number of coefficients of a block.
const COEFFICIENTS: usize = 64;

/// True if the bytes start like a JPEG file.
pub(super) fn is_jpeg(bytes: &[u8]) -> bool {
    bytes.starts_with(&START)
}

/// A component of the image: a color, or brightness.
struct Component {
    id: u8,
    horizontal: u64,
    vertical: u64,
    /// Lowest bit of each coefficient that the scans so far contain. At 0 a coefficient is complete;
    /// sequential scans contain all bits.
    lowest_bits: [u8; COEFFICIENTS],
}

impl Component {
    /// Registers a scan with some coefficients down to a bit. Returns false unless it continues the earlier
    /// scans: the first scan of a coefficient has no predecessor, later ones add the next lower bit.
    fn take(&mut self, coefficients: RangeInclusive<usize>, highest_bit: u8, lowest_bit: u8) -> bool {
        let Some(bits) = self.lowest_bits.get_mut(coefficients) else { return false };
        let before = if highest_bit == 0 { u8::MAX } else { highest_bit };
        let follows = highest_bit == 0 || highest_bit == lowest_bit + 1;
        let continues = follows && bits.iter().all(|bit| *bit == before);
        bits.fill(lowest_bit);
        continues
    }

    fn is_complete(&self) -> bool {
        self.lowest_bits.iter().all(|bit| *bit == 0)
    }
}

/// Contents of the frame header.
struct FrameHeader {
    is_progressive: bool,
    width: u64,
    height: u64,
    components: Vec<Component>,
}

impl FrameHeader {
    /// Parses a start-of-frame segment.
    fn read(marker: u8, segment: &[u8]) -> Option<Self> {
        let &[_, h1, h0, w1, w0, count, ref rest @ ..] = segment else { return None };
        let component = |c: &[u8; 3]| Component {
            id: c[0],
            horizontal: u64::from(c[1] >> 4),
            vertical: u64::from(c[1] & 15),
            lowest_bits: [u8::MAX; COEFFICIENTS],
        };
        let components: Vec<Component> = rest.as_chunks::<3>().0.iter().map(component).collect();
        let valid =
            components.iter().all(|c| (1..=4).contains(&c.horizontal) && (1..=4).contains(&c.vertical));
        (components.len() == usize::from(count) && valid && !components.is_empty()).then(|| Self {
            is_progressive: matches!(marker, 0xC2 | 0xC6 | 0xCA | 0xCE),
            width: u16::from_be_bytes([w1, w0]).into(),
            height: u16::from_be_bytes([h1, h0]).into(),
            components,
        })
    }

    /// Largest horizontal and vertical sampling factor.
    fn largest(&self) -> (u64, u64) {
        let largest = |of: fn(&Component) -> u64| self.components.iter().map(of).max().unwrap_or(1);
        (largest(|c| c.horizontal), largest(|c| c.vertical))
    }

    /// Number of blocks of a component, without padding.
    fn blocks(&self, c: &Component) -> u64 {
        let (horizontal, vertical) = self.largest();
        (self.width * c.horizontal).div_ceil(BLOCK * horizontal)
            * (self.height * c.vertical).div_ceil(BLOCK * vertical)
    }

    /// Number of units in a scan of these components. Restart intervals are counted in units.
    fn units(&self, scan: &[usize]) -> u64 {
        match scan {
            [one] => self.blocks(&self.components[*one]),
            _ => {
                let (horizontal, vertical) = self.largest();
                self.width.div_ceil(BLOCK * horizontal) * self.height.div_ceil(BLOCK * vertical)
            }
        }
    }

    /// Bytes that the decoder needs if it keeps all coefficients.
    fn coefficients(&self) -> u64 {
        let (horizontal, vertical) = self.largest();
        let units = self.width.div_ceil(BLOCK * horizontal) * self.height.div_ceil(BLOCK * vertical);
        self.components.iter().map(|c| 2 * BLOCK * BLOCK * units * c.horizontal * c.vertical).sum()
    }
}

/// Walks through the segments, and the entropy-coded data between them, up to the end marker. Lengths of
/// segments are honored because thumbnails inside Exif have end markers, too.
///
/// # Errors
/// Violations of the rules at the head of this file.
pub(super) fn header(bytes: &[u8]) -> Result<Header, ImageError> {
    let mut walk = Walk { frame: None, interval: 0, scans: Vec::new(), short: None };
    let (mut at, mut exif) = (START.len(), None);
    loop {
        let place = next_marker(bytes, at).ok_or(ImageError::Truncated)?;
        let marker = bytes[place + 1];
        at = place + 2;
        if marker == END[1] {
            break;
        }
        let length = bytes.get(at..).and_then(|rest| rest.first_chunk::<2>()).ok_or(ImageError::Truncated)?;
        let length = usize::from(u16::from_be_bytes(*length)).max(2);
        let segment = bytes.get(at + 2..at + length).ok_or(ImageError::Truncated)?;
        at += length;
        match marker {
            0xC0..=0xCF if !matches!(marker, 0xC4 | 0xC8 | 0xCC) => {
                let frame = FrameHeader::read(marker, segment).filter(|_| walk.frame.is_none());
                walk.frame = Some(frame.ok_or_else(|| damaged("its frame header"))?);
            }
            DEFINE_RESTARTS => {
                let interval = segment.first_chunk::<2>().ok_or_else(|| damaged("its restart interval"))?;
                walk.interval = u16::from_be_bytes(*interval).into();
            }
            START_OF_SCAN => {
                let next = next_marker(bytes, at).ok_or(ImageError::Truncated)?;
                walk.scan(segment, &bytes[at..next])?;
                walk.scans.push(place..next);
            }
            APPLICATION_1 => exif = exif.or(segment.strip_prefix(EXIF)),
            _ => {}
        }
    }
    let Some(frame) = walk.frame else { return Err(ImageError::Decode("it has no frame header".into())) };
    if !frame.components.iter().all(Component::is_complete) {
        return Err(ImageError::Truncated);
    }
    // The decoder loses rows and colors of such files and reports success.
    if !frame.is_progressive && walk.scans.len() > 1 && frame.largest() != (1, 1) {
        let message =
            "its colors are in scans of their own and have fewer pixels; save it as a common JPEG or PNG";
        return Err(ImageError::Decode(message.into()));
    }
    let keeps_all = frame.is_progressive || walk.scans.len() > 1;
    let coefficients = if keeps_all { frame.coefficients() } else { 0 };
    // A gray image is decoded to one byte a pixel, of which the frame's three are made.
    let samples = if frame.components.len() == 1 { 1 + 3 } else { 3 };
    let (packed, least) = walk.short.unwrap_or_default();
    let header = Header {
        is_progressive: frame.is_progressive,
        scans: walk.scans,
        width: frame.width as u32,
        height: frame.height as u32,
        orientation: super::orientation(exif),
        packed,
        least,
        memory: coefficients + frame.width * frame.height * samples,
    };
    header.check(bytes)
}

/// The file with only one of its scans, followed by [`STOP`] and the end marker.
pub(super) fn alone(bytes: &[u8], scans: &[Range<usize>], scan: usize) -> Vec<u8> {
    let (mut made, mut at) = (Vec::new(), 0);
    for before in &scans[..scan] {
        made.extend_from_slice(&bytes[at..before.start]);
        at = before.end;
    }
    [&made, &bytes[at..scans[scan].end], STOP.as_flattened(), &END].concat()
}

fn damaged(what: &str) -> ImageError {
    ImageError::Decode(format!("{what} is damaged"))
}

/// Position of the next marker after entropy-coded data. Within such data, FF is followed only by 00, a
/// restart marker or a fill byte.
fn next_marker(bytes: &[u8], from: usize) -> Option<usize> {
    let rest = bytes.get(from..)?;
    let inside = |second: u8| matches!(second, 0x00 | TEMPORARY | 0xFF) || RESTART.contains(&second);
    rest.windows(2).position(|w| w[0] == 0xFF && !inside(w[1])).map(|at| from + at)
}

/// State while walking through a file.
struct Walk {
    frame: Option<FrameHeader>,
    /// Number of units between two restart markers; 0 for none.
    interval: u64,
    scans: Vec<Range<usize>>,
    /// Size in bytes of the first scan that is too short, and its least size.
    short: Option<(u64, u64)>,
}

impl Walk {
    /// Checks header and data of a scan.
    fn scan(&mut self, segment: &[u8], data: &[u8]) -> Result<(), ImageError> {
        let frame = self.frame.as_mut().ok_or_else(|| damaged("the order of its segments"))?;
        let bad = || damaged("the header of a scan");
        let (&count, rest) = segment.split_first().ok_or_else(bad)?;
        let (ids, rest) = rest.split_at_checked(2 * usize::from(count)).ok_or_else(bad)?;
        let &[first, last, bits, ..] = rest else { return Err(bad()) };
        let (has, highest_bit, lowest_bit) = match frame.is_progressive {
            true => (usize::from(first)..=usize::from(last), bits >> 4, bits & 15),
            false => (0..=COEFFICIENTS - 1, 0, 0),
        };
        let mut scan = Vec::new();
        for id in ids.iter().step_by(2) {
            let component = frame.components.iter().position(|c| c.id == *id).ok_or_else(bad)?;
            if !frame.components[component].take(has.clone(), highest_bit, lowest_bit) {
                return Err(damaged("the order of its scans"));
            }
            scan.push(component);
        }
        let bits_a_block = match (frame.is_progressive, first) {
            (false, _) => 2,
            (true, 0) => 1,
            // One code may say that no block to come has any of these coefficients.
            (true, _) => 0,
        };
        let blocks: u64 = scan.iter().map(|c| frame.blocks(&frame.components[*c])).sum();
        // Zeros that tell a byte of ones from a marker hold nothing.
        let stuffed = data.windows(2).filter(|w| *w == [0xFF, 0]).count();
        let (packed, least) = ((data.len() - stuffed) as u64, (blocks * bits_a_block).div_ceil(8));
        self.short = self.short.or((packed < least).then_some((packed, least)));
        let count = |is: fn(u8) -> bool| data.windows(2).filter(|w| w[0] == 0xFF && is(w[1])).count() as u64;
        let restarts = count(|second| RESTART.contains(&second));
        let needed = match self.interval {
            0 => 0,
            interval => frame.units(&scan).div_ceil(interval).saturating_sub(1),
        };
        if restarts < needed && self.short.is_none() {
            return Err(ImageError::Truncated);
        }
        if restarts > needed || count(|second| second == TEMPORARY) > 0 {
            return Err(damaged("the data of a scan, which has a marker where none belongs,"));
        }
        Ok(())
    }
}
