//! Sequences frame by frame: stills with boxes over a grid of panels.
//!
//! With stills and one row of panels it is laid out as Fig. 3 of Khalid, Cavallaro and Rinner (BMVC
//! 2016), with a column a sequence as their Fig. 4, with two panels a row as their Fig. 5.

use super::axes;
use super::draw::Plot;
use super::error::FigureError;
use super::font;
use super::heading::heading;
use super::legend::{Entry, Rows, Symbol};
use super::panel::{LOSS, Panel, PanelLayout, RECOVERY, SHADE};
use super::scene::{Anchor, Area, Picture, Point, Scene, Stroke};
use super::style::Edge;
use super::style::{CASING, Color, Dash, INK, MARGIN, MEDIUM, SMALL};
use trackfail_core::image::Frame;
use trackfail_core::region::Region;

/// The kind of a box on a still.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BoxStyle {
    /// The background region B_t, red.
    Background,
    /// The tracker's state, yellow.
    State,
    /// The ground truth, green and dashed.
    Truth,
}

impl BoxStyle {
    const ALL: [Self; 3] = [Self::Background, Self::State, Self::Truth];

    fn look(self) -> ([u8; 3], Dash) {
        match self {
            Self::Background => ([0xFF, 0x4B, 0x1F], Dash::Solid),
            Self::State => (Color::Yellow.rgb(), Dash::Solid),
            Self::Truth => ([0x00, 0xD0, 0x8A], Dash::Dashed),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Background => "background region",
            Self::State => "tracker",
            Self::Truth => "ground truth",
        }
    }
}

/// A video frame above the panels.
#[derive(Debug, Clone, PartialEq)]
pub struct Still {
    /// Its number in the dataset.
    pub number: u32,
    /// Its pixels.
    pub pixels: Frame,
    /// Boxes in the frame's pixels; they are cut off at the frame's border.
    pub boxes: Vec<(Region, BoxStyle)>,
    /// Text after the number; may be empty.
    pub caption: String,
}

/// Stills over a grid of panels.
#[derive(Debug, Clone, PartialEq)]
pub struct Strip {
    /// Title; may be empty.
    pub title: String,
    /// Note under the title, such as `12 of 21 targets`; may be empty.
    pub note: String,
    /// Frames above the grid, five a row or, in a column, two; may be empty.
    pub stills: Vec<Still>,
    /// A heading a column; may be empty.
    pub headings: Vec<String>,
    /// Panels, row by row; a shorter row leaves its right end empty.
    pub rows: Vec<Vec<Panel>>,
    /// Meaning of shaded runs of frames.
    pub shaded: &'static str,
}

/// Meaning of shaded frames where there is ground truth.
pub const LOST: &str = "target lost (Oₜ = 1)";

/// Least width of a column of panels, and of a still, in units.
const LEAST_PANEL: f64 = 165.0;
const LEAST_STILL: f64 = 140.0;
const GAP: f64 = 16.0;

impl Plot for Strip {
    fn scene(&self, width: f64) -> Result<Scene, FigureError> {
        let most = ((width / LEAST_PANEL) as usize).max(1);
        let blocks = self.blocks(most);
        let columns = blocks.iter().flat_map(|b| &b.rows).map(Vec::len).max().unwrap_or(0);
        if columns == 0 && self.stills.is_empty() {
            return Err(FigureError::Empty("neither stills nor panels"));
        }
        let mut scene = Scene::new(&self.title, width);
        let mut y = heading(&mut scene, &self.title, &self.note);
        y = self.draw_stills(&mut scene, y);
        if columns > 0 {
            let mut sheet = Sheet::new(columns, width);
            let grids = blocks.iter().map(|b| b.layouts(&mut sheet)).collect::<Result<Vec<_>, _>>()?;
            for (block, grid) in blocks.iter().zip(&grids) {
                y = block.draw(&mut scene, &sheet, grid, y);
            }
        }
        let key = Rows::new(&self.key(), width - 2.0 * MARGIN);
        key.draw(&mut scene, (MARGIN, y));
        scene.height = y + key.height() + MARGIN;
        Ok(scene)
    }
}

