//! A NanoTrack that follows a target, with its template and its place.

use super::look::{Look, Place, Target};
use crate::image::Frame;
use crate::network::nanotrack::Version;
use crate::region::{Rect, Region};
use serde::{Deserialize, Serialize};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Most targets, and most looks, that are cached with a frame.
const MAX_NOTES: usize = 32;

/// A target that is followed from frame to frame.
#[derive(Clone)]
pub struct Follower {
    target: Arc<Target>,
    place: Place,
}

/// Targets and looks cached with a frame. Followers of one target from one region, such as the watchdogs of
/// many tracks, run the network only once.
#[derive(Default)]
struct Notes {
    targets: Kept<(Version, Place), Arc<Target>>,
    looks: Kept<(Arc<Target>, Place), Arc<Look>>,
}

type Kept<K, V> = Mutex<Vec<(K, Arc<OnceLock<V>>)>>;

/// Value stored under a key. The first caller computes the value; other callers wait for it.
fn once<K, V: Clone>(kept: &Kept<K, V>, is_it: impl Fn(&K) -> bool, key: K, new: impl FnOnce() -> V) -> V {
    let mut list = kept.lock().unwrap_or_else(PoisonError::into_inner);
    let found = list.iter().find(|(key, _)| is_it(key)).map(|(_, cell)| cell.clone());
    let cell = found.unwrap_or_else(|| {
        let cell = Arc::default();
        if list.len() < MAX_NOTES {
            list.push((key, Arc::clone(&cell)));
        }
        cell
    });
    drop(list);
    cell.get_or_init(new).clone()
}

/// State of a [`Follower`]: its place, the color outside of frames, and the features of the template.
#[derive(Serialize, Deserialize)]
pub struct Memory {
    place: Place,
    color: [f32; 3],
    features: Vec<f32>,
}

impl Follower {
    /// Starts on a region of the first frame; `None` if a coordinate is NaN.
    pub fn start(version: Version, frame: &Frame, region: &Region) -> Option<Self> {
        if !region.is_finite() {
            return None;
        }
        let place = Place::of(&region.bounds()).near([frame.width() as f64, frame.height() as f64]);
        let new = || Arc::new(Target::new(version, frame, &place));
        let target = match frame.notes::<Notes>() {
            Some(notes) => once(&notes.targets, |of| *of == (version, place), (version, place), new),
            None => new(),
        };
        Some(Self { target, place })
    }

    /// Look around the current place.
    pub fn look(&self, frame: &Frame) -> Arc<Look> {
        self.look_around(frame, self.place)
    }

    /// Scores and boxes of the cells around a box.
    pub fn look_at(&self, frame: &Frame, rect: &Rect) -> Arc<Look> {
        self.look_around(frame, Place::of(rect).near([frame.width() as f64, frame.height() as f64]))
    }

    fn look_around(&self, frame: &Frame, place: Place) -> Arc<Look> {
        let is_it =
            |(target, there): &(Arc<Target>, Place)| Arc::ptr_eq(target, &self.target) && *there == place;
        let new = || Arc::new(self.target.look(frame, &place));
        match frame.notes::<Notes>() {
            Some(notes) => once(&notes.looks, is_it, (self.target.clone(), place), new),
            None => new(),
        }
    }

    /// Looks at the next frame and moves to the target.
    pub fn step(&mut self, frame: &Frame) -> Arc<Look> {
        let look = self.look(frame);
        self.place = look.next(frame);
        look
    }

    /// Current box of the target.
    pub fn rect(&self) -> Rect {
        let Place { center: [x, y], sides: [w, h] } = self.place;
        Rect::new(x - w / 2.0, y - h / 2.0, w, h)
    }

    /// Saves the state.
    pub fn memory(&self) -> Memory {
        Memory { place: self.place, color: self.target.color, features: self.target.features.clone() }
    }

    /// Restores a saved state; `None` if it is of another version or invalid.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn frame() -> Frame {
        Frame::from_fn(120, 90, |x, y| [(x * 7 % 256) as u8, (y * 5 % 256) as u8, (x * y % 251) as u8])
    }

    #[test]
    fn who_follows_the_same_target_shares_its_looks() {
        let (frame, region) = (frame(), Region::Rect(Rect::new(40.0, 30.0, 24.0, 20.0)));
        let start = |region: &Region| Follower::start(Version::V2, &frame, region).unwrap();
        let (mut one, mut other) = (start(&region), start(&region));
        assert!(Arc::ptr_eq(&one.step(&frame), &other.step(&frame)));

        let mut elsewhere = start(&Region::Rect(Rect::new(41.0, 30.0, 24.0, 20.0)));
        let mut remembered = Follower::remembered(Version::V2, start(&region).memory()).unwrap();
        let mut alone = Follower::start(Version::V2, &frame.clone(), &region).unwrap();
        let [there, again, copy] =
            [elsewhere.step(&frame), remembered.step(&frame), alone.step(&frame.clone())];
        let first = start(&region).step(&frame);
        let scores = |look: &Look| look.cells.iter().map(|cell| cell.score).collect::<Vec<_>>();
        assert!(!Arc::ptr_eq(&first, &copy) && scores(&first) == scores(&copy));
        assert!(!Arc::ptr_eq(&first, &again) && scores(&first) == scores(&again));
        assert_ne!(scores(&first), scores(&there));
    }
}
