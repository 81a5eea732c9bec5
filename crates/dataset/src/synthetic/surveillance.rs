//! `synthetic-d1` and `synthetic-d2`: rendered stand-ins for the data sets D1 and D2 of SanMiguel and Cavallaro,
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
//! How they differ: cameras stand still but for a few pans; every target is annotated in every frame, also
//! where it is hidden (the paper does not say what it does there); it is whole and in full view in the first
//! 25 frames; textures and gaits are simpler than in video. `synthetic-d1` has more people and cars of the
//! target's own colors about, so that a lost color tracker often finds something, at times the target again;
//! `synthetic-d2` has calmer scenes with fewer look-alikes and longer ways behind scenery, after which a
//! tracker stays lost. They were set so that a color particle filter with the paper's parameters changes
//! between "no overlap with the ground truth" and "some overlap" about as often a target as the paper counts
//! (1.21 on D1, 0.92 on D2). The suites have 18 targets in 3630 frames and 51 in 7560.
//!
//! Names, lengths, frame sizes, types and attributes are in `datasets.lock`; here is what happens in a
//! sequence, a [`Script`] each, which becomes a plan when the suite is first asked for.

mod d1;
mod d2;

use super::actor::Kind;
use super::ground::Ground;
use super::motion::{Curve, at};
use super::scene::{Actor, ScenePlan};
use crate::lock::{self, RenderedEntry};
use std::sync::OnceLock;

/// Script of a sequence. Frames are 0-based, lengths and places in pixels.
#[derive(Debug, Clone, Copy)]
struct Script {
    /// Its name, as in `datasets.lock`.
    name: &'static str,
    /// Its background.
    ground: Ground,
    /// Kind of the target.
    kind: Kind,
    /// Which individual.
    look: u32,
    /// Width and height of the target at scale 1.
    size: (f64, f64),
    /// Frame, column and row of the target's center.
    path: &'static [(f64, f64, f64)],
    /// Magnification of the target.
    scale: Curve,
    /// Turn of a head in cycles; a walker's stride follows from its way.
    pose: Curve,
    /// Clockwise turn of a car in degrees.
    turn: Curve,
    /// For cars that drive to the left.
    mirrored: bool,
    /// The other people and objects, from far to near.
    others: &'static [Other],
    /// World column of the frame's left border.
    camera: Curve,
    /// Brightness.
    light: Curve,
    /// World column of the middle of a shadow, and its width.
    shadow: (Curve, f64),
    /// Largest deviation of the sensor noise in gray levels.
    noise: f64,
}

impl Script {
    /// A script to be completed.
    const EMPTY: Self = Self {
        name: "",
        ground: Ground::Street,
        kind: Kind::Person,
        look: 1,
        size: (26.0, 72.0),
        path: &[],
        scale: &[],
        pose: &[],
        turn: &[],
        mirrored: false,
        others: &[],
        camera: &[],
        light: &[],
        shadow: (&[], 80.0),
        noise: 6.0,
    };
}

/// A walker on a street.
const S: Script = Script::EMPTY;
/// A car from above.
const ROOF: Script = Script { kind: Kind::Roof, ground: Ground::Road, size: (46.0, 23.0), ..S };
/// A car from the side.
const CAR: Script = Script { kind: Kind::Car, size: (62.0, 30.0), ..S };
/// A head of a person in a room.
const HEAD: Script = Script { kind: Kind::Head, ground: Ground::Room, size: (38.0, 48.0), ..S };

/// A person or an object beside the target.
#[derive(Debug, Clone, Copy)]
struct Other {
    /// Kind and size; without them, those of the target.
    own: Option<(Kind, (f64, f64))>,
    look: u32,
    scale: f64,
    path: ActorPath,
    mirrored: bool,
    before: bool,
}

/// Place of a person or an object.
#[derive(Debug, Clone, Copy)]
enum ActorPath {
    /// Always at this place.
    Stand(f64, f64),
    /// At frame `.0` where the target then is, moving straight on with velocity `.1` (pixels a frame).
    Cross(f64, (f64, f64)),
    /// This far from the target at each frame.
    Along(Curve, Curve),
}

