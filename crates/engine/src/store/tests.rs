//! The store with truncated packs, changed bytes, limits and killed processes.

use super::*;
use trackfail_core::region::{Rect, Region};
use trackfail_methods::tracker::{Moments, Status, TrackerState};

fn name(cell: &str) -> Name {
    Name { experiment: "e".into(), cell: cell.into() }
}

fn recipe(stage: Stage, n: u32) -> Recipe {
    Recipe::new(stage).with("n", n)
}

fn states() -> Vec<TrackerState> {
    let corners = vec![(0.5, 0.25), (9.0, 1.0), (4.0, 8.0)];
    let moments = Moments {
        mean: vec![1.0, -0.0],
        covariance: vec![1.0; 4],
        effective_samples: 3.5,
        samples: 9.0,
        entropy: 0.75,
        likelihood: 1e-300,
        particles: vec![0.5, -2.0, 1.0],
    };
    let skipped = TrackerState::new(Region::Polygon(corners), Status::Skipped);
    let started = TrackerState::initialized(Region::Rect(Rect::new(1.0, 2.0, 3.0, 4.0)));
    vec![started, TrackerState { posterior: Some(moments), ..skipped }]
}

/// A record of each kind of content.
fn records() -> Vec<Record> {
    vec![
        record(name("a/track"), recipe(Stage::Track, 1), 2, &states()).unwrap(),
        record(name("a/signal"), recipe(Stage::Signal, 1), 2, &vec![0.1, f64::MIN_POSITIVE]).unwrap(),
        record(name("a/model"), recipe(Stage::Model, 1), 1, &(3_u64, Some(0.5))).unwrap(),
        record(name("a/labels"), recipe(Stage::Labels, 1), 2, &(vec![true, false], None::<f64>)).unwrap(),
    ]
}

/// True if the store has a content of this stage, and it is what was put; `None` if it has none.
fn holds<T: DeserializeOwned + PartialEq>(store: &Store, stage: Stage, rows: usize, put: &T) -> Option<bool> {
    let got: Option<T> = store.get(&recipe(stage, 1).address(), rows);
    got.as_ref().map(|got| got == put)
}

/// For each content of [`records`], true if the store returns it. A content that differs fails the test.
fn found(store: &Store, what: &str) -> [bool; 4] {
    let found = [
        holds(store, Stage::Track, 2, &states()),
        holds(store, Stage::Signal, 2, &vec![0.1, f64::MIN_POSITIVE]),
        holds(store, Stage::Model, 1, &(3_u64, Some(0.5))),
        holds(store, Stage::Labels, 2, &(vec![true, false], None::<f64>)),
    ];
    assert!(!found.contains(&Some(false)), "{what}: another one: {found:?}");
    found.map(|found| found.is_some())
}

fn store_of(records: &[Record]) -> (tempfile::TempDir, Store) {
    let dir = tempfile::tempdir().unwrap();
    let store = Store::open(dir.path()).unwrap();
    store.put(records).unwrap();
    (dir, store)
}

fn only_pack(dir: &Path) -> PathBuf {
    let packs = packs(&dir.join(".store/packs")).unwrap();
    assert_eq!(packs.len(), 1);
    packs[0].1.clone()
}

#[test]
fn records_are_read_back_now_and_after_opening_again() {
    let (dir, store) = store_of(&records());
    let check = |store: &Store| {
        assert_eq!(found(store, ""), [true; 4]);
        assert_eq!(store.get::<Vec<f64>>(&recipe(Stage::Signal, 2).address(), 2), None);
        assert_eq!((store.len(), store.problems()), (4, vec![]));
        assert!(store.knows(Stage::Labels, "a/labels") && !store.knows(Stage::Track, "a/labels"));
        assert_eq!(store.heads(Stage::Model, "a/model")[0].recipe, recipe(Stage::Model, 1));
    };
    check(&store);
    check(&Store::open(dir.path()).unwrap());
    check(&Store::open_read_only(dir.path()).unwrap());
    assert!(Store::open_read_only(&dir.path().join("nothing")).unwrap().is_empty());
}

#[test]
fn another_number_of_rows_is_damage() {
    let (_dir, store) = store_of(&records());
    assert_eq!(store.get::<Vec<f64>>(&recipe(Stage::Signal, 1).address(), 3), None);
    assert!(store.problems()[0].contains("a record of 2 rows is not one of 3"));
}

#[test]
fn every_cut_and_every_changed_byte_of_a_pack_is_detected() {
    let (dir, store) = store_of(&records());
    drop(store);
    let pack = only_pack(dir.path());
    let bytes = std::fs::read(&pack).unwrap();
    let with = |bytes: &[u8]| {
        std::fs::write(&pack, bytes).unwrap();
        Store::open_read_only(dir.path()).unwrap()
    };
    for at in 0..bytes.len() {
        let store = with(&bytes[..at]);
        assert!(store.is_empty(), "cut to {at} bytes");
        assert!(store.problems()[0].contains("are computed again"), "cut to {at} bytes");
        let mut changed = bytes.clone();
        changed[at] ^= 0x10;
        let store = with(&changed);
        let found = found(&store, &format!("byte {at}"));
        assert!(found.contains(&false) && !store.problems().is_empty(), "byte {at} is not covered");
    }
    assert!(with(&[bytes.clone(), vec![0]].concat()).is_empty(), "one byte more");
    assert_eq!(with(&bytes).len(), 4);
}

