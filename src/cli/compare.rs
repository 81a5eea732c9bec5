//! `trackfail compare A B --in EXPERIMENT [--in EXPERIMENT]`, or of two results folders: `trackfail compare DIR DIR`

use super::Failure;
use super::output::{self, Format};
use crate::num::paired;
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
    let named = |name: &String| read(&finished::folder(&args.results, name)?);
    let tracker = args.tracker.as_deref();
    let (mut compared, mut reason) = (Comparison::new(args), String::new());
    match args.experiments.as_slice() {
        [name, others @ ..] if others.len() <= 1 => {
            let results = named(name)?;
            let other = others.first().map(named).transpose()?;
            let first = pairs::side(&results, &args.first, tracker)?;
            let second = pairs::side(other.as_ref().unwrap_or(&results), &args.second, tracker)?;
            compared.add_sequences("", &first.values, &second.values);
            reason = without_common(&first.values, &second.values);
            if other.is_none() {
                let sides = [(args.first.as_str(), &first), (args.second.as_str(), &second)];
                compared.add_pooled(&pairs::apart(&results, sides, tracker)?);
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
                let of = |results| pairs::side(results, &name, tracker);
                compared.add_sequences(&name, &of(&first)?.values, &of(&second)?.values);
            }
        }
    }
    let Comparison { measures, rows, .. } = compared;
    if let Some(wanted) = args.metric.as_ref().filter(|w| !measures.is_empty() && !measures.contains(w)) {
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

/// The measures that both sides have.
struct Comparison<'a> {
    args: &'a Args,
    /// All of them, each once.
    measures: Vec<String>,
    /// A row for each that the user wants.
    rows: Vec<Vec<String>>,
}

impl<'a> Comparison<'a> {
    fn new(args: &'a Args) -> Self {
        Self { args, measures: Vec::new(), rows: Vec::new() }
    }

    /// Adds the measures of single sequences.
    fn add_sequences(&mut self, name: &str, first: &Values, second: &Values) {
        let Args { level, samples, seed, .. } = *self.args;
        for (measure, pairs) in pairs::common(first, second) {
            let compared = || paired::compare(&pairs, level, samples as usize, seed);
            if let Some(c) = self.wants(&measure).then(compared).flatten() {
                let means = [c.means.0, c.means.1, c.difference, c.interval.0, c.interval.1].map(Some);
                let signs = [c.signs.0, c.signs.1, c.signs.2].map(|n| n.to_string());
                self.rows.push(self.row([name, &measure], Some(c.pairs), means, signs, c.p));
            }
            if !self.measures.contains(&measure) {
                self.measures.push(measure);
            }
        }
    }

    /// Adds the measures over all sequences together.
    fn add_pooled(&mut self, all: &[Apart]) {
        for Apart { measure, sequences, values: [a, b], bounds } in all {
            self.measures.push(measure.clone());
            if self.wants(measure) {
                // Their intervals are those of the tables.
                let bounds = bounds.filter(|_| self.args.level == 0.95);
                let difference = a.zip(*b).map(|(a, b)| a - b);
                let numbers = [*a, *b, difference, bounds.map(|b| b.0), bounds.map(|b| b.1)];
                self.rows.push(self.row(["", measure], *sequences, numbers, Default::default(), None));
            }
        }
    }

    fn wants(&self, measure: &str) -> bool {
        self.args.metric.as_ref().is_none_or(|wanted| wanted == measure)
    }

    fn row(
        &self,
        names: [&str; 2],
        sequences: Option<usize>,
        numbers: [Option<f64>; 5],
        signs: [String; 3],
        p: Option<f64>,
    ) -> Vec<String> {
        let number = |value: Option<f64>| match (value, self.args.format) {
            (None, _) => String::new(),
            (Some(value), Format::Table) => format!("{value:.4}"),
            (Some(value), _) => value.to_string(),
        };
        let count = sequences.map_or_else(String::new, |n| n.to_string());
        let head = names.map(str::to_string).into_iter().chain([count]);
        head.chain(numbers.map(number)).chain(signs).chain([number(p)]).collect()
    }
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
