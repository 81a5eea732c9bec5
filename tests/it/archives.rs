//! Archives that want to be somewhere else, or larger than they are: each is refused as a whole, names the
//! member, and leaves nothing, inside the data root or beside it.

use crate::fetch::{job_of, options, run};
use crate::packed::{Zipped, zip, zipped};
use crate::tools::files;
use proptest::prelude::*;
use std::path::Path;
use trackfail::dataset::fetch::{Caps, FetchError, MARKER};
use trackfail_testing::put;
use trackfail_testing::server::Server;

/// Fetches an archive into a data root inside `outer`.
fn fetched(outer: &Path, bytes: Vec<u8>, caps: Caps) -> Result<(), FetchError> {
    std::fs::create_dir_all(outer.join("root")).unwrap();
    put(outer, "canary", "alive");
    let mut options = options();
    (options.caps, options.patience.limit) = (caps, 1 << 30);
    run(&outer.join("root"), &job_of(&Server::file(bytes, "\"1\"")), &options).map(|_| ())
}

/// Nothing but what was there before.
#[track_caller]
fn untouched(outer: &Path) {
    let left = files(outer);
    assert_eq!(left.keys().collect::<Vec<_>>(), [Path::new("canary"), Path::new("root/.trackfail/lock")]);
    assert_eq!(left[Path::new("canary")], b"alive");
    assert!(!outer.join("root/otb").exists());
    let kept: Vec<_> = std::fs::read_dir(outer.join("root/.trackfail")).unwrap().flatten().collect();
    assert_eq!(kept.len(), 2, "{kept:?}");
}

/// Fetches an archive that is refused with these words and the name of a member, unless that is empty.
#[track_caller]
fn refused(members: &[Zipped], caps: Caps, name: &str, words: &str) {
    refused_bytes(zip(members), caps, name, words);
}

#[track_caller]
fn refused_bytes(bytes: Vec<u8>, caps: Caps, name: &str, words: &str) {
    let outer = tempfile::tempdir().unwrap();
    let error = fetched(outer.path(), bytes, caps).unwrap_err();
    assert!(error.is_data(), "{error}");
    untouched(outer.path());
    let text = error.to_string();
    assert!(text.contains(words) && !text.contains(char::is_control), "{text:?}, not {words}");
    assert!(name.is_empty() || text.contains(&format!("archive try, member `{name}")), "{text}, not {name}");
}

fn good() -> Zipped {
    zipped("seq/good", b"good")
}

fn deflated(name: &str, data: &[u8]) -> Zipped {
    Zipped { deflated: true, ..zipped(name, data) }
}

// The list of all names that are refused is that of a test beside the reader of them.
#[test]
fn names_that_lead_elsewhere_or_cannot_be_stored() {
    let deep = "seq".to_owned() + &"/d".repeat(16);
    let names: [(&[u8], &str, &str); 5] = [
        (b"../canary", "../canary", "`..`"),
        (b"seq/\x1b[2J", "seq/", "control"),
        (b"seq/\xff\xfe", "seq/\u{fffd}\u{fffd}", "not UTF-8"),
        (deep.as_bytes(), &deep, "more than 16 parts"),
        // Outside the folder that is wanted, too.
        (b"elsewhere/../../x", "elsewhere/../../x", "`..`"),
    ];
    for (name, shown, words) in names {
        refused(&[good(), zipped(name, b"x")], Caps::default(), shown, words);
    }
    for (one, two, words) in [
        ("seq/a", "./seq/a", "there twice"),
        ("seq/a", "seq/a/b", "a file and a folder"),
        ("seq/a", "seq/a/", "a file and a folder"),
        ("seq/a/b", "seq/a", "a file and a folder"),
    ] {
        refused(&[good(), zipped(one, b"1"), zipped(two, b"")], Caps::default(), two, words);
    }
    let twice = [good(), zipped("seq/a", b"1"), zipped("seq/a", b"2")];
    refused(&twice, Caps::default(), "", "two of its members have the same name");
}

#[test]
fn what_is_neither_file_nor_folder() {
    for (mode, kind) in [
        (0o120_777, "symbolic link"),
        (0o020_666, "device"),
        (0o060_666, "device"),
        (0o010_666, "named pipe"),
        (0o140_666, "special file"),
    ] {
        // The classic: a link first, and a file written through it.
        let link = Zipped { mode, ..zipped("seq/bad", b"../../canary") };
        refused(&[good(), link, zipped("seq/bad/a", b"x")], Caps::default(), "seq/bad", kind);
    }
}

