//! The layout of a figure: title, stills, panels in rows and columns, legend.

use super::axis::{Ends, NAME_LINE, Ticks, frame, max_ticks};
use super::error::FigureError;
use super::font;
use super::legend::{Entry, Legend};
use super::page::{Area, LINE, Page, Point};
use super::panel::{Mark, Panel};
use super::still::{Still, draw_stills};
use super::style::{INK, LARGE, MARGIN, MEDIUM, SMALL, SOFT, WIDTH};
use plotters::style::text_anchor::HPos;

/// Shape of a figure's panels, and the axes that they share.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Form {
    /// Panels wider than high, which share both axes.
    #[default]
    Chart,
    /// Square panels, which share both axes. The legend is beside a single one.
    Square,
    /// Values over frames; each panel has its own axes.
    Strip,
    /// Panels with named rows, which neighbors share. With `shared`, all panels share the horizontal axis.
    Rows {
        /// True if all panels share the horizontal axis.
        shared: bool,
    },
    /// A diagram without axes.
    Diagram,
    /// A radar chart. The legend is beside a single one.
    Radar,
}

/// A figure: video frames (stills) above, panels below.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Figure {
    /// Title of the figure; may be empty.
    pub title: String,
    /// Note under the title; may be empty.
    pub note: String,
    /// Video frames above the panels.
    pub stills: Vec<Still>,
    /// Shape of the panels.
    pub form: Form,
    /// Panels by row. Columns that do not fit side by side are placed below each other.
    pub rows: Vec<Vec<Panel>>,
    /// Legend, placed below the panels or beside a single square one, so that panels keep their place.
    pub legend: Vec<Entry>,
}

/// Least width of a column with its labels, and of a column with named rows, in units.
const LEAST: f64 = 165.0;
const LEAST_OF_ROWS: f64 = 98.0;
/// Width of a square panel, and of a radar chart with the legend beside it, in units.
const SIDE: f64 = 390.0;
const RADAR: f64 = 470.0;
/// Height of a single panel, then least and largest height of several, in units.
const HEIGHT: (f64, f64, f64) = (300.0, 110.0, 200.0);
/// Least distance between panels, and between their labels, in units.
const GAP: f64 = 14.0;
const APART: f64 = 8.0;
/// Most room for names of rows, and for names of values in a strip, in units.
const ROW_NAMES: f64 = 210.0;
const VALUE_NAMES: f64 = 90.0;
/// Distance between the labels and the name of the vertical axis, in units.
const BESIDE: f64 = 7.0;
/// Height of the horizontal axis's labels, in units.
const LABELS: f64 = 22.0;

/// A panel with the ranges, ticks and texts that its layout depends on.
struct Cell<'f> {
    panel: &'f Panel,
    ends: (Ends, Ends),
    ticks: Ticks,
    /// Lines of the name of the vertical axis.
    name: Vec<String>,
    /// True if the panel on the left has the same legend.
    is_repeated: bool,
    title: Vec<String>,
    legend: Legend,
}

impl Cell<'_> {
    /// Breaks title and legend into lines of a width, in units.
    fn set_head(&mut self, width: f64) {
        self.title = font::wrap(&self.panel.title, MEDIUM, width);
        let entries: &[Entry] = if self.is_repeated { &[] } else { &self.panel.legend };
        self.legend = Legend::new(entries, width, 0.0);
    }

    /// Room on the left of the panel, in units.
    fn left(&self) -> f64 {
        let labels = self.ticks.y.iter().map(|t| font::widest(&t.1, SMALL)).fold(0.0, f64::max);
        let labels = if self.ticks.labels.1 { labels + BESIDE } else { 0.0 };
        let name = if self.name.is_empty() { 0.0 } else { LINE * self.name.len() as f64 + 4.0 };
        labels + name
    }

    /// Upper left corner of the legend, relative to that of the head: beside the title or below it.
    fn legend_at(&self, width: f64) -> Point {
        let beside = font::widest(&self.title, MEDIUM) + 12.0;
        let is_line = self.title.len() == 1 && self.legend.rows.len() == 1;
        match is_line && beside + self.legend.width() <= width {
            true => (beside, -1.0),
            false => (0.0, LINE * self.title.len() as f64),
        }
    }

    /// Height of title and legend above the panel, in units.
    fn head(&self, width: f64) -> f64 {
        let below = self.legend_at(width).1.max(0.0) + self.legend.height();
        let height = below.max(LINE * self.title.len() as f64);
        if height > 0.0 { height + 4.0 } else { 0.0 }
    }
}

