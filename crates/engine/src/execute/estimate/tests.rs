//! Work that is left shrinks by what the store has. Shards add up to the whole, and an interrupted shard
//! keeps its results.

use super::Standing;
use crate::error::RunError;
use crate::execute::{self, Options};
use crate::limits::RunLimits;
use crate::plan::{CellState, Shard};
use crate::testing::{experiment, with_plan};

const METHODS: &str = r#"[[tracker]]
name = "still"

[[method]]
name = "histogram"
signal = { kind = "rgb-histogram" }
detector = { kind = "level", below = 0.9 }

[[method]]
name = "trained"
signal = { kind = "rgb-histogram" }
detector = { kind = "level", below = { train = "others", maximise = "f_score", grid = { values = [0.5, 0.9] } } }
"#;

#[test]
fn the_work_that_is_left_is_known_before_and_after_a_share() {
    with_plan(&experiment("synthetic-vot", METHODS), |plan, store| {
        let sequences = plan.test().sequences.len();
        let shards = [1, 2].map(|number| Shard { number, of: 2 });
        let before = Standing::new(plan, store);
        let whole = before.remaining(None);
        assert_eq!((whole.tracks, whole.tracks_at_hand, whole.all_cells()), (sequences, 0, 2 * sequences));
        assert_eq!((whole.seconds, whole.is_done()), (None, false));
        // Shares leave trained methods to the run behind them.
        let parts = shards.map(|shard| before.remaining(Some(shard)));
        assert_eq!(parts.iter().map(|p| p.tracks).sum::<usize>(), sequences);
        assert_eq!(parts.iter().map(|p| p.all_cells()).sum::<usize>(), sequences);
        assert_eq!(parts.iter().map(|p| p.frames).sum::<u64>(), whole.frames);

        execute::run_shard(plan, store, &Options::default(), shards[0]).unwrap();
        let after = Standing::new(plan, store);
        assert!(after.remaining(Some(shards[0])).is_done());
        assert_eq!(after.remaining(Some(shards[0])).seconds, Some(0.0));
        assert!(!after.remaining(Some(shards[1])).is_done());
        assert_eq!(after.remaining(None).tracks_at_hand, parts[0].tracks);
        // The share has found the cost.
        assert!(after.remaining(Some(shards[1])).seconds.is_some_and(|s| s > 0.0));
    });
}

#[test]
fn an_interrupted_share_has_stored_the_labels_of_the_sequences_that_it_was_done_with() {
    with_plan(&experiment("synthetic-vot", METHODS), |plan, store| {
        let limits = RunLimits::default();
        let stop = limits.stop.clone();
        let in_the_middle = move |done: u64, all: u64| {
            if done * 2 > all {
                stop.set();
            }
        };
        let options = Options { limits, progress: std::sync::Arc::new(in_the_middle), ..Options::default() };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let whole = Shard { number: 1, of: 1 };
        let ended = pool.install(|| execute::run_shard(plan, store, &options, whole));
        assert!(matches!(ended, Err(RunError::Interrupted)));
        let cached = plan.states(store).into_iter().filter(|state| *state == CellState::Cached).count();
        assert!(cached > 0 && cached < plan.test().sequences.len(), "{cached}");
    });
}
