//! Tests the claims of an experiment on our numbers.
//!
//! Each claim has two outcomes for each tracker: that of the numbers as they are, which decides whether a required one is
//! met, and that with their uncertainty ([`trackfail_engine::spec::claim::Claim::judge`]), which reports show.

mod sampled;

use crate::results::{CellScore, Results};
use crate::table::layout;
use crate::table::number::{Style, four_digits};
use sampled::Samples;
use serde::{Deserialize, Serialize};
use trackfail_engine::spec::Tracker;
use trackfail_engine::spec::claim::{Claim, ClaimVerdict, Compared, LEVEL, Quantity, Reference};

/// A claim, tested on our numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The conclusion in words.
    pub text: String,
    /// The predicate.
    pub predicate: String,
    /// Whether the run fails where it does not hold.
    pub required: bool,
    /// Whether it is about anchors alone, a check of the arithmetic and no claim of a paper.
    pub is_check: bool,
    /// One for each tracker, or a single one for a claim that names its trackers.
    pub tested: Vec<Tested>,
}

/// A claim tested for one tracker.
#[derive(Debug, Clone, PartialEq)]
pub struct Tested {
    /// Tracker; empty for a claim that names its trackers.
    pub tracker: String,
    /// Whether our numbers as they are meet it.
    pub is_met: bool,
    /// The verdict of our numbers with their uncertainty.
    pub verdict: ClaimVerdict,
    /// Whether it does not hold at the level, either, that allows for the number of trackers (Bonferroni's).
    pub fails_beyond_chance: bool,
    /// The numbers behind it, one line for each comparison.
    pub lines: Vec<String>,
}

impl Finding {
    /// Whether our numbers as they are meet it for every tracker.
    pub fn is_met(&self) -> bool {
        self.tested.iter().all(|t| t.is_met)
    }

    /// The outcome over all trackers: it holds where it holds for each of them; it does not hold where it holds for none
    /// and fails for one by more than chance does among so many; what can be tested for some trackers is judged by
    /// these; all else is undecided.
    pub fn overall(&self) -> ClaimOutcome {
        let [holds, _, _, untestable] = self.counts();
        match self.tested.len() - untestable {
            0 => ClaimOutcome::CannotBeTested,
            tested if holds == tested => ClaimOutcome::Holds,
            _ if holds == 0 && self.tested.iter().any(|t| t.fails_beyond_chance) => ClaimOutcome::DoesNotHold,
            _ => ClaimOutcome::Undecided,
        }
    }

    /// Numbers of trackers for which it holds, is undecided, does not hold, and cannot be tested.
    fn counts(&self) -> [usize; 4] {
        ClaimOutcome::ALL.map(|o| self.tested.iter().filter(|t| outcome(&t.verdict) == o).count())
    }
}

/// Tests every claim, for each tracker where it names none; `scores` are those of [`Results::scores`].
pub fn test(results: &Results, scores: &[CellScore]) -> Vec<Finding> {
    if results.experiment.claims.is_empty() {
        return Vec::new();
    }
    let samples = Samples::new(results, scores);
    results.experiment.claims.iter().map(|claim| test_one(results, &samples, claim)).collect()
}

fn test_one(results: &Results, samples: &Samples<'_>, claim: &Claim) -> Finding {
    let experiment = &results.experiment;
    // Only trackers on which every method and analysis of the claim is run.
    let concerns = |t: &&Tracker| {
        claim.references().iter().all(|r| match &r.quantity {
            Quantity::Metric(_, method) => {
                experiment.methods.iter().any(|m| m.name == *method && m.runs_on(&t.label))
            }
            Quantity::Finding(made) => {
                experiment.analyses.iter().any(|a| a.name == made.analysis && a.runs_on(&t.label))
            }
        })
    };
    let trackers = experiment.trackers.iter().filter(concerns);
    let trackers: Vec<&str> = trackers.map(|t| t.label.as_str()).collect();
    let each: Vec<&str> = if claim.is_per_tracker() { trackers } else { vec![""] };
    let corrected = 1.0 - (1.0 - LEVEL) / each.len().max(1) as f64;
    let tested = each.iter().map(|tracker| {
        let met = claim.test(tracker, &|r| samples.value(r));
        let judgement = claim.judge(tracker, LEVEL, &|r| samples.measured(r));
        let fails_beyond_chance = judgement.verdict == ClaimVerdict::Fails
            && claim.judge(tracker, corrected, &|r| samples.measured(r)).verdict == ClaimVerdict::Fails;
        let lines = match &judgement.verdict {
            ClaimVerdict::Untestable(reason) => vec![reason.clone()],
            _ => judgement.compared.iter().map(|c| line(claim, c)).collect(),
        };
        let (tracker, is_met) = ((*tracker).to_string(), met == ClaimVerdict::Holds);
        Tested { tracker, is_met, verdict: judgement.verdict, fails_beyond_chance, lines }
    });
    let mut tested: Vec<Tested> = tested.collect();
    if tested.is_empty() {
        let reason = "no tracker has all of its methods".to_string();
        let verdict = ClaimVerdict::Untestable(reason.clone());
        let (tracker, fails_beyond_chance) = (String::new(), false);
        tested.push(Tested { tracker, is_met: false, verdict, fails_beyond_chance, lines: vec![reason] });
    }
    let is_of_anchor = |r: &&Reference| match &r.quantity {
        Quantity::Metric(_, method) => layout::is_anchor(experiment, method),
        Quantity::Finding(_) => false,
    };
    Finding {
        text: claim.text.clone(),
        predicate: claim.predicate.clone(),
        required: claim.required,
        is_check: claim.references().iter().all(is_of_anchor),
        tested,
    }
}

