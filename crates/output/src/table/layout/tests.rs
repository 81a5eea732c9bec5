use super::*;
use crate::testing::{self, items, parsed};
use trackfail_methods::score::Pooled;

#[test]
fn best_and_second_by_hand() {
    let marks = |values: &[f64], direction| {
        let mut cells: Vec<Cell> =
            values.iter().map(|v| Cell { ours: Some(format!("{v:.1}")), ..Cell::default() }).collect();
        // The last one is an anchor.
        mark_best(cells.iter_mut(), direction, |k, _| k + 1 < values.len());
        let mark = |c: &Cell| match (c.best, c.tied, c.second) {
            (true, true, false) => 't',
            (true, false, false) => 'b',
            (false, false, true) => 's',
            (false, false, false) => '.',
            _ => '?',
        };
        cells.iter().map(mark).collect::<String>()
    };
    assert_eq!(marks(&[0.1, 0.3, 0.2, 1.0], Direction::HigherIsBetter), ".bs.");
    assert_eq!(marks(&[0.1, 0.3, 0.2, 0.0], Direction::LowerIsBetter), "b.s.");
    assert_eq!(marks(&[0.3, 0.3, 0.2, 1.0], Direction::HigherIsBetter), "tt..");
    // They are printed alike.
    assert_eq!(marks(&[0.301, 0.299, 0.2, 1.0], Direction::HigherIsBetter), "tt..");
    assert_eq!(marks(&[0.3, 0.2, 0.2, 1.0], Direction::HigherIsBetter), "bss.");
    assert_eq!(marks(&[0.3, 1.0], Direction::HigherIsBetter), "..");
    assert_eq!(marks(&[0.3, 0.2, 1.0], Direction::Neither), "...");
}

/// Precision and F1 of two methods on two trackers. The paper prints precision without leading zeros.
fn experiment() -> Experiment {
    let head = "protocol = 'khalid2016/1'\nsuites = { test = 'synthetic-otb' }\n".to_string();
    let published = "table = 't'; tracker = 'A'; row = 'precision'; values = { DTEF = '.110' }";
    parsed(
        &(head
            + &items("tracker", &["name = 'ncc'; label = 'A'", "name = 'still'; label = 'B'"])
            + &items("method", &["name = 'DTEF'", "name = 'CovF'"])
            + &items("table", &["name = 't'; rows = ['precision', 'f_score']; columns = 'method'"])
            + &items("published", &[published])),
    )
}

fn measure(tracker: &str, method: &str, tp: u64) -> Measure {
    let counts = Counts { tp, fp: 10 - tp, fn_: 1, tn: 0 };
    Measure { pooled: Pooled { counts, ..Pooled::default() }, ..testing::measure(tracker, method, "") }
}

#[test]
fn a_table_has_one_style() {
    let experiment = experiment();
    let measures = [measure("A", "DTEF", 1), measure("A", "CovF", 2), measure("B", "DTEF", 3)];
    let layout = layout(&experiment, &experiment.tables[0], &measures, "");
    let ours: Vec<&str> = layout.cells().filter_map(|(.., cell)| cell.ours.as_deref()).collect();
    assert_eq!(ours, [".100", ".200", ".167", ".308", ".300", ".429"]);
    let differences = layout.cells().filter_map(|(.., cell)| cell.difference.as_deref());
    assert_eq!(differences.collect::<Vec<_>>(), ["-.010"]);
}

// Both groups have the heading "A, B, M".
#[test]
fn a_number_has_its_origin_whatever_its_group_is_called() {
    let mut experiment = experiment();
    let mut table = experiment.tables[0].clone();
    for (tracker, label) in experiment.trackers.iter_mut().zip(["A", "A, B"]) {
        tracker.label = label.to_string();
    }
    for (method, name) in experiment.methods.iter_mut().zip(["B, M", "M"]) {
        method.name = name.to_string();
    }
    table.methods = vec!["B, M".into(), "M".into()];
    table.columns = Side::Axis("length".into());
    table.rows = Side::Metrics(vec![Metric::PRECISION]);
    let with_axis =
        |tracker, method, tp| Measure { params: "length=5".into(), ..measure(tracker, method, tp) };
    let measures = [with_axis("A", "B, M", 1), with_axis("A, B", "M", 2)];
    let layout = layout(&experiment, &table, &measures, "");
    let same: Vec<&Group> = layout.groups.iter().filter(|g| g.key == "A, B, M").collect();
    assert_eq!(same.len(), 2);
    let origin = |g: &Group| g.rows[0].cells[0].of.clone().map(|of| (of.tracker, of.method, of.counts.tp));
    assert_eq!(origin(same[0]), Some(("A".into(), "B, M".into(), 1)));
    assert_eq!(origin(same[1]), Some(("A, B".into(), "M".into(), 2)));
    let all = origins(&experiment, &table, &measures);
    let places: Vec<_> = all.iter().map(|of| (of.row.as_str(), of.column.as_str())).collect();
    assert_eq!(places, [("precision", "5"); 2]);
}