#[test]
fn more_than_the_caps_allow() {
    let tiny = Caps { total: 3000, ratio: 10, slack: 2500, entries: 4 };
    let (roomy, flat) = (Caps { slack: 1 << 20, ..tiny }, Caps { total: 1 << 20, ratio: 2, ..tiny });
    let noise: Vec<u8> = (0..3001_u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    let of = |name: &str, n: usize| deflated(name, &noise[..n]);
    let zeros = |name: &str, n: usize| deflated(name, &vec![0; n]);
    let few = Caps { ratio: 2, slack: 1000, entries: 10, ..Caps::default() };
    for (members, caps, name, words) in [
        (vec![of("seq/big", 3001)], roomy, "seq/big", "more than 3000 bytes"),
        (vec![of("seq/a", 1600), of("seq/b", 1600)], roomy, "seq/b", "more than 3000 bytes"),
        (vec![zeros("seq/a", 2000), zeros("seq/b", 2000)], flat, "seq/b", "more than 2 times its size"),
        // Bombs in the wanted folder and beside it.
        (vec![good(), zeros("other/zeros", 16 << 20)], few, "other/zeros", "more than 2 times its size"),
        (vec![good(), zeros("seq/zeros", 80 << 20)], Caps::default(), "seq/zeros", "more than 100 times"),
    ] {
        refused(&members, caps, name, words);
    }
    // Sizes that are not true: fewer bytes than announced, and more, which is a bomb that says it is small.
    let claim = |size: u64, member: Zipped| [good(), Zipped { size: Some(size), ..member }];
    for (members, words) in [
        (claim(1 << 62, zipped("seq/bad", b"x")), "more than 100 times its size"),
        (claim(u64::MAX - 512, zipped("seq/bad", b"x")), "more than 100 times its size"),
        (claim(9, zipped("seq/bad", b"12345")), "5 bytes, the archive says 9"),
        (claim(3, zeros("seq/bad", 100_000)), ""),
    ] {
        refused(&members, Caps::default(), "seq/bad", words);
    }
    // A list that is too long is refused, and not read to its end.
    let caps = Caps { entries: 100, ..Caps::default() };
    let member = |k: usize| Zipped { same_as: (k > 0).then_some(0), ..zipped(format!("seq/{k}"), b"") };
    let apart: Vec<_> = (0..101).map(|k| zipped(format!("seq/{k}"), b"")).collect();
    for members in [apart, (0..60_000).map(member).collect()] {
        refused(&members, caps, "", "more than 100 members");
    }
}

#[test]
fn members_that_are_locked_damaged_or_share_bytes() {
    let bad = || zipped("seq/bad", b"secret secret");
    for (member, name, words) in [
        (Zipped { flags: 1, ..bad() }, "seq/bad", "Password required"),
        (Zipped { method: Some(14), ..bad() }, "seq/bad", "not packed in the usual way"),
        (Zipped { checksum: Some(1), ..bad() }, "seq/bad", "damaged"),
        (Zipped { same_as: Some(0), ..zipped("seq/bad", b"good") }, "", "share packed bytes"),
    ] {
        refused(&[good(), member], Caps::default(), name, words);
    }
}

#[test]
fn every_cut_archive_is_refused() {
    let zip = zip(&[zipped("seq/a", b"some bytes"), zipped("seq/b", b"")]);
    for n in 0..zip.len() {
        refused_bytes(zip[..n].to_vec(), Caps::default(), "", "");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    /// Names of all sorts, most of them nearly good ones.
    #[test]
    fn arbitrary_names_never_escape(names in proptest::collection::vec(prop_oneof![
        proptest::collection::vec(any::<u8>(), 0..30),
        "(seq/)?[a-c./\\\\: ~]{0,10}".prop_map(String::into_bytes),
        "(seq/|\\.\\./|/|\\./){0,4}[a-cA-C]{1,2}/?".prop_map(String::into_bytes),
    ], 1..5)) {
        let zips: Vec<_> = names.iter().map(|n| zipped(n, b"x")).collect();
        let outer = tempfile::tempdir().unwrap();
        match fetched(outer.path(), zip(&zips), Caps::default()) {
            Err(_) => untouched(outer.path()),
            Ok(()) => {
                let inside = Path::new("root/otb/seq");
                let known = [Path::new("canary"), Path::new("root/.trackfail/lock")];
                for path in files(outer.path()).keys().filter(|p| !known.contains(&p.as_path())) {
                    let below = path.strip_prefix(inside).unwrap();
                    let named = |n: &Vec<u8>| n.ends_with(below.as_os_str().as_encoded_bytes());
                    prop_assert!(below == Path::new(MARKER) || names.iter().any(named), "{path:?}");
                }
            }
        }
    }

    /// Bytes changed anywhere: an error, or what was packed, but never a crash.
    #[test]
    fn damaged_bytes_never_crash(at in any::<prop::sample::Index>(), value in any::<u8>()) {
        let mut bytes = zip(&[zipped("seq/a", b"some bytes"), zipped("seq/b", b"")]);
        let place = at.index(bytes.len());
        bytes[place] = value;
        let outer = tempfile::tempdir().unwrap();
        match fetched(outer.path(), bytes, Caps::default()) {
            Err(_) => untouched(outer.path()),
            Ok(()) => prop_assert!(outer.path().join("root/otb/seq").is_dir()),
        }
    }
}