/// A comparison in one line: `recall[DTEF] > recall[RAW]: 0.714 and 0.667, +0.047 (-0.020 to +0.110), undecided`.
fn line(claim: &Claim, c: &Compared) -> String {
    // Whole numbers where all are counts; else three decimals, or four digits of what is small or large.
    let counts = claim.references().iter().all(|r| match &r.quantity {
        Quantity::Metric(metric, _) => metric.is_count(),
        Quantity::Finding(_) => false,
    });
    let of_analysis = claim.references().iter().any(|r| matches!(r.quantity, Quantity::Finding(_)));
    let shown = |v: f64| match (counts, of_analysis) {
        (true, _) if v == v.trunc() => Style::COUNT.format(v),
        (_, true) => four_digits(v),
        _ => Style::DEFAULT.format(v),
    };
    let signed = |v: f64| {
        let text = shown(v);
        if v > 0.0 && text.bytes().any(|b| (b'1'..=b'9').contains(&b)) { format!("+{text}") } else { text }
    };
    let [a, b] = c.values;
    let interval = match c.bounds {
        Some((low, high)) if low == high => String::new(),
        Some((low, high)) => format!(" ({} to {})", signed(low), signed(high)),
        None => " (too few sequences, or samples with a value, for an interval)".to_string(),
    };
    let (left, right) = (&c.left, &c.right);
    let numbers = format!("{} and {}, {}{interval}", shown(a), shown(b), signed(a - b));
    format!("{left} {right}: {numbers}, {}", outcome(&c.verdict).words())
}

fn outcome(verdict: &ClaimVerdict) -> ClaimOutcome {
    match verdict {
        ClaimVerdict::Holds => ClaimOutcome::Holds,
        ClaimVerdict::Undecided => ClaimOutcome::Undecided,
        ClaimVerdict::Fails => ClaimOutcome::DoesNotHold,
        ClaimVerdict::Untestable(_) => ClaimOutcome::CannotBeTested,
    }
}

/// A claim as the page shows it.
pub fn view(finding: &Finding) -> ClaimView {
    let verdict = finding.overall();
    let several = finding.tested.len() > 1;
    let counted =
        |(outcome, n): (ClaimOutcome, usize)| (n > 0).then(|| format!("{} for {n}", outcome.words()));
    let counts = ClaimOutcome::ALL.into_iter().zip(finding.counts()).filter_map(counted);
    let chip = |t: &Tested| Chip { tracker: t.tracker.clone(), verdict: outcome(&t.verdict) };
    let detail = |Tested { tracker, verdict, lines, .. }: &Tested| {
        let who = if tracker.is_empty() { String::new() } else { format!("{tracker}: ") };
        format!("{who}{}: {}", outcome(verdict).words(), lines.join("; "))
    };
    ClaimView {
        text: finding.text.clone(),
        verdict,
        is_check: finding.is_check,
        counts: if several { counts.collect::<Vec<_>>().join(", ") } else { String::new() },
        predicate: finding.predicate.clone(),
        chips: if several { finding.tested.iter().map(chip).collect() } else { Vec::new() },
        details: finding.tested.iter().map(detail).collect(),
    }
}

/// The outcome of a page's claims in a sentence, with the first claim; `None` without claims of a paper.
pub fn verdict(claims: &[ClaimView]) -> Option<String> {
    let of_paper: Vec<&ClaimView> = claims.iter().filter(|c| !c.is_check).collect();
    let first = of_paper.first()?;
    let words = ClaimCounts::of(of_paper.iter().map(|c| c.verdict)).words();
    let (outcome, text) = (first.verdict.words(), first.text.trim_end_matches('.'));
    Some(match of_paper.len() {
        1 => format!("Its claim {outcome}: {text}."),
        n => format!("Of {n} claims, {words}. The first {outcome}: {text}."),
    })
}

