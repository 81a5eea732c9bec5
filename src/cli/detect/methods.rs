//! The methods that run: named, recommended for the inputs, or all that the inputs allow.

use super::Args;
use crate::cli::Failure;
use crate::plugin;
use crate::spec::builtin::{self, Inputs};
use crate::spec::method::{DetectorChoice, FixedDetector, Method, SignalChoice, Variant};

/// A method with its detector.
pub struct ReadyMethod {
    pub method: Method,
    pub detector: FixedDetector,
}

impl ReadyMethod {
    /// Its signals; `None` for a method without one.
    pub fn signals(&self) -> Vec<Option<&SignalChoice>> {
        let more = self.method.variants.iter().take(1).flat_map(|v| &v.more_signals).map(Some);
        let first = self.method.variants.first().and_then(|v| v.signal.as_ref());
        std::iter::once(first).chain(more).collect()
    }

    /// Its signals and its detector, with their parameters.
    pub fn words(&self) -> String {
        let signals =
            self.signals().into_iter().flatten().map(|s| format!("{} {}", s.kind, s.signal.params()));
        let detector = format!("{} {}", self.detector.kind, self.detector.detector.params());
        signals.chain([detector]).collect::<Vec<_>>().join("; ")
    }
}

/// The signals of each method, one after the other; `None` for methods without one.
pub fn signals_of(methods: &[ReadyMethod]) -> Vec<Option<&SignalChoice>> {
    methods.iter().flat_map(ReadyMethod::signals).collect()
}

/// Methods that the user asks for.
pub enum Wanted {
    /// These.
    Named(Vec<Method>),
    /// The one that the benchmark recommends.
    Recommended,
    /// All that the inputs allow.
    All,
}

impl Wanted {
    /// The methods, the recommended one first, and whether each of them has to run.
    pub fn methods(self, args: &Args, inputs: Inputs) -> Result<(Vec<Method>, bool), Failure> {
        let recommended = match args.budget {
            Some(_) => builtin::recommended_with_budget(inputs),
            None => builtin::recommended(inputs),
        };
        match self {
            Self::Named(methods) => Ok((methods, true)),
            Self::Recommended => Ok((vec![published(args, recommended)?], true)),
            Self::All => {
                let others = builtin::method_names().into_iter().filter(|name| *name != recommended);
                let names = std::iter::once(recommended).chain(others);
                Ok((names.map(|name| published(args, name)).collect::<Result<_, _>>()?, false))
            }
        }
    }
}

/// Methods that the user asks for, checked.
pub fn wanted(args: &Args) -> Result<Wanted, Failure> {
    let known = builtin::method_names();
    for (k, name) in args.method.iter().enumerate() {
        if !known.contains(&name.as_str()) {
            return Err(Failure::usage(plugin::unknown("method", name, known.iter().copied())));
        }
        if args.method.iter().take(k).any(|earlier| earlier == name) {
            return Err(Failure::usage(format!("method `{name}` is given twice")));
        }
        if args.budget.is_some() && !builtin::takes_budget(name) {
            return Err(no_budget(name));
        }
    }
    Ok(match (args.all, args.method.is_empty()) {
        (true, _) => Wanted::All,
        (_, true) => Wanted::Recommended,
        _ => Wanted::Named(args.method.iter().map(|name| published(args, name)).collect::<Result<_, _>>()?),
    })
}

/// Why a method cannot keep to a budget.
fn no_budget(name: &str) -> Failure {
    let takers = builtin::methods_with_budget();
    let takers = if takers.is_empty() { "none".to_string() } else { takers.join(", ") };
    Failure::usage(format!("method `{name}` takes no --budget. Methods that take one: {takers}"))
}

/// A published method, with the budget if it takes one.
fn published(args: &Args, name: &str) -> Result<Method, Failure> {
    let method = match args.budget {
        Some(budget) if builtin::takes_budget(name) => {
            let method = builtin::published_method_with_budget(name, budget);
            return method.map_or_else(|| Err(unpublished(name)), |m| m.map_err(Failure::usage));
        }
        Some(_) if !args.all => return Err(no_budget(name)),
        _ => builtin::published_method(name),
    };
    method.map_or_else(|| Err(unpublished(name)), |m| m.map_err(Failure::io))
}

fn unpublished(name: &str) -> Failure {
    Failure::io(format!("no published method is named `{name}`"))
}

/// The methods that can judge boxes with what else is given.
pub fn on_boxes(args: &Args, wanted: Wanted) -> Result<Vec<ReadyMethod>, Failure> {
    let inputs = Inputs {
        frames: !args.frames.is_empty(),
        companions: !args.companion.is_empty(),
        confidence: args.confidence.is_some(),
    };
    let (methods, must_run) = wanted.methods(args, inputs)?;
    let mut ready = Vec::new();
    for method in methods {
        match method.variants.first().map(|v| (fits(v, inputs), &v.detector)) {
            Some((true, DetectorChoice::Given(fixed))) => {
                let detector = fixed.clone();
                ready.push(ReadyMethod { method, detector });
            }
            _ if must_run => return Err(refuse(&method, inputs)),
            _ => {}
        }
    }
    Ok(ready)
}

fn fits(variant: &Variant, inputs: Inputs) -> bool {
    let given = variant.signals().all(|s| inputs.has(s.signal.reads()));
    given && matches!(variant.detector, DetectorChoice::Given(_)) && !variant.detector.needs_reverse()
}

/// Why a method cannot judge boxes with what is given.
fn refuse(method: &Method, inputs: Inputs) -> Failure {
    let variant = method.variants.first();
    let lacking =
        variant.and_then(|v| v.signals().map(|s| s.signal.reads()).find(|reads| !inputs.has(*reads)));
    let remedy = match lacking {
        Some(crate::signal::Reads::Pixels) => "needs frames; give --frames".to_string(),
        Some(crate::signal::Reads::Companions) => "needs other trackers' boxes; give --companion".to_string(),
        Some(crate::signal::Reads::Confidence) => {
            "needs the tracker's confidence; give --confidence".to_string()
        }
        _ => "needs more of a tracker than boxes; give --init instead of --boxes".to_string(),
    };
    let published =
        builtin::method_names().into_iter().filter_map(|name| builtin::published_method(name)?.ok());
    let can = |m: &Method| m.variants.first().is_some_and(|v| fits(v, inputs));
    let names: Vec<String> = published.filter(can).map(|m| m.name).collect();
    Failure::usage(format!(
        "method `{}` {remedy}. Methods that need only what is given: {}",
        method.name,
        names.join(", ")
    ))
}