impl Figure {
    /// Lays out the figure at a width, in units.
    ///
    /// # Errors
    /// See [`FigureError`].
    pub(super) fn page(&self, width: f64) -> Result<Page, FigureError> {
        let panels = || self.rows.iter().flatten();
        if panels().next().is_none() && self.stills.is_empty() {
            return Err(FigureError::Empty("neither stills nor panels"));
        }
        let is_curve = matches!(self.form, Form::Chart | Form::Square);
        if is_curve && !panels().any(Panel::has_point) {
            return Err(FigureError::Empty("no curve has a point"));
        }
        let mut page = Page::new(&self.title, width);
        let room = width - 2.0 * MARGIN;
        let title = font::wrap(&self.title, LARGE, room);
        let mut y = page.lines(&title, (MARGIN, MARGIN), LARGE, HPos::Left, INK);
        y = page.lines(&font::wrap(&self.note, SMALL, room), (MARGIN, y), SMALL, HPos::Left, SOFT);
        y += if y > MARGIN { 6.0 } else { 0.0 };
        y = draw_stills(&mut page, &self.stills, y);
        let (place, bottom) =
            if panels().next().is_some() { self.draw_panels(&mut page, y)? } else { ((MARGIN, y), y) };
        let (room, is_beside) = (width - place.0 - MARGIN, place.0 > MARGIN);
        let legend = Legend::new(&self.legend, room, if is_beside { SIDE } else { 0.0 });
        legend.draw(&mut page, place);
        page.height = (place.1 + legend.height()).max(bottom) + MARGIN;
        Ok(page)
    }

    /// Rows of panels at a width, in units.
    fn lines(&self, width: f64) -> Vec<&[Panel]> {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let most = match self.form {
            Form::Rows { .. } => (width - self.row_names(width)) / LEAST_OF_ROWS,
            _ => width / LEAST,
        };
        // As few blocks of columns as have room, equally filled.
        let each = columns.div_ceil(columns.div_ceil((most as usize).max(1)).max(1)).max(1);
        let part = |first: usize| {
            self.rows.iter().filter_map(move |row| row.get(first..(first + each).min(row.len())))
        };
        (0..columns).step_by(each).flat_map(part).filter(|line| !line.is_empty()).collect()
    }

    /// Room for names of values on the vertical axis, in units.
    fn row_names(&self, width: f64) -> f64 {
        let names = self.rows.iter().flatten().flat_map(|p| &p.y.names);
        let longest = names.map(|(_, name)| font::width(name, SMALL)).fold(0.0, f64::max);
        match self.form {
            Form::Rows { .. } => (longest + 1.0).min(ROW_NAMES).min(width / 2.5),
            _ => (longest + 1.0).min(VALUE_NAMES),
        }
    }

    /// Height of a panel of width `w`, one of `columns` in its row.
    fn height(&self, w: f64, columns: usize, panel: &Panel, page_width: f64) -> f64 {
        let is_wide = page_width >= WIDTH;
        match self.form {
            Form::Square => w,
            Form::Chart if columns == 1 && is_wide => HEIGHT.0,
            Form::Chart => (0.75 * w).clamp(HEIGHT.1, HEIGHT.2),
            Form::Strip if columns > 3 => 110.0,
            Form::Strip => 140.0,
            Form::Diagram if is_wide => 280.0,
            Form::Diagram => 380.0,
            Form::Radar => {
                let height = |mark: &Mark| if let Mark::Radar(radar) = mark { radar.height(w) } else { 0.0 };
                panel.marks.iter().map(height).fold(0.0, f64::max)
            }
            Form::Rows { .. } => {
                let room = self.row_names(page_width);
                let lines = panel.y.names.iter().map(|(_, name)| font::wrap(name, SMALL, room).len());
                (NAME_LINE * lines.max().unwrap_or(1) as f64 + 5.0) * panel.y.names.len() as f64 + 10.0
            }
        }
    }

