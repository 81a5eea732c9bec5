use super::tables::{diagram, intervals, pairs};
use super::*;
use crate::figure::Mark;
use crate::sampling::{counts_of_column, mean_of_sum, metric_of_sum};
use crate::table::layout::Row;
use crate::testing::{experiment, items};
use trackfail_methods::analysis::Grid;
use trackfail_methods::score::chance::Chance;

/// Competitor with true positives, false positives and misses by sequence.
fn competitor(label: &str, competes: bool, counts: &[[i64; 3]]) -> Standing {
    let of = |(k, c): (usize, &[i64; 3])| (format!("s{k:02}"), [c[0], c[1], c[2], 90]);
    let counts = counts.iter().enumerate().map(of).collect();
    Standing { label: label.into(), name: label.into(), competes, counts, ..Standing::default() }
}

fn competitors() -> Vec<Standing> {
    let (good, bad) = ([3, 1, 0], [1, 3, 2]);
    vec![
        competitor("never", false, &[[0, 0, 3]; 8]),
        competitor("good", true, &[good; 8]),
        competitor("mixed", true, &[good, bad, good, bad, good, bad, good, bad]),
        competitor("bad", true, &[bad; 8]),
        competitor("swept[a=1]", false, &[good; 8]),
    ]
}

/// Field of methods on a tracker by a metric.
fn field_of(tracker: &str, standings: Vec<Standing>, metric: Metric) -> Field {
    let of = |sum: &[i64; 4]| metric_of_sum(metric, Some(Chance::within(5)), sum);
    let names = (tracker.to_string(), tracker.to_string());
    field(names, standings, of, metric.direction(), &Sampling::with_seed(1))
}

fn by(metric: Metric, standings: Vec<Standing>) -> Standings {
    let fields = vec![field_of("NCC", standings, metric)];
    Standings { measured: Measured::metric(metric), fields }
}

fn values(row: &Row) -> Vec<Option<f64>> {
    row.cells.iter().map(|c| c.value).collect()
}

/// Rows and labels of a table with a single group.
fn rows(table: &TableLayout) -> (&[Row], Vec<&str>) {
    let rows = &table.groups[0].rows;
    (rows, rows.iter().map(|row| row.label.name.as_str()).collect())
}

// By hand: F is 6/7 for good, 2/7 for bad and 2 * 16 / (2 * 16 + 16 + 8) = 4/7 for both mixed. Equal sequences have no
// spread. Ranks are 1, 1.5 or 2.5, 3, so 1.25, 2 and 2.75.
#[test]
fn intervals_and_ranks_by_hand() {
    let of = by(Metric::F_SCORE, competitors());
    let table = intervals(&of);
    let (rows, labels) = rows(&table);
    assert_eq!(labels, ["never", "good", "mixed", "bad", "swept[a=1]"]);
    let f = |n: f64| Some(n / 7.0);
    for (k, f, rank) in [(0, f(0.0), None), (1, f(6.0), Some(1.25)), (3, f(2.0), Some(2.75))] {
        assert_eq!(values(&rows[k])[..5], [f, f, f, Some(8.0), rank]);
    }
    // SciPy's friedmanchisquare; a method that is not ranked has none.
    let p = rows.iter().map(|row| values(row)[5]);
    let is_p = |p: f64| (p - 0.002478752176666357).abs() < 1e-12;
    assert_eq!(p.map(|p| p.map(is_p)).collect::<Vec<_>>(), [None, Some(true), Some(true), Some(true), None]);
    assert_eq!(values(&rows[4])[4], None);
    let mixed = values(&rows[2]);
    assert_eq!((mixed[0], mixed[4]), (f(4.0), Some(2.0)));
    assert!(mixed[1] < f(4.0) && f(4.0) < mixed[2], "{mixed:?}");
    assert!(table.groups[0].label.starts_with("NCC (ranks over 8 sequences, Friedman's p 0."), "{table:?}");
    assert_eq!(of, by(Metric::F_SCORE, competitors()));
    // Those that compete, the best first, under their names in sentences.
    let mut more = competitors();
    more.push(Standing { name: "best".into(), ..competitor("best[a=1;b=2]", true, &[[3, 0, 0]; 8]) });
    let of = by(Metric::F_SCORE, more);
    let head = ranked(&of);
    let names: Vec<&str> = head.groups[0].rows.iter().map(|r| r.label.shown.as_str()).collect();
    assert_eq!(names, ["best (a 1, b 2)", "good", "mixed", "bad"]);
}