impl Other {
    const fn new(own: Option<(Kind, (f64, f64))>, look: u32, path: ActorPath) -> Self {
        Self { own, look, scale: 1.0, path, mirrored: false, before: true }
    }

    /// Drawn before the target in time, that is behind it.
    const fn behind(self) -> Self {
        Self { before: false, ..self }
    }

    const fn scaled(self, scale: f64) -> Self {
        Self { scale, ..self }
    }

    const fn mirrored(self) -> Self {
        Self { mirrored: true, ..self }
    }
}

/// Something that stands at `(x, y)`, before the target.
const fn thing(kind: Kind, look: u32, (x, y): (f64, f64), size: (f64, f64)) -> Other {
    Other::new(Some((kind, size)), look, ActorPath::Stand(x, y))
}

/// Something that crosses the target's way at frame `t`, before it.
const fn vehicle(kind: Kind, look: u32, t: f64, velocity: (f64, f64), size: (f64, f64)) -> Other {
    Other::new(Some((kind, size)), look, ActorPath::Cross(t, velocity))
}

/// One of the target's kind that stands at `(x, y)`.
const fn stands(look: u32, x: f64, y: f64) -> Other {
    Other::new(None, look, ActorPath::Stand(x, y))
}

/// One of the target's kind that crosses its way at frame `t`.
const fn crosses(look: u32, t: f64, velocity: (f64, f64)) -> Other {
    Other::new(None, look, ActorPath::Cross(t, velocity))
}

/// One of the target's kind that keeps it company.
const fn along(look: u32, dx: Curve, dy: Curve) -> Other {
    Other::new(None, look, ActorPath::Along(dx, dy))
}

/// Place of the target at frame `t`.
type Way = (Curve, Curve);

/// Kept for as long as the program runs, as the plans are that point to it.
fn kept(points: Vec<(f64, f64)>) -> Curve {
    points.leak()
}

/// A walker's stride in cycles at the points of its way: a step for every 0.3 of its height.
fn stride((x, y): Way, height: f64) -> Curve {
    let mut walked = 0.0;
    let mut points = vec![];
    for k in 0..x.len() {
        if k > 0 {
            let (a, b) = (x[k].1 - x[k - 1].1, y[k].1 - y[k - 1].1);
            walked += (a * a + b * b).sqrt();
        }
        points.push((x[k].0, walked / (0.6 * height)));
    }
    kept(points)
}

impl Other {
    /// The actor, and the shoulders below it where it is a head.
    fn cast(&self, script: &Script, (x, y): Way, frames: f64) -> Vec<Actor> {
        let way: Way = match self.path {
            ActorPath::Stand(x, y) => (kept(vec![(0.0, x)]), kept(vec![(0.0, y)])),
            ActorPath::Cross(t, velocity) => {
                // A curve's end slopes are 0, so the ends are far outside.
                let times = [t - 900.0, t - 600.0, t, t + 600.0, t + 900.0];
                let line = |place: f64, v: f64| kept(times.map(|s| (s, place + v * (s - t))).to_vec());
                (line(at(x, t, 0.0), velocity.0), line(at(y, t, 0.0), velocity.1))
            }
            ActorPath::Along(dx, dy) => {
                let times = || (0..).map(|k| 4.0 * f64::from(k)).take_while(|&t| t < frames + 4.0);
                let sum = |a: Curve, b: Curve| times().map(|t| (t, at(a, t, 0.0) + at(b, t, 0.0))).collect();
                (kept(sum(x, dx)), kept(sum(y, dy)))
            }
        };
        let (kind, size) = self.own.unwrap_or((script.kind, script.size));
        let size = (size.0 * self.scale, size.1 * self.scale);
        let scale = match (self.own, self.path) {
            (None, ActorPath::Along(..)) => script.scale,
            _ => &[],
        };
        // Who stands is caught in mid-step, and other heads look aside.
        let pose: Curve = match (kind, way.0) {
            (Kind::Person, [_, _, ..]) => stride(way, size.1),
            (Kind::Person, _) => &[(0.0, 0.1)],
            _ => &[(0.0, 0.16)],
        };
        let actor = Actor {
            kind,
            look: self.look,
            size,
            x: way.0,
            y: way.1,
            scale,
            pose,
            mirrored: self.mirrored,
            ..Actor::STILL
        };
        with_shoulders(actor, way, frames)
    }
}

