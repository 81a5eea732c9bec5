//! Parser of claims.

use super::super::table::{FindingName, Words};
use super::{Expr, Op, Quantity, Reference};
use std::collections::BTreeSet;
use std::ops::Range;
use trackfail_core::plugin::unknown;
use trackfail_methods::score::Metric;

/// Most claims that a `for all` may expand to.
const MAX_EXPANDED: usize = 256;
/// Deepest nesting of a claim. A hostile file could exhaust the stack otherwise.
const MAX_DEPTH: usize = 64;

/// An error in a claim.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Fault {
    pub message: String,
    /// Range of the wrong word in the claim; `None` if the error is not in a single word.
    pub word: Option<Range<usize>>,
}

/// Parses a claim.
///
/// # Errors
/// All unknown words, and the first syntax error.
pub(super) fn parse(text: &str, words: &Words) -> Result<Expr, Vec<Fault>> {
    let fault = |message: String| Fault { message, word: None };
    if text.len() > 4096 {
        return Err(vec![fault("a claim has at most 4096 characters".to_string())]);
    }
    let mut parser = Parser { text, rest: text, words, depth: 0, unknown: Vec::new() };
    let read = parser.whole();
    let mut faults = parser.unknown;
    match read {
        Ok(e) if faults.is_empty() => return Ok(e),
        Ok(_) => {}
        Err(message) => faults.push(fault(message)),
    }
    Err(faults)
}

/// Returns the expression if it is a truth value (or, with `is_truth` false, a number), otherwise an error.
fn typed(e: Expr, is_truth: bool, otherwise: &str) -> Result<Expr, String> {
    if e.is_truth() == is_truth { Ok(e) } else { Err(otherwise.to_string()) }
}

struct Parser<'a> {
    text: &'a str,
    rest: &'a str,
    words: &'a Words,
    depth: usize,
    /// Unknown words so far. Parsing continues as if they were known.
    unknown: Vec<Fault>,
}

impl<'a> Parser<'a> {
    fn whole(&mut self) -> Result<Expr, String> {
        let e = self.quantified()?;
        match self.rest.trim_start() {
            "" => typed(e, true, "a claim must compare something, e.g. `recall[DTEF] > recall[RAW]`"),
            rest => Err(format!("cannot read the claim from `{rest}` on")),
        }
    }

    /// Records an error in a word, which is a part of the text.
    fn wrong(&mut self, word: &str, message: String) {
        let start = word.as_ptr().addr() - self.text.as_ptr().addr();
        self.unknown.push(Fault { message, word: Some(start..start + word.len()) });
    }

    /// Records an error if a word is not among the known ones.
    fn check(&mut self, what: &str, word: &str, known: &[String]) {
        if known.iter().all(|known| known != word) {
            self.wrong(word, unknown(what, word, known.iter().map(String::as_str)));
        }
    }

    fn take(&mut self, token: &str) -> bool {
        let rest = self.rest.trim_start().strip_prefix(token);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    /// Text up to a sign; the sign is consumed.
    fn up_to(&mut self, sign: char, missing: &str) -> Result<&'a str, String> {
        let (before, rest) = self.rest.split_once(sign).ok_or(missing)?;
        self.rest = rest;
        Ok(before)
    }

