//! Conclusions as predicates over our numbers: `recall[DTEF] >= recall[NAIVE] && fpr[RAW] < 0.05`.
//!
//! ```text
//! claim  = and { "||" and }          and    = not { "&&" not }        not = "!" not | compare
//! compare = sum [ (">=" | "<=" | ">" | "<" | "==" | "!=") sum ]
//! sum    = term { ("+" | "-") term } term   = factor { ("*" | "/") factor }
//! factor = number | "-" factor | "(" claim ")" | metric "[" METHOD { "," TRACKER | axis "=" number } "]"
//!        | "finding" "[" ANALYSIS "." NUMBER { "," TRACKER } "]"
//! ```
//!
//! A metric is pooled over the test suite; a finding is a number that an analysis computes. A claim that names no
//! tracker is tested for every tracker. A missing value makes the claim untestable, never false.

use super::error::{Source, SpecError};
use super::table::{FindingName, Words};
use super::wire;
use crate::plugin::unknown;
use crate::score::Metric;

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
    /// Tests the claim for one tracker; `value` gives the number of a reference, if there is one.
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
pub(super) fn read(source: Source<'_>, wire: &wire::Claim, words: &Words) -> Result<Claim, SpecError> {
    let predicate = wire.holds.get_ref().clone();
    let expression = parse(&predicate, words).map_err(|m| source.error(wire.holds.span(), m))?;
    Ok(Claim { text: wire.text.clone(), predicate, required: wire.required, expression })
}

fn parse(text: &str, words: &Words) -> Result<Expr, String> {
    if text.len() > 4096 {
        return Err("a claim has at most 4096 characters".to_string());
    }
    let mut parser = Parser { rest: text, words, depth: 0 };
    let e = parser.binary(0)?;
    if !parser.rest.trim_start().is_empty() {
        return Err(format!("cannot read the claim from `{}` on", parser.rest.trim_start()));
    }
    if !is_truth(&e) {
        return Err("a claim must compare something, e.g. `recall[DTEF] > recall[RAW]`".to_string());
    }
    Ok(e)
}

fn is_truth(e: &Expr) -> bool {
    match e {
        Expr::Not(_) => true,
        Expr::Binary(op, ..) => op.is_logic() || op.is_comparison(),
        _ => false,
    }
}

/// Operators, those that bind tighter last; where one spelling begins with another, the longer comes first.
const LEVELS: [&[(&str, Op)]; 5] = [
    &[("||", Op::Or)],
    &[("&&", Op::And)],
    &[
        (">=", Op::GreaterEqual),
        ("<=", Op::LessEqual),
        ("==", Op::Equal),
        ("!=", Op::NotEqual),
        (">", Op::Greater),
        ("<", Op::Less),
    ],
    &[("+", Op::Add), ("-", Op::Subtract)],
    &[("*", Op::Multiply), ("/", Op::Divide)],
];

/// Deepest nesting of a claim, so that a hostile one cannot exhaust the stack.
const MAX_DEPTH: usize = 64;

struct Parser<'a> {
    rest: &'a str,
    words: &'a Words,
    depth: usize,
}

