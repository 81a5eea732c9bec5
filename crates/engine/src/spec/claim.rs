//! Conclusions as predicates over our numbers: `recall[DTEF] >= recall[NAIVE] && fpr[RAW] < 0.05`.
//!
//! ```text
//! claim  = "for all" axis [ "in" number { "," number } ] ":" claim | or
//! or     = and { "||" and }          and    = not { "&&" not }        not = "!" not | compare
//! compare = sum [ (">=" | "<=" | ">" | "<" | "==" | "!=") sum ]
//! sum    = term { ("+" | "-") term } term   = factor { ("*" | "/") factor }
//! factor = number | "-" factor | "(" claim ")" | metric "[" METHOD { "," TRACKER | axis "=" number } "]"
//!        | "finding" "[" ANALYSIS "." NUMBER { "," TRACKER } "]"
//! ```
//!
//! `for all length: recall[ARTE*] > recall[ARTE]` stands for the claim at each value of the axis: the methods that have
//! it in their grid take that value, where they do not name one.
//!
//! A metric is pooled over the test suite; a finding is a number that an analysis computes. A claim that names no
//! tracker is tested for every tracker. A missing value makes the claim untestable, never false. Whether a comparison
//! can be told from chance is judged by [`Claim::judge`].

mod judge;
mod parse;

use super::error::At;
use super::table::{FindingName, Words};
use super::wire;
pub use judge::{Compared, Judgement, LEVEL, Measured, Spread};
use parse::parse;
use trackfail_methods::score::Metric;

/// A checked conclusion.
#[derive(Debug, Clone, PartialEq)]
pub struct Claim {
    /// In words.
    pub text: String,
    /// The predicate as written.
    pub predicate: String,
    /// Whether a run must meet it.
    pub required: bool,
    expression: Expr,
}

/// Kind of a number in a claim.
#[derive(Debug, Clone, PartialEq)]
pub enum Quantity {
    /// A pooled metric of a method.
    Metric(Metric, String),
    /// A number that an analysis computes.
    Finding(FindingName),
}

/// A number in a claim.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// The metric or finding.
    pub quantity: Quantity,
    /// Label of the tracker; `None` for every tracker in turn.
    pub tracker: Option<String>,
    /// Grid axis -> value.
    pub point: Vec<(String, f64)>,
}

impl std::fmt::Display for Reference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.quantity {
            Quantity::Metric(metric, method) => write!(f, "{}[{method}", metric.name())?,
            Quantity::Finding(made) => write!(f, "finding[{made}")?,
        }
        for (axis, value) in &self.point {
            write!(f, ", {axis}={value}")?;
        }
        if let Some(tracker) = &self.tracker {
            write!(f, ", {tracker}")?;
        }
        write!(f, "]")
    }
}

/// Outcome of testing a claim on the measured numbers.
#[derive(Debug, Clone, PartialEq)]
pub enum ClaimVerdict {
    /// The predicate is true.
    Holds,
    /// Other sequences of the same kind might as well make it true as false.
    Undecided,
    /// It is false.
    Fails,
    /// A number it needs has no value.
    Untestable(String),
}

#[derive(Debug, Clone, PartialEq)]
enum Expr {
    Number(f64),
    Value(Reference),
    Negate(Box<Expr>),
    Not(Box<Expr>),
    Binary(Op, Box<Expr>, Box<Expr>),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Op {
    Or,
    And,
    GreaterEqual,
    LessEqual,
    Greater,
    Less,
    Equal,
    NotEqual,
    Add,
    Subtract,
    Multiply,
    Divide,
}

impl Op {
    fn is_logic(self) -> bool {
        matches!(self, Self::Or | Self::And)
    }

    fn is_comparison(self) -> bool {
        !self.is_logic() && !matches!(self, Self::Add | Self::Subtract | Self::Multiply | Self::Divide)
    }
}

impl Claim {
    /// Tests the claim on the numbers as they are, for one tracker; `value` gives the number of a reference, if there
    /// is one. No outcome is undecided.
    pub fn test(&self, tracker: &str, value: &dyn Fn(&Reference) -> Option<f64>) -> ClaimVerdict {
        let bound = |r: &Reference| {
            let mut r = r.clone();
            r.tracker.get_or_insert_with(|| tracker.to_string());
            value(&r).ok_or_else(|| format!("{r} has no value"))
        };
        match eval(&self.expression, &bound) {
            Ok(v) if v != 0.0 => ClaimVerdict::Holds,
            Ok(_) => ClaimVerdict::Fails,
            Err(reason) => ClaimVerdict::Untestable(reason),
        }
    }

