//! Plans: tracks that training on others leaves out, and addresses of signals that read other trackers.

use super::{ExperimentPlan, variants};
use crate::execute;
use crate::limits::Stop;
use crate::spec;
use crate::store::address::Recipe;
use crate::testing::{experiment, with_plan};
use trackfail_dataset::suite::Origin;

const METHODS: &str = r#"seed = 7
tracker = [{ name = "still", runs = 2 }, { name = "still", label = "again" }, { name = "ncc" }]

[[method]]
name = "trained"
signal = { kind = "companion-overlap" }
detector = { kind = "level", below = { train = "others", maximise = "f_score", grid = { values = [0.1, 0.5] } } }

[[method]]
name = "given"
signal = { kind = "companion-overlap", at_most = 1 }
detector = { kind = "level", below = 0.1 }
"#;

#[test]
fn others_are_other_videos_and_other_trackers() {
    with_plan(&experiment("synthetic-d1", METHODS), |plan, _| {
        let (method, variant) = variants(plan.experiment).next().unwrap();
        let parts = plan.parts(variant);
        assert_eq!(parts, 10);
        for (tracker, part) in (0..3).flat_map(|t| (0..parts).map(move |part| (t, part))) {
            let tracks = plan.training_tracks((0, method, variant), tracker, part);
            // The sequences of the other folds on the other trackers; one run of `still` is as many as it learns from.
            let sequences = (0..plan.test().sequences.len()).filter(|s| plan.part(variant, *s) != part);
            let jobs = plan.jobs.iter().filter(|job| job.tracker != tracker).count();
            assert_eq!(tracks.len(), sequences.count() * jobs, "{tracker} {part}");
            let is_other = |s, j: usize| plan.part(variant, s) != part && plan.jobs[j].tracker != tracker;
            assert!(tracks.iter().all(|(_, s, j)| is_other(*s, *j)));
        }
        let (_, given) = variants(plan.experiment).nth(1).unwrap();
        assert_eq!((plan.parts(given), plan.part(given, 5)), (1, 0));
    });
}

#[test]
fn a_companion_signal_is_addressed_by_the_tracks_that_it_reads() {
    let address = |methods: &str| {
        with_plan(&experiment("synthetic-d1", methods), |plan, _| {
            let sequence = &plan.test().sequences[0];
            let recipe = plan.signal_recipe(sequence, 0, 0).unwrap();
            let others: Vec<usize> = plan.companions(sequence, 0).map(|j| plan.jobs[j].tracker).collect();
            assert_eq!(others, [1, 2]);
            assert_eq!(recipe.ingredients.iter().filter(|(name, _)| name == "companion").count(), 2);
            Recipe::address(&recipe).to_string()
        })
    };
    let other = METHODS.replace("name = \"ncc\"", "name = \"ncc\", search = 1.5");
    assert_eq!(address(METHODS), address(METHODS));
    assert_ne!(address(METHODS), address(&other));
}

#[test]
fn a_model_is_addressed_by_the_videos_and_sources_that_it_is_learned_from() {
    let methods = METHODS
        .replace("kind = \"companion-overlap\" }\n", "kind = \"box-motion\", measure = \"scale\" }\n")
        .replace("kind = \"level\", below = { train", "kind = \"fused\", inputs = [\"scale\"], train")
        .replace(", maximise = \"f_score\", grid = { values = [0.1, 0.5] } }", "");
    let experiment = spec::parse("try.toml", &experiment("synthetic-d1", &methods)).unwrap();
    let addresses = |change: fn(&mut Origin)| {
        let mut suites = execute::load(&experiment, &[]).unwrap();
        suites.values_mut().for_each(|suite| change(&mut suite.sequences[0].origin));
        let plan = ExperimentPlan::new(&experiment, suites, &[], &Stop::default()).unwrap();
        let needs = plan.needs(|_, _| true).into_iter();
        needs.map(|(_, need)| need.unwrap().address.to_string()).collect::<Vec<_>>()
    };
    let before = addresses(|_| ());
    assert!(!before.is_empty() && before == addresses(|_| ()));
    for change in
        [|origin: &mut Origin| origin.video.push('x'), |origin: &mut Origin| origin.source.push('x')]
    {
        assert_ne!(addresses(change), before);
    }
}
