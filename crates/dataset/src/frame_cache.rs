//! Cache of decoded frames, for readers that go over a sequence more than once or backwards.
//!
//! Frames of more than `MAX_FRAME_BYTES` are not kept: too few would fit for one to be found again.

use super::{DatasetError, Sequence};
use lru::LruCache;
use std::sync::{Arc, Mutex, PoisonError};
use trackfail_core::image::Frame;

/// Largest frame that is kept, in bytes: about 2.8 megapixels.
const MAX_FRAME_BYTES: usize = 8 << 20;

/// The most recently used frames of all sequences, up to a limit in bytes.
pub struct FrameCache {
    most: usize,
    kept: Mutex<CachedFrames>,
}

struct CachedFrames {
    bytes: usize,
    /// Frames by the address of their sequence and their index. The entry owns the sequence, so that the
    /// address stays in use.
    frames: LruCache<(usize, usize), (Arc<Sequence>, Arc<Frame>)>,
}

impl FrameCache {
    /// Creates a cache of at most `most` bytes of pixels. With 0 nothing is kept.
    pub fn new(most: usize) -> Self {
        Self { most, kept: Mutex::new(CachedFrames { bytes: 0, frames: LruCache::unbounded() }) }
    }

    /// Frame `t` (0-based) of a sequence, from the cache or decoded.
    ///
    /// # Errors
    /// When the frame cannot be decoded.
    pub fn frame(&self, sequence: &Arc<Sequence>, t: usize) -> Result<Arc<Frame>, DatasetError> {
        let key = (Arc::as_ptr(sequence) as usize, t);
        if let Some((_, frame)) = self.kept().frames.get(&key) {
            return Ok(frame.clone());
        }
        let frame = Arc::new(sequence.frame(t)?);
        if frame.bytes().len() <= self.most.min(MAX_FRAME_BYTES) {
            let mut kept = self.kept();
            if kept.frames.put(key, (sequence.clone(), frame.clone())).is_none() {
                kept.bytes += frame.bytes().len();
            }
            while kept.bytes > self.most
                && let Some((_, (_, oldest))) = kept.frames.pop_lru()
            {
                kept.bytes -= oldest.bytes().len();
            }
        }
        Ok(frame)
    }

    fn kept(&self) -> std::sync::MutexGuard<'_, CachedFrames> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Frames;
    use crate::user_frames::without_frames;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// A sequence of 4 x 2 pixels (24 bytes), and the number of its frames that were rendered.
    fn counted() -> (Arc<Sequence>, Arc<AtomicUsize>) {
        let count = Arc::new(AtomicUsize::new(0));
        let rendered = count.clone();
        let render = move |t: usize| {
            rendered.fetch_add(1, Ordering::Relaxed);
            Frame::from_fn(4, 2, |_, _| [t as u8; 3])
        };
        let frames = Frames::Rendered(Arc::new(render), 9);
        (Arc::new(Sequence { frames, ..without_frames("counted", 9) }), count)
    }

    // By hand: room for three frames of 24 bytes.
    #[test]
    fn the_frames_used_last_are_kept() {
        let (sequence, count) = counted();
        let cache = FrameCache::new(80);
        let made = |t: usize| {
            let before = count.load(Ordering::Relaxed);
            assert_eq!(cache.frame(&sequence, t).unwrap().pixel(0, 0), [t as u8; 3]);
            count.load(Ordering::Relaxed) > before
        };
        assert_eq!([0, 1, 2, 0, 1].map(made), [true, true, true, false, false]);
        // 2 is the one not used for longest.
        assert_eq!([3, 0, 1, 2].map(made), [true, false, false, true]);
    }

    #[test]
    fn sequences_are_kept_apart_and_a_cache_without_room_keeps_nothing() {
        let ((one, ones), (other, others)) = (counted(), counted());
        let cache = FrameCache::new(1 << 20);
        for sequence in [&one, &other, &one, &other] {
            cache.frame(sequence, 4).unwrap();
        }
        assert_eq!((ones.load(Ordering::Relaxed), others.load(Ordering::Relaxed)), (1, 1));
        let none = FrameCache::new(0);
        for _ in 0..3 {
            none.frame(&one, 4).unwrap();
        }
        assert_eq!(ones.load(Ordering::Relaxed), 4);
    }
}
