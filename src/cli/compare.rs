//! `trackfail compare A B --in EXPERIMENT [--in EXPERIMENT]`, or `trackfail compare DIR DIR` for two results
//! folders.

use super::Failure;
use super::output::{self, Format};
use crate::num::paired;
use crate::plugin::unknown;
use crate::report::finished;
use crate::report::pairs::{self, Apart, Side, Values};
use crate::results::Results;
use crate::table::number::p_value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Arguments of `compare`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A tracker or a method (`DTEF`, `AVU[length=20]`) of the experiment, or a results folder
    #[arg(value_name = "A")]
    first: String,
    /// The tracker, method or folder that A is compared with
    #[arg(value_name = "B")]
    second: String,
    /// The experiment whose results are compared, or that of A and that of B; not for two folders
    #[arg(long = "in", value_name = "EXPERIMENT")]
    experiments: Vec<String>,
    /// Folder of the results
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// Methods: only on this tracker; on all, pooled, where it is left out
    #[arg(long, value_name = "LABEL")]
    tracker: Option<String>,
    /// Only this measure: `f_score`, `success_auc`, `failures` ...
    #[arg(long, value_name = "NAME")]
    metric: Option<String>,
    /// How to print it
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Number of bootstrap samples.
const SAMPLES: usize = 10_000;
/// Probability with which an interval contains the mean difference.
const LEVEL: f64 = 0.95;

/// Runs the verb.
///
/// # Errors
/// See [`Failure`].
pub fn run(args: &Args) -> Result<(), Failure> {
    let read = |folder: &Path| Results::read(folder).map_err(Failure::from);
    let named = |name: &String| read(&finished::folder(&args.results, name)?);
    let tracker = args.tracker.as_deref();
    let (mut compared, mut reason) = (Vec::new(), String::new());
    match args.experiments.as_slice() {
        [name, others @ ..] if others.len() <= 1 => {
            let results = named(name)?;
            let other = others.first().map(named).transpose()?;
            let of_second = other.as_ref().unwrap_or(&results);
            check_tracker(&[&results, of_second], tracker)?;
            let [first, second] =
                pairs::sides([(&results, &args.first), (of_second, &args.second)], tracker)?;
            note_left_out([&first, &second].map(|side| side.left_out));
            compared.extend(by_sequence("", &first.values, &second.values));
            reason = without_common(&first, &second);
            if other.is_none() {
                let sides = [(args.first.as_str(), &first), (args.second.as_str(), &second)];
                compared.extend(pairs::apart(&results, sides, tracker)?.into_iter().map(Compared::Pooled));
            }
        }
        [_, ..] => return Err(Failure::usage("--in is given once, or once for A and once for B")),
        [] => {
            let folders = [&args.first, &args.second].map(Path::new);
            if let Some(other) = folders.iter().find(|f| !f.is_dir()) {
                let message = format!(
                    "{}: no results folder; trackers and methods are compared in an experiment: --in EXPERIMENT",
                    other.display()
                );
                return Err(Failure::usage(message));
            }
            let [first, second] = [read(folders[0])?, read(folders[1])?];
            check_tracker(&[&first, &second], tracker)?;
            let mut left_out = [0; 2];
            for name in pairs::names(&first).into_iter().filter(|n| pairs::names(&second).contains(n)) {
                let [a, b] = pairs::sides([(&first, &name), (&second, &name)], tracker)?;
                left_out = [left_out[0] + a.left_out, left_out[1] + b.left_out];
                compared.extend(by_sequence(&name, &a.values, &b.values));
                reason = without_common(&a, &b);
            }
            note_left_out(left_out);
        }
    }
    let measures: BTreeSet<&str> = compared.iter().map(Compared::measure).collect();
    let wanted = args.metric.as_deref();
    if let Some(wanted) = wanted.filter(|wanted| !measures.is_empty() && !measures.contains(wanted)) {
        return Err(Failure::usage(unknown("measure", wanted, measures)));
    }
    let chosen = compared.iter().filter(|one| wanted.is_none_or(|wanted| one.measure() == wanted));
    let rows: Vec<Vec<String>> = chosen.filter_map(|one| one.row(args.format)).collect();
    if rows.is_empty() {
        let what = wanted.map_or("measure".to_string(), |m| format!("measure `{m}`"));
        let message =
            format!("{} and {} have no {what} on a common sequence{reason}", args.first, args.second);
        return Err(Failure::usage(message));
    }
    let [low, high] = ["95% from", "95% to"];
    let headings =
        ["of", "measure", "sequences", "A", "B", "A - B", low, high, "A higher", "equal", "B higher", "p"];
    output::note(&format!(
        "A is {}, B is {}; means over sequences, interval by bootstrap over sequences, p of Wilcoxon's signed-rank \
         test; `pooled` and measures of frames are over all sequences together",
        args.first, args.second
    ));
    output::print(args.format, &headings, &rows)
}

