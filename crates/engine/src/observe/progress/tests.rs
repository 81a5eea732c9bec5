//! Progress of runs that finish, stop, and meet foreign files.

use super::*;
use crate::spec::{self, builtin};

fn experiment() -> Experiment {
    let text = builtin::EXPERIMENTS.iter().find(|e| e.0 == builtin::QUICKSTART).unwrap().1;
    spec::parse("quickstart", text).unwrap()
}

fn left(results: &Path) -> usize {
    folders(&results.join(FOLDER).join(RUNNING)).len()
}

#[test]
fn a_run_is_shown_while_it_lives_and_removed_when_it_finishes() {
    let dir = tempfile::tempdir().unwrap();
    let (experiment, watch) = (experiment(), Arc::new(ProgressWatch::default()));
    assert_eq!(running(dir.path()), []);
    watch.stage("judging");
    watch.frames(7, 9);
    watch.frames(3, 9);
    watch.all_cells(5);
    watch.cells(2);
    let girl = watch.enter("Girl");
    drop(watch.enter("Bolt"));
    let publisher = publish(dir.path(), &experiment, None, &watch).unwrap();
    let shard = publish(dir.path(), &experiment, "2/3".parse().ok(), &watch).unwrap();
    let [all, share] = &running(dir.path())[..] else { panic!() };
    assert!(all.alive && share.alive);
    assert_eq!((all.snapshot.shard.as_str(), share.snapshot.shard.as_str()), ("", "2/3"));
    assert_eq!((all.snapshot.frames, all.snapshot.cells), ([7, 9], [2, 5]));
    assert_eq!((all.snapshot.stage.as_str(), &all.snapshot.now[..]), ("judging", &["Girl".to_string()][..]));
    drop(girl);
    // A last snapshot is written even if the next one was not due.
    drop(publisher);
    let stopped = running(dir.path());
    assert_eq!(stopped.iter().map(|r| r.alive).collect::<Vec<_>>(), [true, false]);
    assert!(stopped[1].snapshot.now.is_empty());
    shard.finish();
    assert_eq!(left(dir.path()), 1);
    // The next run of the same replaces what stopped.
    publish(dir.path(), &experiment, None, &watch).unwrap().finish();
    assert_eq!((running(dir.path()), left(dir.path())), (vec![], 0));
}

#[test]
fn a_stopped_shard_stays_until_it_or_the_whole_experiment_runs_again() {
    let dir = tempfile::tempdir().unwrap();
    let (experiment, watch) = (experiment(), Arc::new(ProgressWatch::default()));
    let run = |shard: &str| publish(dir.path(), &experiment, shard.parse().ok(), &watch).unwrap();
    drop(run("10/10"));
    drop(run("2/10"));
    run("1/10").finish();
    let shards: Vec<_> = running(dir.path()).into_iter().map(|r| r.snapshot.shard).collect();
    assert_eq!(shards, ["2/10", "10/10"]);
    run("2/10").finish();
    assert_eq!(left(dir.path()), 1);
    run("").finish();
    assert_eq!(left(dir.path()), 0);
}

#[test]
fn foreign_files_are_ignored_and_removed_by_the_next_run() {
    let dir = tempfile::tempdir().unwrap();
    let parent = dir.path().join(FOLDER).join(RUNNING);
    let broken = ["", "{", "[]", "{\"format\": 2}", "null"];
    for (k, text) in broken.iter().enumerate() {
        let folder = parent.join(format!("run-{k}"));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join(PROGRESS), text).unwrap();
    }
    let huge = parent.join("run-huge");
    std::fs::create_dir_all(&huge).unwrap();
    File::create(huge.join(PROGRESS)).unwrap().set_len(MAX_FILE + 1).unwrap();
    assert_eq!((running(dir.path()), left(dir.path())), (vec![], broken.len() + 1));
    let experiment = experiment();
    publish(dir.path(), &experiment, None, &Arc::default()).unwrap().finish();
    assert_eq!(left(dir.path()), 0);
    // Where nothing can be written, nothing is published and nothing fails.
    let file = dir.path().join("file");
    std::fs::write(&file, "").unwrap();
    assert!(publish(&file, &experiment, None, &Arc::default()).is_none());
    assert_eq!(running(&file), []);
}
