//! Packs of the store: as they are, and with a tail that makes the index believable.

#![no_main]

use libfuzzer_sys::fuzz_target;
use sha2::{Digest, Sha256};
use std::io::Cursor;
use std::path::Path;
use trackfail::engine::execute::detector_outputs::StoredDetectorOutput;
use trackfail::engine::store::pack::{index_of, record_of};
use trackfail::tracker::TrackerState;

fn read(bytes: &[u8]) {
    let path = Path::new("fuzz.pack");
    let mut pack = Cursor::new(bytes);
    let Ok(index) = index_of(&mut pack, path) else { return };
    for place in index.iter().take(16) {
        if let Ok((head, payload)) = record_of(&mut pack, place, path) {
            assert_eq!(head.recipe.address(), place.address);
            content(&payload);
        }
    }
}

fn content(payload: &[u8]) {
    let _ = postcard::from_bytes::<Vec<TrackerState>>(payload);
    let _ = postcard::from_bytes::<Vec<f64>>(payload);
    if let Ok(verdict) = postcard::from_bytes::<StoredDetectorOutput>(payload) {
        let _ = verdict.on(&[0.5; 8]);
    }
}

fuzz_target!(|data: &[u8]| {
    read(data);
    content(data);
    let magic = b"trackfail-pack/1";
    let tail = [&(data.len() as u64).to_le_bytes()[..], &Sha256::digest(data), magic].concat();
    read(&[&magic[..], data, data, &tail].concat());
});