// By hand: good and bad differ in all 8 sequences, and only exchanging none or all reaches 4/7, so p = 2/256. Where
// mixed is good or bad they differ in 4, so p = 2/16. Holm: 3 * 2/256, then 2 * 2/16 for both.
#[test]
fn pairs_by_hand() {
    let table = pairs(&by(Metric::F_SCORE, competitors())).unwrap();
    let (rows, labels) = rows(&table);
    assert_eq!(labels, ["good against mixed", "good against bad", "mixed against bad"]);
    let (half, all) = ([0.125, 0.25, 8.0], [2.0 / 256.0, 6.0 / 256.0, 8.0]);
    for (row, expected) in rows.iter().zip([half, all, half]) {
        assert_eq!(values(row)[3..], expected.map(Some));
    }
    assert_eq!(rows[1].cells[0].ours.as_deref(), Some("+0.571"));
    let is_all = |v: Option<f64>| v.is_some_and(|v| (v - 4.0 / 7.0).abs() < 1e-12);
    assert!(is_all(rows[1].cells[1].value) && is_all(rows[1].cells[2].value), "equal sequences");
}

// Precision of the silent method has no value anywhere; those of the others are 3/4 and 1/4.
#[test]
fn missing_values_stay_empty() {
    let mut with_silent = competitors();
    with_silent.push(competitor("silent", true, &[[0, 0, 3]; 8]));
    let of = by(Metric::PRECISION, with_silent);
    assert!(of.fields[0].friedman.is_none());
    let table = pairs(&of).unwrap();
    let (rows, labels) = rows(&table);
    assert_eq!(labels[1..3], ["good against bad", "good against silent"]);
    assert_eq!(values(&rows[2]), [None, None, None, None, None, Some(8.0)]);
    assert_eq!((rows[1].cells[0].value, rows[1].cells[4].value), (Some(0.5), Some(6.0 / 256.0)), "three p");

    let few = vec![competitor("a", true, &[[1, 0, 0]; 2]), competitor("b", true, &[[1, 1, 0]; 2])];
    let few = by(Metric::F_SCORE, few);
    assert!(few.fields[0].friedman.is_none() && few.fields[0].pairs[0].p.is_none());
    let alone = by(Metric::F_SCORE, vec![competitor("a", true, &[[1, 0, 0]; 4])]);
    assert!(pairs(&alone).is_none() && diagram(&alone, "").is_none());
}

#[test]
fn the_diagram_shows_those_that_compete() {
    let (ranks, caption) =
        diagram(&by(Metric::F_SCORE, competitors()), "Suite s: 8 targets.").unwrap().unwrap();
    let panel = &ranks.rows[0][0];
    let names: Vec<&str> = panel.y.names.iter().map(|n| n.1.as_str()).collect();
    let point = |mark: &Mark| if let Mark::Point(at, ..) = mark { Some(at.0) } else { None };
    let means: Vec<f64> = panel.marks.iter().filter_map(point).collect();
    assert_eq!((names, means), (vec!["good", "mixed", "bad"], vec![1.25, 2.0, 2.75]));
    assert!(caption.starts_with("Mean ranks by F1 score") && caption.ends_with("8 targets."));
    assert!(ranks.to_svg().is_ok());
    // Smaller is better for false positives: the order is the same, as good has 1 and bad 3.
    assert_eq!(by(Metric::FP, competitors()).fields[0].standings[1].mean_rank, Some(1.25));
}

#[test]
fn of_more_than_twelve_methods_the_best_is_tested_and_no_diagram_is_drawn() {
    let name = |k: usize| format!("m{k:02}");
    let many: Vec<Standing> =
        (0..13).map(|k| competitor(&name(k), true, &[[1 + k as i64, 1, 1]; 4])).collect();
    let of = by(Metric::F_SCORE, many);
    let reason = diagram(&of, "").unwrap().unwrap_err();
    assert!(reason.contains("13 methods are more than a diagram can show"), "{reason}");
    let tested: Vec<[String; 2]> = of.fields[0].pairs.iter().map(|pair| pair.labels.clone()).collect();
    assert_eq!(tested, (0..12).map(|k| [name(12), name(k)]).collect::<Vec<_>>());
}

// By hand: means .5 and .4; the first is better in 3 of 4 sequences by .2 and worse by .2 in one. Of 16 patterns those
// with a mean difference of .1 or more in size have 0, 1, 3 or 4 exchanged: 10 of 16.
#[test]
fn trackers_are_compared_by_their_mean() {
    let tracker = |label: &str, values: [f64; 4]| {
        let row = |(k, v): (usize, f64)| (format!("s{k}"), vec![Some(v)]);
        let rows = values.into_iter().enumerate().map(row).collect();
        let column = vec!["success AUC".to_string()];
        let table = Grid { name: "sequences".into(), corner: "sequence".into(), columns: column, rows };
        let counts = counts_of_column(&table, 0);
        Standing { label: label.into(), name: label.into(), competes: true, counts, ..Standing::default() }
    };
    let both = vec![tracker("A", [0.5, 0.6, 0.4, 0.5]), tracker("B", [0.3, 0.4, 0.2, 0.7])];
    let measured = Measured::column("success AUC");
    let names = (String::new(), String::new());
    let fields = vec![field(names, both, mean_of_sum, measured.direction, &Sampling::with_seed(1))];
    let of = Standings { measured, fields };
    let table = intervals(&of);
    let rows = &table.groups[0].rows;
    assert_eq!((rows[0].cells[0].value, rows[0].cells[4].value), (Some(0.5), Some(1.25)));
    assert_eq!(table.corner, "tracker");
    let row = &pairs(&of).unwrap().groups[0].rows[0];
    assert!((row.cells[0].value.unwrap() - 0.1).abs() < 1e-12);
    assert_eq!(row.cells[3].value, Some(10.0 / 16.0));
    assert_eq!(Measured::column("failures").direction, Direction::LowerIsBetter);
}

