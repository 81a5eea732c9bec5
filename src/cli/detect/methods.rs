//! Methods to run: named by the user, recommended for the inputs, or all that the inputs allow.

use super::Args;
use crate::cli::Failure;
use crate::method::{self, Inputs, Method, MethodError};
use crate::signal::Reads;

/// Methods that the user requests.
pub enum Wanted {
    /// Methods named by the user.
    Named(Vec<Method>),
    /// The method that the benchmark recommends for the inputs.
    Recommended,
    /// All methods that the inputs allow.
    All,
}

impl Wanted {
    /// Checks the methods that the user requests.
    pub fn of(args: &Args) -> Result<Self, Failure> {
        let mut methods: Vec<Method> = Vec::new();
        let of_tier = args.tier.map(|tier| tier.method());
        for name in args.method.iter().map(String::as_str).chain(of_tier) {
            if methods.iter().any(|earlier| earlier.name == name) {
                return Err(Failure::usage(format!("method `{name}` is given twice")));
            }
            methods.push(named(args, name)?);
        }
        Ok(match (args.all, methods.is_empty()) {
            (true, _) => Self::All,
            (_, true) => Self::Recommended,
            _ => Self::Named(methods),
        })
    }

    /// Methods that can run with the inputs, the recommended one first. `need` returns a further need that a
    /// method has. With `All`, methods with unmet needs are left out. A method that must run is refused
    /// instead, and `hint` ends the message.
    pub fn ready(
        self,
        args: &Args,
        inputs: Inputs,
        need: impl Fn(&Method) -> Option<&'static str>,
        hint: impl Fn() -> String,
    ) -> Result<Vec<Method>, Failure> {
        let recommended = method::recommended(inputs, args.budget);
        let must_run = match self {
            Self::Named(methods) => methods,
            Self::Recommended => vec![named(args, recommended)?],
            Self::All => {
                let mut methods = all(args.budget, recommended)?;
                methods.retain(|method| need(method).is_none());
                return Ok(methods);
            }
        };
        let refused = must_run.iter().find_map(|method| Some((method, need(method)?)));
        match refused {
            Some((method, need)) => Err(Failure::usage(format!("method `{}` {need}{}", method.name, hint()))),
            None => Ok(must_run),
        }
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

fn named(args: &Args, name: &str) -> Result<Method, Failure> {
    Method::named(name, args.budget).map_err(Failure::usage)
}

/// Methods that can judge boxes with the given inputs.
pub fn on_boxes(args: &Args, wanted: Wanted) -> Result<Vec<Method>, Failure> {
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
            None if detector.learner().is_none() && !detector.needs_reverse() => None,
            _ => Some("needs more of a tracker than boxes; give --init instead of --boxes"),
        }
    };
    let hint = || {
        let all = method::names().into_iter().filter_map(|name| Method::named(name, None).ok());
        let names: Vec<String> = all.filter(|method| need(method).is_none()).map(|m| m.name).collect();
        format!(". Methods that need only what is given: {}", names.join(", "))
    };
    wanted.ready(args, inputs, need, hint)
}
