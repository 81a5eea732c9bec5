//! Laws that every analysis in the list obeys, checked on random tracks.

use super::processing_time::{Spent, Timing};
use super::*;
use crate::tracker::Status;
use rand::RngExt;
use sha2::{Digest, Sha256};
use trackfail_core::num::hexadecimal;
use trackfail_core::num::seed;
use trackfail_core::region::{Rect, Region};

/// c_t and tracking errors of a few tracks: c_t is mostly small, and larger where the track is lost.
fn tracks(name: &str, scale: f64) -> Vec<(Vec<f64>, Vec<f64>)> {
    let mut rng = seed::rng(seed::seed(1, &[name]));
    let mut track = |_| {
        let error: Vec<f64> = (0..150)
            .map(|t| match t {
                70..90 => 1.0,
                20..25 => f64::NAN,
                _ => rng.random_range(0.05..0.85),
            })
            .collect();
        let draw = |(t, error): (usize, &f64)| {
            let u: f64 = rng.random_range(1e-6..1.0);
            match t {
                0 | 1 => 0.0,
                _ if *error == 1.0 => -3.0 * u.ln(),
                _ => -scale * u.ln() * if t % 3 == 0 { 4.0 } else { 1.0 },
            }
        };
        (error.iter().enumerate().map(draw).collect(), error)
    };
    (0..6).map(&mut track).collect()
}

/// Regions and ground truth of a track that drifts off and is started again.
struct Drawn {
    regions: Vec<Region>,
    status: Vec<Status>,
    truth: Vec<Option<Region>>,
    attributes: Vec<String>,
    frame_attributes: Vec<(String, Vec<bool>)>,
}

fn drawn(k: usize) -> Drawn {
    let square = |x: f64| Region::Rect(Rect::new(x, 20.0, 30.0, 40.0));
    let status = |t: usize| match t {
        0 => Status::Initialized,
        95 if k > 0 => Status::Initialized,
        90 if k > 0 => Status::Failed,
        91..95 if k > 0 => Status::Skipped,
        _ => Status::Tracked,
    };
    Drawn {
        regions: (0..150).map(|t| square(50.0 + ((t * (k + 1)) % 17) as f64)).collect(),
        status: (0..150).map(status).collect(),
        truth: (0..150).map(|t| (t % 9 != 4).then(|| square(50.0))).collect(),
        attributes: vec!["SV".into()],
        frame_attributes: vec![("occlusion".into(), (0..150).map(|t| t % 3 == 0).collect())],
    }
}

fn trajectories(drawn: &[Drawn]) -> Vec<Trajectory<'_>> {
    fn trajectory((k, d): (usize, &Drawn)) -> Trajectory<'_> {
        Trajectory {
            sequence: ["first", "first", "second", "third"][k],
            run: u32::from(k == 1),
            regions: &d.regions,
            status: &d.status,
            truth: &d.truth,
            frame: Some((160, 120)),
            attributes: &d.attributes,
            frame_attributes: &d.frame_attributes,
            ..Trajectory::default()
        }
    }
    drawn.iter().enumerate().map(trajectory).collect()
}

fn population<'a>(suite: &'a str, tracks: &'a [(Vec<f64>, Vec<f64>)], drawn: &'a [Drawn]) -> Population<'a> {
    let tracks = tracks.iter().map(|(signal, error)| Example::new(signal, error)).collect();
    let spent =
        |seconds: f64| Spent { signal: seconds, detection: 0.25, reverse: seconds, runs: 3, frames: 40 };
    let timing = |repeat: usize| Timing {
        repeat,
        frames: 100,
        tracking: 0.5,
        methods: [1.0, 2.0].map(|k| spent(0.125 * k * (repeat + 1) as f64)).into(),
    };
    let timings = if drawn.is_empty() { vec![] } else { (0..4).map(timing).collect() };
    Population { suite, tracks, trajectories: trajectories(drawn), timings }
}

