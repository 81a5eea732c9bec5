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
//! Both numbers are computed again from the same samples, so that what all methods find hard cancels out of d (a paired
//! interval). Numbers of which the bounds alone are known are added and subtracted as if they were independent (MOVER:
//! Zou, Donner, Statistics in Medicine 27(10), 2008), which is too wide for methods on the same sequences; numbers
//! without either are taken as they are. A sample without a value, such as a ratio whose lower part is 0 there, might lie
//! anywhere: where there are more of them than lie beyond a bound, 2.5 %, a comparison of order has no interval. Outcomes are joined by Kleene's logic: `&&` takes the worse one, `||` the
//! better one, `!` turns it. The level is that of each comparison by itself; nothing corrects for their number.

use super::parse::LEVELS;
use super::{Claim, ClaimVerdict, Expr, Op, Reference};
use trackfail_core::num::pooled::percentiles;

/// Level of the intervals that reports show.
pub const LEVEL: f64 = 0.95;

/// Differences this close to 0 are rounding.
const EQUAL: f64 = 1e-12;

/// A number of a claim.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// The number.
    pub value: f64,
    /// How far other sequences might move it.
    pub spread: Spread,
}

/// How far other sequences of the same kind might move a number.
#[derive(Debug, Clone, PartialEq)]
pub enum Spread {
    /// Not at all, or nobody knows: it is taken as it is.
    Exact,
    /// Its value for each sample of the sequences, NaN where it has none; the same samples for all numbers of a claim.
    Draws(Vec<f64>),
    /// The bounds of its 95 % interval.
    Bounds(f64, f64),
    /// There are too few sequences to tell.
    TooFew,
}

/// A comparison of a claim.
#[derive(Debug, Clone, PartialEq)]
pub struct Compared {
    /// Its left side, with the sign: `recall[DTEF] >`.
    pub left: String,
    /// Its right side.
    pub right: String,
    /// The numbers of both sides.
    pub values: [f64; 2],
    /// The bounds of left minus right.
    pub bounds: Option<(f64, f64)>,
    /// The outcome.
    pub verdict: ClaimVerdict,
}

/// Outcome of a claim for one tracker.
#[derive(Debug, Clone, PartialEq)]
pub struct Judgement {
    /// The outcome.
    pub verdict: ClaimVerdict,
    /// Its comparisons, in the order of the claim.
    pub compared: Vec<Compared>,
}

impl Claim {
    /// Tests the claim for one tracker, as far as the sequences can tell with intervals of a level such as [`LEVEL`];
    /// `measured` gives the number of a reference, if there is one.
    pub fn judge(
        &self,
        tracker: &str,
        level: f64,
        measured: &dyn Fn(&Reference) -> Option<Measured>,
    ) -> Judgement {
        let bound = |r: &Reference| {
            let mut r = r.clone();
            r.tracker.get_or_insert_with(|| tracker.to_string());
            measured(&r).ok_or_else(|| format!("{r} has no value"))
        };
        let mut compared = Vec::new();
        let numbers = Numbers { level, of: &bound };
        let verdict = truth(&self.expression, &numbers, &mut compared);
        Judgement { verdict: verdict.unwrap_or_else(ClaimVerdict::Untestable), compared }
    }
}

/// The numbers of a claim, and the level of their intervals.
struct Numbers<'a> {
    level: f64,
    of: &'a dyn Fn(&Reference) -> Result<Measured, String>,
}

fn truth(e: &Expr, numbers: &Numbers<'_>, compared: &mut Vec<Compared>) -> Result<ClaimVerdict, String> {
    let rank = |v: &ClaimVerdict| match v {
        ClaimVerdict::Fails => 0,
        ClaimVerdict::Holds => 2,
        _ => 1,
    };
    match e {
        Expr::Not(a) => Ok(match truth(a, numbers, compared)? {
            ClaimVerdict::Holds => ClaimVerdict::Fails,
            ClaimVerdict::Fails => ClaimVerdict::Holds,
            other => other,
        }),
        Expr::Binary(op, a, b) if op.is_logic() => {
            let (a, b) = (truth(a, numbers, compared)?, truth(b, numbers, compared)?);
            let takes_first = if *op == Op::And { rank(&a) <= rank(&b) } else { rank(&a) >= rank(&b) };
            Ok(if takes_first { a } else { b })
        }
        Expr::Binary(op, a, b) => {
            let found = compare(*op, (a, b), numbers)?;
            let verdict = found.verdict.clone();
            compared.push(found);
            Ok(verdict)
        }
        _ => Err("a claim must compare something".to_string()),
    }
}

