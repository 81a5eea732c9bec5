//! Numbers as regions, and what is computed from two of them.

#![no_main]

use libfuzzer_sys::fuzz_target;
use trackfail::region::Region;

fuzz_target!(|data: &[u8]| {
    let numbers: Vec<f64> =
        data.chunks_exact(8).filter_map(|c| Some(f64::from_le_bytes(c.try_into().ok()?))).collect();
    let (a, b) = numbers.split_at(numbers.len() / 2);
    let (Ok(a), Ok(b)) = (Region::from_numbers(a), Region::from_numbers(b)) else { return };
    assert!(a.area() >= 0.0 && b.area() >= 0.0);
    assert!(!(a.intersection(&b) < 0.0));
    let _ = a.rect();
});
