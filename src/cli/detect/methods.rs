//! Methods to run: named by the user, recommended for the inputs, or all that the inputs allow.

use super::Args;
use crate::cli::Failure;
use crate::method::{self, Inputs, Method, MethodError};
use crate::signal::Reads;

/// Methods that the user names, checked.
pub fn named(args: &Args) -> Result<Vec<Method>, Failure> {
    let mut methods: Vec<Method> = Vec::new();
    let of_tier = args.tier.map(|tier| tier.method());
    for name in args.method.iter().map(String::as_str).chain(of_tier) {
        if methods.iter().any(|earlier| earlier.name == name) {
            return Err(Failure::usage(format!("method `{name}` is given twice")));
        }
        methods.push(of_name(args, name)?);
    }
    Ok(methods)
}

/// Methods that can run with the inputs: those that are named; with `--all`, those without unmet needs; else the
/// recommended one. `need` returns a further need that a method has. A method that must run and has one is refused, and
/// `hint` ends the message.
pub fn ready(
    args: &Args,
    named: Vec<Method>,
    inputs: Inputs,
    need: impl Fn(&Method) -> Option<&'static str>,
    hint: impl Fn() -> String,
) -> Result<Vec<Method>, Failure> {
    let recommended = method::recommended(inputs, args.budget);
    if args.all {
        let mut methods = all(args.budget, recommended)?;
        methods.retain(|method| need(method).is_none());
        return Ok(methods);
    }
    let must_run = if named.is_empty() { vec![of_name(args, recommended)?] } else { named };
    let refused = must_run.iter().find_map(|method| Some((method, need(method)?)));
    match refused {
        Some((method, need)) => Err(Failure::usage(format!("method `{}` {need}{}", method.name, hint()))),
        None => Ok(must_run),
    }
}

/// All methods that need no training, with `first` at the start; with a budget, those that accept one.
fn all(budget: Option<f64>, first: &'static str) -> Result<Vec<Method>, Failure> {
    let others = method::names().into_iter().filter(|name| *name != first);
    let mut methods = Vec::new();
    for name in std::iter::once(first).chain(others) {
        match Method::named(name, budget.filter(|_| method::takes_budget(name))) {
            Ok(method) => methods.push(method),
            Err(MethodError::Trained(_)) => {}
            Err(e) => return Err(Failure::usage(e)),
        }
    }
    Ok(methods)
}

fn of_name(args: &Args, name: &str) -> Result<Method, Failure> {
    Method::named(name, args.budget).map_err(Failure::usage)
}

/// Methods that can judge boxes with the given inputs.
pub fn on_boxes(args: &Args, named: Vec<Method>) -> Result<Vec<Method>, Failure> {
    let inputs = Inputs {
        frames: !args.frames.is_empty(),
        companions: !args.companion.is_empty(),
        confidence: args.confidence.is_some(),
    };
    let need = |method: &Method| {
        let detector = &method.detector.detector;
        match method.reads().find(|reads| !inputs.has(*reads)) {
            Some(Reads::Pixels) => Some("needs frames; give --frames"),
            Some(Reads::Companions) => Some("needs other trackers' boxes; give --companion"),
            Some(Reads::Confidence) => Some("needs the tracker's confidence; give --confidence"),
            None if detector.learner().is_none() && !detector.facts().needs_reverse => None,
            _ => Some("needs more of a tracker than boxes; give --init instead of --boxes"),
        }
    };
    let hint = || {
        let all = method::names().into_iter().filter_map(|name| Method::named(name, None).ok());
        let names: Vec<String> = all.filter(|method| need(method).is_none()).map(|m| m.name).collect();
        format!(". Methods that need only what is given: {}", names.join(", "))
    };
    ready(args, named, inputs, need, hint)
}
