//! Synthetic suites: rendered sequences with exact ground truth, so that everything runs without data.
//!
//! * `synthetic-otb`: 20 sequences with upright boxes and OTB's attributes (occlusion, clutter of
//!   look-alikes, changes of light and scale, fast motion, blur, rotation, low resolution).
//! * `synthetic-vot`: 9 sequences with turned boxes and VOT's attributes a frame.
//! * `synthetic-d1`, `synthetic-d2`: 18 and 51 sequences of cars, people and faces as surveillance cameras see
//!   them, stand-ins for the data sets of SanMiguel and Cavallaro (2015), see `surveillance`.
//!
//! A sequence is a plan (who moves where, before which background) played by `scene`: a background
//! picture scrolled by the camera, sprites warped bilinearly over it, motion blur as the mean of
//! instants within the exposure, light and shadow, sensor noise from a hash of place and frame. Frames
//! depend on names alone and can be rendered in any order; only IEEE-exact operations are used, so that
//! they are the same bytes everywhere. Ground truth is the whole target's box also where it is hidden,
//! as OTB annotates it, on a grid of 1/64 pixel. Where a target is turned, the upright box is that of
//! the turned box's inscribed ellipse.
//!
//! To add a sequence, add its plan to the suite's file and raise [`VERSION`].

mod actor;
mod figures;
mod ground;
mod motion;
mod noise;
mod otb;
mod places;
mod scene;
mod sensor;
mod sprite;
mod surveillance;
mod vot;

#[cfg(test)]
mod tests;

use super::Sequence;
pub use scene::FRAME_ATTRIBUTES;

/// Raised whenever a frame or a region of any sequence changes.
pub const VERSION: u32 = 1;

/// Format that `trackfail data render` writes a suite in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RenderLayout {
    /// `<Seq>/img/0001.png` and `groundtruth_rect.txt`, counted from 1.
    Otb,
    /// `<seq>/00000001.png` and `groundtruth.txt` with corners, counted from 0.
    Vot,
}

/// A suite of rendered sequences.
#[derive(Debug, Clone, Copy)]
pub struct RenderedSuite {
    /// Its name in experiment files.
    pub name: &'static str,
    /// One line about it.
    pub summary: &'static str,
    /// Layout that `trackfail data render` writes.
    pub layout: RenderLayout,
    plans: fn() -> &'static [scene::ScenePlan],
}

impl RenderedSuite {
    fn plans(&self) -> &'static [scene::ScenePlan] {
        (self.plans)()
    }

    /// Number of sequences.
    pub fn len(&self) -> usize {
        self.plans().len()
    }

    /// Whether it has no sequence.
    pub fn is_empty(&self) -> bool {
        self.plans().is_empty()
    }

    /// Names of the sequences, sorted.
    pub fn names(&self) -> impl Iterator<Item = &'static str> + use<> {
        self.plans().iter().map(|p| p.name)
    }

    /// The sequences with their ground truth; nothing is painted until a frame is rendered.
    pub fn sequences(&self) -> Vec<Sequence> {
        self.plans().iter().map(|p| scene::sequence(self.name, VERSION, p)).collect()
    }
}

/// Every synthetic suite.
pub static SUITES: &[RenderedSuite] = &[
    RenderedSuite {
        name: "synthetic-otb",
        summary: "20 rendered sequences with upright boxes and OTB's attributes",
        layout: RenderLayout::Otb,
        plans: || otb::PLANS,
    },
    RenderedSuite {
        name: "synthetic-vot",
        summary: "9 rendered sequences with turned boxes and VOT's attributes a frame",
        layout: RenderLayout::Vot,
        plans: || vot::PLANS,
    },
    RenderedSuite {
        name: "synthetic-d1",
        summary: "18 rendered targets as in surveillance: cars, people, faces (stands in for D1 of CVIU 2015)",
        layout: RenderLayout::Otb,
        plans: surveillance::d1,
    },
    RenderedSuite {
        name: "synthetic-d2",
        summary: "51 rendered targets as in surveillance: cars, people, faces (stands in for D2 of CVIU 2015)",
        layout: RenderLayout::Otb,
        plans: surveillance::d2,
    },
];

/// Whether a suite of this name is rendered by the program, so that it is no real video.
pub fn is_rendered(name: &str) -> bool {
    SUITES.iter().any(|suite| suite.name == name)
}

/// The sequences of a suite, or `None` if there is no such suite.
pub fn suite(name: &str) -> Option<Vec<Sequence>> {
    SUITES.iter().find(|s| s.name == name).map(RenderedSuite::sequences)
}
