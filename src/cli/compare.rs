//! `trackfail compare A B --in EXPERIMENT [--in EXPERIMENT]`, or of two results folders: `trackfail compare DIR DIR`

use super::Failure;
use super::output::{self, Format};
use crate::num::paired::{self, Compared};
use crate::plugin::unknown;
use crate::report::finished;
use crate::report::pairs::{self, Apart, PairsError, Values};
use crate::results::Results;
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
    /// Probability that the interval holds the mean difference
    #[arg(long, value_name = "P", default_value_t = 0.95, value_parser = probability)]
    level: f64,
    /// Bootstrap samples
    #[arg(long, value_name = "N", default_value_t = 10_000, value_parser = clap::value_parser!(u32).range(100..=1_000_000))]
    samples: u32,
    /// Seed of the bootstrap
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// How to print it
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

fn probability(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|p: &f64| *p > 0.0 && *p < 1.0);
    number.ok_or_else(|| format!("`{text}` is no number between 0 and 1"))
}

/// Runs the verb.
///
/// # Errors
/// See [`Failure`].
pub fn run(args: &Args) -> Result<(), Failure> {
    let read = |folder: &Path| Results::read(folder).map_err(Failure::from);
    let (mut rows, mut measures, mut reason) = (Vec::new(), Vec::new(), String::new());
    match args.experiments.as_slice() {
        [name, others @ ..] if others.len() <= 1 => {
            let results = read(&finished::folder(&args.results, name)?)?;
            let tracker = args.tracker.as_deref();
            let first = pairs::side(&results, &args.first, tracker)?;
            let second = match others {
                [other] => {
                    let other = read(&finished::folder(&args.results, other)?)?;
                    pairs::side(&other, &args.second, tracker)?
                }
                _ => pairs::side(&results, &args.second, tracker)?,
            };
            rows.extend(compared(args, &mut measures, "", &first.values, &second.values));
            reason = without_common(&first.values, &second.values);
            if others.is_empty() {
                let apart = pairs::apart(&results, [(&args.first, &first), (&args.second, &second)], tracker);
                rows.extend(together(args, &mut measures, &apart.map_err(Failure::from)?));
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
            for name in pairs::names(&first).into_iter().filter(|n| pairs::names(&second).contains(n)) {
                let of = |results| pairs::side(results, &name, args.tracker.as_deref());
                rows.extend(compared(args, &mut measures, &name, &of(&first)?.values, &of(&second)?.values));
            }
        }
    }
    if let Some(wanted) =
        args.metric.as_ref().filter(|wanted| !measures.is_empty() && !measures.contains(wanted))
    {
        return Err(Failure::usage(unknown("measure", wanted, measures.iter().map(String::as_str))));
    }
    if rows.is_empty() {
        let what = args.metric.as_deref().map_or("measure".to_string(), |m| format!("measure `{m}`"));
        let message =
            format!("{} and {} have no {what} on a common sequence{reason}", args.first, args.second);
        return Err(Failure::usage(message));
    }
    let percent = args.level * 100.0;
    let (low, high) = (format!("{percent}% from"), format!("{percent}% to"));
    let headings =
        ["of", "measure", "sequences", "A", "B", "A - B", &low, &high, "A higher", "equal", "B higher", "p"];
    output::note(&format!(
        "A is {}, B is {}; means over sequences, interval by bootstrap over sequences, p of Wilcoxon's signed-rank \
         test; `pooled` and measures of frames are over all sequences together, as tables have them",
        args.first, args.second
    ));
    output::print(args.format, &headings, &rows)
}

impl From<PairsError> for Failure {
    fn from(e: PairsError) -> Self {
        match e {
            PairsError::Results(e) => e.into(),
            PairsError::Unknown(_) => Self::usage(e),
        }
    }
}

/// A row for each measure that both sides have and the user wants; all of them are added to `measures`, each once.
fn compared(
    args: &Args,
    measures: &mut Vec<String>,
    name: &str,
    first: &Values,
    second: &Values,
) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for (metric, pairs) in pairs::common(first, second) {
        if args.metric.as_ref().is_none_or(|wanted| *wanted == metric)
            && let Some(compared) = paired::compare(&pairs, args.level, args.samples as usize, args.seed)
        {
            rows.push(row(name, &metric, &compared, args.format));
        }
        if !measures.contains(&metric) {
            measures.push(metric);
        }
    }
    rows
}

/// Why two sides have nothing in common, for the end of a sentence.
fn without_common(first: &Values, second: &Values) -> String {
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

/// A row for each measure over all sequences together that the user wants; all of them are added to `measures`.
fn together(args: &Args, measures: &mut Vec<String>, all: &[Apart]) -> Vec<Vec<String>> {
    measures.extend(all.iter().map(|apart| apart.measure.clone()));
    let wanted = |apart: &&Apart| args.metric.as_ref().is_none_or(|wanted| *wanted == apart.measure);
    let row = |Apart { measure, sequences, values: [a, b], bounds }: &Apart| {
        // Their intervals are those of the tables.
        let bounds = bounds.filter(|_| args.level == 0.95);
        let difference = a.zip(*b).map(|(a, b)| a - b);
        let numbers = [*a, *b, difference, bounds.map(|b| b.0), bounds.map(|b| b.1)];
        let mut row =
            vec![String::new(), measure.clone(), sequences.map_or_else(String::new, |n| n.to_string())];
        row.extend(numbers.map(|v| v.map_or_else(String::new, |v| number(v, args.format))));
        row.extend(std::iter::repeat_n(String::new(), 4));
        row
    };
    all.iter().filter(wanted).map(row).collect()
}

fn number(v: f64, format: Format) -> String {
    if format == Format::Table { format!("{v:.4}") } else { v.to_string() }
}

fn row(name: &str, metric: &str, c: &Compared, format: Format) -> Vec<String> {
    let number = |v: f64| number(v, format);
    let mut row = vec![name.to_string(), metric.to_string(), c.pairs.to_string()];
    row.extend([c.means.0, c.means.1, c.difference, c.interval.0, c.interval.1].map(number));
    row.extend([c.signs.0, c.signs.1, c.signs.2].map(|n| n.to_string()));
    row.push(c.p.map_or_else(String::new, number));
    row
}
