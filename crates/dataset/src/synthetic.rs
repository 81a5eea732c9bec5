//! Synthetic suites: rendered sequences with exact ground truth, so that everything runs without data.
//!
//! * `synthetic-otb`: 20 sequences with upright boxes and OTB's attributes (occlusion, clutter of
//!   look-alikes, changes of light and scale, fast motion, blur, rotation, low resolution).
//! * `synthetic-vot`: 9 sequences with turned boxes and VOT's attributes for each frame.
//! * `synthetic-d1`, `synthetic-d2`: 18 and 51 sequences of cars, people and faces as surveillance cameras see
//!   them, see below.
//!
//! A sequence is a plan (who moves where, before which background) played by `scene`: a background picture
//! scrolled by the camera, sprites warped bilinearly over it, motion blur as the mean of instants within the
//! exposure, light and shadow, sensor noise from a hash of place and frame. Frames depend on names alone and
//! can be rendered in any order; only IEEE-exact operations are used, so that they are the same bytes
//! everywhere. Ground truth is the box of the whole target, even where it is hidden, as in OTB, on a grid of
//! 1/64 pixel. For a turned target, the upright box bounds the ellipse inscribed in the turned box.
//!
//! The plans are data, see [`scenes`]. To add a sequence, add its scene to the suite's file and raise [`VERSION`].
//!
//! # `synthetic-d1` and `synthetic-d2`
//!
//! They stand in for the data sets D1 and D2 of SanMiguel and Cavallaro,
//! "Temporal validation of Particle Filters for video tracking" (CVIU 131, 2015, section 7).
//!
//! The paper's sets are 18 targets in about 3400 frames and 51 targets in about 7500 frames, chosen from
//! CAVIAR, PETS2001, PETS2010, CLEMSON, VISOR, AVSS2007, TRECVID and MIT TRAFFIC; which clips, frames and
//! targets they are is not published. These suites have the same numbers of targets, about as many frames,
//! the same three types of target (`target-car`, `target-person`, `target-face`) and the difficulties that
//! the paper names: total and partial occlusion by scenery and by others, clutter of similar colors, changes
//! of light and of scale; limbs swing and heads turn, so that a target's own colors change too. **None of the
//! paper's video is in them**, and no number found on them is a number about the paper's sets.
//!
//! How they differ: cameras stand still, except for a few pans; every target is annotated in every frame,
//! also where it is hidden (the paper does not say how it annotates such frames); it is whole and in full
//! view in the first 25 frames; textures and gaits are simpler than in video. `synthetic-d1` has more people
//! and cars of the target's own colors about, so that a lost color tracker often finds something, at times
//! the target again; `synthetic-d2` has calmer scenes with fewer look-alikes and longer ways behind scenery,
//! after which a tracker stays lost. They were set so that a color particle filter with the paper's
//! parameters changes between "no overlap with the ground truth" and "some overlap" about as often per target
//! as the paper counts (1.21 on D1, 0.92 on D2). The suites have 18 targets in 3630 frames and 51 in 7560.

mod actor;
mod figures;
mod ground;
mod motion;
mod noise;
mod scene;
pub mod scenes;
mod sensor;
mod sprite;

#[cfg(test)]
mod tests;

use super::Sequence;
use super::digest::Hash;
use super::suite::Origin;
use scenes::SceneFile;
use serde::Deserialize;
use std::path::Path;
use std::sync::OnceLock;

/// Raised whenever a frame or a region of any sequence changes.
pub const VERSION: u32 = 1;

/// Layout in which `trackfail data render` writes a suite.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RenderLayout {
    /// `<Seq>/img/0001.png` and `groundtruth_rect.txt`, with pixels counted from 1.
    Otb,
    /// `<seq>/00000001.png` and `groundtruth.txt` of corners, with pixels counted from 0.
    Vot,
}

/// A suite of rendered sequences.
#[derive(Debug)]
pub struct RenderedSuite {
    /// Name of the suite in experiment files.
    pub name: &'static str,
    text: &'static str,
    parsed: OnceLock<SceneFile>,
}

impl RenderedSuite {
    const fn new(name: &'static str, text: &'static str) -> Self {
        Self { name, text, parsed: OnceLock::new() }
    }

    /// Scenes of the suite, parsed at the first call.
    pub fn scenes(&self) -> &SceneFile {
        self.parsed.get_or_init(|| {
            scenes::parse(Path::new(self.name), self.text).expect("the scenes are part of the program")
        })
    }

    /// Sequences with their ground truth. Nothing is painted until a frame is rendered. The digest of a
    /// sequence is made of its names and [`VERSION`], not of pixels; a test ensures that the version is
    /// raised when pixels change.
    pub fn sequences(&self) -> Vec<Sequence> {
        let mut sequences = self.scenes().sequences(self.name);
        for sequence in &mut sequences {
            let (video, source) = (sequence.name.clone(), self.name.into());
            sequence.origin = Origin { video, source, ..Origin::default() };
            let bits = scene::bits(self.name, &sequence.name).to_string();
            let mut hash = Hash::new("trackfail synthetic");
            for part in [&*VERSION.to_string(), self.name, &sequence.name, &bits] {
                hash.bytes(part.as_bytes());
            }
            sequence.digest = hash.hexadecimal().into();
        }
        sequences
    }
}

/// Every synthetic suite.
pub static SUITES: [RenderedSuite; 4] = [
    RenderedSuite::new("synthetic-otb", include_str!("../../../scenes/synthetic-otb.toml")),
    RenderedSuite::new("synthetic-vot", include_str!("../../../scenes/synthetic-vot.toml")),
    RenderedSuite::new("synthetic-d1", include_str!("../../../scenes/synthetic-d1.toml")),
    RenderedSuite::new("synthetic-d2", include_str!("../../../scenes/synthetic-d2.toml")),
];

/// True if the program renders the suite of this name, so that it is not real video.
pub fn is_rendered(name: &str) -> bool {
    SUITES.iter().any(|suite| suite.name == name)
}

/// Sequences of a rendered suite; `None` if no rendered suite has the name.
pub fn suite(name: &str) -> Option<Vec<Sequence>> {
    SUITES.iter().find(|s| s.name == name).map(RenderedSuite::sequences)
}
