//! Archives that want to be somewhere else, or larger than they are: each is refused as a whole, names the
//! member, and leaves nothing, inside the data root or beside it.

use crate::fetch::{job_of, options, run};
use crate::packed::{Zipped, zip, zipped};
use crate::server::Server;
use crate::tools::files;
use proptest::prelude::*;
use std::path::Path;
use trackfail::dataset::fetch::{Caps, FetchError, MARKER};
use trackfail::dataset::text::visible;
use trackfail_testing::put;

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

/// Fetches an archive that is refused with these words.
#[track_caller]
fn refused(bytes: Vec<u8>, caps: Caps, words: &str) -> String {
    let outer = tempfile::tempdir().unwrap();
    let error = fetched(outer.path(), bytes, caps).unwrap_err();
    assert!(error.is_data(), "{error}");
    untouched(outer.path());
    let text = error.to_string();
    assert!(text.contains(words) && !text.contains(char::is_control), "{text:?}, not {words}");
    text
}

#[track_caller]
fn refused_member(bytes: Vec<u8>, caps: Caps, name: &[u8], words: &str) {
    let text = refused(bytes, caps, words);
    let name: String = visible(&String::from_utf8_lossy(name)).chars().take(120).collect();
    assert!(text.contains(&format!("archive try, member `{name}")), "{text}");
}

fn zip_after(bad: Zipped) -> Vec<u8> {
    zip(&[zipped("seq/good", b"good"), bad])
}

#[test]
fn names_that_lead_elsewhere_or_cannot_be_stored() {
    let long = format!("seq/{}", "x".repeat(256));
    let deep = "seq".to_owned() + &"/d".repeat(16);
    let names: [(&[u8], &str); 23] = [
        (b"../canary", "`..`"),
        (b"seq/../../../canary", "`..`"),
        (b"seq/./a", "`..`"),
        (b"/canary", "absolute"),
        (b"//host/share", "absolute"),
        (b"C:\\canary", "backslash"),
        (b"..\\canary", "backslash"),
        (b"C:canary", "colon"),
        (b"seq/a:stream", "colon"),
        (b"seq//a", "empty"),
        (b"", "empty"),
        (b"seq/\x1b[2J", "control"),
        (b"seq/a\nb", "control"),
        (b"seq/a\0.jpg", "control"),
        (b"seq/\xff\xfe", "not UTF-8"),
        (b"seq/a.", "a dot or a space"),
        (b"seq/a ", "a dot or a space"),
        (b"seq /a", "a dot or a space"),
        (b"seq/.trackfail-complete", "keeps for itself"),
        (b"seq/.trackfail/lock", "keeps for itself"),
        (long.as_bytes(), "longer than 255 bytes"),
        (deep.as_bytes(), "more than 16 parts"),
        // Outside the folder that is wanted, too.
        (b"elsewhere/../../x", "`..`"),
    ];
    for (name, words) in names {
        refused_member(zip_after(zipped(name, b"x")), Caps::default(), name, words);
    }
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
        let bytes = zip(&[zipped("seq/good", b"good"), link, zipped("seq/bad/a", b"x")]);
        refused_member(bytes, Caps::default(), b"seq/bad", kind);
    }
}

#[test]
fn paths_that_are_there_twice() {
    for (one, two, words) in [
        ("seq/a", "./seq/a", "there twice"),
        ("seq/a", "seq/a/b", "a file and a folder"),
        ("seq/a", "seq/a/", "a file and a folder"),
        ("seq/a/b", "seq/a", "a file and a folder"),
    ] {
        let bytes = zip(&[zipped("seq/good", b"good"), zipped(one, b"1"), zipped(two, b"")]);
        refused_member(bytes, Caps::default(), two.as_bytes(), words);
    }
    let bytes = zip(&[zipped("seq/good", b"good"), zipped("seq/a", b"1"), zipped("seq/a", b"2")]);
    refused(bytes, Caps::default(), "two of its members have the same name");
}

