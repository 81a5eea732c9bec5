//! Trackers that find their target by one kernel filter: place of the target, and its moves by responses.

use super::response::{MapOptions, ResponseMap};
use super::{KernelFilter, halvings, reduced};
use crate::image::Frame;
use crate::region::{Rect, Region};
use crate::tracker::{StartResult, Tracker, TrackerError, TrackerState};

/// Place of a target, in pixels of the frame.
#[derive(Debug, Clone)]
pub struct Place {
    /// Upright rectangle of the first region.
    pub first: Rect,
    /// Shift of the center since the first frame, in pixels.
    pub moved: (f64, f64),
    /// Size of the target relative to the first region.
    pub scale: f64,
    /// Number of times that frames are halved.
    pub halvings: u32,
    /// Sides of the first rectangle in pixels of the halved frame, at most those of the frame.
    pub sides: (f64, f64),
}

impl Place {
    /// Place of a region in a frame of this size. With `halves`, frames of large targets are halved.
    pub fn new(region: &Region, frame: (usize, usize), halves: bool) -> Self {
        let first = region.bounds();
        let (w, h) = (first.w.clamp(1.0, frame.0 as f64), first.h.clamp(1.0, frame.1 as f64));
        let times = if halves { halvings((w * h).sqrt()) } else { 0 };
        let factor = f64::from(1_u32 << times);
        let side = |side: f64| if times > 0 { (side / factor).floor().max(1.0) } else { side };
        Self { first, moved: (0.0, 0.0), scale: 1.0, halvings: times, sides: (side(w), side(h)) }
    }

    /// Side of a pixel of the halved frame, in pixels of the frame.
    pub fn factor(&self) -> f64 {
        f64::from(1_u32 << self.halvings)
    }

    /// Current rectangle: the first one, moved and scaled.
    pub fn rect(&self) -> Rect {
        let (cx, cy) = self.first.center();
        let (w, h) = (self.first.w * self.scale, self.first.h * self.scale);
        Rect::new(cx + self.moved.0 - 0.5 * w, cy + self.moved.1 - 0.5 * h, w, h)
    }

    /// Clamps the place so that the target overlaps the frame and, if it was scaled, is no larger than the
    /// frame.
    fn keep_inside(&mut self, frame: &Frame, tolerance: f64) {
        let (width, height) = (frame.width() as f64, frame.height() as f64);
        let Rect { w, h, .. } = self.first;
        if self.scale != 1.0 {
            // The window of a larger target is that of one as large as the frame.
            let (w, h) = (w.min(width), h.min(height));
            let most = (width / w).min(height / h).max(1e-9);
            let least = (4.0 / w.min(h)).min(1.0).min(most);
            self.scale = self.scale.clamp(least, most);
        }
        let scale = self.scale;
        let touch = |center: f64, moved: f64, side: f64, room: f64| {
            let reach = 0.5 * (side * scale).min(room);
            let inside = (center + moved).clamp(-reach, room + reach);
            // Only coordinates that were outside change, so that moves by whole pixels stay exact.
            let is_outside = (center + moved - inside).abs() > tolerance * center.abs().max(1.0);
            if is_outside { inside - center } else { moved }
        };
        let (cx, cy) = self.first.center();
        self.moved = (touch(cx, self.moved.0, w, width), touch(cy, self.moved.1, h, height));
    }
}

/// Features of the window around a target.
pub trait Look: Clone + Send + 'static {
    /// Computes the features of the window around the target, at the target's scale times `step`.
    fn look(&mut self, place: &Place, frame: &Frame, step: f64, features: &mut Vec<f32>);

    /// Side of a cell of that window, in pixels of the frame.
    fn cell_side(&self, place: &Place, step: f64) -> f64;

    /// Reported region of a target.
    fn region(&self, place: &Place) -> Region {
        Region::Rect(place.rect())
    }

    /// Saves the state of the tracker; `None` from trackers that cannot be interrupted.
    fn save(&self, _place: &Place, _filter: &KernelFilter) -> Option<Vec<u8>> {
        None
    }
}

