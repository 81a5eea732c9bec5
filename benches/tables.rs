//! From a full store to tables, and what the engine costs by itself.
//!
//! The tables are Table 2 of Khalid et al. (2016) where there are real data (`TRACKFAIL_DATA`, or `../shared/data` beside
//! the checkout), and the quickstart otherwise. Every cell is in the store before the clock starts. The engine plans
//! 100,000 cells, writes records and reads them.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::path::{Path, PathBuf};
use trackfail::engine::Stop;
use trackfail::engine::store::address::{Recipe, Stage};
use trackfail::engine::store::{self, Name, Store};
use trackfail::engine::{ExperimentPlan, Options, run};
use trackfail::report;
use trackfail::results::{self, Detail, Results, RunRecord};
use trackfail::spec::{self, Experiment, builtin};
use trackfail_benches::many_cells;

fn plan<'a>(experiment: &'a Experiment, roots: &[PathBuf]) -> ExperimentPlan<'a> {
    ExperimentPlan::new(experiment, run::load(experiment, roots).expect("suites"), roots, &Stop::default())
        .expect("a plan")
}

fn tables(c: &mut Criterion) {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let named = std::env::var_os("TRACKFAIL_DATA");
    let roots = named.map_or_else(|| vec![beside], |named| std::env::split_paths(&named).collect());
    let roots: Vec<PathBuf> = roots.into_iter().filter(|root: &PathBuf| root.is_dir()).collect();
    let name = if !roots.is_empty() { "khalid2016/table2" } else { "quickstart" };
    let text = builtin::EXPERIMENTS.iter().find(|e| e.0 == name).expect("a built-in experiment").1;
    let experiment = spec::parse(name, text).expect("a valid experiment");
    let options = Options { data_roots: roots.clone(), ..Options::default() };
    let results = tempfile::tempdir().expect("a folder");
    let store = Store::open(results.path()).expect("a store");
    let laid_out = plan(&experiment, &roots);
    let outcome = run::run(&laid_out, &store, &options).expect("cells");

    let mut group = c.benchmark_group(name.replace('/', "-"));
    group.sample_size(10);
    group.bench_function("plan", |b| b.iter(|| plan(&experiment, &roots).states(&store).len()));
    group.bench_function("run-from-store", |b| {
        b.iter(|| run::run(black_box(&laid_out), &store, &options).expect("cells"));
    });
    let dir = tempfile::tempdir().expect("a folder");
    group.bench_function("write-results", |b| {
        b.iter(|| {
            let (outcome, record) = (black_box(&outcome), RunRecord::here(None, 0.0));
            results::write(dir.path(), &experiment, outcome, &record, Detail::Frames).expect("written")
        });
    });
    group.bench_function("render-from-results", |b| {
        b.iter(|| {
            let results = Results::read(dir.path()).expect("results");
            report::write(&results, &dir.path().join("report")).expect("a report")
        });
    });
}

fn engine(c: &mut Criterion) {
    // 20 sequences x 50 runs x 100 thresholds.
    let experiment = many_cells(50);
    let results = tempfile::tempdir().expect("a folder");
    let store = Store::open(results.path()).expect("a store");
    let mut group = c.benchmark_group("engine");
    group.sample_size(10);
    group.bench_function("plan-100000-cells", |b| {
        b.iter(|| {
            assert_eq!(plan(&experiment, &[]).states(&store).len(), 100_000);
        });
    });

    // The verdicts of one sequence: 110 records of 400 frames in one pack.
    let series: Vec<f64> = (0..400).map(f64::from).collect();
    let mut round = 0;
    let mut records = || {
        round += 1;
        let record = |k: usize| {
            let name = Name { experiment: "many".into(), cell: format!("synthetic-otb/Girl/ncc/0/{k}") };
            let recipe = Recipe::new(Stage::Labels).with("round", round).with("cell", k);
            store::record(name, recipe, series.len(), &series).expect("a record")
        };
        (0..110).map(record).collect::<Vec<_>>()
    };
    group.bench_function("put-110-cells", |b| {
        b.iter_batched(&mut records, |r| store.put(&r).expect("kept"), criterion::BatchSize::PerIteration);
    });
    let kept = records();
    store.put(&kept).expect("kept");
    let addresses: Vec<_> = kept.iter().map(|r| r.head.recipe.address()).collect();
    group.bench_function("get-110-cells", |b| {
        b.iter(|| {
            let get = |a| store.get::<Vec<f64>>(a, 400).expect("there").len();
            addresses.iter().map(get).sum::<usize>()
        });
    });
}

criterion_group!(benches, tables, engine);
criterion_main!(benches);
