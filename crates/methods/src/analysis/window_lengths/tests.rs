//! Numbers by window length, compared with values computed by hand and with SciPy.

use super::*;
use crate::analysis::Findings;

/// c_t and errors of a track of 120 frames: three frames without a reference, then a squared sawtooth. The
/// track is lost twice, and nearly lost twice.
fn track(k: usize, scale: f64) -> (Vec<f64>, Vec<f64>) {
    let change = |t: usize| match t {
        0..3 => 0.0,
        _ => scale * (((t * (37 + k)) % 101) as f64 / 50.0).powi(2),
    };
    let error = |t: usize| match t % 60 {
        30..34 => 0.95,
        place if (40 - 5 * k..52).contains(&place) => 1.0,
        _ => 0.25,
    };
    ((0..120).map(change).collect(), (0..120).map(error).collect())
}

fn population<'a>(suite: &'a str, tracks: &'a [(Vec<f64>, Vec<f64>)]) -> Population<'a> {
    let tracks = tracks.iter().map(|(signal, error)| Example::new(signal, error)).collect();
    Population { suite, tracks, trajectories: Vec::new(), timings: Vec::new() }
}

fn found(lengths: &[usize]) -> Findings {
    let (first, second) = ([track(0, 1.0), track(1, 1.0)], [track(1, 1.25), track(2, 1.25)]);
    let analysis = Params { alpha: 0.05, lengths: lengths.to_vec(), ..Params::default() };
    analysis.analyze(&[population("first", &first), population("second", &second)]).unwrap()
}

fn values(findings: &Findings, table: &str) -> Vec<Vec<f64>> {
    let table = findings.tables.iter().find(|t| t.name == table).unwrap();
    table.rows.iter().map(|(_, values)| values.iter().map(|v| v.unwrap()).collect()).collect()
}

fn assert_close(found: &[f64], expected: &[f64]) {
    let close = found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 1e-12 * b.abs().max(1e-3));
    assert!(close && found.len() == expected.len(), "{found:?} {expected:?}");
}

// By hand: lost in frames 3 and 4, found in 5 and 6, lost from 7 on; frame 4 has no annotation.
#[test]
fn a_change_lasts_until_the_next_one() {
    let changes = changes_of(&[0.2, 0.2, 0.2, 1.0, f64::NAN, 0.5, 0.5, 1.0, 1.0, 1.0]);
    let change = |sign, from, to, to_the_end| Change { sign, from, to, to_the_end };
    assert_eq!(changes, [change(1, 3, 5, false), change(-1, 5, 7, false), change(1, 7, 10, true)]);
    let shorter = |length| changes.iter().map(|c| c.is_shorter(length)).collect::<Vec<_>>();
    assert_eq!(shorter(2), [false; 3]);
    assert_eq!(shorter(100), [true, true, false]);
}

// By hand: the alarm of frames 20 to 29 is in time for a loss in 15 to 25, late for one in 5, under way for one in 27 and
// in 29; its end is in time for a recovery in 30, and late for one in 22.
#[test]
fn an_alarm_meets_a_change_in_time_late_before_or_never() {
    use Meeting::{Before, InTime, Late, Never};
    let alarm: Vec<bool> = (0..60).map(|t| (20..30).contains(&t)).collect();
    let crossings = changes(&alarm);
    let met = |sign, from, to| meeting(&Change { sign, from, to, to_the_end: false }, &alarm, &crossings);
    assert!((15..=25).all(|from| met(1, from, 60) == InTime));
    let losses = [met(1, 5, 60), met(1, 5, 20), met(1, 27, 60), met(1, 40, 60)];
    assert_eq!(losses, [Late, Never, Before, Never]);
    let recoveries = [met(-1, 33, 60), met(-1, 22, 60), met(-1, 22, 28), met(-1, 50, 60)];
    assert_eq!(recoveries, [InTime, Late, Never, Before]);
}

// Python, SciPy 1.17 and NumPy 2.4, on the tracks above; a, x: ascending values of the first and of another kind:
//   scipy.stats.ks_2samp(a, x).statistic;  e = n * m / (n + m);  ((-numpy.log(.025) / 2) / e) ** .5
//   scipy.stats.kstwobign.sf((e ** .5 + .12 + .11 / e ** .5) * statistic)
#[test]
fn distances_agree_with_scipy() {
    let expected = [
        [0.12162162162162163, 0.154887633083887, 0.1917614787932868, 160.0, 148.0],
        [0.2375, 0.356097221605514, 0.3384864300194392, 160.0, 16.0],
        [0.10982142857142857, 0.19461985318066277, 0.5748970556069579, 160.0, 70.0],
    ];
    let findings = found(&[1, 5]);
    let distances = values(&findings, "distances");
    distances.iter().zip(expected).for_each(|(found, expected)| assert_close(found, &expected));
    assert_eq!(findings.number("distance"), Some(distances[0][0]));
    assert_eq!(findings.number("distance-lost"), Some(distances[2][0]));
}

