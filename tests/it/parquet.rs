//! Parquet files as other programs read them: the rows of `signals.parquet` of methods with a grid, and filters on texts in
//! pyarrow and DuckDB.

use crate::tools::{Place, Ran, experiment, needs, suite};
use polars::prelude::{DataFrame, ParquetReader, SerReader};
use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

const FRAMES: usize = 60;

const SPEC: &str = r#"tracker = [{ name = "replay", results = "T", label = "T" }, { name = "color-particle-filter", label = "PF" }]
table = [{ name = "t", rows = ["detections"], columns = "method", methods = ["plain"] }]
method = [
    { name = "followed", trackers = ["PF"], signal = { kind = "uncertainty", components = [0, 1] }, detector.kind = "arte", protocol = "sanmiguel2015-segmentation/1", grid = { tau_1 = [1.0, 2.0] } },
]

[[method-group]]
trackers = ["T"]
methods = [
    { name = "plain", signal.kind = "box-motion", detector = { kind = "level", above = 5.0 } },
    { name = "levels", signal.kind = "box-motion", detector = { kind = "level", above = 5.0 }, grid = { above = [1.0, 5.0, 9.0] } },
    { name = "bins", signal.kind = "rgb-histogram", detector = { kind = "level", below = 0.9 }, grid = { bins = [4, 8] } },
    { name = "forecasts", signal.kind = "box-motion", detector = { kind = "naive-forecast", window = 20, threshold = 5.0 }, grid = { horizon = [1, 5] } },
]
"#;

/// A place with the results of the experiment in `r/mine/parquet`.
fn results() -> Place {
    let lock = suite("my-boxes", "otb", &[("Walk", "frames/Walk")]);
    let spec = experiment("mine/parquet", "my-boxes", SPEC);
    let place = Place::with(&[("datasets.lock", &lock), ("spec.toml", &spec)]);
    let boxes =
        |of: fn(usize) -> usize| -> String { (0..FRAMES).map(|t| format!("{},1,9,9\n", of(t))).collect() };
    place.write("frames/Walk/groundtruth_rect.txt", boxes(|t| t + 1));
    place.frames("frames/Walk/img/0000.png", FRAMES as u32, (120, 12), |t, x, y| {
        if (t..t + 9).contains(&x) && y < 9 { [250, 80, 10] } else { [x as u8, y as u8, 99] }
    });
    place.write("results/T/Walk.txt", boxes(|t| t + 1 + if t < 40 { 0 } else { 30 }));
    place.run("run spec.toml --results r --data-root .").ends(0);
    place
}

fn table(path: &Path) -> DataFrame {
    ParquetReader::new(Cursor::new(std::fs::read(path).unwrap())).finish().unwrap()
}

/// Method and grid point, empty for none -> rows.
fn rows_of_points(table: &DataFrame) -> BTreeMap<String, usize> {
    let texts = |name: &str| table.column(name).unwrap().str().unwrap().clone();
    let (method, params) = (texts("method"), texts("params"));
    let mut rows = BTreeMap::new();
    for (method, params) in method.iter().zip(params.iter()) {
        *rows.entry(format!("{} {}", method.unwrap(), params.unwrap_or_default())).or_default() += 1;
    }
    rows
}

/// As many rows for each `method point` as there are frames.
fn all_frames(points: &[&str]) -> BTreeMap<String, usize> {
    points.iter().map(|point| (point.to_string(), FRAMES)).collect()
}

#[test]
fn every_method_has_its_signal_once_where_its_grid_shares_it() {
    let place = results();
    let conditions = table(&place.path("r/mine/parquet/conditions.parquet"));
    assert_eq!(rows_of_points(&conditions), all_frames(&["followed tau_1=1", "followed tau_1=2"]));
    let table = table(&place.path("r/mine/parquet/signals.parquet"));
    let shared = ["followed ", "levels ", "plain "];
    let apart = ["bins bins=4", "bins bins=8", "forecasts horizon=1", "forecasts horizon=5"];
    assert_eq!(rows_of_points(&table), all_frames(&[&shared[..], &apart].concat()));
    let method = table.column("method").unwrap().str().unwrap().clone();
    let forecasts = table.column("forecast").unwrap().f64().unwrap().clone();
    let foreseen = method.iter().zip(forecasts.iter()).filter_map(|(method, f)| f.and(method));
    let foreseen: Vec<&str> = foreseen.collect();
    assert!(foreseen.len() > FRAMES / 2 && foreseen.iter().all(|method| *method == "forecasts"));
}

/// Counts the rows of one method by the filters that people write, in both programs.
const FILTERS: &str = r#"
import duckdb, pyarrow.dataset, pyarrow.parquet, sys
for file, column, value in [arg.split("|") for arg in sys.argv[1:]]:
    read = pyarrow.parquet.read_table
    select = f'select count(*) from read_parquet(?) where "{column}"'
    found = {
        read(file, filters=[(column, "=", value)]).num_rows,
        read(file, filters=[(column, "in", [value])]).num_rows,
        pyarrow.dataset.dataset(file).to_table(filter=pyarrow.dataset.field(column) == value).num_rows,
        read(file).sort_by(column).column(column).to_pylist().count(value),
        duckdb.execute(select + " = ?", [file, value]).fetchone()[0],
        duckdb.execute(select + " like ?", [file, value]).fetchone()[0],
    }
    print(*found)
"#;

#[needs(pyarrow)]
#[test]
fn texts_are_filtered_in_pyarrow_and_duckdb() {
    let place = results();
    let mut command = assert_cmd::Command::new("python3");
    command.args(["-c", FILTERS]).current_dir(place.path("r/mine/parquet"));
    let asked = [
        ("frames.parquet|method|plain", FRAMES),
        ("signals.parquet|method|levels", FRAMES),
        ("signals.parquet|params|horizon=5", FRAMES),
        ("conditions.parquet|params|tau_1=2", FRAMES),
        ("truth.parquet|sequence|Walk", FRAMES),
        ("tables/t.parquet|column|plain", 1),
    ];
    let told = Ran::of(command.args(asked.map(|(what, _)| what))).all();
    assert_eq!(told.lines().collect::<Vec<_>>(), asked.map(|(_, rows)| rows.to_string()));
}