/// The actor; a head comes with its shoulders, behind it.
fn with_shoulders(head: Actor, (x, y): Way, frames: f64) -> Vec<Actor> {
    if head.kind != Kind::Head {
        return vec![head];
    }
    let size = (2.3 * head.size.0, 5.5 * head.size.1);
    let drop = |t: f64| at(y, t, 0.0) + 2.96 * head.size.1 * at(head.scale, t, 1.0);
    let times = (0..).map(|k| 4.0 * f64::from(k)).take_while(|&t| t < frames + 4.0);
    let rows = if head.scale.is_empty() {
        y.iter().map(|p| (p.0, drop(p.0))).collect()
    } else {
        times.map(|t| (t, drop(t))).collect()
    };
    let body = Actor { kind: Kind::Shoulders, size, x, y: kept(rows), pose: &[], ..head };
    vec![body, head]
}

/// The plan of a script with the facts that `datasets.lock` has.
fn plan(script: &Script, entry: &'static RenderedEntry) -> ScenePlan {
    let column =
        |pick: fn(&(f64, f64, f64)) -> f64| kept(script.path.iter().map(|p| (p.0, pick(p))).collect());
    let way: Way = (column(|p| p.1), column(|p| p.2));
    let length = entry.frames as f64;
    let target = Actor {
        kind: script.kind,
        look: script.look,
        size: script.size,
        x: way.0,
        y: way.1,
        scale: script.scale,
        turn: script.turn,
        pose: if script.kind == Kind::Person { stride(way, script.size.1) } else { script.pose },
        mirrored: script.mirrored,
        ..Actor::STILL
    };
    let cast = |before: bool| script.others.iter().filter(move |o| o.before == before);
    let mut behind: Vec<Actor> = cast(false).flat_map(|o| o.cast(script, way, length)).collect();
    let mut own = with_shoulders(target, way, length);
    own.pop();
    behind.extend(own);
    let front: Vec<Actor> = cast(true).flat_map(|o| o.cast(script, way, length)).collect();
    let words = crate::sorted(lock::attribute_words(&entry.attributes, Some(entry.target_type)));
    let attributes: Vec<&'static str> = words.into_iter().map(|word| &*word.leak()).collect();
    ScenePlan {
        name: script.name,
        attributes: attributes.leak(),
        size: entry.size,
        frames: entry.frames,
        ground: script.ground,
        behind: behind.leak(),
        target,
        front: front.leak(),
        camera_x: script.camera,
        light: script.light,
        shadow: script.shadow.0,
        shadow_width: script.shadow.1,
        noise: script.noise,
        ..ScenePlan::EMPTY
    }
}

/// The plans of the suite `name`: a script for each entry of `datasets.lock`, in its order.
fn plans(name: &str, scripts: &'static [Script]) -> Vec<ScenePlan> {
    let entries = lock::rendered_entries(name);
    let script = |e: &'static RenderedEntry| scripts.iter().find(|s| s.name == e.name).map(|s| plan(s, e));
    entries.iter().filter_map(script).collect()
}

/// The plans of `synthetic-d1`.
pub fn d1() -> &'static [ScenePlan] {
    static PLANS: OnceLock<Vec<ScenePlan>> = OnceLock::new();
    PLANS.get_or_init(|| plans("synthetic-d1", d1::SCRIPTS))
}

/// The plans of `synthetic-d2`.
pub fn d2() -> &'static [ScenePlan] {
    static PLANS: OnceLock<Vec<ScenePlan>> = OnceLock::new();
    PLANS.get_or_init(|| plans("synthetic-d2", d2::SCRIPTS))
}

#[cfg(test)]
mod tests;