#[test]
fn more_than_the_caps_allow() {
    let tiny = Caps { total: 3000, ratio: 10, slack: 2500, entries: 4 };
    let roomy = Caps { slack: 1 << 20, ..tiny };
    let noise: Vec<u8> = (0..3001_u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    let member = |name: &str, n: usize| (name.to_owned(), noise[..n].to_vec());
    let cases = [
        (vec![member("seq/big", 3001)], roomy, "seq/big", "more than 3000 bytes"),
        (vec![member("seq/a", 1600), member("seq/b", 1600)], roomy, "seq/b", "more than 3000 bytes"),
        (
            vec![("seq/a".into(), vec![0; 2000]), ("seq/b".into(), vec![0; 2000])],
            Caps { total: 1 << 20, ratio: 2, slack: 2500, ..tiny },
            "seq/b",
            "more than 2 times its size",
        ),
    ];
    for (members, caps, name, words) in cases {
        let zips: Vec<_> = members.iter().map(|(n, d)| Zipped { deflated: true, ..zipped(n, d) }).collect();
        refused_member(zip(&zips), caps, name.as_bytes(), words);
    }
}

#[test]
fn sizes_that_are_not_true() {
    for claim in [1 << 62, u64::MAX - 512] {
        let bytes = zip_after(Zipped { size: Some(claim), ..zipped("seq/bad", b"x") });
        refused_member(bytes, Caps::default(), b"seq/bad", "more than 100 times its size");
    }
    // Fewer bytes than announced, and more: a bomb that says it is small.
    let few = zip_after(Zipped { size: Some(9), ..zipped("seq/bad", b"12345") });
    refused_member(few, Caps::default(), b"seq/bad", "5 bytes, the archive says 9");
    let bomb = Zipped { size: Some(3), deflated: true, ..zipped("seq/bad", &vec![0; 100_000]) };
    refused_member(zip_after(bomb), Caps::default(), b"seq/bad", "");
}

#[test]
fn bombs_do_not_go_off_in_the_wanted_folder_or_beside_it() {
    let few = Caps { ratio: 2, slack: 1000, entries: 10, ..Caps::default() };
    for (name, length, caps, words) in [
        ("other/zeros", 16 << 20, few, "more than 2 times its size"),
        ("seq/zeros", 80 << 20, Caps::default(), "more than 100 times its size"),
    ] {
        let bytes = zip_after(Zipped { deflated: true, ..zipped(name, &vec![0; length]) });
        assert!(bytes.len() < length / 900);
        refused_member(bytes, caps, name.as_bytes(), words);
    }
}

#[test]
fn a_list_of_members_that_is_too_long_is_not_read_to_its_end() {
    let member = |k: usize| Zipped { same_as: (k > 0).then_some(0), ..zipped(format!("seq/{k}"), b"") };
    let bytes = zip(&(0..60_000).map(member).collect::<Vec<_>>());
    refused(bytes, Caps { entries: 100, ..Caps::default() }, "more than 100 members");
}

#[test]
fn a_list_of_members_that_is_too_long_is_refused() {
    let bytes = zip(&(0..101).map(|k| zipped(format!("seq/{k}"), b"")).collect::<Vec<_>>());
    refused(bytes, Caps { entries: 100, ..Caps::default() }, "more than 100 members");
}

#[test]
fn members_that_are_locked_damaged_or_share_bytes() {
    let bad = || zipped("seq/bad", b"secret secret");
    for (member, words) in [
        (Zipped { flags: 1, ..bad() }, "Password required"),
        (Zipped { method: Some(14), ..bad() }, "not packed in the usual way"),
        (Zipped { checksum: Some(1), ..bad() }, "damaged"),
    ] {
        refused_member(zip_after(member), Caps::default(), b"seq/bad", words);
    }
    let shared = zip_after(Zipped { same_as: Some(0), ..zipped("seq/bad", b"good") });
    refused(shared, Caps::default(), "share packed bytes");
}

#[test]
fn every_cut_archive_is_refused() {
    let zip = zip(&[zipped("seq/a", b"some bytes"), zipped("seq/b", b"")]);
    for n in 0..zip.len() {
        refused(zip[..n].to_vec(), Caps::default(), "");
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
        let at = at.index(bytes.len());
        bytes[at] = value;
        let outer = tempfile::tempdir().unwrap();
        match fetched(outer.path(), bytes, Caps::default()) {
            Err(_) => untouched(outer.path()),
            Ok(()) => prop_assert!(outer.path().join("root/otb/seq").is_dir()),
        }
    }
}
