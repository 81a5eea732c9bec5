//! Tests a claim with the uncertainty of its numbers.
//!
//! ```text
//! comparison  a > b        d = a - b with the 95 % interval [l, u] of d over samples of the sequences
//! holds                    every value of [l, u] satisfies it
//! does not hold            no value of [l, u] satisfies it
//! undecided                some do; or d = 0 between two measured numbers of which one is to be larger (a tie);
//!                          or there are too few sequences for an interval, or too many samples without a value
//! ```
//!
//! Both numbers are computed from the same samples, so that the difficulty of sequences cancels out of d (a
//! paired interval). If only bounds of the numbers are known, they are combined as if the numbers were
//! independent (MOVER: Zou, Donner, Statistics in Medicine 27(10), 2008); this interval is too wide for
//! methods on the same sequences. At another level it is as much wider as that of a normal number. Numbers
//! without samples and bounds are taken as exact. A sample without a value (such as a ratio with denominator
//! 0) might lie anywhere. If more than 2.5 % of the samples have none, as many as lie beyond a bound, a
//! comparison of order has no interval. Outcomes are combined by Kleene's logic: `&&` takes the worse one,
//! `||` the better one, `!` inverts it. The level is that of a single comparison; there is no correction for
//! their number.
//!
//! A missing number makes the claim untestable, never false.

use super::ClaimOutcome;
use crate::sampling::LEVEL;
use trackfail_core::num::pooled::{at_level, percentiles};
use trackfail_engine::spec::claim::{Claim, Expr, Op, Reference};

/// Differences up to this size count as rounding errors.
const EQUAL: f64 = 1e-12;

/// A number of a claim, with its uncertainty.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Value of the number.
    pub value: f64,
    /// Uncertainty that comes from the choice of sequences.
    pub spread: Spread,
}

/// Uncertainty of a number that comes from the choice of sequences.
#[derive(Debug, Clone, PartialEq)]
pub enum Spread {
    /// No uncertainty, or an unknown one: the number is taken as exact.
    Exact,
    /// Value in each sample of the sequences, NaN if it has none. All numbers of a claim have the same
    /// samples.
    Draws(Vec<f64>),
    /// Lower and upper bound of the 95 % interval.
    Bounds(f64, f64),
    /// Too few sequences to estimate the uncertainty.
    TooFew,
}

/// A comparison of a claim, with its numbers and outcome.
#[derive(Debug, Clone, PartialEq)]
pub struct Compared {
    /// Left side with the operator: `recall[DTEF] >`.
    pub left: String,
    /// Right side.
    pub right: String,
    /// Values of the left and the right side.
    pub values: [f64; 2],
    /// Bounds of left minus right; `None` without an interval.
    pub bounds: Option<(f64, f64)>,
    /// True if measured numbers are compared of which none has an interval.
    pub is_taken_as_is: bool,
    /// Outcome of the comparison.
    pub outcome: ClaimOutcome,
}

/// Outcome of a claim for one tracker.
#[derive(Debug, Clone, PartialEq)]
pub struct Judgement {
    /// Outcome with the uncertainty of the numbers.
    pub outcome: ClaimOutcome,
    /// True if the plain numbers meet the claim.
    pub is_met: bool,
    /// Comparisons in the order of the claim.
    pub compared: Vec<Compared>,
}

/// Tests a claim for one tracker with intervals of a level such as [`LEVEL`]. `measured` returns the number
/// of a reference; `None` if there is none.
///
/// # Errors
/// The reason why the claim cannot be tested.
pub fn judge(
    claim: &Claim,
    tracker: &str,
    level: f64,
    measured: &dyn Fn(&Reference) -> Option<Measured>,
) -> Result<Judgement, String> {
    let bound = |r: &Reference| {
        let mut r = r.clone();
        r.tracker.get_or_insert_with(|| tracker.to_string());
        measured(&r).ok_or_else(|| format!("{r} has no value"))
    };
    let mut compared = Vec::new();
    let (outcome, is_met) = truth(&claim.expression, level, &bound, &mut compared)?;
    Ok(Judgement { outcome, is_met, compared })
}