fn compare(op: Op, (a, b): (&Expr, &Expr), numbers: &Numbers<'_>) -> Result<Compared, String> {
    let (left, right) = (number(a, numbers)?, number(b, numbers)?);
    let difference = combine(Op::Subtract, (&left, &right), numbers.level)?;
    let is_order = !matches!(op, Op::Equal | Op::NotEqual);
    let bounds = bounds(&difference, numbers.level, is_order);
    let zeroed = |d: f64| if d.abs() < EQUAL { 0.0 } else { d };
    let is_true = |d: f64| match op {
        Op::GreaterEqual => d >= 0.0,
        Op::LessEqual => d <= 0.0,
        Op::Greater => d > 0.0,
        Op::Less => d < 0.0,
        Op::Equal => d == 0.0,
        _ => d != 0.0,
    };
    let is_tie = is_order && a != b && measures(a) && measures(b) && zeroed(difference.value) == 0.0;
    let verdict = match bounds.map(|(low, high)| (zeroed(low), zeroed(high))) {
        _ if is_tie => ClaimVerdict::Undecided,
        None => ClaimVerdict::Undecided,
        // Where 0 lies within, equal and different are both possible.
        Some((low, high)) if !is_order && low < 0.0 && high > 0.0 => ClaimVerdict::Undecided,
        Some((low, high)) => match (is_true(low), is_true(high)) {
            (true, true) => ClaimVerdict::Holds,
            (false, false) => ClaimVerdict::Fails,
            _ => ClaimVerdict::Undecided,
        },
    };
    let left_side = format!("{a} {}", op.sign());
    let values = [left.value, right.value];
    Ok(Compared { left: left_side, right: b.to_string(), values, bounds, verdict })
}

/// Whether a side of a comparison has a number that was measured.
fn measures(e: &Expr) -> bool {
    let mut found = Vec::new();
    super::collect(e, &mut found);
    !found.is_empty()
}

fn number(e: &Expr, numbers: &Numbers<'_>) -> Result<Measured, String> {
    match e {
        Expr::Number(value) => Ok(Measured { value: *value, spread: Spread::Exact }),
        Expr::Value(r) => (numbers.of)(r),
        Expr::Negate(a) => {
            let zero = Measured { value: 0.0, spread: Spread::Exact };
            combine(Op::Subtract, (&zero, &number(a, numbers)?), numbers.level)
        }
        Expr::Binary(op, a, b) => combine(*op, (&number(a, numbers)?, &number(b, numbers)?), numbers.level),
        Expr::Not(_) => Err("a comparison cannot be used as a number".to_string()),
    }
}

fn combine(op: Op, (a, b): (&Measured, &Measured), level: f64) -> Result<Measured, String> {
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
        _ => match (bounds(a, level, true), bounds(b, level, true)) {
            (Some(x), Some(y)) => together(op, (a.value, x), (b.value, y), of),
            _ => Spread::TooFew,
        },
    };
    Ok(Measured { value: of(a.value, b.value), spread })
}

/// The bounds of two numbers of which no more than the bounds are known.
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

/// The bounds of a number. Samples without a value are left out; too many of them leave none where the `order` of two
/// numbers is asked for, while equality, such as that of an anchor with 1, is a matter of the samples that have a value.
/// Bounds that are known alone stay as they are, whatever the level.
fn bounds(m: &Measured, level: f64, order: bool) -> Option<(f64, f64)> {
    match &m.spread {
        Spread::Exact => Some((m.value, m.value)),
        Spread::Draws(draws) => {
            let missing = draws.iter().filter(|draw| draw.is_nan()).count();
            let beyond = (1.0 - LEVEL) / 2.0 * draws.len() as f64;
            let is_known = !order || missing as f64 <= beyond;
            is_known.then(|| percentiles(draws.clone(), draws.len(), level)).flatten()
        }
        Spread::Bounds(low, high) => Some((*low, *high)),
        Spread::TooFew => None,
    }
}

impl Op {
    fn sign(self) -> &'static str {
        let mut all = LEVELS.iter().copied().flatten();
        all.find(|(_, op)| *op == self).map_or("", |(sign, _)| *sign)
    }
}

impl std::fmt::Display for Expr {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let inner = |e: &Self| match e {
            Self::Binary(..) => format!("({e})"),
            e => e.to_string(),
        };
        match self {
            Self::Number(v) => write!(f, "{v}"),
            Self::Value(r) => write!(f, "{r}"),
            Self::Negate(a) => write!(f, "-{}", inner(a)),
            Self::Not(a) => write!(f, "!{}", inner(a)),
            Self::Binary(op, a, b) => write!(f, "{} {} {}", inner(a), op.sign(), inner(b)),
        }
    }
}
