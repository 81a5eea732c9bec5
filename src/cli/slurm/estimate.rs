//! How long the tasks of an array may take, from a dry run: the work of each share, and what a frame of each tracker with
//! its signals takes. That is known from earlier runs on the results folder; a tracker that has none is tried here on a few
//! frames. Training, reverse runs and the times of other machines are not in it.

use super::Args;
use crate::cli::{Failure, run, times};
use crate::engine::execute::estimate::Standing;
use crate::engine::observe::costs::Costs;
use crate::engine::store::Store;
use crate::engine::{ExperimentPlan, Shard};
use crate::spec::Experiment;

/// Checks the data of the experiments, and says in a line how long the shares may take.
///
/// # Errors
/// `Data` for data that is missing or cannot be read, `Io` for a store that cannot be read.
pub fn estimate(args: &Args, experiments: &[Experiment]) -> Result<String, Failure> {
    let roots = args.data_roots.folders()?;
    let stop = run::stop_on_signals();
    let mut shares: Vec<Option<f64>> = vec![Some(0.0); usize::from(args.shards)];
    let mut tried = 0;
    // All data is checked before any tracker is tried.
    let mut loaded = Vec::new();
    for experiment in experiments {
        loaded.push((experiment, run::load(experiment, &roots, args.allow_missing)?));
    }
    let store = Store::open_read_only(&args.results).map_err(Failure::io)?;
    for (experiment, suites) in loaded {
        let plan = ExperimentPlan::new(experiment, suites, &roots, &stop)
            .map_err(|e| Failure::io(crate::cli::within(&experiment.name, e)))?;
        let mut standing = Standing::new(&plan, &store, Costs::read(&store));
        tried += standing.probe_unknown(&roots, &stop);
        for (number, share) in (1..).zip(&mut shares) {
            let left = standing.remaining(Some(Shard { number, of: u32::from(args.shards) }));
            *share = share.zip(left.seconds).map(|(sum, more)| sum + more / f64::from(args.cpus));
        }
    }
    let idle = shares.iter().filter(|share| **share == Some(0.0)).count();
    let from = match tried {
        0 => "from earlier runs on these results".to_string(),
        n => format!("from a few frames of {n} trackers on this machine"),
    };
    let Some(longest) =
        shares.iter().copied().collect::<Option<Vec<f64>>>().and_then(|all| all.into_iter().reduce(f64::max))
    else {
        return Ok("not known: not all trackers could be tried here".to_string());
    };
    if idle == shares.len() {
        return Ok("nothing to track; what is left is labels, training and analyses".to_string());
    }
    let longest_of = times::span(longest);
    let mut text = format!(
        "about {longest_of} for the longest share on {} cores, {from}; training and reverse runs come on top",
        args.cpus
    );
    if args.time.seconds().is_some_and(|limit| longest > limit as f64) {
        text.push_str(&format!(
            "\nwarning: --time {} is less; tasks are stopped then and go on when submitted again. Take more --shards or --cpus",
            args.time
        ));
    }
    Ok(text)
}
