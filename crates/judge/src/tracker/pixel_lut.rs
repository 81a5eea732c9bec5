//! A reconstruction of PLT_14, the most robust of the four trackers whose VOT2014 results Khalid, Cavallaro
//! and Rinner (BMVC 2016, Table 2) judge: a window classifier of look-up tables, learned online.
//!
//! PLT_14 (Heng, Lim, Niu and Li) is known from half a page in the VOT2013 and VOT2014 reports; there is no
//! paper and no code. From there: a linear classifier on quantized colors, gray levels and gradients,
//! evaluated by looking up every pixel's code; a structural SVM learned online; a soft mask of the target
//! from color histograms; one scale, no motion model, nothing random. All numbers and everything below those
//! words are choices made here. Results are those of this reconstruction.
//!
//! ```text
//! s(y) = sum_c T_c[code(c + y)] = w . phi(y)   y: whole shifts within the radius, c: the cells of the box
//! y* = argmax s(y)                             high is good; no unit
//! l = loss(y) - w . (phi(y*) - phi(y)),  loss(y) = 1 - IoU(y, y*)
//! w <- w + min(C, l / (d' M d)) M d,  d = phi(y*) - phi(y),  where l > 0
//! ```
//!
//! `phi` is one-hot: three codes a cell (color 8 x 8 x 8, gray level 16, direction of the gradient 8 or
//! flat) at the pixel that holds the cell's center, each of length `1 / sqrt(3 cells)`. `M` is diagonal: `f
//! + (1 - f) P`, with `P` the probability that the color under the cell in `y*` is the target's rather than
//! its surroundings' (histograms of 16 x 16 x 16, equal priors) and `f` the `mask_floor`. The update is the
//! passive-aggressive one (Crammer et al., JMLR 7, 2006, PA-I) for the structured loss of Struck (Hare,
//! Saffari and Torr, ICCV 2011): the smallest change, in the metric of `1 / M`, after which the window
//! keeps its margin. Coordinates are 0-based as in [`crate::region`].
//!
//! A frame: code the surroundings, score all windows (every one of them, exactly), move to the best one
//! (whole pixels), pick the windows that violate their margin most, no two within an eighth of the box, and
//! step `rounds` times on the worst of them; then one step on the worst window of every remembered frame.
//! The first frame is remembered for good and learned in four such passes, the others are a queue. A frame
//! whose best score is below `learn_above` times its running mean over the frames that taught (rate 0.05)
//! teaches nothing: the target is hidden or lost. Windows whose center leaves the frame are not considered;
//! pixels beyond the border repeat it.
//!
//! The box is the region's rectangle, cut to the frame's size around its center; the answer has the
//! region's own sides in proportion.
//!
//! Defaults: radius and loss are Struck's; 16 cells a side and `learn_above` are those with the fewest lost
//! frames on the 19 public sequences of OTB and VOT2014 on which they were tried (coarser and finer grids
//! lost more), so results on these are not blind. Two more of the reports' words are left out: weak features
//! are not shrunk, and the size, there from scores projected back to the pixels, is fixed. What was made of
//! the words alone made the tracker a little worse on those sequences.

mod codes;
mod colors;
mod model;
#[cfg(test)]
mod tests;

use crate::tracker::prelude::*;
use codes::Codes;
use colors::Colors;
use model::{Example, Model, Pattern};

/// Rate of the running mean of the score.
const FOLLOW: f32 = 0.05;

/// Parameters of the tracker.
#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Maximum number of cells per side of the template, from 2 to 64.
    #[default(16)]
    pub cells: usize,
    /// Search radius in every direction, in pixels, from 1 to 100.
    #[default(30)]
    pub search_radius: usize,
    /// Length of the gradient below which a pixel is flat, in gray levels over two pixels, from 0 to 400.
    #[default(16.0)]
    pub flat_below: f64,
    /// Largest step C of the passive-aggressive update, from 0.001 to 1000.
    #[default(0.2)]
    pub aggressiveness: f64,
    /// Number of windows per frame for learning, from 1 to 200.
    #[default(12)]
    pub violators: usize,
    /// Number of frames that are rehearsed, from 2 to 500, including the first frame.
    #[default(40)]
    pub memory: usize,
    /// Interval at which frames are remembered, from 1 to 1000 frames.
    #[default(4)]
    pub remember_every: usize,
    /// Number of steps over the windows of the newest frame, from 1 to 100.
    #[default(8)]
    pub rounds: usize,
    /// Least share of the usual score for learning from a frame, from 0 to 1.
    #[default(0.4)]
    pub learn_above: f64,
    /// Least weight of a cell in learning, from 0.01 to 1 (1: all equal).
    #[default(0.2)]
    pub mask_floor: f64,
    /// Rate at which the color histograms are updated, from 0 to 1.
    #[default(0.05)]
    pub color_rate: f64,
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[
        Range::within("flat_below", 0.0, 400.0),
        Range::within("aggressiveness", 0.001, 1000.0),
        Range::within("learn_above", 0.0, 1.0),
        Range::within("mask_floor", 0.01, 1.0),
        Range::within("color_rate", 0.0, 1.0),
        Range::within("cells", 2.0, 64.0),
        Range::within("search_radius", 1.0, 100.0),
        Range::within("violators", 1.0, 200.0),
        Range::within("memory", 2.0, 500.0),
        Range::within("remember_every", 1.0, 1000.0),
        Range::within("rounds", 1.0, 100.0),
    ];
}

