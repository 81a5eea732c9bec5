//! Messages of trackers; what is read can be written and read again.

#![no_main]

use libfuzzer_sys::fuzz_target;
use trackfail::tracker::trax;

fuzz_target!(|data: &[u8]| {
    let mut rest = data;
    while let Ok(Some(message)) = trax::read(&mut rest) {
        let Ok(line) = trax::write(&message) else { continue };
        assert_eq!(trax::parse(line.as_bytes()).ok().flatten().as_ref(), Some(&message));
    }
});