/// Checks that one of the results has the tracker of `--tracker`, also where trackers are compared, which need none.
fn check_tracker(results: &[&Results], tracker: Option<&str>) -> Result<(), Failure> {
    let of_analyses = results.iter().flat_map(|r| &r.analyses).map(|a| a.tracker.as_str());
    let of_measures = results.iter().flat_map(|r| &r.measures).map(|m| m.tracker.as_str());
    let known: BTreeSet<&str> = of_measures.chain(of_analyses.filter(|label| !label.is_empty())).collect();
    match tracker.filter(|wanted| !known.contains(wanted)) {
        Some(wanted) => Err(Failure::usage(unknown("tracker", wanted, known))),
        None => Ok(()),
    }
}

/// A measure that both sides have.
enum Compared {
    /// A measure by sequence, on the common sequences; `of` names the method or tracker.
    Sequences { of: String, measure: String, pairs: Vec<(f64, f64)> },
    /// A measure over all sequences together.
    Pooled(Apart),
}

/// Measures of both sides on the common sequences.
fn by_sequence(of: &str, first: &Values, second: &Values) -> Vec<Compared> {
    let one = |(measure, pairs)| Compared::Sequences { of: of.to_string(), measure, pairs };
    pairs::common(first, second).into_iter().map(one).collect()
}

impl Compared {
    fn measure(&self) -> &str {
        match self {
            Self::Sequences { measure, .. } | Self::Pooled(Apart { measure, .. }) => measure,
        }
    }

    /// Row of the measure; `None` without a common sequence.
    fn row(&self, format: Format) -> Option<Vec<String>> {
        let number = |value: Option<f64>| match (value, format) {
            (None, _) => String::new(),
            (Some(value), Format::Table) => format!("{value:.4}"),
            (Some(value), _) => value.to_string(),
        };
        let (of, sequences, numbers, signs, p) = match self {
            Self::Sequences { of, pairs, .. } => {
                let c = paired::compare(pairs, LEVEL, SAMPLES, 0)?;
                let numbers = [c.means.0, c.means.1, c.difference, c.interval.0, c.interval.1].map(Some);
                let signs = [c.signs.0, c.signs.1, c.signs.2].map(|n| n.to_string());
                (of.as_str(), Some(c.pairs), numbers, signs, c.p)
            }
            Self::Pooled(Apart { sequences, values: [a, b], bounds, .. }) => {
                let difference = a.zip(*b).map(|(a, b)| a - b);
                let numbers = [*a, *b, difference, bounds.map(|b| b.0), bounds.map(|b| b.1)];
                ("", *sequences, numbers, Default::default(), None)
            }
        };
        let count = sequences.map_or_else(String::new, |n| n.to_string());
        let head = [of.to_string(), self.measure().to_string(), count].into_iter();
        let p = match (p, format) {
            (Some(p), Format::Table) => p_value(p),
            _ => number(p),
        };
        Some(head.chain(numbers.map(number)).chain(signs).chain([p]).collect())
    }
}

/// Tells how many tracks of A and B are left out, since the method was run on them on one side alone.
fn note_left_out(numbers: [usize; 2]) {
    let told = |(name, n): (&str, usize)| (n > 0).then(|| format!("{n} of {name}"));
    let told: Vec<String> = ["A", "B"].into_iter().zip(numbers).filter_map(told).collect();
    if !told.is_empty() {
        let told = told.join(" and ");
        output::note(&format!(
            "methods are compared on the tracks that both sides have; left out are {told}"
        ));
    }
}

/// Reason why two sides have no measures in common, as the end of a sentence.
fn without_common(first: &Side, second: &Side) -> String {
    if first.is_apart() && second.is_apart() {
        let [a, b] = [first.left_out, second.left_out];
        return format!(": A has {a} tracks and B {b}, none of which both have");
    }
    let [first, second] = [&first.values, &second.values];
    let measures = |side: &Values| side.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", ");
    let sequences = |side: &Values| {
        let all: BTreeSet<&str> =
            side.iter().flat_map(|(_, values)| values.keys()).map(String::as_str).collect();
        all.first().map_or("none".to_string(), |first| format!("{} such as {first}", all.len()))
    };
    let [a, b] = [measures(first), measures(second)];
    if first.iter().any(|(name, _)| second.iter().any(|(other, _)| name == other)) {
        format!(": A has sequences {}, B has {}", sequences(first), sequences(second))
    } else {
        format!(": A is measured by {a}, B by {b}")
    }
}
