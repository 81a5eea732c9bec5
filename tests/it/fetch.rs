//! Files that a fetch leaves on disk, and the messages of the program; `download.rs` has the network, `archives.rs` the archives.

use crate::download::fails;
use crate::packed::{zip, zipped};
use crate::tools::{Place, assert_says, files};
use sha2::{Digest, Sha256};
use std::path::Path;
use std::time::Duration;
use trackfail::dataset::archive::{Archive, Packing};
use trackfail::dataset::fetch::{
    Caps, FetchError, FetchJob, FetchOptions, Fetched, MARKER, Patience, Workspace, fetch,
};
use trackfail::dataset::lock;
use trackfail::dataset::suite::Catalog;
use trackfail_testing::put;
use trackfail_testing::server::{Server, full};

/// Pauses that cost no time; nothing here waits for a timeout unless a test makes one short.
pub fn options() -> FetchOptions {
    let (pause, longest) = (Duration::from_millis(1), Duration::from_millis(20));
    let patience = Patience { stall: Duration::from_secs(60), attempts: 4, pause, longest, limit: 1 << 20 };
    FetchOptions { mirror: None, patience, caps: Caps::default() }
}

/// Fetches `/a.zip` of a server.
pub fn job_of(server: &Server) -> FetchJob {
    job(&server.archive(), Packing::Zip)
}

pub fn job(url: &str, packing: Packing) -> FetchJob {
    let [name, url, into] = ["try", url, "otb"].map(String::from);
    let archive = Archive { name, url, packing, into, ..Archive::default() };
    FetchJob { archive, folders: vec!["otb/seq".into()], ..FetchJob::default() }
}

/// Fetches into a new workspace in `root`.
pub fn run(root: &Path, job: &FetchJob, options: &FetchOptions) -> Result<Fetched, FetchError> {
    fetch(&Workspace::open(root)?, job, options, &|_| {})
}

pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}

