//! A NanoTrack that follows a target: its template, and the place at which it is.

use super::look::{Look, Place, Target};
use crate::image::Frame;
use crate::network::nanotrack::Version;
use crate::region::{Rect, Region};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A target that is followed from frame to frame.
#[derive(Clone)]
pub struct Follower {
    target: Arc<Target>,
    place: Place,
}

/// Memory of a [`Follower`]: its place, the color beyond the frames, the features of the template.
#[derive(Serialize, Deserialize)]
pub struct Memory {
    place: Place,
    color: [f32; 3],
    features: Vec<f32>,
}

impl Follower {
    /// One with the target at a region of the first frame; `None` if a coordinate is no number.
    pub fn start(version: Version, frame: &Frame, region: &Region) -> Option<Self> {
        if !region.is_finite() {
            return None;
        }
        let place = Place::of(&region.bounds()).near([frame.width() as f64, frame.height() as f64]);
        Some(Self { target: Arc::new(Target::new(version, frame, &place)), place })
    }

    /// What it sees around its place.
    pub fn look(&self, frame: &Frame) -> Look {
        self.target.look(frame, &self.place)
    }

    /// Scores and boxes of the cells around a box.
    pub fn look_at(&self, frame: &Frame, rect: &Rect) -> Look {
        self.target.look(frame, &Place::of(rect).near([frame.width() as f64, frame.height() as f64]))
    }

    /// Looks at the next frame and goes where the target is.
    pub fn step(&mut self, frame: &Frame) -> Look {
        let look = self.look(frame);
        self.place = look.next(frame);
        look
    }

    /// Its box.
    pub fn rect(&self) -> Rect {
        let Place { center: [x, y], sides: [w, h] } = self.place;
        Rect::new(x - w / 2.0, y - h / 2.0, w, h)
    }

    /// Everything that it remembers.
    pub fn memory(&self) -> Memory {
        let (color, features) = self.target.memory();
        Memory { place: self.place, color, features }
    }

    /// One that goes on from a memory; `None` if that is of another version or no memory at all.
    pub fn remembered(version: Version, Memory { place, color, features }: Memory) -> Option<Self> {
        let is_place = place.center.iter().chain(&place.sides).all(|v| v.abs() <= 1e9);
        if !is_place
            || place.sides.iter().any(|s| *s < 1.0)
            || !color.iter().all(|c| (0.0..=255.0).contains(c))
        {
            return None;
        }
        let target = Arc::new(Target::remembered(version, color, features)?);
        Some(Self { target, place })
    }
}
