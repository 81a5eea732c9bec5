//! Scores of real result files, compared with those of the VOT toolkit.

use super::{Base, rows, vot};
use crate::tracker::Status;
use std::path::PathBuf;
use trackfail_core::region::{Areas, Region};
use trackfail_dataset::format;
use trackfail_dataset::text::read_capped;
use trackfail_judge::score::resets::{
    Measured, Rules, expected_average_overlap, expected_overlap, of_sequence,
};
use trackfail_judge::score::trajectory::Trajectory;

// Accuracy, failures and EAO[108..371] of real result files on the sequences of VOT2014 that are here, by
// vot-toolkit 0.7.4 with attributee 0.1.9: python3 tests/oracles/resets.py DATA prints these lines.
#[trackfail_testing::needs(real_data)]
#[test]
fn real_results_score_as_in_the_vot_toolkit() {
    let root = trackfail_testing::real_data();
    let rules = Rules { areas: Areas::VotToolkit, bounded: true, burn_in: 10 };
    for (tracker, runs, per_sequence, eao) in TOOLKIT {
        let mut tracks = Vec::new();
        let folders = per_sequence.iter().map(|row| root.join("vot2014").join(row.0));
        let load = |folder: PathBuf| format::vot::load(&folder, &Default::default()).unwrap();
        let sequences: Vec<_> = folders.map(load).collect();
        let mut states = Vec::new();
        for q in &sequences {
            for run in 1..=*runs {
                let path = format!("results/vot2014/{tracker}/{0}/{0}_{run:03}.txt", q.name);
                let path = root.join(path);
                let rows = rows::read(&path, &read_capped(&path).unwrap()).unwrap();
                let read = vot::parse(&path, rows, &q.truth, Base::Zero, None).unwrap();
                let status: Vec<Status> = read.iter().map(|s| s.status).collect();
                let regions: Vec<Region> = read.into_iter().map(|s| s.region).collect();
                states.push((q, status, regions));
            }
        }
        for (q, status, regions) in &states {
            let (sequence, truth, frame) = (&q.name, &q.truth, Some(q.size().unwrap()));
            let trajectory = Trajectory { sequence, regions, status, truth, frame, ..Trajectory::default() };
            tracks.push((trajectory, rules.measure(&trajectory)));
        }
        for (k, (name, accuracy, failures)) in per_sequence.iter().enumerate() {
            let mine: Vec<&Measured> = tracks[k * runs..(k + 1) * runs].iter().map(|t| &t.1).collect();
            let (a, f) = of_sequence(&mine).unwrap();
            assert!((a - accuracy).abs() < 1e-9, "{tracker} {name}: {a} {accuracy}");
            assert!((f - failures).abs() < 1e-9, "{tracker} {name}: {f} {failures}");
        }
        let got = expected_average_overlap(&expected_overlap(&tracks), 108, 371).unwrap();
        // The toolkit sums in f32.
        assert!((got - eao).abs() < 1e-5, "{tracker}: {got} {eao}");
    }
}

/// Folder, number of repetitions, accuracy and failures of each sequence, and EAO.
type Row = (&'static str, usize, &'static [(&'static str, f64, f64)], f64);
const TOOLKIT: &[Row] = &[
    (
        "GOTURN/baseline",
        3,
        &[
            ("diving", 0.5582562683845803, 0.0),
            ("drunk", 0.7099631005235306, 0.0),
            ("gymnastics", 0.5508803883314619, 0.0),
            ("jogging", 0.6651935994895743, 1.0),
            ("sphere", 0.8280713596041175, 0.0),
            ("sunshade", 0.7913071176193721, 0.0),
            ("surfing", 0.6496674200253496, 0.0),
            ("tunnel", 0.365633271063516, 1.0),
        ],
        0.48059289522166815,
    ),
    (
        "PFTracker/baseline_lite",
        1,
        &[
            ("diving", 0.35757428672853436, 0.0),
            ("drunk", 0.43705734157720044, 3.0),
            ("gymnastics", 0.5128444455207859, 0.0),
            ("jogging", 0.606735658989343, 1.0),
            ("sphere", 0.2895175388149421, 2.0),
            ("sunshade", 0.5119618510743428, 9.0),
            ("surfing", 0.4368051426661301, 3.0),
            ("tunnel", 0.3598065394153686, 5.0),
        ],
        0.1582266089799985,
    ),
    (
        "CFTTracker/baseline_lite",
        1,
        &[
            ("diving", 0.1980958125634327, 2.0),
            ("drunk", 0.235767377586989, 0.0),
            ("gymnastics", 0.398573605360548, 2.0),
            ("jogging", 0.6951368137224537, 1.0),
            ("sphere", 0.6072438883222873, 2.0),
            ("sunshade", 0.5820815313512173, 2.0),
            ("surfing", 0.5698771284765938, 0.0),
            ("tunnel", 0.22158360307419153, 0.0),
        ],
        0.19887852231015507,
    ),
];
