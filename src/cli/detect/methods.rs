//! The methods that run: named, recommended for the inputs, or all that the inputs allow.

use super::Args;
use crate::cli::Failure;
use crate::signal::Reads;
use trackfail_judge::method::{self, Inputs, Method, MethodError};

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
            Some(_) => method::recommended_with_budget(inputs),
            None => method::recommended(inputs),
        };
        match self {
            Self::Named(methods) => Ok((methods, true)),
            Self::Recommended => Ok((vec![named(args, recommended)?], true)),
            Self::All => {
                let others = method::names().into_iter().filter(|name| *name != recommended);
                let mut methods = Vec::new();
                for name in std::iter::once(recommended).chain(others) {
                    let budget = args.budget.filter(|_| method::takes_budget(name));
                    match Method::named(name, budget) {
                        Ok(method) => methods.push(method),
                        Err(MethodError::Trained(_)) => {}
                        Err(e) => return Err(Failure::usage(e)),
                    }
                }
                Ok((methods, false))
            }
        }
    }
}

/// Methods that the user asks for, checked.
pub fn wanted(args: &Args) -> Result<Wanted, Failure> {
    let mut methods: Vec<Method> = Vec::new();
    let of_tier = args.tier.map(|tier| tier.method());
    for name in args.method.iter().map(String::as_str).chain(of_tier) {
        if methods.iter().any(|earlier| earlier.name == name) {
            return Err(Failure::usage(format!("method `{name}` is given twice")));
        }
        methods.push(named(args, name)?);
    }
    Ok(match (args.all, methods.is_empty()) {
        (true, _) => Wanted::All,
        (_, true) => Wanted::Recommended,
        _ => Wanted::Named(methods),
    })
}

fn named(args: &Args, name: &str) -> Result<Method, Failure> {
    Method::named(name, args.budget).map_err(Failure::usage)
}

/// The methods that can judge boxes with what else is given.
pub fn on_boxes(args: &Args, wanted: Wanted) -> Result<Vec<Method>, Failure> {
    let inputs = Inputs {
        frames: !args.frames.is_empty(),
        companions: !args.companion.is_empty(),
        confidence: args.confidence.is_some(),
    };
    let (methods, must_run) = wanted.methods(args, inputs)?;
    let mut ready = Vec::new();
    for method in methods {
        match fits(&method, inputs) {
            true => ready.push(method),
            false if must_run => return Err(refuse(&method, inputs)),
            false => {}
        }
    }
    Ok(ready)
}

fn fits(method: &Method, inputs: Inputs) -> bool {
    let detector = &method.detector.detector;
    method.reads().all(|reads| inputs.has(reads)) && detector.learner().is_none() && !detector.needs_reverse()
}

/// Why a method cannot judge boxes with what is given.
fn refuse(method: &Method, inputs: Inputs) -> Failure {
    let remedy = match method.reads().find(|reads| !inputs.has(*reads)) {
        Some(Reads::Pixels) => "needs frames; give --frames",
        Some(Reads::Companions) => "needs other trackers' boxes; give --companion",
        Some(Reads::Confidence) => "needs the tracker's confidence; give --confidence",
        _ => "needs more of a tracker than boxes; give --init instead of --boxes",
    };
    let all = method::names().into_iter().filter_map(|name| Method::named(name, None).ok());
    let names: Vec<String> = all.filter(|method| fits(method, inputs)).map(|method| method.name).collect();
    Failure::usage(format!(
        "method `{}` {remedy}. Methods that need only what is given: {}",
        method.name,
        names.join(", ")
    ))
}
