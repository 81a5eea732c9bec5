//! Plans: tracks that training on others leaves out, and addresses of signals that read other trackers.

use super::{ExperimentPlan, variants};
use crate::execute::run;
use crate::limits::Stop;
use crate::spec;
use crate::store::address::Recipe;

const SPEC: &str = r#"schema = 1
name = "mine/others"
title = "A try"
protocol = "khalid2016/1"
seed = 7

[suites]
test = "synthetic-d1"

[[tracker]]
name = "still"
runs = 2

[[tracker]]
name = "still"
label = "again"

[[tracker]]
name = "ncc"

[[method]]
name = "trained"
signal = { kind = "companion-overlap" }
detector = { kind = "level", below = { train = "others", maximise = "f_score", grid = { values = [0.1, 0.5] } } }

[[method]]
name = "given"
signal = { kind = "companion-overlap", at_most = 1 }
detector = { kind = "level", below = 0.1 }
"#;

fn with_plan(text: &str, check: impl FnOnce(&ExperimentPlan<'_>)) {
    let experiment = spec::parse("mine.toml", text).unwrap();
    let suites = run::load(&experiment, &[]).unwrap();
    check(&ExperimentPlan::new(&experiment, suites, &[], &Stop::default()).unwrap());
}

#[test]
fn others_are_other_videos_and_other_trackers() {
    with_plan(SPEC, |plan| {
        let (method, variant) = variants(plan.experiment).next().unwrap();
        let parts = plan.parts(variant);
        assert_eq!(parts, 10);
        for (tracker, part) in (0..3).flat_map(|t| (0..parts).map(move |part| (t, part))) {
            let tracks = plan.training_tracks((0, method, variant), tracker, part);
            // The sequences of the other folds on the other trackers; one run of `still` is as many as it learns from.
            let sequences = (0..plan.test().sequences.len()).filter(|s| plan.part(variant, *s) != part);
            let jobs = plan.jobs.iter().filter(|job| job.tracker != tracker).count();
            assert_eq!(tracks.len(), sequences.count() * jobs, "{tracker} {part}");
            assert!(
                tracks
                    .iter()
                    .all(|(_, s, j)| plan.part(variant, *s) != part && plan.jobs[*j].tracker != tracker)
            );
        }
        let (_, given) = variants(plan.experiment).nth(1).unwrap();
        assert_eq!((plan.parts(given), plan.part(given, 5)), (1, 0));
    });
}

#[test]
fn a_companion_signal_is_addressed_by_the_tracks_that_it_reads() {
    let address = |text: &str| {
        let mut found = String::new();
        with_plan(text, |plan| {
            let recipe = plan.signal_recipe(&plan.test().sequences[0], 0, 0).unwrap();
            let companions = recipe.ingredients.iter().filter(|(name, _)| name == "companion").count();
            let others: Vec<usize> = plan.companions(&plan.test().sequences[0], 0).collect();
            assert_eq!(others.iter().map(|j| plan.jobs[*j].tracker).collect::<Vec<_>>(), [1, 2]);
            assert_eq!(companions, 2);
            found = Recipe::address(&recipe).to_string();
        });
        found
    };
    let other = SPEC.replace("name = \"ncc\"", "name = \"ncc\"\nsearch = 1.5");
    assert_eq!(address(SPEC), address(SPEC));
    assert_ne!(address(SPEC), address(&other));
}
