//! Claims of a paper, each a predicate over our numbers: `recall[DTEF] >= recall[NAIVE] && fpr[RAW] < 0.05`.
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
//! `for all length: recall[ARTE*] > recall[ARTE]` is the claim at each value of the axis `length`. A method
//! with this axis in its grid uses that value, unless the claim gives another.
//!
//! A metric is pooled over the test suite; a finding is a number that an analysis computes. A claim that names no
//! tracker is tested for every tracker.

mod parse;

use super::error::At;
use super::table::{FindingName, Words};
use super::wire;
use parse::{Fault, parse};
use trackfail_methods::score::Metric;

/// A checked claim.
#[derive(Debug, Clone, PartialEq)]
pub struct Claim {
    /// Conclusion in words.
    pub text: String,
    /// The predicate as written.
    pub predicate: String,
    /// True if a run must meet the claim.
    pub required: bool,
    /// Parsed predicate.
    pub expression: Expr,
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
    /// Metric or finding.
    pub quantity: Quantity,
    /// Label of the tracker; `None` to test each tracker.
    pub tracker: Option<String>,
    /// Values of grid axes, by name.
    pub point: Vec<(String, f64)>,
}

impl Reference {
    /// Fixes an axis of the grid at a value.
    fn set(&mut self, axis: &str, value: f64) {
        self.point.push((axis.to_string(), value));
        self.point.sort_by(|a, b| a.0.cmp(&b.0));
    }
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

/// An expression of a claim. The parser ensures that truth values and numbers are not mixed.
#[derive(Debug, Clone, PartialEq)]
pub enum Expr {
    /// A literal number.
    Number(f64),
    /// A measured number.
    Value(Reference),
    /// `-a`.
    Negate(Box<Expr>),
    /// `!a`.
    Not(Box<Expr>),
    /// Two expressions joined by an operator.
    Binary(Op, Box<Expr>, Box<Expr>),
}

/// A binary operator. Operators that bind tighter are larger.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Op {
    /// `||`.
    Or,
    /// `&&`.
    And,
    /// `>=`.
    GreaterEqual,
    /// `<=`.
    LessEqual,
    /// `==`.
    Equal,
    /// `!=`.
    NotEqual,
    /// `>`.
    Greater,
    /// `<`.
    Less,
    /// `+`.
    Add,
    /// `-`.
    Subtract,
    /// `*`.
    Multiply,
    /// `/`.
    Divide,
}

impl Op {
    /// All operators with how tightly they bind. If one begins with another, the longer comes first.
    const ALL: [(&str, Self, usize); 12] = [
        ("||", Self::Or, 0),
        ("&&", Self::And, 1),
        (">=", Self::GreaterEqual, 2),
        ("<=", Self::LessEqual, 2),
        ("==", Self::Equal, 2),
        ("!=", Self::NotEqual, 2),
        (">", Self::Greater, 2),
        ("<", Self::Less, 2),
        ("+", Self::Add, 3),
        ("-", Self::Subtract, 3),
        ("*", Self::Multiply, 4),
        ("/", Self::Divide, 4),
    ];

    /// The operator as written in a claim.
    pub fn sign(self) -> &'static str {
        Self::ALL[self as usize].0
    }

    /// True for the operators that join comparisons.
    pub fn is_logic(self) -> bool {
        matches!(self, Self::Or | Self::And)
    }
}

impl Expr {
    fn is_truth(&self) -> bool {
        match self {
            Self::Not(_) => true,
            Self::Binary(op, ..) => *op < Op::Add,
            _ => false,
        }
    }

    /// Numbers that the expression refers to, in order, without repetitions.
    pub fn references(&self) -> Vec<&Reference> {
        let mut found = Vec::new();
        self.collect(&mut found);
        found
    }