/// Source of the numbers of a claim.
type Numbers<'a> = &'a dyn Fn(&Reference) -> Result<Measured, String>;

/// Outcome of a part of a claim, and true if the plain numbers meet it.
fn truth(
    e: &Expr,
    level: f64,
    numbers: Numbers<'_>,
    compared: &mut Vec<Compared>,
) -> Result<(ClaimOutcome, bool), String> {
    match e {
        Expr::Not(a) => {
            let (outcome, is_met) = truth(a, level, numbers, compared)?;
            let turned = match outcome {
                ClaimOutcome::Holds => ClaimOutcome::DoesNotHold,
                ClaimOutcome::DoesNotHold => ClaimOutcome::Holds,
                other => other,
            };
            Ok((turned, !is_met))
        }
        Expr::Binary(op, a, b) if op.is_logic() => {
            let (a, a_is_met) = truth(a, level, numbers, compared)?;
            let (b, b_is_met) = truth(b, level, numbers, compared)?;
            Ok(match op {
                Op::And => (a.max(b), a_is_met && b_is_met),
                _ => (a.min(b), a_is_met || b_is_met),
            })
        }
        Expr::Binary(op, a, b) => {
            let found = compare(*op, (a, b), level, numbers)?;
            let outcome = (found.outcome, is_true(*op, found.values[0], found.values[1]));
            compared.push(found);
            Ok(outcome)
        }
        _ => Err("a claim must compare something".to_string()),
    }
}

fn is_true(op: Op, a: f64, b: f64) -> bool {
    match op {
        Op::GreaterEqual => a >= b,
        Op::LessEqual => a <= b,
        Op::Greater => a > b,
        Op::Less => a < b,
        Op::Equal => a == b,
        _ => a != b,
    }
}

fn compare(op: Op, (a, b): (&Expr, &Expr), level: f64, numbers: Numbers<'_>) -> Result<Compared, String> {
    let (left, right) = (number(a, numbers)?, number(b, numbers)?);
    let difference = combine(Op::Subtract, (&left, &right))?;
    let is_order = !matches!(op, Op::Equal | Op::NotEqual);
    let bounds = bounds(&difference, level, is_order);
    let zeroed = |d: f64| if d.abs() < EQUAL { 0.0 } else { d };
    let is_tie = is_order && a != b && measures(a) && measures(b) && zeroed(difference.value) == 0.0;
    let outcome = match bounds.map(|(low, high)| (zeroed(low), zeroed(high))) {
        _ if is_tie => ClaimOutcome::Undecided,
        None => ClaimOutcome::Undecided,
        // Where 0 lies within, equal and different are both possible.
        Some((low, high)) if !is_order && low < 0.0 && high > 0.0 => ClaimOutcome::Undecided,
        Some((low, high)) => match (is_true(op, low, 0.0), is_true(op, high, 0.0)) {
            (true, true) => ClaimOutcome::Holds,
            (false, false) => ClaimOutcome::DoesNotHold,
            _ => ClaimOutcome::Undecided,
        },
    };
    Ok(Compared {
        left: format!("{a} {}", op.sign()),
        right: b.to_string(),
        values: [left.value, right.value],
        bounds,
        is_taken_as_is: difference.spread == Spread::Exact && (measures(a) || measures(b)),
        outcome,
    })
}

/// True if a side of a comparison contains a measured number.
fn measures(e: &Expr) -> bool {
    !e.references().is_empty()
}

fn number(e: &Expr, numbers: Numbers<'_>) -> Result<Measured, String> {
    match e {
        Expr::Number(value) => Ok(Measured { value: *value, spread: Spread::Exact }),
        Expr::Value(r) => numbers(r),
        Expr::Negate(a) => {
            let zero = Measured { value: 0.0, spread: Spread::Exact };
            combine(Op::Subtract, (&zero, &number(a, numbers)?))
        }
        Expr::Binary(op, a, b) => combine(*op, (&number(a, numbers)?, &number(b, numbers)?)),
        Expr::Not(_) => Err("a comparison cannot be used as a number".to_string()),
    }
}

