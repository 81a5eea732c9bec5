//! Archives that want to be somewhere else, or larger than they are: each is refused as a whole, names the
//! member, and leaves nothing, inside the data root or beside it.

use crate::fetch::{job, options, run};
use crate::packed::{Taped, Zipped, gz, record, special, taped, tar_gz, zip, zipped};
use crate::server::Server;
use crate::tools::files;
use proptest::prelude::*;
use std::path::Path;
use trackfail::dataset::archive::Packing;
use trackfail::dataset::fetch::{Caps, FetchError, MARKER, MemberFault};

/// Fetches an archive into a data root inside `outer`.
fn fetched(outer: &Path, packing: Packing, bytes: Vec<u8>, caps: Caps) -> Result<(), FetchError> {
    let root = outer.join("root");
    std::fs::create_dir_all(&root).unwrap();
    std::fs::write(outer.join("canary"), "alive").unwrap();
    let mut options = options();
    (options.caps, options.patience.limit) = (caps, 1 << 30);
    run(&root, &job(&format!("{}/a", Server::file(bytes, "\"1\"").url), packing), &options).map(|_| ())
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

#[track_caller]
fn refused(packing: Packing, bytes: Vec<u8>, caps: Caps) -> FetchError {
    let outer = tempfile::tempdir().unwrap();
    let error = fetched(outer.path(), packing, bytes, caps).unwrap_err();
    assert!(error.is_data(), "{error}");
    untouched(outer.path());
    error
}

#[track_caller]
fn refused_member(packing: Packing, bytes: Vec<u8>, caps: Caps, name: &[u8], why: &MemberFault) {
    let error = refused(packing, bytes, caps);
    let FetchError::Member { member, reason: found, .. } = &error else { panic!("{error}") };
    assert_eq!(member.as_bytes(), String::from_utf8_lossy(name).as_bytes(), "{error}");
    assert_eq!(found, why, "{error}");
    assert!(!error.to_string().contains(char::is_control), "{error:?}");
}

fn zip_after(bad: Zipped) -> Vec<u8> {
    zip(&[zipped("seq/good", b"good"), bad])
}

fn tar_after(bad: &[Taped]) -> Vec<u8> {
    tar_gz(&[&[taped("seq/good", b"good")], bad].concat())
}

#[test]
fn names_that_lead_elsewhere_or_cannot_be_stored() {
    let long = format!("seq/{}", "x".repeat(256));
    let deep = "seq".to_owned() + &"/d".repeat(16);
    let names: [(&[u8], MemberFault); 22] = [
        (b"../canary", MemberFault::Dots),
        (b"seq/../../../canary", MemberFault::Dots),
        (b"seq/./a", MemberFault::Dots),
        (b"/canary", MemberFault::Absolute),
        (b"//host/share", MemberFault::Absolute),
        (b"C:\\canary", MemberFault::Backslash),
        (b"..\\canary", MemberFault::Backslash),
        (b"C:canary", MemberFault::Colon),
        (b"seq/a:stream", MemberFault::Colon),
        (b"seq//a", MemberFault::Empty),
        (b"seq/\x1b[2J", MemberFault::Control),
        (b"seq/a\nb", MemberFault::Control),
        (b"seq/\xff\xfe", MemberFault::NotUtf8),
        (b"seq/NUL.jpg", MemberFault::Device),
        (b"seq/com7", MemberFault::Device),
        (b"seq/a.", MemberFault::End),
        (b"seq/a ", MemberFault::End),
        (b"seq /a", MemberFault::End),
        (b"seq/.trackfail-complete", MemberFault::Reserved),
        (b"seq/.trackfail/lock", MemberFault::Reserved),
        (long.as_bytes(), MemberFault::Long),
        (deep.as_bytes(), MemberFault::Deep(16)),
    ];
    for (name, why) in names {
        refused_member(Packing::Zip, zip_after(zipped(name, b"x")), Caps::default(), name, &why);
        let header = special("x", b'L', &[name, b"\0"].concat());
        let tar = tar_after(&[header, taped("seq/a", b"x")]);
        refused_member(Packing::TarGz, tar, Caps::default(), name, &why);
        if name.len() <= 100 {
            refused_member(Packing::TarGz, tar_after(&[taped(name, b"x")]), Caps::default(), name, &why);
        }
        if std::str::from_utf8(name).is_ok_and(|n| !n.contains('\n')) {
            let tar = tar_after(&[special("x", b'x', &record("path", name)), taped("seq/a", b"x")]);
            refused_member(Packing::TarGz, tar, Caps::default(), name, &why);
        }
    }
    // In a tar file a name ends at NUL, so only a zip file can have these.
    for (name, why) in [(&b"seq/a\0.jpg"[..], MemberFault::Control), (b"", MemberFault::Empty)] {
        refused_member(Packing::Zip, zip_after(zipped(name, b"x")), Caps::default(), name, &why);
    }
    // Outside the folder that is wanted, too.
    let name = b"elsewhere/../../x";
    refused_member(Packing::Zip, zip_after(zipped(name, b"x")), Caps::default(), name, &MemberFault::Dots);
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
        let bytes = zip_after(Zipped { mode, ..zipped("seq/bad", b"../../canary") });
        refused_member(Packing::Zip, bytes, Caps::default(), b"seq/bad", &MemberFault::Kind(kind));
    }
    for (type_flag, kind) in [
        (b'1', "hard link"),
        (b'2', "symbolic link"),
        (b'3', "device"),
        (b'4', "device"),
        (b'6', "named pipe"),
        (b'K', "hard link"),
        (b'S', "sparse file"),
        (b'V', "special file"),
    ] {
        let bad = Taped { link: b"../../canary", ..special("seq/bad", type_flag, b"") };
        // The classic: a link first, and a file written through it.
        let bytes = tar_after(&[bad, taped("seq/bad/a", b"x")]);
        refused_member(Packing::TarGz, bytes, Caps::default(), b"seq/bad", &MemberFault::Kind(kind));
    }
}

