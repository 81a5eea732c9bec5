//! JPEG and PNG frames.

#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let size = trackfail::image::size(data);
    // Pixels of large pictures are the decoders' own business and take seconds.
    if size.as_ref().is_ok_and(|(w, h)| w * h > 1 << 16) {
        return;
    }
    if let Ok(frame) = trackfail::image::decode(data) {
        assert_eq!(size.ok(), Some((frame.width(), frame.height())));
        assert_eq!(frame.bytes().len(), 3 * frame.width() * frame.height());
    }
});
