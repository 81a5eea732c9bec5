//! Numbers printed in a paper, matched to a table by tracker, row and column.

use super::Cell;
use crate::table::number::{Style, bare, four_digits, printed_value};
use trackfail_engine::spec::Experiment;
use trackfail_engine::spec::table::{Published, Table};

/// Published numbers of a table.
pub(super) struct Printed<'a> {
    experiment: &'a Experiment,
    rows: Vec<&'a Published>,
    /// True if the paper omits the zero before the point. Then all numbers of the table do.
    is_bare: bool,
}

impl<'a> Printed<'a> {
    pub(super) fn of(experiment: &'a Experiment, table: &Table) -> Self {
        let rows: Vec<&Published> = experiment.published.iter().filter(|p| p.table == table.name).collect();
        let is_bare = rows.iter().flat_map(|p| &p.values).any(|(_, text)| Style::of(text).bare);
        Self { experiment, rows, is_bare }
    }

    /// Trackers with published numbers, in order of the rows.
    pub(super) fn trackers(&self) -> impl Iterator<Item = &'a str> {
        self.rows.iter().map(|p| p.tracker.as_str())
    }

    /// Tracker whose published numbers stand beside those of `tracker`: the tracker itself or, if the paper
    /// has a single tracker that was not run, that one.
    pub(super) fn beside(&self, tracker: Option<&str>) -> Option<&'a str> {
        let first = self.trackers().next()?;
        let only = self.trackers().all(|t| t == first);
        let is_run = self.experiment.trackers.iter().any(|t| t.label == first);
        let own = self.trackers().find(|t| Some(*t) == tracker);
        own.or((only && !is_run).then_some(first))
    }

    /// Name of a tracker in the paper; for a reading, that of the tracker that it is like.
    pub(super) fn name(&self, label: &str) -> String {
        let tracker = self.experiment.trackers.iter().find(|t| t.label == label);
        tracker.and_then(|t| t.like.as_deref()).unwrap_or(label).to_string()
    }

    /// Printed text of a cell.
    pub(super) fn text(&self, tracker: Option<&str>, row: &str, column: &str) -> Option<&'a str> {
        let mine = self.rows.iter().filter(|p| Some(p.tracker.as_str()) == tracker && p.row == row);
        mine.flat_map(|p| &p.values).find(|(known, _)| known == column).map(|(_, text)| text.as_str())
    }

    /// Style in which the paper prints a row, for any tracker. A row is rounded uniformly.
    pub(super) fn style(&self, row: &str) -> Option<Style> {
        let of_row = self.rows.iter().filter(|p| p.row == row);
        of_row.flat_map(|p| &p.values).next().map(|(_, text)| Style::of(text))
    }

    /// Our number as printed; with four digits without a style.
    pub(super) fn shown(&self, v: f64, style: Option<Style>) -> String {
        let text = style.map_or_else(|| four_digits(v), |style| style.format(v));
        if self.is_bare { bare(&text) } else { text }
    }

    /// Cell with our number, the published one and their difference, as printed.
    pub(super) fn cell(&self, value: Option<f64>, style: Option<Style>, published: Option<&str>) -> Cell {
        let style = style.map(|style| Style { bare: self.is_bare, ..style });
        let printed = published.and_then(printed_value);
        let difference = value.zip(printed).zip(style).map(|((v, p), s)| s.format_signed(s.round(v) - p));
        let ours = value.map(|v| self.shown(v, style));
        Cell { value, ours, published: published.map(String::from), difference, ..Cell::default() }
    }
}