    /// Draws the panels below `y`. Returns the place of the legend, and the height at which the page is free
    /// below the panels.
    fn draw_panels(&self, page: &mut Page, mut y: f64) -> Result<((f64, f64), f64), FigureError> {
        let width = page.width;
        let lines = self.lines(width);
        let columns = lines.iter().map(|line| line.len()).max().unwrap_or(1);
        let has_room = matches!(self.form, Form::Square | Form::Radar) && width >= WIDTH;
        let is_beside = has_room && columns == 1 && lines.len() == 1;
        let side = if self.form == Form::Radar { RADAR } else { SIDE };
        // How many ticks an axis takes depends on its length, and that on the room of the labels, which is guessed first.
        let guess = if is_beside { side } else { (width - 2.0 * MARGIN - 60.0) / columns as f64 - GAP };
        let height_of = |w: f64, line: &[Panel]| self.height(w, columns, &line[0], width);
        let mut grid = self.cells(&lines, (guess, height_of(guess, lines[0])), width)?;

        let (common_x, common_y) = self.common();
        let left_of = |c: usize| grid.iter().filter_map(|l| l.get(c)).map(Cell::left).fold(0.0, f64::max);
        let lefts: Vec<f64> = (0..columns).map(left_of).collect();
        let labels = grid.iter().flatten().flat_map(|cell| &cell.ticks.x);
        let widest = labels.map(|t| font::width(&t.1, SMALL)).fold(0.0, f64::max);
        // The label at the end of an axis stands beside the one at the beginning of the next.
        let gap = if common_y { GAP.max(widest + APART) } else { GAP };
        let room = width - 2.0 * MARGIN - APART - lefts.iter().sum::<f64>();
        let w = if is_beside { side } else { (room - gap * (columns - 1) as f64) / columns as f64 };
        let x_of = |c: usize| MARGIN + lefts[..=c].iter().sum::<f64>() + (w + gap) * c as f64;
        grid.iter_mut().flatten().for_each(|cell| cell.set_head(w));
        let head = grid.iter().flatten().map(|cell| cell.head(w)).fold(0.0, f64::max);
        let mut place = (MARGIN, y);
        for (r, (line, cells)) in lines.iter().zip(&grid).enumerate() {
            let (top, h) = (y + head, height_of(w, line));
            for (c, cell) in cells.iter().enumerate() {
                self.draw_cell(page, cell, Area { x: x_of(c), y: top, w, h }, lefts[c]);
            }
            place = (x_of(0) + w + 22.0, top);
            y = top + h + if head > 0.0 { 8.0 } else { GAP };
            if cells.iter().any(|cell| cell.ticks.labels.0) {
                y += LABELS;
                if !common_x || r + 1 == lines.len() {
                    y = draw_names(page, cells, (&x_of, w), y);
                }
            }
        }
        Ok((if is_beside { place } else { (MARGIN, y) }, y))
    }

    /// True, for the horizontal and the vertical axis, if all panels share it.
    fn common(&self) -> (bool, bool) {
        match self.form {
            Form::Chart | Form::Square => (true, true),
            Form::Rows { shared } => (shared, true),
            Form::Strip | Form::Diagram | Form::Radar => (false, false),
        }
    }

    fn has_axes(&self) -> bool {
        !matches!(self.form, Form::Diagram | Form::Radar)
    }