impl Strip {
    /// Legend of the marks that mean the same in every panel.
    fn key(&self) -> Vec<Entry> {
        let mut out = Vec::new();
        let mut add = |symbol, name: &str| out.push(Entry { symbol, name: name.to_owned() });
        for style in BoxStyle::ALL {
            if self.stills.iter().flat_map(|s| &s.boxes).any(|b| b.1 == style) {
                let (rgb, dash) = style.look();
                add(Symbol::Outline { rgb, dash }, style.name());
            }
        }
        let panels = || self.rows.iter().flatten();
        if panels().any(|p| !p.spans.is_empty()) {
            add(Symbol::Patch(SHADE), self.shaded);
        }
        let has =
            |of: fn(&Panel) -> &[(usize, Edge)], edge| panels().any(|p| of(p).iter().any(|e| e.1 == edge));
        for (edge, style, name) in [(Edge::Begins, LOSS, "loss"), (Edge::Ends, RECOVERY, "recovery")] {
            if has(|p| &p.events, edge) {
                add(Symbol::Upright(style), name);
            }
        }
        let mut colors: Vec<Color> = Vec::new();
        for panel in panels().filter(|p| !p.alarms.is_empty()) {
            if !colors.contains(&panel.alarm_color) {
                colors.push(panel.alarm_color);
            }
        }
        // Triangles of several methods have the colors of their lines.
        let color = if let [only] = colors.as_slice() { *only } else { Color::Gray };
        for (edge, name) in [(Edge::Begins, "alarm begins"), (Edge::Ends, "alarm ends")] {
            if has(|p| &p.alarms, edge) {
                add(Symbol::Alarm(color, edge), name);
            }
        }
        out
    }

    /// The panels in blocks of at most `most` columns, so that they stay readable.
    fn blocks(&self, most: usize) -> Vec<Block<'_>> {
        if self.headings.is_empty() {
            let rows = self.rows.iter().flat_map(|row| row.chunks(most).map(|part| part.iter().collect()));
            return vec![Block { headings: &[], rows: rows.collect() }];
        }
        // Headings without a panel below are left out.
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let block = |first: usize| {
            let part = |length: usize| first.min(length)..(first + most).min(length);
            let rows = self.rows.iter().map(|row| row[part(row.len())].iter().collect()).collect();
            Block { headings: &self.headings[part(self.headings.len().min(columns))], rows }
        };
        (0..columns).step_by(most).map(block).collect()
    }

    fn draw_stills(&self, scene: &mut Scene, mut y: f64) -> f64 {
        let most = ((scene.width / LEAST_STILL) as usize).max(1);
        let a_row = self.stills.len().max(3).min(most);
        let gap = 6.0;
        let w = (scene.width - 2.0 * MARGIN - gap * (a_row - 1) as f64) / a_row as f64;
        for row in self.stills.chunks(a_row) {
            // Frames taller than wide are kept to the height of a square.
            let sized: Vec<(f64, f64)> = row
                .iter()
                .map(|s| {
                    let aspect = s.pixels.height() as f64 / s.pixels.width() as f64;
                    if aspect > 1.0 { (w / aspect, w) } else { (w, w * aspect) }
                })
                .collect();
            let tallest = sized.iter().map(|s| s.1).fold(0.0, f64::max);
            for (i, (still, (sw, sh))) in row.iter().zip(sized).enumerate() {
                let x = MARGIN + i as f64 * (w + gap) + (w - sw) / 2.0;
                let area = Area { x, y: y + tallest - sh, w: sw, h: sh };
                draw_still(scene, still, area);
                let text = if still.caption.trim().is_empty() {
                    format!("frame {}", still.number)
                } else {
                    format!("frame {}: {}", still.number, still.caption)
                };
                let text = font::fit(&text, SMALL, w);
                scene.text(&text, (x + sw / 2.0, y + tallest + 9.0), SMALL, Anchor::Middle, INK);
            }
            y += tallest + 22.0;
        }
        y
    }
}

/// Panels whose columns belong together.
struct Block<'s> {
    headings: &'s [String],
    rows: Vec<Vec<&'s Panel>>,
}

/// The room of all blocks: plots of the same column share their left edge, and all are equally large.
struct Sheet {
    columns: usize,
    gap: f64,
    /// Width of a column with its labels, and height of a plot.
    cell: (f64, f64),
    /// Room for the labels of each column.
    left: Vec<f64>,
    /// Room for captions and legends: that of the highest, so that a legend does not shift the panels below it.
    head: f64,
}

impl Sheet {
    fn new(columns: usize, width: f64) -> Self {
        let gap = if columns > 3 { 10.0 } else { GAP };
        let height = match columns {
            1 => 130.0,
            2 => 140.0,
            3 => 150.0,
            _ => 110.0,
        };
        let column = (width - 2.0 * MARGIN - gap * (columns - 1) as f64) / columns as f64;
        Self { columns, gap, cell: (column, height), left: vec![0.0; columns], head: 0.0 }
    }