fn combine(op: Op, (a, b): (&Measured, &Measured)) -> Result<Measured, String> {
    let of = |a: f64, b: f64| match op {
        Op::Add => a + b,
        Op::Subtract => a - b,
        Op::Multiply => a * b,
        _ => a / b,
    };
    if op == Op::Divide && b.value == 0.0 {
        return Err("a division by 0".to_string());
    }
    // A sample without a finite value has none: a ratio whose lower part is 0 there.
    let drawn = |a: f64, b: f64| Some(of(a, b)).filter(|v| v.is_finite()).unwrap_or(f64::NAN);
    let spread = match (&a.spread, &b.spread) {
        (Spread::TooFew, _) | (_, Spread::TooFew) => Spread::TooFew,
        (Spread::Exact, Spread::Exact) => Spread::Exact,
        (Spread::Draws(x), Spread::Draws(y)) => {
            Spread::Draws(x.iter().zip(y).map(|(x, y)| drawn(*x, *y)).collect())
        }
        (Spread::Draws(x), Spread::Exact) => Spread::Draws(x.iter().map(|x| drawn(*x, b.value)).collect()),
        (Spread::Exact, Spread::Draws(y)) => Spread::Draws(y.iter().map(|y| drawn(a.value, *y)).collect()),
        _ => match (bounds(a, LEVEL, true), bounds(b, LEVEL, true)) {
            (Some(x), Some(y)) => together(op, (a.value, x), (b.value, y), of),
            _ => Spread::TooFew,
        },
    };
    Ok(Measured { value: of(a.value, b.value), spread })
}

/// Interval of the sum, difference, product or quotient of two numbers whose bounds alone are known.
fn together(
    op: Op,
    (a, x): (f64, (f64, f64)),
    (b, y): (f64, (f64, f64)),
    of: impl Fn(f64, f64) -> f64,
) -> Spread {
    let value = of(a, b);
    match op {
        Op::Add => Spread::Bounds(value - (a - x.0).hypot(b - y.0), value + (x.1 - a).hypot(y.1 - b)),
        Op::Subtract => Spread::Bounds(value - (a - x.0).hypot(y.1 - b), value + (x.1 - a).hypot(b - y.0)),
        _ => {
            let corners = [of(x.0, y.0), of(x.0, y.1), of(x.1, y.0), of(x.1, y.1)];
            let fold = |f: fn(f64, f64) -> f64| corners.into_iter().fold(value, f);
            Spread::Bounds(fold(f64::min), fold(f64::max))
        }
    }
}