impl Parser<'_> {
    fn take(&mut self, token: &str) -> bool {
        match self.rest.trim_start().strip_prefix(token) {
            Some(rest) => {
                self.rest = rest;
                true
            }
            None => false,
        }
    }

    fn binary(&mut self, level: usize) -> Result<Expr, String> {
        let Some(operators) = LEVELS.get(level) else { return self.factor() };
        let mut left = self.binary(level + 1)?;
        while let Some((_, op)) = operators.iter().find(|(token, _)| self.take(token)) {
            let right = self.binary(level + 1)?;
            let wants_truth = op.is_logic();
            if is_truth(&left) != wants_truth || is_truth(&right) != wants_truth {
                return Err("`&&` and `||` join comparisons; the other signs join numbers".to_string());
            }
            left = Expr::Binary(*op, Box::new(left), Box::new(right));
        }
        Ok(left)
    }

    fn factor(&mut self) -> Result<Expr, String> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err("the claim is nested too deeply".to_string());
        }
        let e = self.factor_inner();
        self.depth -= 1;
        e
    }

    fn factor_inner(&mut self) -> Result<Expr, String> {
        if self.take("(") {
            let e = self.binary(0)?;
            return if self.take(")") { Ok(e) } else { Err("a `)` is missing".to_string()) };
        }
        if self.take("!") {
            let e = self.factor()?;
            return if is_truth(&e) {
                Ok(Expr::Not(Box::new(e)))
            } else {
                Err("`!` stands before a comparison in brackets".to_string())
            };
        }
        if self.take("-") {
            let e = self.factor()?;
            return if is_truth(&e) {
                Err("`-` stands before a number".to_string())
            } else {
                Ok(Expr::Negate(Box::new(e)))
            };
        }
        let text = self.rest.trim_start();
        let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '.';
        let end = text.find(|c| !is_word(c)).unwrap_or(text.len());
        let (word, rest) = text.split_at(end);
        self.rest = rest;
        if word.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
            return word.parse().map(Expr::Number).map_err(|_| format!("`{word}` is not a number"));
        }
        if word.is_empty() {
            return Err(format!("a number or a metric is missing before `{text}`"));
        }
        let metric = match word {
            "finding" => None,
            word => Some(Metric::from_name(word).ok_or_else(|| unknown("metric", word, Metric::names()))?),
        };
        if !self.take("[") {
            return Err(format!("`{word}` needs a method, e.g. `{word}[DTEF]`"));
        }
        let Some((inside, rest)) = self.rest.split_once(']') else {
            return Err("a `]` is missing".to_string());
        };
        self.rest = rest;
        self.reference(metric, inside).map(Expr::Value)
    }

    fn reference(&self, metric: Option<Metric>, inside: &str) -> Result<Reference, String> {
        let mut parts = inside.split(',').map(str::trim);
        let subject = parts.next().unwrap_or_default().to_string();
        let quantity = match metric {
            None => {
                Quantity::Finding(self.words.finding(&subject, |n| &n.numbers).map_err(|e| e.to_string())?)
            }
            Some(_) if !self.words.methods.contains(&subject) => {
                return Err(unknown("method", &subject, self.words.methods.iter().map(String::as_str)));
            }
            Some(metric) => Quantity::Metric(metric, subject),
        };
        let mut r = Reference { quantity, tracker: None, point: Vec::new() };
        for part in parts {
            if let Some((axis, value)) = part.split_once('=').filter(|_| metric.is_some()) {
                let axis = axis.trim().to_string();
                if !self.words.axes.contains(&axis) {
                    return Err(unknown("grid axis", &axis, self.words.axes.iter().map(String::as_str)));
                }
                let value = value.trim().parse().map_err(|_| format!("`{part}` has no number"))?;
                r.point.push((axis, value));
            } else if self.words.trackers.iter().any(|t| t == part) {
                r.tracker = Some(part.to_string());
            } else {
                return Err(unknown("tracker", part, self.words.trackers.iter().map(String::as_str)));
            }
        }
        r.point.sort_by(|a, b| a.0.cmp(&b.0));
        Ok(r)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::Names;
    use proptest::prelude::*;

    fn words() -> Words {
        let own = |w: &[&str]| w.iter().map(|s| s.to_string()).collect();
        Words {
            methods: own(&["DTEF", "RAW", "ARTE*"]),
            trackers: own(&["ncc", "Struck"]),
            axes: own(&["length"]),
            sequences: vec![],
            drawn: vec![],
            with_signal: vec![],
            analyses: vec![("model".into(), Names { numbers: own(&["components"]), ..Names::default() })],
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
    fn a_missing_number_is_untestable() {
        let reason = "precision[RAW, ncc] has no value".to_string();
        assert_eq!(verdict("precision[RAW] > 0"), ClaimVerdict::Untestable(reason));
        assert!(matches!(verdict("1 / (recall[RAW] - 0.4) > 0"), ClaimVerdict::Untestable(_)));
    }

    #[test]
    fn wrong_words_name_the_nearest() {
        let e = |text: &str| parse(text, &words()).unwrap_err();
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

    proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in "[a-zA-Z0-9_\\[\\]()<>=!&|+*/., -]{0,80}") {
            let _ = parse(&text, &words());
        }
    }
}