#[test]
fn paths_that_are_there_twice() {
    for (one, two, why) in [
        ("seq/a", "seq/a", MemberFault::Twice),
        ("seq/a", "seq/A", MemberFault::Twice),
        ("seq/a", "./seq/a", MemberFault::Twice),
        ("seq/É", "seq/é", MemberFault::Twice),
        ("seq/img/1", "seq/IMG/2", MemberFault::Twice),
        ("seq/a", "seq/a/b", MemberFault::FileAndFolder),
        ("seq/a/b", "seq/a", MemberFault::FileAndFolder),
        ("seq/a/b", "seq/A", MemberFault::FileAndFolder),
        ("x/a", "x/A", MemberFault::Twice),
    ] {
        let bytes = zip(&[zipped("seq/good", b"good"), zipped(one, b"1"), zipped(two, b"2")]);
        refused_member(Packing::Zip, bytes, Caps::default(), two.as_bytes(), &why);
        let bytes = tar_after(&[taped(one, b"1"), taped(two, b"2")]);
        refused_member(Packing::TarGz, bytes, Caps::default(), two.as_bytes(), &why);
    }
}

#[test]
fn more_than_the_caps_allow() {
    let tiny = Caps { total: 3000, member: 2000, ratio: 10, slack: 2500, entries: 4, depth: 3 };
    let roomy = Caps { slack: 1 << 20, ..tiny };
    let noise: Vec<u8> = (0..2001_u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    let member = |name: &str, n: usize| (name.to_owned(), noise[..n].to_vec());
    let cases = [
        (vec![member("seq/big", 2001)], roomy, "seq/big", MemberFault::Large(2000)),
        (vec![member("seq/a", 1600), member("seq/b", 1600)], roomy, "seq/b", MemberFault::Total(3000)),
        ((0..5).map(|k| member(&format!("seq/{k}"), 1)).collect(), roomy, "seq/4", MemberFault::Many(4)),
        (vec![member("seq/1/2/3", 1)], roomy, "seq/1/2/3", MemberFault::Deep(3)),
        (
            vec![("seq/a".into(), vec![0; 2000]), ("seq/b".into(), vec![0; 2000])],
            Caps { total: 1 << 20, ratio: 2, slack: 2500, ..tiny },
            "seq/b",
            MemberFault::Ratio(2),
        ),
    ];
    for (members, caps, name, why) in cases {
        let zips: Vec<_> = members.iter().map(|(n, d)| Zipped { deflated: true, ..zipped(n, d) }).collect();
        refused_member(Packing::Zip, zip(&zips), caps, name.as_bytes(), &why);
        let tapes: Vec<_> = members.iter().map(|(n, d)| taped(n, d)).collect();
        refused_member(Packing::TarGz, tar_gz(&tapes), caps, name.as_bytes(), &why);
    }
}

#[test]
fn sizes_that_are_not_true() {
    for claim in [1 << 62, u64::MAX - 512] {
        let bytes = zip_after(Zipped { size: Some(claim), ..zipped("seq/bad", b"x") });
        refused_member(Packing::Zip, bytes, Caps::default(), b"seq/bad", &MemberFault::Large(1 << 36));
    }
    let bytes = tar_after(&[Taped { size: Some(1 << 62), ..taped("seq/bad", b"x") }]);
    refused_member(Packing::TarGz, bytes, Caps::default(), b"seq/bad", &MemberFault::Large(1 << 36));
    // Fewer bytes than announced, and more: a bomb that says it is small.
    let few = zip_after(Zipped { size: Some(9), ..zipped("seq/bad", b"12345") });
    refused_member(
        Packing::Zip,
        few,
        Caps::default(),
        b"seq/bad",
        &MemberFault::Length { got: 5, declared: 9 },
    );
    let bomb = Zipped { size: Some(3), deflated: true, ..zipped("seq/bad", &vec![0; 100_000]) };
    let error = refused(Packing::Zip, zip_after(bomb), Caps::default());
    assert!(matches!(error, FetchError::Member { reason: MemberFault::Damaged(_), .. }), "{error}");
}

#[test]
fn a_bomb_beside_the_wanted_folder_does_not_go_off_either() {
    let caps = Caps { ratio: 2, slack: 1000, entries: 10, ..Caps::default() };
    let zeros = vec![0; 1 << 20];
    let bytes = zip_after(Zipped { deflated: true, ..zipped("other/zeros", &zeros) });
    refused_member(Packing::Zip, bytes, caps, b"other/zeros", &MemberFault::Ratio(2));
    let bytes = tar_after(&[taped("other/zeros", &zeros), taped("seq/a", b"")]);
    refused_member(Packing::TarGz, bytes, caps, b"other/zeros", &MemberFault::Ratio(2));
    // Nor behind the end of the archive.
    let bytes = [tar_after(&[]), gz(&zeros)].concat();
    refused_member(Packing::TarGz, bytes, caps, b"seq/good", &MemberFault::Ratio(2));
}

#[test]
fn a_thousand_to_one() {
    let zeros = vec![0; 80 << 20];
    let bytes = zip_after(Zipped { deflated: true, ..zipped("seq/zeros", &zeros) });
    assert!(bytes.len() < zeros.len() / 900);
    refused_member(Packing::Zip, bytes, Caps::default(), b"seq/zeros", &MemberFault::Ratio(100));
    let bytes = tar_after(&[taped("seq/zeros", &zeros)]);
    refused_member(Packing::TarGz, bytes, Caps::default(), b"seq/zeros", &MemberFault::Ratio(100));
}

#[test]
fn a_million_members() {
    let caps = Caps { entries: 1000, ..Caps::default() };
    let folders = (0..2000).map(|k| special(format!("seq/{k}/"), b'5', b""));
    let bytes = tar_gz(&folders.collect::<Vec<_>>());
    refused_member(Packing::TarGz, bytes, caps, b"seq/1000/", &MemberFault::Many(1000));
    // A list of members that is itself too long is not read to its end.
    let member = |k: usize| Zipped { same_as: (k > 0).then_some(0), ..zipped(format!("seq/{k}"), b"") };
    let bytes = zip(&(0..60_000).map(member).collect::<Vec<_>>());
    let error = refused(Packing::Zip, bytes, Caps { entries: 100, ..Caps::default() });
    assert!(error.to_string().contains("one of more than 100 members"), "{error}");
}

#[test]
fn members_that_are_locked_damaged_or_share_bytes() {
    let locked = zip_after(Zipped { flags: 1, ..zipped("seq/bad", b"secret secret") });
    refused_member(Packing::Zip, locked, Caps::default(), b"seq/bad", &MemberFault::Encrypted);
    let other = zip_after(Zipped { method: Some(14), ..zipped("seq/bad", b"x") });
    let error = refused(Packing::Zip, other, Caps::default());
    assert!(matches!(error, FetchError::Member { reason: MemberFault::Method(_), .. }), "{error}");
    let wrong = zip_after(Zipped { checksum: Some(1), ..zipped("seq/bad", b"x") });
    let error = refused(Packing::Zip, wrong, Caps::default());
    assert!(matches!(error, FetchError::Member { reason: MemberFault::Damaged(_), .. }), "{error}");
    let shared = zip_after(Zipped { same_as: Some(0), ..zipped("seq/bad", b"good") });
    let error = refused(Packing::Zip, shared, Caps::default());
    assert!(matches!(error, FetchError::Member { reason: MemberFault::Overlap, .. }), "{error}");
    // Headers other readers would take another size or name from.
    for (kind, key) in [(b'x', "size"), (b'x', "linkpath"), (b'x', "GNU.sparse.name"), (b'g', "path")] {
        let bytes = tar_after(&[special("h", kind, &record(key, b"1")), taped("seq/bad", b"x")]);
        refused_member(Packing::TarGz, bytes, Caps::default(), b"h", &MemberFault::Header(key.into()));
    }
    let bytes = tar_after(&[special("h", b'L', &[b'x'; 70_000]), taped("seq/bad", b"x")]);
    refused_member(Packing::TarGz, bytes, Caps::default(), b"h", &MemberFault::Large(1 << 16));
    let long = special("h", b'L', b"seq/b");
    let bytes = tar_after(&[long.clone(), long.clone(), taped("seq/bad", b"x")]);
    refused_member(Packing::TarGz, bytes, Caps::default(), b"h", &MemberFault::Twice);
    assert!(matches!(
        refused(Packing::TarGz, tar_after(&[long]), Caps::default()),
        FetchError::NotAnArchive { .. }
    ));
}

#[test]
fn every_cut_archive_is_refused() {
    let zip = zip(&[zipped("seq/a", b"some bytes"), zipped("seq/b", b"")]);
    for n in 0..zip.len() {
        refused(Packing::Zip, zip[..n].to_vec(), Caps::default());
    }
    let tar = tar_gz(&[taped("seq/a", b"some bytes"), taped("seq/b", b"")]);
    for n in 0..tar.len() {
        refused(Packing::TarGz, tar[..n].to_vec(), Caps::default());
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
        let tapes: Vec<_> = names.iter().map(|n| taped(n, b"x")).collect();
        for (packing, bytes) in [(Packing::Zip, zip(&zips)), (Packing::TarGz, tar_gz(&tapes))] {
            let outer = tempfile::tempdir().unwrap();
            match fetched(outer.path(), packing, bytes, Caps::default()) {
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
    }

    /// Bytes changed anywhere: an error, or what was packed, but never a crash.
    #[test]
    fn damaged_bytes_never_crash(at in any::<prop::sample::Index>(), value in any::<u8>(), tar in any::<bool>()) {
        let packing = if tar { Packing::TarGz } else { Packing::Zip };
        let mut bytes = if tar {
            tar_gz(&[taped("seq/a", b"some bytes"), special("seq/d/", b'5', b"")])
        } else {
            zip(&[zipped("seq/a", b"some bytes"), zipped("seq/b", b"")])
        };
        let at = at.index(bytes.len());
        bytes[at] = value;
        let outer = tempfile::tempdir().unwrap();
        match fetched(outer.path(), packing, bytes, Caps::default()) {
            Err(_) => untouched(outer.path()),
            Ok(()) => prop_assert!(outer.path().join("root/otb/seq").is_dir()),
        }
    }
}