#[test]
fn merging_adds_new_records_and_refuses_contradicting_ones() {
    let (_a, mine) = store_of(&records()[..2]);
    let (_b, theirs) = store_of(&records());
    assert_eq!(mine.merge(&theirs).unwrap(), Merged { added: 2, known: 2 });
    assert_eq!(mine.merge(&theirs).unwrap(), Merged { added: 0, known: 4 });
    let other = record(name("a/model"), recipe(Stage::Model, 1), 1, &(4_u64, Some(0.5))).unwrap();
    let (_c, contrary) = store_of(&[other]);
    assert!(mine.merge(&contrary).unwrap_err().to_string().contains("the model of a/model is not what"));
}

#[test]
fn eviction_removes_the_least_recently_used_packs_but_none_in_use() {
    let dir = tempfile::tempdir().unwrap();
    for n in 0..3 {
        let signal = record(name("x"), recipe(Stage::Signal, n), 2, &vec![f64::from(n); 2]).unwrap();
        Store::open(dir.path()).unwrap().put(&[signal]).unwrap();
    }
    // Whatever the order of writing: the third is the oldest, the first the newest.
    let age = |n: u32, seconds: u64| {
        let store = Store::open_read_only(dir.path()).unwrap();
        let pack = store.index().places[&recipe(Stage::Signal, n).address()].0;
        let path = store.index().packs[pack].0.clone();
        let time = SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(seconds);
        File::options().append(true).open(&path).unwrap().set_modified(time).unwrap();
        path.metadata().unwrap().len()
    };
    let sizes = [age(0, 30), age(1, 20), age(2, 10)];
    let size = || packs(&dir.path().join(".store/packs")).unwrap().iter().map(|(.., size)| size).sum::<u64>();
    let store = Store::open(dir.path()).unwrap();
    let other = Store::open(dir.path()).unwrap();
    assert_eq!(store.evict(0), 0, "another run uses the store");
    assert_eq!((other.evict(sizes[0] + sizes[1]), size()), (1, sizes[0] + sizes[1]));
    let store = Store::open(dir.path()).unwrap();
    assert!(!store.contains(&recipe(Stage::Signal, 2).address()));
    assert!(store.get::<Vec<f64>>(&recipe(Stage::Signal, 1).address(), 2).is_some());
    assert_eq!((store.evict(0), size()), (1, sizes[1]), "used packs stay");
}

#[test]
fn of_two_records_under_one_address_the_new_one_counts() {
    let model = |n: u64| record(name("a/model"), recipe(Stage::Model, 1), 1, &(n, Some(0.5))).unwrap();
    let get =
        |store: &Store| store.get::<(u64, Option<f64>)>(&recipe(Stage::Model, 1).address(), 1).unwrap().0;
    let (dir, store) = store_of(&records());
    for n in 4..12 {
        store.put(&[model(n)]).unwrap();
        assert_eq!((get(&store), store.len(), store.problems()), (n, 4, vec![]));
    }
    // The packs of all of them are marked as used.
    store.evict(u64::MAX);
    for _ in 0..2 {
        let store = Store::open(dir.path()).unwrap();
        assert!(store.head(&recipe(Stage::Track, 1).address()).is_some());
        assert_eq!((get(&store), store.len()), (11, 4));
        store.evict(u64::MAX);
    }
    // Also if another record of the first pack is all that is read.
    let store = Store::open(dir.path()).unwrap();
    assert!(store.head(&recipe(Stage::Track, 1).address()).is_some());
    store.evict(u64::MAX);
    assert_eq!(get(&Store::open(dir.path()).unwrap()), 11);
}

#[test]
fn unreadable_packs_are_reported_and_left_in_place() {
    let (dir, store) = store_of(&records());
    drop(store);
    let folder = dir.path().join(".store/packs/folder.pack");
    std::fs::create_dir(&folder).unwrap();
    let store = Store::open(dir.path()).unwrap();
    assert_eq!((store.len(), store.problems().len()), (4, 1));
    assert!(folder.exists());
    // A store that is open for reading only removes nothing.
    std::fs::remove_dir(&folder).unwrap();
    std::fs::write(only_pack(dir.path()), "short").unwrap();
    assert!(Store::open_read_only(dir.path()).unwrap().is_empty());
    assert!(only_pack(dir.path()).exists());
}

#[test]
fn remains_of_a_killed_run_are_swept_and_folders_in_use_are_not() {
    let dir = tempfile::tempdir().unwrap();
    let store = Store::open(dir.path()).unwrap();
    let used = store.staging().unwrap();
    let left = dir.path().join(".store/staging").join(format!("{TEMPORARY}left"));
    std::fs::create_dir_all(left.join("tables")).unwrap();
    File::create(left.join(trackfail_dataset::leftover::LOCK)).unwrap();
    let half = dir.path().join(".store/packs").join(format!("{TEMPORARY}half"));
    std::fs::write(&half, "half").unwrap();
    drop(Store::open(dir.path()).unwrap());
    assert!(used.path().is_dir() && half.exists() && !left.exists(), "the first still uses the store");
    drop(store);
    drop(Store::open(dir.path()).unwrap());
    assert!(used.path().is_dir() && !half.exists());
}