/// Rules of the search for the highest response.
#[derive(Debug, Clone)]
pub struct Search {
    /// Scales to try, relative to the target's; among equal responses the first one wins.
    pub steps: Vec<f64>,
    /// Factor of the responses at scales other than the target's.
    pub weight: f32,
    /// True if a smaller scale with a better response ends the search.
    pub smaller_ends: bool,
    /// True if the peak is located between cells.
    pub sub_cell: bool,
    /// Largest move back to the frame that counts as rounding error and is not made, relative to the first
    /// center's coordinate (at least 1 pixel).
    pub tolerance: f64,
    /// Options for reading the response map.
    pub response: MapOptions,
}

/// A target that is followed by a kernel filter.
#[derive(Clone)]
pub struct Follower<L> {
    /// Place of the target.
    pub place: Place,
    /// Computes the features of the target's window.
    pub look: L,
    /// Kernel filter of the target.
    pub filter: KernelFilter,
    search: Search,
    /// Response with the highest peak in the newest frame.
    map: ResponseMap,
    features: Vec<f32>,
}

impl<L: Look> Follower<L> {
    /// Creates a target with an untrained filter.
    pub fn new(place: Place, look: L, filter: KernelFilter, search: Search) -> Self {
        let map = ResponseMap::new(filter.fourier.width(), filter.fourier.height());
        Self { place, look, filter, search, map, features: Vec::new() }
    }

    /// Learns the target in its first frame.
    pub fn start(mut self, frame: &Frame, region: &Region) -> StartResult {
        self.learn(&reduced(frame, self.place.halvings));
        let cell = self.look.cell_side(&self.place, 1.0);
        match self.filter.respond(&self.features) {
            Some(peak) => self.map.take(&mut self.filter.plane, peak, cell),
            None => self.map.clear(cell),
        }
        let state = self.map.describe(&self.search.response, TrackerState::initialized(region.clone()));
        Ok((Box::new(self), state))
    }

    /// Learns the window at the target's place.
    fn learn(&mut self, frame: &Frame) {
        self.look.look(&self.place, frame, 1.0, &mut self.features);
        self.filter.learn(&self.features);
    }

    /// Moves and scales the target by the highest response.
    fn follow(&mut self, frame: &Frame) {
        let Self { place, look, filter, search, map, features } = self;
        let mut best: Option<(f32, f64, f64, (f64, f64))> = None;
        for &step in &search.steps {
            look.look(place, frame, step, features);
            let Some(peak) = filter.respond(features) else { continue };
            let value = if step == 1.0 { peak.value } else { search.weight * peak.value };
            if best.is_none_or(|(highest, ..)| value > highest) {
                let whole = (peak.x as f64, peak.y as f64);
                let shift = if search.sub_cell { filter.refine(&peak) } else { whole };
                let cell = look.cell_side(place, step);
                best = Some((value, step, cell, shift));
                map.take(&mut filter.plane, peak, cell);
                if search.smaller_ends && step < 1.0 {
                    break;
                }
            }
        }
        let Some((_, step, cell, (dx, dy))) = best else {
            map.clear(look.cell_side(place, 1.0));
            return;
        };
        place.scale *= step;
        place.moved = (place.moved.0 + dx * cell, place.moved.1 + dy * cell);
    }
}

impl<L: Look> Tracker for Follower<L> {
    fn update(&mut self, frame: &Frame) -> Result<TrackerState, TrackerError> {
        let small = reduced(frame, self.place.halvings);
        self.follow(&small);
        self.place.keep_inside(frame, self.search.tolerance);
        self.learn(&small);
        let state = TrackerState::tracked(self.look.region(&self.place));
        Ok(self.map.describe(&self.search.response, state))
    }

    fn fork(&self, _seed: Option<u64>) -> Option<Box<dyn Tracker>> {
        Some(Box::new(self.clone()))
    }

    fn save(&self) -> Option<Vec<u8>> {
        self.look.save(&self.place, &self.filter)
    }
}