    fn collect<'a>(&'a self, found: &mut Vec<&'a Reference>) {
        match self {
            Self::Number(_) => {}
            Self::Value(r) if found.contains(&r) => {}
            Self::Value(r) => found.push(r),
            Self::Negate(a) | Self::Not(a) => a.collect(found),
            Self::Binary(_, a, b) => {
                a.collect(found);
                b.collect(found);
            }
        }
    }

    /// Applies `how` to all references.
    fn change(&mut self, how: &mut dyn FnMut(&mut Reference)) {
        match self {
            Self::Number(_) => {}
            Self::Value(r) => how(r),
            Self::Negate(a) | Self::Not(a) => a.change(how),
            Self::Binary(_, a, b) => {
                a.change(how);
                b.change(how);
            }
        }
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

/// Checks a `[[claim]]`.
pub(super) fn read(at: At<'_>, wire: &wire::Claim, words: &Words) -> Option<Claim> {
    let (text, predicate) = (wire.text.clone(), wire.holds.clone());
    let tell = |fault: Fault| at.key("holds").tell_part(&predicate, fault.word, fault.message);
    let expression = parse(&predicate, words).map_err(|faults| faults.into_iter().for_each(tell)).ok()?;
    Some(Claim { text, predicate, required: wire.required, expression })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use toml::de::DeTable;
    use trackfail_methods::analysis::Names;

    fn words() -> Words {
        let text = "tracker = [{ name = 'ncc' }, { name = 'Struck' }]
            method = [{ name = 'DTEF' }, { name = 'RAW', grid.width = [1] }, { name = 'ARTE*', grid.length = [5, 1] }]";
        let numbers = vec!["components".to_string()];
        let analyses = vec![("model".to_string(), Some(Names { numbers, ..Names::default() }))];
        Words { analyses, ..Words::of(DeTable::parse(text).unwrap().get_ref()) }
    }

    #[track_caller]
    fn same(short: &str, long: &str) {
        assert_eq!(parse(short, &words()).unwrap(), parse(long, &words()).unwrap(), "{short}");
    }

    #[test]
    fn signs_bind_as_usual() {
        same("1 > 2 || 1 < 2 && 3 != 3", "(1 > 2) || ((1 < 2) && (3 != 3))");
        same("1 - 2 - 3 * 4 / 5 < 0", "((1 - 2) - ((3 * 4) / 5)) < 0");
        same("-1 * 2>=-.5+1.4", "((-1) * 2) >= ((-0.5) + 1.4)");
        let text = "!(recall[ARTE*, length=5, Struck] - 2 > -(1 + finding[model.components]))";
        let shown = "!((recall[ARTE*, length=5, Struck] - 2) > -(1 + finding[model.components]))";
        assert_eq!(parse(text, &words()).unwrap().to_string(), shown);
        for (k, (sign, op, _)) in Op::ALL.into_iter().enumerate() {
            assert_eq!((op as usize, op.sign()), (k, sign));
        }
    }

    #[test]
    fn for_all_stands_for_the_claim_at_each_value() {
        same(
            "for all length: recall[ARTE*] > recall[RAW] && fpr[ARTE*] < 1",
            "(recall[ARTE*, length=1] > recall[RAW] && fpr[ARTE*, length=1] < 1)
                && (recall[ARTE*, length=5] > recall[RAW] && fpr[ARTE*, length=5] < 1)",
        );
        same(
            "for all length in 5: recall[ARTE*, length=1] <= recall[ARTE*, Struck]",
            "recall[ARTE*, length=1] <= recall[ARTE*, length=5, Struck]",
        );
        same(
            "for all length in 5, 1, 5: recall[ARTE*] > 0",
            "recall[ARTE*, length=5] > 0 && recall[ARTE*, length=1] > 0",
        );
        same("1 < 2 || (for all length in 1: recall[ARTE*] > 0)", "1 < 2 || recall[ARTE*, length=1] > 0");
    }

    #[test]
    fn what_is_wrong_is_told_and_words_name_the_nearest() {
        let fault = |text: &str| parse(text, &words()).unwrap_err().remove(0).message;
        for (text, message) in [
            ("recal[DTEF] > 0", "unknown metric `recal`; did you mean `recall`?"),
            (
                "finding[model.component] > 0",
                "unknown finding `model.component`; did you mean `model.components`?",
            ),
            ("recall[DTFE] > 0", "unknown method `DTFE`; did you mean `DTEF`?"),
            ("recall[RAW, lenght=5] > 0", "unknown grid axis `lenght`; did you mean `length`?"),
            ("for all lenght: recall[ARTE*] > 0", "unknown grid axis `lenght`; did you mean `length`?"),
            ("for all length: recall[RAW] > 0", "nothing in the claim varies with `length`"),
            (
                "for all length: for all length: recall[ARTE*] > 0",
                "`for all length` changes nothing: the claim behind it gives `length` already",
            ),
            ("for all width: recall[ARTE*] > 0", "nothing in the claim varies with `width`"),
            ("for all length in 5, 7: recall[ARTE*] > 0", "no grid has length = 7; there are 1, 5"),
            ("for all length recall[ARTE*] > 0", "a `:` is missing after `for all AXIS`"),
        ] {
            assert_eq!(fault(text), message, "{text}");
        }
        assert!(fault("recall[RAW]").starts_with("a claim must compare"));
        assert!(fault("for all length: recall[ARTE*]").contains("comparison"));
        assert!(fault("1 < 2 < 3").contains("join"));
        assert!(fault(&"(".repeat(2000)).contains("too deeply"));
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
