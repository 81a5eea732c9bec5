//! Archives: whatever the bytes say, nothing appears outside of the folder, and no more than the limits allow.

#![no_main]

use libfuzzer_sys::fuzz_target;
use trackfail::dataset::archive::{Archive, Packing};
use trackfail::dataset::fetch::{Caps, unpack};
use walkdir::WalkDir;

fuzz_target!(|data: &[u8]| {
    let place = tempfile::tempdir_in("/dev/shm").expect("a folder");
    let (file, into) = (place.path().join("file"), place.path().join("into"));
    std::fs::write(&file, data).expect("a file");
    std::fs::create_dir(&into).expect("a folder");
    let [name, url, into_root] = ["fuzz", "https://example.org/fuzz", "otb"].map(String::from);
    let packing = Packing::Zip;
    let archive = Archive { name, url, packing, size: None, sha256: None, into: into_root, below: None };
    let caps = Caps { total: 1 << 20, ratio: 10, slack: 1 << 16, entries: 64 };
    let _ = unpack(&file, &archive, &["otb/seq".into()], &caps, &into);
    let mut names: Vec<_> =
        std::fs::read_dir(place.path()).expect("there").map(|e| e.expect("one").file_name()).collect();
    names.sort();
    assert_eq!(names, ["file", "into"]);
    let entries = WalkDir::new(into).into_iter().map(|entry| entry.expect("one"));
    let files: Vec<_> = entries.filter(|entry| !entry.file_type().is_dir()).collect();
    assert!(files.iter().all(|entry| entry.file_type().is_file()));
    assert!(files.iter().map(|entry| entry.metadata().expect("known").len()).sum::<u64>() <= caps.total);
});