    /// Whether it is tested for each tracker separately.
    pub fn is_per_tracker(&self) -> bool {
        self.references().iter().any(|r| r.tracker.is_none())
    }

    /// The numbers it refers to, in order, each once.
    pub fn references(&self) -> Vec<&Reference> {
        let mut found = Vec::new();
        collect(&self.expression, &mut found);
        found
    }
}

fn collect<'a>(e: &'a Expr, found: &mut Vec<&'a Reference>) {
    match e {
        Expr::Number(_) => {}
        Expr::Value(r) if found.contains(&r) => {}
        Expr::Value(r) => found.push(r),
        Expr::Negate(a) | Expr::Not(a) => collect(a, found),
        Expr::Binary(_, a, b) => {
            collect(a, found);
            collect(b, found);
        }
    }
}

/// Value of an expression. True is 1 and false is 0; the parser has kept truth values and numbers apart.
fn eval(e: &Expr, value: &dyn Fn(&Reference) -> Result<f64, String>) -> Result<f64, String> {
    let truth = |b: bool| f64::from(u8::from(b));
    Ok(match e {
        Expr::Number(v) => *v,
        Expr::Value(r) => value(r)?,
        Expr::Negate(a) => -eval(a, value)?,
        Expr::Not(a) => truth(eval(a, value)? == 0.0),
        Expr::Binary(op, a, b) => {
            let (a, b) = (eval(a, value)?, eval(b, value)?);
            match op {
                Op::Or => truth(a != 0.0 || b != 0.0),
                Op::And => truth(a != 0.0 && b != 0.0),
                Op::GreaterEqual => truth(a >= b),
                Op::LessEqual => truth(a <= b),
                Op::Greater => truth(a > b),
                Op::Less => truth(a < b),
                Op::Equal => truth(a == b),
                Op::NotEqual => truth(a != b),
                Op::Add => a + b,
                Op::Subtract => a - b,
                Op::Multiply => a * b,
                Op::Divide if b == 0.0 => return Err("a division by 0".to_string()),
                Op::Divide => a / b,
            }
        }
    })
}

