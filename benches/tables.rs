//! From signals to tables: table2 of Khalid et al. 2016 where real data is there (`TRACKFAIL_DATA`, or
//! `../shared/data` beside the checkout), the quickstart otherwise. Tracking and signals are done once,
//! before the clock starts.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::path::{Path, PathBuf};
use trackfail::engine::{Options, run};
use trackfail::report::{self, results::Results};
use trackfail::spec::{self, builtin};
use trackfail::table::folder;

fn tables(c: &mut Criterion) {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let root = std::env::var_os("TRACKFAIL_DATA").map_or(beside, PathBuf::from);
    let root = root.is_dir().then_some(root);
    let name = if root.is_some() { "khalid2016/table2" } else { "quickstart" };
    let text = builtin::EXPERIMENTS.iter().find(|e| e.0 == name).expect("a built-in experiment").1;
    let experiment = spec::parse(name, text).expect("a valid experiment");
    let load = || run::load(&experiment, root.as_deref()).expect("suites");
    let options = Options { data_root: root.clone(), jobs: None, progress: &|_, _| {} };
    let tracked = run::track(&experiment, &load(), &options).expect("tracks");

    let mut group = c.benchmark_group(name.replace('/', "-"));
    group.sample_size(10);
    group.bench_function("judge-from-signals", |b| {
        b.iter_batched(
            || (load(), tracked.clone()),
            |(suites, tracked)| run::judge_all(&experiment, suites, black_box(tracked)).expect("cells"),
            criterion::BatchSize::PerIteration,
        );
    });
    let outcome = run::judge_all(&experiment, load(), tracked).expect("cells");
    let dir = tempfile::tempdir().expect("a folder");
    group.bench_function("write-results", |b| {
        b.iter(|| folder::write(dir.path(), &experiment, black_box(&outcome), 0.0).expect("written"));
    });
    group.bench_function("render-from-results", |b| {
        b.iter(|| {
            let results = Results::read(dir.path()).expect("results");
            report::write(&results, &dir.path().join("report")).expect("a report")
        });
    });
    group.finish();
}

criterion_group!(benches, tables);
criterion_main!(benches);