// numpy.quantile(x, p, method="inverted_cdf") for p in (.5, .75, .9, .95, .99, .995, .999), x of the four kinds
#[test]
fn quantiles_agree_with_numpy() {
    let expected = [
        [1.0, 1.2005, 1.7405, 1.152],
        [2.3716, 2.738, 2.888, 2.8125],
        [3.24, 4.05, 4.802, 3.872],
        [3.5344, 4.608, 5.0, 4.3245],
        [3.9204, 4.9005, 5.0, 5.0],
        [3.9204, 4.9005, 5.0, 5.0],
        [3.9204, 4.9005, 5.0, 5.0],
    ];
    let found = values(&found(&[1]), "quantiles");
    found.iter().zip(expected).for_each(|(found, expected)| assert_close(found, &expected));
}

// s: sums of L values, all of consistent frames of the first tracks; a: the values.
//   (numpy.var(s) / (L * numpy.var(a))) ** .5;  numpy.quantile(s, .95, method="inverted_cdf")
#[test]
fn spreads_agree_with_numpy_and_rates_are_those_of_the_windows() {
    let lengths = [1, 5, 20];
    let expected = [[3.5344, 1.0], [9.0012, 0.5290065569313629], [31.2436, 0.4508615109212524]];
    let rates = values(&found(&lengths), "rates");
    let (first, second) = ([track(0, 1.0), track(1, 1.0)], [track(1, 1.25), track(2, 1.25)]);
    for ((row, expected), length) in rates.iter().zip(expected).zip(lengths) {
        assert_close(&row[1..3], &expected);
        let cut = row[0];
        let windows = |tracks: &[(Vec<f64>, Vec<f64>)]| {
            let of_track = |(c, e): &(Vec<f64>, Vec<f64>)| {
                let is_good = |t: &usize| e[t + 1 - length..=*t].iter().all(|e| *e < 0.9);
                let ends = (2 + length..120).filter(is_good).collect::<Vec<_>>();
                ends.into_iter().map(|t| c[t + 1 - length..=t].iter().sum()).collect::<Vec<f64>>()
            };
            let sums: Vec<f64> = tracks.iter().flat_map(of_track).collect();
            sums.iter().filter(|s| **s > cut).count() as f64 / sums.len() as f64
        };
        assert_close(&row[3..5], &[windows(&first), windows(&second)]);
        let lost = second.iter().flat_map(|(c, e)| {
            let sum = |t: usize| c[(t + 1).saturating_sub(length)..=t].iter().sum::<f64>();
            (0..120).filter(|t| e[*t] >= 1.0).map(sum).collect::<Vec<f64>>()
        });
        let lost: Vec<f64> = lost.collect();
        let beyond = |cut: f64| lost.iter().filter(|s| **s > cut).count() as f64 / lost.len() as f64;
        assert_close(&row[5..7], &[beyond(cut), beyond(row[1])]);
    }
}

// Python: the runs between numpy.nonzero(numpy.diff(e >= 1)): 17, 43, 17, 8 and 18, 42, 18, 8 frames, the last ones cut
#[test]
fn durations_and_shares_agree_with_numpy() {
    let findings = found(&[17, 18, 42, 60]);
    assert_eq!(values(&findings, "durations"), [[4.0, 0.0, 17.0, 17.0, 18.0], [4.0, 2.0, 8.0, 8.0, 42.0]]);
    let shares = values(&findings, "changes");
    let expected = [[0.0; 3], [0.25, 0.5, 0.0], [0.5, 1.0, 0.0], [0.75, 1.0, 0.5]];
    assert_eq!(shares, expected);
    assert_eq!(findings.number("shorter"), Some(0.75));
    for row in values(&findings, "delays") {
        assert_eq!((row[1..5].iter().sum::<f64>(), row[5..].iter().sum::<f64>()), (4.0, 4.0));
    }
}

#[test]
fn lengths_that_do_not_ascend_are_refused() {
    assert!(ENTRY.build_from_text("{ lengths = [5, 1] }").is_err());
}