fn digest(findings: &Findings) -> String {
    let mut hash = Sha256::new();
    let mut number = |v: f64| hash.update(format!("{v:.6e} ").as_bytes());
    findings.numbers.iter().for_each(|(_, v)| number(*v));
    let cells = findings.tables.iter().flat_map(|t| &t.rows).flat_map(|(_, values)| values);
    cells.flatten().for_each(|v| number(*v));
    let points = findings.charts.iter().flat_map(|c| &c.curves).flat_map(|(_, points)| points);
    points.for_each(|p| [p.0, p.1].into_iter().for_each(&mut number));
    hexadecimal(&hash.finalize()[..8])
}

#[test]
fn findings_have_the_promised_names_are_finite_and_golden() {
    let (first, second) = (tracks("first", 0.05), tracks("second", 0.08));
    let drawn: Vec<Drawn> = (0..4).map(drawn).collect();
    let mut found = Vec::new();
    for entry in ANALYSES {
        let analysis = entry.build_from_text(entry.example).unwrap();
        let (fewest, most) = analysis.suites();
        for suites in fewest..=most {
            let populations = [population("first", &first, &drawn), population("second", &second, &drawn)];
            let findings = analysis.analyze(&populations[..suites]).unwrap();
            let names = Names {
                numbers: findings.numbers.iter().map(|n| n.0.clone()).collect(),
                tables: findings.tables.iter().map(|t| t.name.clone()).collect(),
                charts: findings.charts.iter().map(|c| c.name.clone()).collect(),
            };
            assert_eq!(names, analysis.layout(suites).names());
            for Grid { name, columns, rows, .. } in &findings.tables {
                assert!(rows.iter().all(|(_, values)| values.len() == columns.len()), "{name}");
                assert!(rows.iter().flat_map(|r| &r.1).flatten().all(|v| v.is_finite()), "{name}");
            }
            for chart in &findings.charts {
                let points = || chart.curves.iter().flat_map(|c| &c.1);
                assert!(points().next().is_some(), "{} is empty", chart.name);
                assert!(points().all(|p| p.0.is_finite() && p.1.is_finite()), "{}", chart.name);
            }
            assert!(findings.numbers.iter().all(|(_, v)| v.is_finite()));
            if suites == most {
                found.push(format!("{} {} {}", entry.kind, entry.version, digest(&findings)));
            }
        }
    }
    trackfail_testing::check_pins("output analysis", found);
}

#[test]
fn ranges_are_what_is_accepted() {
    crate::range_tests::check(ANALYSES);
    trackfail_testing::check_pins("range analysis", crate::range_tests::pins(ANALYSES));
}

#[test]
fn suites_without_consistent_frames_are_an_error() {
    let mut lost = tracks("lost", 0.05);
    lost.iter_mut().for_each(|(_, error)| error.fill(1.0));
    for entry in ANALYSES {
        let analysis = entry.build_from_text(entry.example).unwrap();
        let populations = [population("lost", &lost, &[]), population("lost", &lost, &[])];
        let is_of_signal = analysis.reads().has_signal() && !analysis.reads().has_regions();
        let reason = analysis.analyze(&populations[..analysis.suites().0]).unwrap_err();
        let words = if is_of_signal { "mixture of Gammas" } else { "no track" };
        trackfail_testing::assert_says(format!("{}: {reason}", entry.kind), words);
    }
}

/// The same suite twice: the distance and the differences are 0.
#[test]
fn a_suite_has_no_distance_from_itself() {
    let one = tracks("one", 0.05);
    let analysis = uncertainty_model::ENTRY.build_from_text("{}").unwrap();
    let findings = analysis.analyze(&[population("a", &one, &[]), population("b", &one, &[])]).unwrap();
    for name in ["similarity", "cut-difference"] {
        let table = findings.tables.iter().find(|t| t.name == name).unwrap();
        assert!(table.rows.iter().flat_map(|r| &r.1).flatten().all(|v| *v == 0.0), "{name}");
    }
}