/// A claim as the page shows it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ClaimView {
    /// The statement.
    pub text: String,
    /// The outcome over all trackers.
    pub verdict: ClaimOutcome,
    /// Whether it is a check of the arithmetic, see [`Finding::is_check`].
    pub is_check: bool,
    /// How many trackers have each outcome: `holds for 2, undecided for 1`; empty for a single one.
    pub counts: String,
    /// The predicate over our numbers; may be empty.
    pub predicate: String,
    /// The outcome for each tracker, of several.
    pub chips: Vec<Chip>,
    /// One line for each tracker: the verdict and the numbers behind it.
    pub details: Vec<String>,
}

impl ClaimView {
    /// The outcome in words, with that of the trackers where there are several.
    pub fn headline(&self) -> String {
        let words = self.verdict.words();
        if self.counts.is_empty() { words.to_string() } else { format!("{words} ({})", self.counts) }
    }
}

/// The outcome of a claim for a tracker.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Chip {
    /// Label of the tracker.
    pub tracker: String,
    /// The outcome.
    pub verdict: ClaimOutcome,
}

/// Numbers of claims by outcome.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClaimCounts {
    /// Claims that hold.
    pub hold: u64,
    /// Claims that the sequences cannot decide; none in summaries before format 2.
    #[serde(default)]
    pub undecided: u64,
    /// Claims that do not hold.
    pub do_not_hold: u64,
    /// Claims of which data or numbers are missing.
    pub cannot_be_tested: u64,
}

impl ClaimCounts {
    /// Counts outcomes.
    pub fn of(outcomes: impl IntoIterator<Item = ClaimOutcome>) -> Self {
        let mut counts = Self::default();
        for outcome in outcomes {
            *match outcome {
                ClaimOutcome::Holds => &mut counts.hold,
                ClaimOutcome::Undecided => &mut counts.undecided,
                ClaimOutcome::DoesNotHold => &mut counts.do_not_hold,
                ClaimOutcome::CannotBeTested => &mut counts.cannot_be_tested,
            } += 1;
        }
        counts
    }

    /// `2 hold, 1 undecided, 3 do not hold`, with those that cannot be tested where there are any; empty without claims.
    pub fn words(self) -> String {
        let Self { hold, undecided, do_not_hold, cannot_be_tested } = self;
        if self == Self::default() {
            return String::new();
        }
        let one = |n: u64, one: &str, many: &str| format!("{n} {}", if n == 1 { one } else { many });
        let mut words = vec![
            one(hold, "holds", "hold"),
            format!("{undecided} undecided"),
            one(do_not_hold, "does not hold", "do not hold"),
        ];
        words.extend((cannot_be_tested > 0).then(|| format!("{cannot_be_tested} cannot be tested")));
        words.join(", ")
    }
}

/// The outcome of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ClaimOutcome {
    /// It holds in our numbers.
    Holds,
    /// The sequences cannot decide it.
    Undecided,
    /// It does not.
    DoesNotHold,
    /// Data or numbers are missing.
    CannotBeTested,
}

impl ClaimOutcome {
    /// All outcomes, in the order of reports.
    pub const ALL: [Self; 4] = [Self::Holds, Self::Undecided, Self::DoesNotHold, Self::CannotBeTested];

    /// The outcome in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Undecided => "undecided",
            Self::DoesNotHold => "does not hold",
            Self::CannotBeTested => "cannot be tested",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_tracker_of_many_decides_only_beyond_chance() {
        let tested = |verdict: ClaimVerdict, fails_beyond_chance: bool| Tested {
            tracker: String::new(),
            is_met: false,
            verdict,
            fails_beyond_chance,
            lines: Vec::new(),
        };
        let overall = |tested: Vec<Tested>| {
            let (text, predicate) = (String::new(), String::new());
            Finding { text, predicate, required: false, is_check: false, tested }.overall()
        };
        let (holds, open) = (tested(ClaimVerdict::Holds, false), tested(ClaimVerdict::Undecided, false));
        let fails = |beyond| tested(ClaimVerdict::Fails, beyond);
        assert_eq!(overall(vec![holds.clone(), holds.clone()]), ClaimOutcome::Holds);
        assert_eq!(overall(vec![open.clone(), fails(true)]), ClaimOutcome::DoesNotHold);
        assert_eq!(overall(vec![open.clone(), fails(false)]), ClaimOutcome::Undecided);
        assert_eq!(overall(vec![holds, fails(true)]), ClaimOutcome::Undecided);
        let untestable = tested(ClaimVerdict::Untestable(String::new()), false);
        assert_eq!(overall(vec![untestable.clone(), fails(true)]), ClaimOutcome::DoesNotHold);
        assert_eq!(overall(vec![untestable]), ClaimOutcome::CannotBeTested);
    }
}