    /// Parses a nested part, with a limit on the depth.
    fn deeper(&mut self, read: fn(&mut Self) -> Result<Expr, String>) -> Result<Expr, String> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err("the claim is nested too deeply".to_string());
        }
        let e = read(self)?;
        self.depth -= 1;
        Ok(e)
    }

    /// Parses `for all AXIS: claim`, `for all AXIS in 1, 5: claim`, or a claim without a quantifier.
    fn quantified(&mut self) -> Result<Expr, String> {
        if !self.rest.trim_start().starts_with("for ") {
            return self.binary(0);
        }
        self.take("for");
        if !self.take("all") {
            return Err("`for` begins `for all AXIS: ...`".to_string());
        }
        let head = self.up_to(':', "a `:` is missing after `for all AXIS`")?;
        let (axis, chosen) = match head.trim().split_once(" in ") {
            Some((axis, list)) => (axis.trim(), Some(numbers(list)?)),
            None => (head.trim(), None),
        };
        self.check("grid axis", axis, &self.words.axes);
        let body = typed(self.deeper(Self::quantified)?, true, "`for all` stands before a comparison")?;
        // What varies with the axis is known of known words only.
        if self.unknown.is_empty() { self.for_all(axis, chosen, &body) } else { Ok(body) }
    }

    /// Joins the claims for each value of the axis: the `chosen` values, or all in the grids of the methods
    /// that are mentioned.
    fn for_all(&self, axis: &str, chosen: Option<Vec<f64>>, body: &Expr) -> Result<Expr, String> {
        let references = body.references();
        let free: Vec<&[f64]> = references.iter().filter_map(|r| self.varies(r, axis)).collect();
        if free.is_empty() {
            let is_given = references.iter().any(|r| r.point.iter().any(|(given, _)| given == axis));
            return Err(if is_given {
                format!("`for all {axis}` changes nothing: the claim behind it gives `{axis}` already")
            } else {
                format!("nothing in the claim varies with `{axis}`")
            });
        }
        let mut known = free.concat();
        known.sort_by(f64::total_cmp);
        known.dedup();
        let mut values = chosen.unwrap_or_else(|| known.clone());
        let mut seen = BTreeSet::new();
        values.retain(|value| seen.insert(value.to_bits()));
        if let Some(wrong) = values.iter().find(|v| !known.contains(v)) {
            let known: Vec<String> = known.iter().map(f64::to_string).collect();
            return Err(format!("no grid has {axis} = {wrong}; there are {}", known.join(", ")));
        }
        if values.len() * references.len() > MAX_EXPANDED {
            return Err(format!("`for all` makes more than {MAX_EXPANDED} numbers of the claim"));
        }
        let bound = values.iter().map(|value| {
            let mut bound = body.clone();
            bound.change(&mut |r: &mut Reference| {
                if self.varies(r, axis).is_some() {
                    r.set(axis, *value);
                }
            });
            bound
        });
        let all = bound.reduce(|a, b| Expr::Binary(Op::And, Box::new(a), Box::new(b)));
        all.ok_or_else(|| format!("`for all {axis}` has no values"))
    }

    /// Values of the axis in the grid of the method; `None` if the reference fixes one.
    fn varies(&self, r: &Reference, axis: &str) -> Option<&'a [f64]> {
        let Quantity::Metric(_, method) = &r.quantity else { return None };
        let is_free = r.point.iter().all(|(fixed, _)| fixed != axis);
        let grids = &self.words.grids;
        let grid = grids.iter().find(|g| is_free && g.method == *method && g.axis == axis)?;
        Some(&grid.values)
    }

    /// Parses operators that bind at least as tightly as `tight`, by precedence climbing.
    fn binary(&mut self, tight: usize) -> Result<Expr, String> {
        let mut left = self.deeper(Self::factor)?;
        while let Some((_, op, level)) =
            Op::ALL.iter().find(|(sign, _, level)| *level >= tight && self.take(sign))
        {
            let wrong = "`&&` and `||` join comparisons; the other signs join numbers";
            let right = typed(self.binary(level + 1)?, op.is_logic(), wrong)?;
            left = Expr::Binary(*op, Box::new(typed(left, op.is_logic(), wrong)?), Box::new(right));
        }
        Ok(left)
    }

    fn factor(&mut self) -> Result<Expr, String> {
        if self.take("(") {
            let e = self.quantified()?;
            return if self.take(")") { Ok(e) } else { Err("a `)` is missing".to_string()) };
        }
        if self.take("!") {
            let e = self.deeper(Self::factor)?;
            return Ok(Expr::Not(Box::new(typed(e, true, "`!` stands before a comparison in brackets")?)));
        }
        if self.take("-") {
            let e = self.deeper(Self::factor)?;
            return Ok(Expr::Negate(Box::new(typed(e, false, "`-` stands before a number")?)));
        }
        let text = self.rest.trim_start();
        let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '.';
        let (word, rest) = text.split_at(text.find(|c| !is_word(c)).unwrap_or(text.len()));
        self.rest = rest;
        if word.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
            return word.parse().map(Expr::Number).map_err(|_| format!("`{word}` is not a number"));
        }
        if word.is_empty() {
            return Err(format!("a number or a metric is missing before `{text}`"));
        }
        let metric = match word {
            "finding" => None,
            word => Some(Metric::from_name(word).unwrap_or_else(|| {
                self.wrong(word, Metric::unknown(word));
                Metric::F_SCORE
            })),
        };
        if !self.take("[") {
            return Err(format!("`{word}` needs a method, e.g. `{word}[DTEF]`"));
        }
        let inside = self.up_to(']', "a `]` is missing")?;
        self.reference(metric, inside).map(Expr::Value)
    }

    fn reference(&mut self, metric: Option<Metric>, inside: &'a str) -> Result<Reference, String> {
        let words = self.words;
        let mut parts = inside.split(',').map(str::trim);
        let subject = parts.next().unwrap_or_default();
        let quantity = match metric {
            None => Quantity::Finding(words.finding(subject, |n| &n.numbers).unwrap_or_else(|e| {
                self.wrong(subject, e);
                FindingName { analysis: String::new(), part: String::new() }
            })),
            Some(metric) => {
                self.check("method", subject, &words.methods);
                Quantity::Metric(metric, subject.to_string())
            }
        };
        let mut r = Reference { quantity, tracker: None, point: Vec::new() };
        for part in parts {
            if let Some((axis, value)) = part.split_once('=').filter(|_| metric.is_some()) {
                self.check("grid axis", axis.trim(), &words.axes);
                r.set(axis.trim(), value.trim().parse().map_err(|_| format!("`{part}` has no number"))?);
            } else {
                self.check("tracker", part, &words.trackers);
                r.tracker = Some(part.to_string());
            }
        }
        Ok(r)
    }
}

/// Parses numbers like `1, 5, 10`.
fn numbers(list: &str) -> Result<Vec<f64>, String> {
    let number = |text: &str| text.trim().parse().map_err(|_| format!("`{}` is not a number", text.trim()));
    list.split(',').map(number).collect()
}
