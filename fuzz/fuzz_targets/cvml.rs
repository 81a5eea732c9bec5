//! CVML ground truth.

#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use trackfail::dataset::cvml;

fuzz_target!(|data: &[u8]| {
    let Ok(document) = std::str::from_utf8(data) else { return };
    let Ok(annotation) = cvml::parse(Path::new("fuzz.xml"), document) else { return };
    for object in annotation.objects().take(4) {
        let Some((first, last)) = annotation.presence(object) else { continue };
        assert!(first <= last && last <= annotation.last());
        for image in (first..=last).take(64) {
            let Some(rect) = annotation.region(object, image) else { continue };
            assert!(rect.w > 0.0 && rect.h > 0.0 && (rect.x + rect.y + rect.w + rect.h).is_finite());
        }
    }
});