/// An archive with one file that does not shrink.
pub fn sample() -> Vec<u8> {
    let noise: Vec<u8> = (0..5000_u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    zip(&[zipped("seq/groundtruth_rect.txt", b"1,2,3,4\n"), zipped("seq/img/0001.jpg", &noise)])
}

/// Fetches `/a.zip` of a server into a root where a part may lie, and checks what is there afterwards.
#[track_caller]
pub fn arrives(root: &Path, server: &Server) -> Fetched {
    let fetched = run(root, &job_of(server), &options()).unwrap();
    assert_eq!(fetched.sha256, sha256(&sample()));
    assert_eq!(fetched.placed.new, ["otb/seq"]);
    whole(root);
    fetched
}

#[track_caller]
pub fn whole(root: &Path) {
    let found = files(root);
    let names: Vec<_> = found.keys().map(|p| p.to_str().unwrap()).collect();
    let marker = format!("otb/seq/{MARKER}");
    assert_eq!(names, [".trackfail/lock", &marker, "otb/seq/groundtruth_rect.txt", "otb/seq/img/0001.jpg"]);
    assert_eq!(found[Path::new("otb/seq/groundtruth_rect.txt")], b"1,2,3,4\n");
    assert_eq!(found[Path::new("otb/seq/img/0001.jpg")].len(), 5000);
}

/// Nothing under the data root but the working folder, and in it nothing of a download.
#[track_caller]
pub fn nothing_left(root: &Path) {
    assert_eq!(files(root).keys().collect::<Vec<_>>(), [Path::new(".trackfail/lock")]);
}

#[test]
fn a_good_archive_is_placed_and_tells_its_digest() {
    let root = tempfile::tempdir().unwrap();
    let server = Server::file(sample(), "\"1\"");
    assert_eq!(arrives(root.path(), &server).size, sample().len() as u64);
    let marker = std::fs::read_to_string(root.path().join("otb/seq").join(MARKER)).unwrap();
    assert!(marker.contains(&sha256(&sample())), "{marker}");
    let request = &server.asked()[0];
    assert_eq!((server.asked().len(), request.path.as_str()), (1, "/a.zip"));
    assert_eq!(request.headers["accept-encoding"], "identity");
    assert!(request.headers["user-agent"].starts_with("trackfail/"));
}

#[test]
fn modes_are_the_usual_ones_whatever_the_archive_says() {
    use std::os::unix::fs::PermissionsExt;
    let root = tempfile::tempdir().unwrap();
    let mut members = [zipped("seq/", b""), zipped("seq/a", b"x"), zipped("seq/img/b", b"y")];
    [0o040_000, 0o104_777, 0o100_000].iter().zip(&mut members).for_each(|(mode, m)| m.mode = *mode);
    run(root.path(), &job_of(&Server::file(zip(&members), "\"1\"")), &options()).unwrap();
    let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode() & 0o7777;
    let (folder, file) = (root.path().join("folder"), root.path().join("file"));
    std::fs::create_dir(&folder).unwrap();
    std::fs::write(&file, "").unwrap();
    for (name, like) in [("", &folder), ("a", &file), ("img", &folder), ("img/b", &file), (MARKER, &file)] {
        assert_eq!(mode(&root.path().join("otb/seq").join(name)), mode(like), "{name}");
    }
}

#[test]
fn a_file_that_is_no_archive_is_kept_as_it_is() {
    let root = tempfile::tempdir().unwrap();
    let server = Server::file(b"<xml/>".to_vec(), "\"1\"");
    let mut job = job(&format!("{}/data/truth.xml?v=1", server.url), Packing::File);
    job.folders.clear();
    assert_eq!(run(root.path(), &job, &options()).unwrap().placed.new, ["otb/truth.xml"]);
    assert_eq!(std::fs::read(root.path().join("otb/truth.xml")).unwrap(), b"<xml/>");
    put(root.path(), "otb/truth.xml", "mine");
    assert_eq!(run(root.path(), &job, &options()).unwrap().placed.kept, ["otb/truth.xml"]);
    assert_eq!(std::fs::read(root.path().join("otb/truth.xml")).unwrap(), b"mine");
    job.archive.url = format!("{}/..", server.url);
    assert!(matches!(run(root.path(), &job, &options()), Err(FetchError::Data(_))));
    let server = Server::file(b"\n<!DOCTYPE html><title>gone</title>".to_vec(), "\"1\"");
    for name in ["clip.mpg", "clip.xml"] {
        job.archive.url = format!("{}/data/{name}", server.url);
        let told = format!("a web page and not otb/{name}");
        assert_says(run(root.path(), &job, &options()).unwrap_err(), told);
        assert!(!root.path().join("otb").join(name).exists());
    }
}

#[test]
fn what_the_user_put_there_stays_and_what_a_kill_left_goes() {
    let root = tempfile::tempdir().unwrap();
    let mine = root.path().join("otb/seq");
    std::fs::create_dir_all(&mine).unwrap();
    put(root.path(), ".trackfail/unpack-abc/otb/seq/0001.jpg", "half");
    let server = Server::file(sample(), "\"1\"");
    let fetched = run(root.path(), &job_of(&server), &options()).unwrap();
    assert_eq!((fetched.placed.kept, fetched.placed.new.len()), (vec!["otb/seq".into()], 0));
    nothing_left(root.path());
    std::fs::remove_dir(&mine).unwrap();
    arrives(root.path(), &server);
}

// Before: the user's notes were deleted without a word.
#[test]
fn a_folder_that_is_replaced_is_kept_where_it_has_files_of_its_own() {
    let root = tempfile::tempdir().unwrap();
    let server = Server::file(sample(), "\"1\"");
    arrives(root.path(), &server);
    let job = FetchJob { again: vec!["otb/seq".into()], ..job_of(&server) };
    put(root.path(), "otb/seq/groundtruth_rect.txt", "damaged");
    let again = || run(root.path(), &job, &options()).unwrap().placed;
    let placed = again();
    assert_eq!((placed.replaced, placed.moved), (vec!["otb/seq".to_string()], Vec::new()));
    whole(root.path());
    for (n, notes) in [(1, "img/notes.txt"), (2, "mine/deep.txt")] {
        let mine = put(root.path(), format!("otb/seq/{notes}"), "mine");
        let aside = root.path().join(format!("otb/seq.replaced-{n}"));
        assert_eq!(again().moved, [("otb/seq".to_string(), aside.clone())]);
        assert_eq!(std::fs::read(aside.join(notes)).unwrap(), b"mine");
        assert!(!mine.exists());
    }
    assert_eq!(std::fs::read(root.path().join("otb/seq/groundtruth_rect.txt")).unwrap(), b"1,2,3,4\n");
}

#[test]
fn one_fetch_at_a_time() {
    let root = tempfile::tempdir().unwrap();
    let first = Workspace::open(root.path()).unwrap();
    let error = Workspace::open(root.path()).unwrap_err();
    assert!(matches!(error, FetchError::Busy(_)) && !error.is_data());
    drop(first);
    Workspace::open(root.path()).unwrap();
}

#[test]
fn an_archive_without_the_folder_names_what_it_begins_with() {
    let server = Server::file(zip(&[zipped("SEQ/a", b""), zipped("readme", b"")]), "\"1\"");
    let (error, root) = fails(&server, |_, _| {});
    assert_says(error.to_string(), "no folder otb/seq, and begins with `SEQ/a`");
    nothing_left(root.path());
}

/// The first sequence of the list that can, or cannot, be downloaded.
fn listed(downloads: bool) -> Option<(String, lock::Entry)> {
    Catalog::default().suites().find_map(|suite| {
        let entry = suite.entries().iter().find(|entry| entry.archives().next().is_some() == downloads)?;
        Some((format!("{}/{}", suite.name(), entry.name), entry.clone()))
    })
}

#[test]
fn the_program_asks_for_consent_and_tells_what_is_not_there() {
    let place = Place::new();
    let (name, _) = listed(true).expect("a sequence with an address");
    let server = Server::always(full("404 Not Found", &[], b""));
    let fetch =
        |more: &str| place.run(&format!("data fetch '{name}' --mirror {} --data-root . {more}", server.url));
    fetch("").ends(2).tells("licence: ").tells("--accept-licence");
    assert!(server.asked().is_empty());
    fetch("--accept-licence").ends(3).tells("licence: ").tells("404");
    // It is remembered.
    assert!(!fetch("").ends(3).err.contains("licence: "));
}

#[test]
fn wrong_names_and_missing_addresses_are_told() {
    let place = Place::new();
    for (arguments, words) in [
        ("vot2014", "--data-root"),
        ("vot2015x --data-root .", "vot201"),
        ("vot2014/bal --data-root .", "did you mean `ball`"),
        ("vot2014/ --data-root .", "sequence"),
    ] {
        place.run(&format!("data fetch {arguments}")).ends(2).tells(words);
    }
    assert_eq!(place.run("data fetch synthetic-otb --data-root .").ends(0).all(), "");
    let (name, entry) = listed(false).expect("a sequence without an address");
    let ran = place.run(&format!("data fetch '{name}' --data-root .")).ends(3).tells(&name);
    ran.says(&format!("{name}  by hand: ")).says(&entry.folder);
}
