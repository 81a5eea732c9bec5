//! Tests of the lists that include external programs and result files.

use crate::{detector, signal, tracker};
use trackfail_core::plugin::Entry;

/// Checks the list of all kinds against the list of built-in kinds.
fn check<T: ?Sized>(all: &[Entry<T>], built_in: &[Entry<T>]) {
    let kinds: std::collections::BTreeSet<&str> = all.iter().map(|entry| entry.kind).collect();
    assert_eq!(kinds.len(), all.len());
    assert!(built_in.iter().all(|entry| kinds.contains(entry.kind)));
    for entry in all.iter().filter(|entry| built_in.iter().all(|known| known.kind != entry.kind)) {
        crate::range_tests::check(std::slice::from_ref(entry));
    }
}

#[test]
fn lists_are_those_of_the_judging_crate_and_what_comes_from_outside() {
    check(signal::SIGNALS, trackfail_judge::signal::SIGNALS);
    check(detector::DETECTORS, trackfail_judge::detector::DETECTORS);
    check(tracker::TRACKERS, trackfail_judge::tracker::TRACKERS);
}
