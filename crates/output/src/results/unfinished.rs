//! Cells without a result, in groups for people: missing data by tracker; failed or unrun cells by reason.

use super::cells::grouped;
use super::manifest::{FailedCell, NotRun};

/// Most lines that list methods that were not run one by one.
const MAX_LINES: usize = 12;

/// Cells that have no result for the same reason.
#[derive(Debug, Clone, PartialEq)]
pub struct Unfinished {
    /// True if data are missing; false if the computation failed.
    pub missing: bool,
    /// Description of the cells: `IVT (file), 24 sequences, 12 methods`.
    pub cells: String,
    /// Kind of the cells: `cells`, `tracks` or `analyses`.
    pub what: &'static str,
    /// Number of cells.
    pub count: usize,
    /// Reason of the first cell; if several cells failed, without the first one's name.
    pub reason: String,
}

impl std::fmt::Display for Unfinished {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.count {
            1 => write!(f, "{}: {}", self.cells, self.reason),
            count => write!(f, "{count} {}: {} ({})", self.what, self.reason, self.cells),
        }
    }
}

/// Text in the reason of a failed program, before the last lines of its stderr.
const ON_STDERR: &str = "its stderr ends with: ";

/// Cause of a failed cell without its own and its sequence's name, so that cells with the same cause can be
/// grouped: the last line of a program's output, or the reason with `…` for the sequence.
fn cause(cell: &FailedCell) -> String {
    let mut reason = cell.reason.as_str();
    let own = format!("{}/{}/{}/", cell.sequence, cell.tracker, cell.run);
    while let Some((name, rest)) = reason.split_once(": ")
        && !cell.sequence.is_empty()
        && (name == cell.sequence || name.contains(&own))
    {
        reason = rest;
    }
    let told = reason.rsplit_once(ON_STDERR).and_then(|(_, told)| told.rsplit(" | ").next());
    if let Some(told) = told.map(str::trim).filter(|told| !told.is_empty()) {
        return told.to_string();
    }
    let is_name = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
    let mut text = String::new();
    let mut rest = reason;
    while let Some(at) = rest.find(cell.sequence.as_str()).filter(|_| !cell.sequence.is_empty()) {
        let (before, from) = rest.split_at(at);
        let (name, after) = from.split_at(cell.sequence.len());
        let stands_alone = !before.ends_with(is_name) && !after.starts_with(is_name);
        text.push_str(before);
        text.push_str(if stands_alone { "…" } else { name });
        rest = after;
    }
    text + rest
}

/// Kind of a record of the manifest, in the plural.
pub fn what(cell: &FailedCell) -> &'static str {
    match cell {
        FailedCell { method, .. } if method.is_empty() => "tracks",
        FailedCell { sequence, .. } if sequence == "*" => "analyses",
        _ => "cells",
    }
}

/// Names in order of first occurrence, without repetitions.
fn names<'a, T>(cells: &[&'a T], name: fn(&'a T) -> &'a str) -> Vec<&'a str> {
    grouped(cells.iter().copied(), name).into_iter().map(|(name, _)| name).collect()
}

/// A single name, or the number of names.
fn counted(names: &[&str], what: &str) -> String {
    match names {
        [one] => (*one).to_string(),
        many => format!("{} {what}", many.len()),
    }
}