// By hand: F is 6/7, 4/7 and 2/7 for good, mixed and bad, without spread for good and bad; two goods are equal.
#[test]
fn many_trackers_are_counted_and_few_are_named() {
    let told = |fields: &[(&str, &[&str])]| {
        let (good, bad) = ([3, 1, 0], [1, 3, 2]);
        // Those that are equal and the best, then the worst.
        let field = |(tracker, best): &(&str, &[&str])| {
            let mut list: Vec<Standing> =
                best.iter().map(|best| competitor(best, true, &[good; 8])).collect();
            list.push(competitor("bad", true, &[bad; 8]));
            // Numbers of fewer sequences are no best ones.
            list.push(competitor("easy", true, &[[3, 0, 0]; 7]));
            field_of(tracker, list, Metric::F_SCORE)
        };
        let fields = fields.iter().map(field).collect();
        verdict(&Standings { measured: Measured::metric(Metric::F_SCORE), fields }).unwrap()
    };
    let [x, y, z, u, v] = ["x", "y", "z", "u", "v"].map(|name| [name]);
    let [x, y, z, u, v] = [&x[..], &y, &z, &u, &v];
    let even: &[&str] = &["good", "as good"];
    let three: &[&str] = &["good", "as good", "too"];
    let eight = [("A", x), ("B", y), ("C", y), ("D", z), ("E", u), ("F", v), ("G", u), ("H", even)];
    assert!(told(&[("A", x)]).starts_with("Largest F1 score on A: x, 0.857"));
    for (fields, sentence) in [
        (
            &[("A", x), ("B", y), ("EVEN", even)][..],
            ", of 3 trackers: x on 1 (A 0.857), y on 1 (B 0.857), two or more equal at the top on 1; on 2 of them the lead \
             is more than chance.",
        ),
        (
            &[("EVEN", even)],
            " on EVEN: good and as good are equal, 0.857 (95 % of their difference: 0.000 to 0.000).",
        ),
        (&[("EVEN", three)], " on EVEN: good, as good and 1 more are equal, 0.857."),
        (
            &eight,
            ", of 8 trackers: y on 2, u on 2, x on 1, 2 more methods on 2, two or more equal at the top on 1; on 7 of them \
             the lead is more than chance.",
        ),
    ] {
        assert_eq!(told(fields), format!("Largest F1 score{sentence}"));
    }
}

#[test]
fn a_report_is_ordered_by_a_metric_that_orders_by_itself_where_it_can() {
    let of = |tables: &str| ordering_metric(&experiment("", &[("DTEF", "")], tables)).name();
    let rows = |list: &str| items("table", &[&format!("name = 't'; rows = [{list}]; columns = 'method'")]);
    assert_eq!(of(&rows("'events', 'recall', 'f_score'")), "f_score");
    assert_eq!(of(&rows("'recall', 'fpr', 'informedness'")), "informedness");
    let single = ["'events', 'recall'", "'reverse_runs', 'fpr'", "'events'"].map(|list| of(&rows(list)));
    assert_eq!((single, of("")), (["recall", "fpr", "f_score"], "f_score"));
}

#[test]
fn a_published_value_has_a_sign_and_a_word() {
    let table = &items("table", &["name = 't'; rows = ['f_score']; columns = 'method'"]);
    let published =
        items("published", &["table = 't'; tracker = 'NCC'; row = 'f_score'; values = { DTEF = '.191' }"]);
    let mut of = by(Metric::F_SCORE, competitors());
    of.fields[0].standings[1].name = "DTEF".into();
    let note = |tables: &str| dots(&of, &experiment("", &[("DTEF", "")], tables), "").unwrap().0;
    let with = note(&format!("{table}{published}"));
    assert!(with.note.ends_with("; a diamond is the published value"));
    assert_eq!(with.panels[0].published, [Some(0.191), None, None]);
    assert_eq!(with.rows, ["good", "mixed", "bad"]);
    assert!(note(table).note.ends_with("over sequences"));
}

#[test]
fn a_point_of_a_grid_is_in_words() {
    let spoken = |name: &str, label: &str| {
        let (label, name) = (label.to_string(), name.to_string());
        Standing { label, name, ..Standing::default() }.spoken()
    };
    assert_eq!(spoken("NAIVE", "NAIVE[horizon=5;threshold=0.004]"), "NAIVE (horizon 5, threshold 0.004)");
    assert_eq!((spoken("CovF", "CovF"), spoken("a[b]", "a[b]")), ("CovF".into(), "a[b]".into()));
}