    /// Width of a plot.
    fn plot(&self, width: f64) -> f64 {
        let gaps = self.gap * (self.columns - 1) as f64;
        (width - 2.0 * MARGIN - gaps - self.left.iter().sum::<f64>()) / self.columns as f64 - 6.0
    }
}

type Layouts<'s> = Vec<Vec<PanelLayout<'s>>>;

impl<'s> Block<'s> {
    /// Lays the panels out, and makes room for them on the sheet.
    fn layouts(&self, sheet: &mut Sheet) -> Result<Layouts<'s>, FigureError> {
        let mut grid: Layouts<'s> = Vec::new();
        for row in &self.rows {
            grid.push(row.iter().map(|&p| PanelLayout::new(p, sheet.cell)).collect::<Result<_, _>>()?);
        }
        if sheet.columns > 2 {
            for row in &mut grid {
                for c in (1..row.len())
                    .rev()
                    .filter(|c| row[*c].entries() == row[c - 1].entries())
                    .collect::<Vec<_>>()
                {
                    row[c].without_legend();
                }
            }
        }
        for (c, left) in sheet.left.iter_mut().enumerate() {
            let here = || (0..self.rows.len()).filter(move |r| c < self.rows[*r].len());
            let name = if here().any(|r| self.is_named(r, c)) { 18.0 } else { 0.0 };
            let labels = here().map(|r| grid[r][c].labels(sheet.cell.1)).fold(0.0, f64::max);
            *left = left.max(name + 7.0 + labels);
        }
        sheet.head = grid.iter().flatten().map(PanelLayout::head).fold(sheet.head, f64::max);
        Ok(grid)
    }

    /// Whether the axis of a panel has its name: not where the neighbor on the left has the same.
    fn is_named(&self, r: usize, c: usize) -> bool {
        c == 0 || self.rows[r][c].label != self.rows[r][c - 1].label
    }

    /// Draws the panels below `y`; returns the first free line below them.
    fn draw(&self, scene: &mut Scene, sheet: &Sheet, grid: &Layouts<'s>, mut y: f64) -> f64 {
        let (plot, height) = (sheet.plot(scene.width), sheet.cell.1);
        let mut lefts = vec![MARGIN];
        for left in &sheet.left {
            lefts.push(lefts[lefts.len() - 1] + left + plot + 6.0 + sheet.gap);
        }
        if self.headings.iter().any(|h| !h.trim().is_empty()) {
            for (c, text) in self.headings.iter().enumerate() {
                let text = font::fit(text, MEDIUM, plot);
                let middle = lefts[c] + sheet.left[c] + plot / 2.0;
                scene.text(&text, (middle, y + 8.0), MEDIUM, Anchor::Middle, INK);
            }
            y += 20.0;
        }
        for (r, row) in grid.iter().enumerate() {
            y += sheet.head + 4.0;
            let mut foot: f64 = 8.0;
            for (c, panel) in row.iter().enumerate() {
                let x = lefts[c];
                let area = Area { x: x + sheet.left[c], y, w: plot, h: height };
                // Frame numbers stand under the last of a stack of panels over the same frames.
                let below = self.rows.get(r + 1).and_then(|row| row.get(c));
                let last = below.is_none_or(|p| p.frames != self.rows[r][c].frames);
                panel.draw(scene, &area, x, sheet.head, last);
                if self.is_named(r, c) {
                    let label = font::fit(&self.rows[r][c].label, MEDIUM, height + 20.0);
                    scene.text_upwards(&label, (x + 7.0, y + height / 2.0), MEDIUM, INK);
                }
                if last {
                    let at = (area.x + area.w / 2.0, area.bottom() + 26.0);
                    scene.text("frame", at, SMALL, Anchor::Middle, INK);
                    foot = 36.0;
                }
            }
            y += height + foot;
        }
        y + 2.0
    }
}

fn draw_still(scene: &mut Scene, still: &Still, area: Area) {
    let (sx, sy) = (area.w / still.pixels.width() as f64, area.h / still.pixels.height() as f64);
    for (region, style) in &still.boxes {
        let mut corners: Vec<Point> =
            region.corners().iter().map(|c| (area.x + c.0 * sx, area.y + c.1 * sy)).collect();
        if corners.iter().any(|c| !axes::usable(c.0) || !axes::usable(c.1)) {
            continue;
        }
        corners.extend(corners.first().copied());
        let (rgb, dash) = style.look();
        scene.clipped(&corners, &area, Stroke { rgb: CASING, width: 3.2, dash: Dash::Solid });
        scene.clipped(&corners, &area, Stroke { rgb, width: 1.7, dash });
    }
    scene.pictures.push(Picture { area, frame: still.pixels.clone() });
}