/// Bounds of a number. Samples without a value are left out. If there are too many of them, a comparison of
/// `order` gets no bounds; equality, such as that of an anchor with 1, concerns only samples with a value.
/// Known bounds, which are those of 95 %, are widened as if the number were normal.
fn bounds(m: &Measured, level: f64, order: bool) -> Option<(f64, f64)> {
    match &m.spread {
        Spread::Exact => Some((m.value, m.value)),
        Spread::Draws(draws) => {
            let missing = draws.iter().filter(|draw| draw.is_nan()).count();
            let beyond = (1.0 - LEVEL) / 2.0 * draws.len() as f64;
            let is_known = !order || missing as f64 <= beyond;
            is_known.then(|| percentiles(draws.clone(), draws.len(), level)).flatten()
        }
        Spread::Bounds(low, high) => Some(at_level(m.value, (*low, *high), level)),
        Spread::TooFew => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{experiment, items};
    use ClaimOutcome::{DoesNotHold, Holds, Undecided};
    use trackfail_engine::spec::claim::Quantity;
    use trackfail_testing::assert_near;

    /// A claim about published methods, one method with a grid, two trackers and an analysis.
    fn claim(holds: &str) -> Claim {
        let level = "signal = { kind = 'rgb-histogram' }\ndetector = { kind = 'level' }";
        let grid = format!("{level}\ngrid = {{ below = [0.1, 0.5] }}");
        let model = "name = 'model'; signal.kind = 'uncertainty'; compute.kind = 'uncertainty-model'; suites = ['test']";
        let below = items("tracker", &["name = 'kcf'; label = 'Struck'"])
            + &items("analysis", &[model])
            + &items("claim", &[&format!("text = 'a'; holds = '{holds}'")]);
        experiment("", &[("DTEF", ""), ("RAW", ""), ("G", grid.as_str())], &below).claims.remove(0)
    }

    /// Subject of a number: the name of the method or finding.
    fn subject(r: &Reference) -> String {
        match &r.quantity {
            Quantity::Metric(metric, method) if metric.name() == "recall" => method.clone(),
            Quantity::Metric(..) => String::new(),
            Quantity::Finding(made) => made.to_string(),
        }
    }

    /// True if numbers without uncertainty meet a claim.
    fn met(holds: &str) -> Result<bool, String> {
        let value = |r: &Reference| match (subject(r).as_str(), r.tracker.as_deref()) {
            ("DTEF", Some("ncc")) => Some(0.7),
            ("RAW", Some("ncc")) => Some(0.4),
            ("model.components", Some("ncc")) => Some(4.0),
            ("G", Some("Struck")) if r.point == [("below".to_string(), 0.5)] => Some(0.9),
            _ => None,
        };
        let exact = |r: &Reference| Some(Measured { value: value(r)?, spread: Spread::Exact });
        judge(&claim(holds), "ncc", LEVEL, &exact).map(|judgement| judgement.is_met)
    }

    #[test]
    fn numbers_as_they_are_meet_a_claim_or_not() {
        assert_eq!(met("recall[DTEF] > recall[RAW] && recall[RAW] == 0.4"), Ok(true));
        assert_eq!(met("recall[DTEF] - recall[RAW] * 2 < 0"), Ok(true));
        assert_eq!(met("(recall[DTEF] - recall[RAW]) * 2 < 0"), Ok(false));
        assert_eq!(met("1 > 2 || 1 < 2 && 3 != 3"), Ok(false));
        assert_eq!(met("!(1 > 2)"), Ok(true));
        assert_eq!(met("finding[model.components] == 4"), Ok(true));
        assert_eq!(met("recall[DTEF] >= recall[DTEF] && 2 <= 2"), Ok(true));
        assert_eq!(met("recall[G, below=0.5, Struck] >= -.5 + 1.4"), Ok(true));
    }

    #[test]
    fn a_missing_number_is_untestable() {
        assert_eq!(met("precision[RAW] > 0"), Err("precision[RAW, ncc] has no value".to_string()));
        assert_eq!(met("1 / (recall[RAW] - 0.4) > 0"), Err("a division by 0".to_string()));
    }

    /// Outcome for paired samples of `recall[DTEF]` and `recall[RAW]`.
    fn tested(text: &str, dtef: &[f64], raw: &[f64]) -> Result<ClaimOutcome, String> {
        let mean = |draws: &[f64]| draws.iter().sum::<f64>() / draws.len() as f64;
        let measured = |r: &Reference| match &r.quantity {
            Quantity::Metric(_, m) if m == "DTEF" => Some((dtef, mean(dtef))),
            Quantity::Metric(_, m) if m == "RAW" => Some((raw, mean(raw))),
            _ => None,
        };
        let of = |(draws, value): (&[f64], f64)| Measured { value, spread: Spread::Draws(draws.to_vec()) };
        judge(&claim(text), "ncc", LEVEL, &|r| measured(r).map(of)).map(|judgement| judgement.outcome)
    }

    fn judged(text: &str, dtef: &[f64], raw: &[f64]) -> ClaimOutcome {
        tested(text, dtef, raw).unwrap()
    }

    #[test]
    fn verdicts_know_uncertainty_by_hand() {
        // Both move together: their difference is .1 to .2 in all samples although their ranges overlap.
        let (a, b) = ([0.3, 0.5, 0.8, 0.9], [0.2, 0.3, 0.7, 0.7]);
        assert_eq!(judged("recall[DTEF] > recall[RAW]", &a, &b), Holds);
        assert_eq!(judged("recall[DTEF] <= recall[RAW]", &a, &b), DoesNotHold);
        assert_eq!(judged("recall[DTEF] - 0.15 > recall[RAW]", &a, &b), Undecided);
        assert_eq!(judged("!(recall[RAW] > recall[DTEF])", &a, &b), Holds);
        // By Kleene's logic an undecided part decides nothing.
        let (holds, open) = ("recall[DTEF] > recall[RAW]", "recall[DTEF] - 0.15 > recall[RAW]");
        assert_eq!(judged(&format!("{holds} && {open}"), &a, &b), Undecided);
        assert_eq!(judged(&format!("{holds} || {open}"), &a, &b), Holds);
        assert_eq!(judged(&format!("{open} && recall[RAW] > 0.9"), &a, &b), DoesNotHold);
        // Ties are undecided between measured numbers, not against a constant or of a number with itself.
        assert_eq!(judged("recall[DTEF] >= recall[RAW]", &a, &a), Undecided);
        assert_eq!(judged("recall[DTEF] >= recall[DTEF]", &a, &a), Holds);
        assert_eq!(judged("recall[DTEF] == 1", &[1.0; 4], &a), Holds);
        assert_eq!(judged("recall[DTEF] == 1", &[1.0, 1.0, 1.0, 0.5], &a), Undecided);
        assert_eq!(judged("recall[DTEF] == 1", &a, &a), DoesNotHold);
        assert_eq!(judged("recall[DTEF] != 1", &a, &a), Holds);
        // A sample without a value might lie anywhere: as few as lie beyond a bound are left out, more leave no interval.
        let missing = |n: usize| [vec![f64::NAN; n], vec![0.5; 80 - n]].concat();
        assert_eq!(judged("recall[DTEF] > 0", &missing(2), &[0.1; 80]), Holds);
        assert_eq!(judged("recall[DTEF] > 0", &missing(3), &[0.1; 80]), Undecided);
        assert!(tested("recall[DTEF] > recall[G]", &a, &a).is_err());
        // Equality is a matter of the samples that have a value.
        let ones = [vec![f64::NAN; 9], vec![1.0; 71]].concat();
        assert_eq!(judged("recall[DTEF] == 1", &ones, &[0.1; 80]), Holds);
        // So are samples whose ratio has no value.
        let raw = [vec![0.0; 2], vec![0.3; 78]].concat();
        assert_eq!(judged("recall[DTEF] / recall[RAW] > 1", &[0.5; 80], &raw), Holds);
        let raw = [vec![0.0; 3], vec![0.3; 77]].concat();
        assert_eq!(judged("recall[DTEF] / recall[RAW] > 1", &[0.5; 80], &raw), Undecided);
    }

    #[test]
    fn bounds_without_samples_are_combined_as_if_independent() {
        let of = |r: &Reference| {
            let dtef = matches!(&r.quantity, Quantity::Metric(_, m) if m == "DTEF");
            let (value, low, high) = if dtef { (0.9, 0.86, 0.93) } else { (0.8, 0.77, 0.83) };
            Some(Measured { value, spread: Spread::Bounds(low, high) })
        };
        let at = |level, text| judge(&claim(text), "ncc", level, &of).unwrap();
        let order = "recall[DTEF] > recall[RAW]";
        // .1 - sqrt(.04^2 + .03^2) and .1 + sqrt(.03^2 + .03^2). SciPy's norm.ppf: at 99.9 % they are wider by
        // 3.290527 / 1.959964.
        for (level, wider, within) in [(LEVEL, 1.0, 1e-12), (0.999, 1.678_871, 1e-6)] {
            let (low, high) = at(level, order).compared[0].bounds.unwrap();
            assert_near([low, high], [0.1 - 0.05 * wider, 0.1 + 0.0018_f64.sqrt() * wider], within, level);
        }
        let decided = [0.68, LEVEL].map(|level| at(level, "recall[DTEF] > recall[RAW] + 0.06").outcome);
        assert_eq!(decided, [Holds, Undecided]);
        let Judgement { outcome, compared, .. } = at(LEVEL, order);
        assert_eq!(outcome, Holds);
        assert_eq!([&compared[0].left, &compared[0].right], ["recall[DTEF] >", "recall[RAW]"]);
    }
}