/// Groups in the order of their first cells.
pub fn groups(cells: &[FailedCell]) -> Vec<Unfinished> {
    // Reasons of missing data name the file of each sequence.
    let common = |cell: &FailedCell| if cell.missing { cell.tracker.clone() } else { cause(cell) };
    let group = |((missing, what, common), cells): ((bool, &'static str, String), Vec<&FailedCell>)| {
        let sequences = names(&cells, |c| &c.sequence);
        let reason = if missing || sequences.len() == 1 { cells[0].reason.clone() } else { common };
        let parts = [
            counted(&names(&cells, |c| &c.tracker), "trackers"),
            counted(&sequences, "sequences"),
            counted(&names(&cells, |c| &c.method), "methods"),
        ];
        let parts: Vec<String> = parts.into_iter().filter(|part| !part.is_empty()).collect();
        Unfinished { missing, cells: parts.join(", "), what, count: cells.len(), reason }
    };
    grouped(cells, |cell| (cell.missing, what(cell), common(cell))).into_iter().map(group).collect()
}

/// Lines about tracks that are declared absent and methods that were not run: one line each or, if there are
/// many, one for each unmet need.
pub fn not_run(all: &[NotRun]) -> Vec<String> {
    let (tracks, methods): (Vec<&NotRun>, Vec<&NotRun>) = all.iter().partition(|n| n.method.is_empty());
    let mut lines: Vec<String> = tracks.iter().map(ToString::to_string).collect();
    if methods.len() <= MAX_LINES {
        lines.extend(methods.iter().map(ToString::to_string));
        return lines;
    }
    let line = |(reason, mine): (&String, Vec<&NotRun>)| {
        let methods = names(&mine, |n| &n.method).join(", ");
        let trackers = counted(&names(&mine, |n| &n.tracker), "trackers");
        format!("Not run on {trackers}: {methods}; each {reason}")
    };
    lines.extend(grouped(methods, |n| &n.reason).into_iter().map(line));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::failed_cell as cell;

    #[test]
    fn what_is_not_there_is_told_by_tracker_and_what_failed_by_reason() {
        let cells = [
            cell("a", "x", "m", true, "no a.txt"),
            cell("b", "x", "m", true, "no b.txt"),
            cell("b", "x", "n", true, "no b.txt"),
            cell("a", "y", "m", false, "no module"),
            cell("a", "z", "m", false, "no module"),
            cell("a", "z", "m", false, "it broke"),
            cell("a", "z", "m", false, "a: it hung"),
            cell("b", "z", "m", false, "suite/b/z/0/m: b: it hung"),
            cell("a", "w", "m", false, "mine: frame 1 of a: it ended; its stderr ends with: A | no numpy"),
            cell("b", "w", "m", false, "mine: frame 7 of b: it ended; its stderr ends with: A | no numpy"),
            cell("a", "v", "m", false, "frame 3 of a: it ran away"),
            cell("b", "v", "m", false, "frame 3 of b: it ran away"),
        ];
        let told = |cells: &[FailedCell]| groups(cells).iter().map(ToString::to_string).collect::<Vec<_>>();
        let lines = [
            "3 cells: no a.txt (x, 2 sequences, 2 methods)",
            "2 cells: no module (2 trackers, a, m)",
            "z, a, m: it broke",
            "2 cells: it hung (z, 2 sequences, m)",
            "2 cells: no numpy (w, 2 sequences, m)",
            "2 cells: frame 3 of …: it ran away (v, 2 sequences, m)",
        ];
        assert_eq!(told(&cells), lines);
        assert_eq!(groups(&cells).iter().filter(|g| g.missing).count(), 1);
        assert!(groups(&cells)[0].missing && groups(&[]).is_empty());
        // Tracks and analyses do not stand among cells.
        let others = [
            cell("a", "x", "m", true, "no a.txt"),
            cell("a", "x", "", true, "no a.txt"),
            cell("b", "x", "", true, "no b.txt"),
            cell("*", "", "analysis o of x", true, "no a.txt"),
        ];
        let lines =
            ["x, a, m: no a.txt", "2 tracks: no a.txt (x, 2 sequences)", "*, analysis o of x: no a.txt"];
        assert_eq!(told(&others), lines);
    }

    #[test]
    fn much_that_was_not_run_is_told_by_need() {
        let entry = |tracker: usize, method: &str, reason: &str| NotRun {
            tracker: format!("t{tracker}"),
            method: method.to_string(),
            reason: reason.to_string(),
            cells: 2,
        };
        let few = [entry(0, "a", "needs x")];
        assert_eq!(not_run(&few), ["a was not run on t0 (2 cells): it needs x"]);
        let mut many: Vec<NotRun> =
            (0..6).flat_map(|t| [entry(t, "a", "needs x"), entry(t, "b", "needs x")]).collect();
        many.push(entry(3, "c", "needs y"));
        let told = ["Not run on 6 trackers: a, b; each needs x", "Not run on t3: c; each needs y"];
        assert_eq!(not_run(&many), told);
        many.insert(0, entry(7, "", "has no track on a, as declared: it is short"));
        assert_eq!(not_run(&many).len(), 3);
        assert_eq!(not_run(&many)[0], "t7 has no track on a, as declared: it is short (2 cells)");
    }
}