/// Checks a `[[claim]]`.
pub(super) fn read(at: At<'_>, wire: &wire::Claim, words: &Words) -> Option<Claim> {
    let (text, predicate) = (wire.text.clone(), wire.holds.clone());
    match parse(&predicate, words) {
        Ok(expression) => Some(Claim { text, predicate, required: wire.required, expression }),
        Err(faults) => {
            let at = at.key("holds");
            faults.into_iter().for_each(|fault| at.tell_part(&predicate, fault.word, fault.message));
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::table::GridAxis;
    use proptest::prelude::*;
    use trackfail_methods::analysis::Names;

    fn words() -> Words {
        let own = |w: &[&str]| w.iter().map(|s| s.to_string()).collect();
        Words {
            methods: own(&["DTEF", "RAW", "ARTE*"]),
            trackers: own(&["ncc", "Struck"]),
            axes: own(&["length", "width"]),
            grids: vec![GridAxis { method: "ARTE*".into(), axis: "length".into(), values: vec![5.0, 1.0] }],
            analyses: vec![(
                "model".into(),
                Some(Names { numbers: own(&["components"]), ..Names::default() }),
            )],
            ..Words::default()
        }
    }

    fn verdict(text: &str) -> ClaimVerdict {
        let expression = parse(text, &words()).unwrap();
        let claim = Claim { text: String::new(), predicate: text.into(), required: false, expression };
        let subject = |r: &Reference| match &r.quantity {
            Quantity::Metric(metric, method) if *metric == Metric::RECALL => method.clone(),
            Quantity::Metric(..) => String::new(),
            Quantity::Finding(made) => made.to_string(),
        };
        claim.test("ncc", &|r| match (subject(r).as_str(), r.tracker.as_deref()) {
            ("DTEF", Some("ncc")) => Some(0.7),
            ("RAW", Some("ncc")) => Some(0.4),
            ("model.components", Some("ncc")) => Some(4.0),
            ("ARTE*", Some("Struck")) if r.point == [("length".to_string(), 5.0)] => Some(0.9),
            _ => None,
        })
    }

    #[test]
    fn precedence_and_comparisons() {
        assert_eq!(verdict("recall[DTEF] > recall[RAW] && recall[RAW] == 0.4"), ClaimVerdict::Holds);
        assert_eq!(verdict("recall[DTEF] - recall[RAW] * 2 < 0"), ClaimVerdict::Holds);
        assert_eq!(verdict("(recall[DTEF] - recall[RAW]) * 2 < 0"), ClaimVerdict::Fails);
        assert_eq!(verdict("1 > 2 || 1 < 2 && 3 != 3"), ClaimVerdict::Fails);
        assert_eq!(verdict("!(1 > 2)"), ClaimVerdict::Holds);
        assert_eq!(verdict("finding[model.components] == 4"), ClaimVerdict::Holds);
        assert_eq!(verdict("recall[ARTE*, length=5, Struck] >= -.5 + 1.4"), ClaimVerdict::Holds);
    }

    #[test]
    fn for_all_stands_for_the_claim_at_each_value() {
        let same = |short: &str, long: &str| {
            assert_eq!(parse(short, &words()).unwrap(), parse(long, &words()).unwrap(), "{short}");
        };
        same(
            "for all length: recall[ARTE*] > recall[RAW] && fpr[ARTE*] < 1",
            "(recall[ARTE*, length=1] > recall[RAW] && fpr[ARTE*, length=1] < 1)
                && (recall[ARTE*, length=5] > recall[RAW] && fpr[ARTE*, length=5] < 1)",
        );
        same(
            "for all length in 5: recall[ARTE*, length=1] <= recall[ARTE*, Struck]",
            "recall[ARTE*, length=1] <= recall[ARTE*, length=5, Struck]",
        );
        same("1 < 2 || (for all length in 1: recall[ARTE*] > 0)", "1 < 2 || recall[ARTE*, length=1] > 0");
        let e = |text: &str| parse(text, &words()).unwrap_err().remove(0).message;
        assert_eq!(
            e("for all lenght: recall[ARTE*] > 0"),
            "unknown grid axis `lenght`; did you mean `length`?"
        );
        assert_eq!(e("for all length: recall[RAW] > 0"), "nothing in the claim varies with `length`");
        assert_eq!(
            e("for all length: for all length: recall[ARTE*] > 0"),
            "`for all length` changes nothing: the claim behind it gives `length` already"
        );
        assert_eq!(e("for all width: recall[ARTE*] > 0"), "nothing in the claim varies with `width`");
        assert_eq!(e("for all length in 5, 7: recall[ARTE*] > 0"), "no grid has length = 7; there are 1, 5");
        assert_eq!(e("for all length recall[ARTE*] > 0"), "a `:` is missing after `for all AXIS`");
        assert!(e("for all length: recall[ARTE*]").contains("comparison"));
    }

    /// The verdict for draws of recall[DTEF] and recall[RAW] that are paired.
    fn judged(text: &str, dtef: &[f64], raw: &[f64]) -> ClaimVerdict {
        let expression = parse(text, &words()).unwrap();
        let claim = Claim { text: String::new(), predicate: text.into(), required: false, expression };
        let mean = |draws: &[f64]| draws.iter().sum::<f64>() / draws.len() as f64;
        let measured = |r: &Reference| match &r.quantity {
            Quantity::Metric(_, m) if m == "DTEF" => Some((dtef, mean(dtef))),
            Quantity::Metric(_, m) if m == "RAW" => Some((raw, mean(raw))),
            _ => None,
        };
        let of = |(draws, value): (&[f64], f64)| Measured { value, spread: Spread::Draws(draws.to_vec()) };
        claim.judge("ncc", LEVEL, &|r| measured(r).map(of)).verdict
    }

    #[test]
    fn verdicts_know_uncertainty_by_hand() {
        use ClaimVerdict::{Fails, Holds, Undecided, Untestable};
        // Both move together: their difference is .1 to .2 in all samples although their ranges overlap.
        let (a, b) = ([0.3, 0.5, 0.8, 0.9], [0.2, 0.3, 0.7, 0.7]);
        assert_eq!(judged("recall[DTEF] > recall[RAW]", &a, &b), Holds);
        assert_eq!(judged("recall[DTEF] <= recall[RAW]", &a, &b), Fails);
        assert_eq!(judged("recall[DTEF] - 0.15 > recall[RAW]", &a, &b), Undecided);
        assert_eq!(judged("!(recall[RAW] > recall[DTEF])", &a, &b), Holds);
        // By Kleene's logic an undecided part decides nothing.
        let (holds, open) = ("recall[DTEF] > recall[RAW]", "recall[DTEF] - 0.15 > recall[RAW]");
        assert_eq!(judged(&format!("{holds} && {open}"), &a, &b), Undecided);
        assert_eq!(judged(&format!("{holds} || {open}"), &a, &b), Holds);
        assert_eq!(judged(&format!("{open} && recall[RAW] > 0.9"), &a, &b), Fails);
        // Ties are undecided between measured numbers, not against a constant or of a number with itself.
        assert_eq!(judged("recall[DTEF] >= recall[RAW]", &a, &a), Undecided);
        assert_eq!(judged("recall[DTEF] >= recall[DTEF]", &a, &a), Holds);
        assert_eq!(judged("recall[DTEF] == 1", &[1.0; 4], &a), Holds);
        assert_eq!(judged("recall[DTEF] == 1", &[1.0, 1.0, 1.0, 0.5], &a), Undecided);
        assert_eq!(judged("recall[DTEF] == 1", &a, &a), Fails);
        assert_eq!(judged("recall[DTEF] != 1", &a, &a), Holds);
        // A sample without a value might lie anywhere: as few as lie beyond a bound are left out, more leave no interval.
        let missing = |n: usize| [vec![f64::NAN; n], vec![0.5; 80 - n]].concat();
        assert_eq!(judged("recall[DTEF] > 0", &missing(2), &[0.1; 80]), Holds);
        assert_eq!(judged("recall[DTEF] > 0", &missing(3), &[0.1; 80]), Undecided);
        assert!(matches!(judged("recall[DTEF] > recall[ARTE*]", &a, &a), Untestable(_)));
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
        let text = "recall[DTEF] > recall[RAW]";
        let expression = parse(text, &words()).unwrap();
        let claim = Claim { text: String::new(), predicate: text.into(), required: false, expression };
        let of = |r: &Reference| {
            let dtef = matches!(&r.quantity, Quantity::Metric(_, m) if m == "DTEF");
            let (value, low, high) = if dtef { (0.9, 0.86, 0.93) } else { (0.8, 0.77, 0.83) };
            Some(Measured { value, spread: Spread::Bounds(low, high) })
        };
        let judgement = claim.judge("ncc", LEVEL, &of);
        // .1 - sqrt(.04^2 + .03^2) and .1 + sqrt(.03^2 + .03^2).
        let (low, high) = judgement.compared[0].bounds.unwrap();
        assert!((low - 0.05).abs() < 1e-12 && (high - (0.1 + 0.0018_f64.sqrt())).abs() < 1e-12);
        assert_eq!(judgement.verdict, ClaimVerdict::Holds);
        assert_eq!(
            (judgement.compared[0].left.as_str(), judgement.compared[0].right.as_str()),
            ("recall[DTEF] >", "recall[RAW]")
        );
    }

    #[test]
    fn a_missing_number_is_untestable() {
        let reason = "precision[RAW, ncc] has no value".to_string();
        assert_eq!(verdict("precision[RAW] > 0"), ClaimVerdict::Untestable(reason));
        assert!(matches!(verdict("1 / (recall[RAW] - 0.4) > 0"), ClaimVerdict::Untestable(_)));
    }

    #[test]
    fn wrong_words_name_the_nearest() {
        let e = |text: &str| parse(text, &words()).unwrap_err().remove(0).message;
        assert_eq!(e("recal[DTEF] > 0"), "unknown metric `recal`; did you mean `recall`?");
        assert_eq!(
            e("finding[model.component] > 0"),
            "unknown finding `model.component`; did you mean `model.components`?"
        );
        assert_eq!(e("recall[DTFE] > 0"), "unknown method `DTFE`; did you mean `DTEF`?");
        assert_eq!(e("recall[RAW, lenght=5] > 0"), "unknown grid axis `lenght`; did you mean `length`?");
        assert!(e("recall[RAW]").starts_with("a claim must compare"));
        assert!(e("1 < 2 < 3").contains("join"));
        assert!(e(&"(".repeat(2000)).contains("too deeply"));
    }

    #[test]
    fn all_unknown_words_are_told_with_their_places() {
        let text = "for all lenght: recal[DTEF, nc] > 0 && finding[model.x] > recall[RWA]";
        let faults = parse(text, &words()).unwrap_err();
        let places: Vec<&str> = faults.iter().map(|fault| &text[fault.word.clone().unwrap()]).collect();
        assert_eq!(places, ["lenght", "recal", "nc", "model.x", "RWA"]);
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in "[a-zA-Z0-9_\\[\\]()<>=!&|+*/., -]{0,80}") {
            let _ = parse(&text, &words());
        }
    }
}