/// The PLT reconstruction in the list of trackers.
pub const ENTRY: Entry<dyn TrackerConfig> = Entry::of::<Params>(
    "pixel-lut",
    1,
    "reconstruction of PLT_14: windows scored by look-up tables of pixel codes, learned online",
);

impl TrackerConfig for Params {
    fn facts(&self) -> Facts {
        Facts::BOXES
    }

    fn start(&self, _: &RunContext<'_>, frame: &Frame, region: &Region) -> StartResult {
        let given = region.rect();
        if ![given.x, given.y, given.w, given.h].iter().all(|v| v.is_finite()) {
            return Err(TrackerError::no_region("pixel-lut"));
        }
        let (cx, cy) = given.center();
        let (w, h) = (given.w.clamp(1.0, frame.width() as f64), given.h.clamp(1.0, frame.height() as f64));
        let rect = Rect::new(cx - w / 2.0, cy - h / 2.0, w, h);
        let cells = |side: f64| (side.round() as usize).clamp(1, self.cells);
        let (columns, rows) = (cells(w), cells(h));
        let mut target = Target {
            stretch: (given.w / w, given.h / h),
            grid: Grid::new(&rect, (columns, rows), self.search_radius),
            model: Model::new(columns * rows),
            codes: Codes::default(),
            scores: Vec::new(),
            colors: Colors::new(),
            memory: Vec::new(),
            frames: 0,
            usual: 0.0,
            rect,
        };
        target.look(self, frame);
        target.colors.follow(frame, &target.codes, &target.rect, 1.0);
        let middle = (self.search_radius, self.search_radius);
        // The first windows to learn from are chosen without weights; later rounds see what was learned.
        for _ in 0..4 {
            target.scan(self);
            let example = target.example(self, frame, middle);
            for _ in 0..self.rounds {
                target.model.learn(&example, self.aggressiveness as f32);
            }
            if let Some(first) = target.memory.first_mut() {
                first.others.extend(example.others);
            } else {
                target.memory.push(example);
            }
        }
        target.usual = target.model.score(&target.memory[0].target);
        let tracker = Tracking { params: self.clone(), target };
        Ok((Box::new(tracker), TrackerState::initialized(region.clone())))
    }
}

struct Tracking {
    params: Params,
    target: Target,
}

/// Target with its model.
struct Target {
    /// Box that is searched, at most as large as the frame.
    rect: Rect,
    /// Ratio of the reported sides to those of the box.
    stretch: (f64, f64),
    grid: Grid,
    model: Model,
    codes: Codes,
    scores: Vec<f32>,
    colors: Colors,
    memory: Vec<Example>,
    frames: usize,
    usual: f32,
}

/// Pixels under the cells of the unshifted box.
struct Grid {
    /// Left top pixel of the block that is coded.
    origin: (i64, i64),
    /// Size of the block that is coded.
    size: (usize, usize),
    /// Columns of the cells at shift `(-radius, -radius)`, within the block; the rows follow.
    columns: Vec<usize>,
    rows: Vec<usize>,
}

impl Grid {
    fn new(rect: &Rect, cells: (usize, usize), radius: usize) -> Self {
        let line = |start: f64, side: f64, n: usize| {
            let first = start.clamp(-1e9, 1e9).floor();
            let within = start.clamp(-1e9, 1e9) - first;
            let places: Vec<usize> =
                (0..n).map(|k| (within + (k as f64 + 0.5) * side / n as f64) as usize).collect();
            let length = (within + side).ceil() as usize + 2 * radius;
            (first as i64 - radius as i64, length, places)
        };
        let (x, w, columns) = line(rect.x, rect.w, cells.0);
        let (y, h, rows) = line(rect.y, rect.h, cells.1);
        Self { origin: (x, y), size: (w, h), columns, rows }
    }

    /// Columns and rows of the cells, row by row.
    fn cells(&self) -> impl Iterator<Item = (usize, usize)> {
        self.rows.iter().flat_map(move |&y| self.columns.iter().map(move |&x| (x, y)))
    }

    /// Codes under the cells at a shift, which counts from `(-radius, -radius)`.
    fn pattern(&self, codes: &Codes, (dx, dy): (usize, usize)) -> Pattern {
        let places = self.cells().map(|(x, y)| (y + dy) * codes.width + x + dx);
        let (colors, tones) = places.map(|at| (codes.colors[at], codes.tones[at])).unzip();
        Pattern { colors, tones }
    }
}