    /// Panels of each row with their ranges, ticks and texts, for a size of panels and a width of the page.
    fn cells<'f>(
        &self,
        lines: &[&'f [Panel]],
        size: (f64, f64),
        width: f64,
    ) -> Result<Vec<Vec<Cell<'f>>>, FigureError> {
        let (common_x, common_y) = self.common();
        let (all_x, all_y): (Vec<f64>, Vec<f64>) =
            lines.iter().copied().flatten().flat_map(Panel::values).unzip();
        let has_axes = self.has_axes();
        let names = self.row_names(width).max(VALUE_NAMES);
        let max = max_ticks(size);
        let cell = |panel: &'f Panel, before: Option<&Panel>| {
            let (x, y): (Vec<f64>, Vec<f64>) = panel.values().into_iter().unzip();
            let ends = (
                panel.x.ends(if common_x { &all_x } else { &x }, max.0)?,
                panel.y.ends(if common_y { &all_y } else { &y }, max.1)?,
            );
            let is_named = before.is_none_or(|before| before.y.label != panel.y.label);
            let wrapped = |(at, text): (f64, String)| (at, font::wrap(&text, SMALL, names));
            let ticks = Ticks {
                x: panel.x.ticks(ends.0, max.0),
                y: panel.y.ticks(ends.1, max.1).into_iter().map(wrapped).collect(),
                labels: (has_axes, has_axes && (before.is_none() || !common_y)),
            };
            Ok::<_, FigureError>(Cell {
                panel,
                ends,
                ticks,
                name: font::wrap(if is_named { panel.y.label.as_str() } else { "" }, MEDIUM, size.1 + 20.0),
                is_repeated: before.is_some_and(|before| before.legend == panel.legend),
                title: Vec::new(),
                legend: Legend::default(),
            })
        };
        let of_line = |line: &'f [Panel]| -> Result<Vec<Cell<'f>>, FigureError> {
            let before = |c: usize| c.checked_sub(1).map(|c| &line[c]);
            line.iter().enumerate().map(|(c, panel)| cell(panel, before(c))).collect()
        };
        let mut grid: Vec<Vec<Cell<'f>>> =
            lines.iter().copied().map(of_line).collect::<Result<_, FigureError>>()?;
        // The labels of the horizontal axis stand under the last of a stack of panels with the same one.
        for r in 1..grid.len() {
            let (above, below) = grid.split_at_mut(r);
            for (above, below) in above[r - 1].iter_mut().zip(&below[0]) {
                let is_same = above.ends.0 == below.ends.0 && above.panel.x.label == below.panel.x.label;
                above.ticks.labels.0 &= !is_same;
            }
        }
        Ok(grid)
    }

    fn draw_cell(&self, page: &mut Page, cell: &Cell<'_>, area: Area, left: f64) {
        let place = cell.panel.place(area, &cell.ends);
        cell.panel.draw(page, &place);
        if self.has_axes() {
            frame(page, &place, &cell.ticks);
        }
        let top = area.y - cell.head(area.w);
        page.lines(&cell.title, (area.x, top), MEDIUM, HPos::Left, INK);
        let at = cell.legend_at(area.w);
        cell.legend.draw(page, (area.x + at.0, top + at.1));
        let at = (area.x - left + LINE / 2.0, area.middle().1);
        page.lines_upwards(cell.name.clone(), at, MEDIUM, INK);
    }
}

/// Draws the names of the horizontal axes of a row below `y`, only once for neighbors with the same name.
/// Returns the height at which the page is free below them.
fn draw_names(page: &mut Page, cells: &[Cell<'_>], (x_of, w): (&dyn Fn(usize) -> f64, f64), y: f64) -> f64 {
    let mut bottom = y;
    let shown: Vec<usize> = (0..cells.len()).filter(|c| cells[*c].ticks.labels.0).collect();
    let label = |c: usize| &cells[c].panel.x.label;
    for span in shown.chunk_by(|a, b| a + 1 == *b && label(*a) == label(*b)) {
        let (from, to) = (x_of(span[0]), x_of(span[span.len() - 1]) + w);
        let lines = font::wrap(label(span[0]), MEDIUM, to - from);
        let middle = ((from + to) / 2.0, y - 4.0);
        bottom = bottom.max(page.lines(&lines, middle, MEDIUM, HPos::Center, INK));
    }
    bottom
}
