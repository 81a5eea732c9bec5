//! Laws of the lists with what comes from outside: programs and result files.

use crate::{detector, signal, tracker};
use trackfail_core::plugin::Entry;

/// Checks a list of all kinds against that of the built-in ones.
fn check<T: ?Sized>(all: &[Entry<T>], built_in: &[Entry<T>]) {
    let kinds: std::collections::BTreeSet<&str> = all.iter().map(|entry| entry.kind).collect();
    assert_eq!(kinds.len(), all.len());
    assert!(built_in.iter().all(|entry| kinds.contains(entry.kind)));
    for entry in all.iter().filter(|entry| built_in.iter().all(|known| known.kind != entry.kind)) {
        crate::range_tests::check(std::slice::from_ref(entry));
        assert!(entry.version >= 1 && !entry.summary.is_empty(), "{}", entry.kind);
        let shown = entry.build_from_text(entry.example).unwrap().params();
        let set = shown.as_object().unwrap().iter().filter(|(_, value)| !value.is_null());
        let mut set: toml::Table =
            set.map(|(key, value)| (key.clone(), toml::Value::try_from(value).unwrap())).collect();
        let again = entry.build_from_text(&toml::Value::Table(set.clone()).to_string()).unwrap();
        assert_eq!(again.params(), shown, "{}", entry.kind);
        set.insert("no_such_parameter".into(), 1.into());
        let refused = entry.build_from_text(&toml::Value::Table(set).to_string()).err().unwrap();
        assert!(refused.message.contains("no_such_parameter"), "{}: {refused}", entry.kind);
    }
}

#[test]
fn lists_are_those_of_the_judging_crate_and_what_comes_from_outside() {
    check(signal::SIGNALS, trackfail_judge::signal::SIGNALS);
    check(detector::DETECTORS, trackfail_judge::detector::DETECTORS);
    check(tracker::TRACKERS, trackfail_judge::tracker::TRACKERS);
}