impl Tracker for Tracking {
    fn update(&mut self, frame: &Frame) -> Result<TrackerState, TrackerError> {
        let t = &mut self.target;
        let p = &self.params;
        t.look(p, frame);
        t.scan(p);
        let (best, place) = t.best(p, frame);
        t.frames += 1;
        let r = p.search_radius as f64;
        t.rect = t.rect.shifted(place.0 as f64 - r, place.1 as f64 - r);
        if f64::from(best) >= p.learn_above * f64::from(t.usual) {
            t.colors.follow(frame, &t.codes, &t.rect, p.color_rate);
            let example = t.example(p, frame, place);
            for _ in 0..p.rounds {
                if t.model.learn(&example, p.aggressiveness as f32) == 0.0 {
                    break;
                }
            }
            for old in &t.memory {
                t.model.learn(old, p.aggressiveness as f32);
            }
            if t.frames.is_multiple_of(p.remember_every) {
                if t.memory.len() >= p.memory {
                    t.memory.remove(1);
                }
                t.memory.push(example);
            }
            t.usual += FOLLOW * (best - t.usual);
        }
        let (cx, cy) = t.rect.center();
        let (w, h) = (t.rect.w * t.stretch.0, t.rect.h * t.stretch.1);
        Ok(TrackerState::tracked(Region::Rect(Rect::new(cx - w / 2.0, cy - h / 2.0, w, h))))
    }
}

impl Target {
    /// Codes the part of a frame around the box.
    fn look(&mut self, p: &Params, frame: &Frame) {
        let cells = (self.grid.columns.len(), self.grid.rows.len());
        self.grid = Grid::new(&self.rect, cells, p.search_radius);
        self.codes.look(frame, self.grid.origin, self.grid.size, p.flat_below);
    }

    /// Scores all windows.
    fn scan(&mut self, p: &Params) {
        self.model.tabulate();
        let (grid, side) = (&self.grid, 2 * p.search_radius + 1);
        self.model.scan(&self.codes, &grid.columns, &grid.rows, side, &mut self.scores);
    }

    /// Highest score of a window with its center in the frame, and the shift; among equal scores the nearest,
    /// then topmost, then leftmost.
    fn best(&self, p: &Params, frame: &Frame) -> (f32, (usize, usize)) {
        let r = p.search_radius as i64;
        let (cx, cy) = self.rect.center();
        let inside = |c: f64, d: i64, room: usize| (0.0..=room as f64).contains(&(c + d as f64));
        let mut best = (f32::NEG_INFINITY, i64::MAX, (p.search_radius, p.search_radius));
        for (row, dy) in self.scores.chunks_exact(2 * p.search_radius + 1).zip(-r..) {
            if !inside(cy, dy, frame.height()) {
                continue;
            }
            for (&score, dx) in row.iter().zip(-r..) {
                let far = dx * dx + dy * dy;
                if (score > best.0 || (score == best.0 && far < best.1)) && inside(cx, dx, frame.width()) {
                    best = (score, far, ((dx + r) as usize, (dy + r) as usize));
                }
            }
        }
        (best.0, best.2)
    }

    /// The window at `place`, and windows that violate their margin most, no two of which are close to each
    /// other.
    fn example(&self, p: &Params, frame: &Frame, place: (usize, usize)) -> Example {
        let side = 2 * p.search_radius + 1;
        let (w, h) = (self.rect.w, self.rect.h);
        let loss = |x: usize, y: usize| {
            let (dx, dy) = (x.abs_diff(place.0) as f64, y.abs_diff(place.1) as f64);
            let both = (w - dx).max(0.0) * (h - dy).max(0.0);
            (1.0 - both / (2.0 * w * h - both)) as f32
        };
        let mut values: Vec<f32> = Vec::with_capacity(side * side);
        for (y, row) in self.scores.chunks_exact(side).enumerate() {
            values.extend(row.iter().enumerate().map(|(x, s)| s + loss(x, y)));
        }
        let near = ((w.min(h) / 8.0) as usize).clamp(1, p.search_radius.div_ceil(3));
        values[place.1 * side + place.0] = f32::NEG_INFINITY;
        let mut others = Vec::new();
        while others.len() < p.violators {
            let top = super::first_largest(values.iter().map(|v| f64::from(*v)));
            if values[top] == f32::NEG_INFINITY {
                break;
            }
            let (x, y) = (top % side, top / side);
            others.push((self.grid.pattern(&self.codes, (x, y)), loss(x, y)));
            for row in values.chunks_exact_mut(side).skip(y.saturating_sub(near)).take(2 * near + 1) {
                row[x.saturating_sub(near)..(x + near + 1).min(side)].fill(f32::NEG_INFINITY);
            }
        }
        let weight = |(x, y): (usize, usize)| {
            let (left, top) = self.grid.origin;
            let at = ((x + place.0) as i64 + left, (y + place.1) as i64 + top);
            (p.mask_floor + (1.0 - p.mask_floor) * self.colors.probability(frame, at.0, at.1)) as f32
        };
        let mask = self.grid.cells().map(weight).collect();
        Example { target: self.grid.pattern(&self.codes, place), others, mask }
    }
}
