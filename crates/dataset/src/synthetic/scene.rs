//! From a plan (who moves where, under which light) to frames and ground truth.
//!
//! The world is a plane in pixels; the camera shows the part whose left top corner is at `camera`. Time is a
//! real number of frames from 0, so that the exposure of a frame can be divided.

use super::actor::Kind;
use super::ground::{Ground, Picture};
use super::motion::{Curve, at};
use super::noise::{hash, smoothstep, value};
use super::sprite::{Pose, Sprite};
use super::{scenes, sensor};
use crate::user_frames::without_frames;
use crate::{Frames, Sequence};
use serde::Deserialize;
use std::collections::HashMap;
use std::sync::{Arc, OnceLock};
use trackfail_core::image::Frame;
use trackfail_core::num::seed::seed;
use trackfail_core::region::{Rect, Region};

/// A drawn object and its path.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Actor {
    /// Kind of the object.
    pub kind: Kind,
    /// Number of the individual, which decides colors and patterns.
    #[serde(default = "first_look")]
    pub look: u32,
    /// Width and height in pixels at scale 1.
    #[serde(deserialize_with = "scenes::actor_size")]
    pub size: (f64, f64),
    /// World column of the center.
    #[serde(default, deserialize_with = "scenes::curve")]
    pub x: Curve,
    /// World row of the center.
    #[serde(default, deserialize_with = "scenes::curve")]
    pub y: Curve,
    /// Path across that of the target; replaces `x` and `y`.
    pub crosses: Option<Crossing>,
    /// Path beside the target; replaces `x` and `y`.
    pub along: Option<Company>,
    /// Magnification, 1 by default.
    #[serde(default, deserialize_with = "scenes::scale")]
    pub scale: Curve,
    /// Clockwise turn in degrees, 0 by default.
    #[serde(default, deserialize_with = "scenes::curve")]
    pub turn: Curve,
    /// Phase of the stride in cycles, or yaw; 0 by default.
    #[serde(default, deserialize_with = "scenes::curve")]
    pub pose: Curve,
    /// True to make a step for every 0.3 heights of path; replaces `pose`.
    #[serde(default)]
    pub strides: bool,
    /// Cycles of the stride per frame, added to `pose`.
    #[serde(default, deserialize_with = "scenes::number")]
    pub cadence: f64,
    /// True to swap left and right. Walkers and swimmers always face where they go and need no swap.
    #[serde(default)]
    pub mirrored: bool,
}

fn first_look() -> u32 {
    1
}

/// Straight path that crosses that of the target.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Crossing {
    /// Frame in which the actor is at the target's place.
    #[serde(deserialize_with = "scenes::number")]
    frame: f64,
    /// Pixels per frame, to the right and down.
    #[serde(deserialize_with = "scenes::numbers")]
    velocity: (f64, f64),
}

/// Path beside the target: offset from it in pixels, to the right and down.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Company {
    #[serde(deserialize_with = "scenes::curve")]
    x: Curve,
    #[serde(deserialize_with = "scenes::curve")]
    y: Curve,
}

/// Every fourth frame of a sequence, and the last one.
fn fourths(frames: usize) -> impl Iterator<Item = f64> {
    (0..).map(|k| 4.0 * f64::from(k)).take_while(move |&t| t < frames as f64 + 4.0)
}

/// Stride of a walker in cycles, at the points of its path.
fn stride(x: &Curve, y: &Curve, height: f64) -> Curve {
    let (mut walked, mut points) = (0.0, Curve::new());
    let mut last = None;
    for &(t, _) in if x.len() < y.len() { y } else { x } {
        let place = (at(x, t, 0.0), at(y, t, 0.0));
        if let Some(last) = last.replace(place) {
            let (a, b): (f64, f64) = (place.0 - last.0, place.1 - last.1);
            walked += (a * a + b * b).sqrt();
        }
        points.push((t, walked / (0.6 * height)));
    }
    points
}

impl Actor {
    /// The actor with curves computed from the target's path, in a sequence of `frames` frames.
    fn placed(mut self, (x, y): (&Curve, &Curve), frames: usize) -> Self {
        if let Some(Crossing { frame, velocity }) = self.crosses {
            // A curve's end slopes are 0, so the ends are far outside.
            let times = [frame - 900.0, frame - 600.0, frame, frame + 600.0, frame + 900.0];
            let line = |place: f64, v: f64| times.map(|t| (t, place + v * (t - frame))).to_vec();
            self.x = line(at(x, frame, 0.0), velocity.0);
            self.y = line(at(y, frame, 0.0), velocity.1);
        } else if let Some(beside) = &self.along {
            let sum = |a: &Curve, b: &Curve| -> Curve {
                fourths(frames).map(|t| (t, at(a, t, 0.0) + at(b, t, 0.0))).collect()
            };
            (self.x, self.y) = (sum(x, &beside.x), sum(y, &beside.y));
        }
        if self.strides {
            self.pose = stride(&self.x, &self.y, self.size.1);
        }
        self
    }

    /// Shoulders below a head, drawn behind it; `None` for other kinds.
    fn shoulders(&self, frames: usize) -> Option<Self> {
        if self.kind != Kind::Head {
            return None;
        }
        let size = (2.3 * self.size.0, 5.5 * self.size.1);
        let drop = |t: f64| (t, at(&self.y, t, 0.0) + 2.96 * self.size.1 * at(&self.scale, t, 1.0));
        let y = if self.scale.is_empty() {
            self.y.iter().map(|p| drop(p.0)).collect()
        } else {
            fourths(frames).map(drop).collect()
        };
        Some(Self { kind: Kind::Shoulders, size, y, pose: Curve::new(), ..self.clone() })
    }

    fn pose_at(&self, t: f64, camera: (f64, f64)) -> Pose {
        let s = at(&self.scale, t, 1.0);
        Pose {
            x: at(&self.x, t, 0.0) - camera.0,
            y: at(&self.y, t, 0.0) - camera.1,
            w: self.size.0 * s,
            h: self.size.1 * s,
            turn: at(&self.turn, t, 0.0),
        }
    }

    /// True if the actor looks to the left. Walkers and swimmers face where they go.
    fn faces_left(&self, t: f64) -> bool {
        let swims = matches!(self.kind, Kind::Person | Kind::Fish);
        self.mirrored || swims && at(&self.x, t + 3.0, 0.0) < at(&self.x, t - 3.0, 0.0)
    }

    /// True if the actor covers a place in its box.
    fn covers(&self, (u, v): (f64, f64)) -> bool {
        let round = matches!(self.kind, Kind::Person | Kind::Bush | Kind::Ball | Kind::Face | Kind::Head);
        let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
        if round { a * a + b * b < 1.0 } else { a.abs() < 1.0 && b.abs() < 1.0 }
    }
}

/// Plan of a sequence: all that its frames and ground truth are made from.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScenePlan {
    /// Name of the sequence.
    pub name: String,
    /// Attributes of the whole sequence, sorted. In VOT layout they are computed from those of the frames.
    #[serde(default)]
    pub attributes: Vec<String>,
    /// Width and height of the frames in pixels.
    #[serde(deserialize_with = "scenes::frame_size")]
    pub size: (usize, usize),
    /// Length of the sequence in frames.
    #[serde(deserialize_with = "scenes::frames")]
    pub frames: usize,
    /// Background.
    pub ground: Ground,
    /// Objects drawn before the target, in this order.
    #[serde(default)]
    pub behind: Vec<Actor>,
    /// Path and appearance of the target.
    pub target: Actor,
    /// Objects drawn over the target.
    #[serde(default)]
    pub front: Vec<Actor>,
    /// World column of the frame's left border, 0 by default.
    #[serde(default, deserialize_with = "scenes::curve")]
    pub camera_x: Curve,
    /// World row of the frame's top border, 0 by default.
    #[serde(default, deserialize_with = "scenes::curve")]
    pub camera_y: Curve,
    /// Amplitude of the camera's shake, in pixels.
    #[serde(default, deserialize_with = "scenes::number")]
    pub shake: f64,
    /// Brightness, 1 by default.
    #[serde(default, deserialize_with = "scenes::curve")]
    pub light: Curve,
    /// World column of the middle of a shadow; empty for no shadow.
    #[serde(default, deserialize_with = "scenes::curve")]
    pub shadow: Curve,
    /// Width of the shadow in pixels.
    #[serde(default = "usual_shadow", deserialize_with = "scenes::number")]
    pub shadow_width: f64,
    /// Part of the frame interval in which the shutter is open: 0 for no motion blur, above 1 for more than a
    /// real shutter gives.
    #[serde(default, deserialize_with = "scenes::number")]
    pub exposure: f64,
    /// Amplitude of the sensor noise: the largest deviation in gray levels.
    #[serde(default = "usual_noise", deserialize_with = "scenes::number")]
    pub noise: f64,
    /// True for ground truth as turned boxes (VOT), false for upright rectangles (OTB).
    #[serde(skip)]
    pub polygon: bool,
}

fn usual_shadow() -> f64 {
    80.0
}

fn usual_noise() -> f64 {
    6.0
}

impl ScenePlan {
    /// The plan with the curves of all actors computed and shoulders added to heads.
    pub fn placed(mut self) -> Self {
        let (x, y) = (self.target.x.clone(), self.target.y.clone());
        let frames = self.frames;
        let cast = |actors: Vec<Actor>| {
            let placed = actors.into_iter().map(|actor| actor.placed((&x, &y), frames));
            placed.flat_map(|a| a.shoulders(frames).into_iter().chain([a])).collect::<Vec<_>>()
        };
        self.behind = cast(self.behind);
        self.front = cast(self.front);
        self.target = self.target.placed((&x, &y), frames);
        self.behind.extend(self.target.shoulders(frames));
        self
    }
}

/// A plan that can be rendered. The background and the sprites are painted when the first frame is requested.
struct Scene {
    plan: ScenePlan,
    seed: u32,
    assets: OnceLock<Assets>,
}

struct Assets {
    picture: Picture,
    /// Sprites of each actor in drawing order, one per phase.
    cast: Vec<Arc<[Sprite]>>,
}

/// Most instants that the exposure of a frame is divided into.
const MAX_SUBFRAMES: usize = 8;

impl Scene {
    fn camera(&self, t: f64) -> (f64, f64) {
        let p = &self.plan;
        let wobble = |k: f64| {
            if p.shake == 0.0 { 0.0 } else { 2.0 * p.shake * (value(self.seed, 0.37 * t, k) - 0.5) }
        };
        (at(&p.camera_x, t, 0.0) + wobble(0.0), at(&p.camera_y, t, 0.0) + wobble(9.0))
    }

    fn actors(&self) -> impl Iterator<Item = &Actor> {
        self.plan.behind.iter().chain([&self.plan.target]).chain(&self.plan.front)
    }

    fn assets(&self) -> &Assets {
        self.assets.get_or_init(|| {
            let p = &self.plan;
            let (mut low, mut high) = ((f64::MAX, f64::MAX), (f64::MIN, f64::MIN));
            for k in 0..=4 * p.frames {
                let c = self.camera(k as f64 / 4.0 - 1.0);
                low = (low.0.min(c.0), low.1.min(c.1));
                high = (high.0.max(c.0), high.1.max(c.1));
            }
            let (left, top) = (low.0.floor() - 1.0, low.1.floor() - 1.0);
            let width = (high.0 - left).ceil() as usize + p.size.0 + 2;
            let height = (high.1 - top).ceil() as usize + p.size.1 + 2;
            let (left, top) = (left as i64, top as i64);
            let picture = Picture::paint(p.ground, self.seed, left, top, width, height, p.size.1 as f64);
            // Those of one kind, look and size share their sprites.
            let mut painted: HashMap<_, Arc<[Sprite]>> = HashMap::new();
            let sprites = |a: &Actor| {
                let largest = a.scale.iter().map(|s| s.1).reduce(f64::max).unwrap_or(1.0);
                let size = [a.size.0, a.size.1].map(|s| ((s * largest).ceil() as usize).clamp(4, 400));
                let aspect = a.size.0 / a.size.1;
                let phase = |n| Sprite::paint(size[0], size[1], |u, v| a.kind.paint(a.look, n, aspect, u, v));
                let paint = || (0..a.kind.phases()).map(phase).collect();
                painted.entry((a.kind, a.look, size)).or_insert_with(paint).clone()
            };
            Assets { picture, cast: self.actors().map(sprites).collect() }
        })
    }

    /// Draws the scene at an instant, without light and noise.
    fn instant(&self, t: f64, out: &mut [u8]) {
        let assets = self.assets();
        let camera = self.camera(t);
        let width = self.plan.size.0;
        assets.picture.view(camera.0, camera.1, width, out);
        for (a, sprites) in self.actors().zip(&assets.cast) {
            let phase = a.kind.phase_of(at(&a.pose, t, 0.0) + a.cadence * t);
            sprites[phase].draw(&a.pose_at(t, camera), a.faces_left(t), out, width);
        }
    }

    /// Number of instants that the exposure of frame `t` is divided into: one per 1.5 pixels of motion.
    fn subframes(&self, t: f64) -> usize {
        let half = self.plan.exposure / 2.0;
        if half == 0.0 {
            return 1;
        }
        let (a, b) = (self.camera(t - half), self.camera(t + half));
        let (p, q) = (self.plan.target.pose_at(t - half, a), self.plan.target.pose_at(t + half, b));
        let travel =
            [b.0 - a.0, b.1 - a.1, q.x - p.x, q.y - p.y].map(f64::abs).into_iter().fold(0.0, f64::max);
        ((travel / 1.5).ceil() as usize).clamp(1, MAX_SUBFRAMES)
    }

    fn truth(&self, t: usize) -> Region {
        let t = t as f64;
        let pose = self.plan.target.pose_at(t, self.camera(t));
        if self.plan.polygon {
            return Region::Polygon(pose.corners().map(|(x, y)| (snap(x), snap(y))).to_vec());
        }
        let (rx, ry) = pose.half_bounds();
        Region::Rect(Rect::new(snap(pose.x - rx), snap(pose.y - ry), snap(2.0 * rx), snap(2.0 * ry)))
    }

    /// Share of the target that other objects hide, 0 to 1, over an 8 x 8 grid in its box.
    fn occluded(&self, t: usize) -> f64 {
        let t = t as f64;
        let camera = self.camera(t);
        let target = self.plan.target.pose_at(t, camera);
        let front: Vec<_> = self.plan.front.iter().map(|a| (a, a.pose_at(t, camera))).collect();
        let c = target.corners();
        let mut covered = 0;
        for k in 0..64 {
            let (u, v) = ((f64::from(k % 8) + 0.5) / 8.0, (f64::from(k / 8) + 0.5) / 8.0);
            let x = c[0].0 + u * (c[1].0 - c[0].0) + v * (c[3].0 - c[0].0);
            let y = c[0].1 + u * (c[1].1 - c[0].1) + v * (c[3].1 - c[0].1);
            covered += i32::from(front.iter().any(|(a, pose)| a.covers(pose.place(x, y))));
        }
        f64::from(covered) / 64.0
    }

    /// Brightness at the center of the target.
    fn brightness(&self, t: f64) -> f64 {
        let p = &self.plan;
        at(&p.light, t, 1.0) * self.shadow_gain(at(&p.target.x, t, 0.0), t)
    }

    /// Factor by which the shadow darkens a world column.
    fn shadow_gain(&self, x: f64, t: f64) -> f64 {
        if self.plan.shadow.is_empty() {
            return 1.0;
        }
        let half = self.plan.shadow_width / 2.0;
        let distance = (x - at(&self.plan.shadow, t, 0.0)).abs();
        1.0 - 0.55 * (1.0 - smoothstep(half - 6.0, half + 6.0, distance))
    }

    /// Applies light, shadow and sensor noise.
    fn expose(&self, t: usize, rgb: &mut [u8]) {
        let width = self.plan.size.0;
        let now = t as f64;
        let (left, light) = (self.camera(now).0, at(&self.plan.light, now, 1.0));
        let gain = |i: usize| 256.0 * light * self.shadow_gain(left + i as f64 + 0.5, now);
        let gains: Vec<i32> = (0..width).map(|i| gain(i).clamp(0.0, 2048.0).round() as i32).collect();
        sensor::expose(rgb, &gains, self.plan.noise, hash(self.seed, t as i32, 77));
    }

    /// Frame `t` as the camera takes it.
    fn render(&self, t: usize) -> Frame {
        let (width, height) = self.plan.size;
        let now = t as f64;
        let n = self.subframes(now);
        let mut rgb = vec![0_u8; 3 * width * height];
        if n == 1 {
            self.instant(now, &mut rgb);
        } else {
            let mut sum = vec![0_u16; rgb.len()];
            for k in 0..n {
                let s = (k as f64 + 0.5) / n as f64 - 0.5;
                self.instant(now + s * self.plan.exposure, &mut rgb);
                for (s, &v) in sum.iter_mut().zip(&rgb) {
                    *s += u16::from(v);
                }
            }
            let n = n as u16;
            for (o, s) in rgb.iter_mut().zip(&sum) {
                *o = ((s + n / 2) / n) as u8;
            }
        }
        self.expose(t, &mut rgb);
        Frame::new(width, height, rgb)
    }

    /// Attributes of a frame, in the order of [`FRAME_ATTRIBUTES`].
    fn frame_attributes(&self, t: usize) -> [bool; 5] {
        let now = t as f64;
        let place = |s: f64| {
            let p = self.plan.target.pose_at(s, (0.0, 0.0));
            (p.x, p.y, p.w * p.h)
        };
        let (a, b, c) = (place((now - 4.0).max(0.0)), place(now), place(now + 4.0));
        let side = b.2.sqrt();
        let (x, y) = (c.0 - 2.0 * b.0 + a.0, c.1 - 2.0 * b.1 + a.1);
        let bend = (x * x + y * y).sqrt();
        let earlier = place((now - 10.0).max(0.0)).2;
        let (light, first) = (self.brightness(now), self.brightness(0.0));
        let (here, before) = (self.camera(now), self.camera((now - 1.0).max(0.0)));
        let moved = (here.0 - before.0).abs().max((here.1 - before.1).abs());
        [
            self.occluded(t) > 0.2,
            !(0.8..=1.25).contains(&(light / first)),
            bend > 0.04 * side,
            !(0.97..=1.03).contains(&(b.2 / earlier).sqrt()),
            moved > 0.5,
        ]
    }
}

/// The attributes a frame of `synthetic-vot` can have. Of the target's center, size and brightness:
///
/// * `occlusion`: more than a fifth of its box is behind something;
/// * `illum_change`: its brightness differs from that of frame 0 by a quarter;
/// * `motion_change`: its motion in the world over the next four frames differs from that over the last
///   four by more than 4 % of its size (root of the area);
/// * `size_change`: its size differs by 3 % from that of ten frames before;
/// * `camera_motion`: the camera moved by more than half a pixel since the frame before.
const FRAME_ATTRIBUTES: [&str; 5] =
    ["occlusion", "illum_change", "motion_change", "size_change", "camera_motion"];

/// Rounds to a grid of 1/64 pixel, on which adding 1 and subtracting it again is exact.
fn snap(v: f64) -> f64 {
    (v * 64.0).round() / 64.0
}

/// Seed of the textures and the noise of a sequence.
pub fn bits(suite: &str, name: &str) -> u64 {
    seed(0, &["synthetic", suite, name])
}

/// Creates the sequence of a plan, in the suite `suite`.
pub fn sequence(suite: &str, plan: &ScenePlan) -> Sequence {
    let bits = bits(suite, &plan.name);
    let scene = Scene { plan: plan.clone(), seed: (bits ^ (bits >> 32)) as u32, assets: OnceLock::new() };
    let truth = (0..plan.frames).map(|t| Some(scene.truth(t))).collect();
    let mut frame_attributes: Vec<(String, Vec<bool>)> = Vec::new();
    let mut attributes = plan.attributes.clone();
    if plan.polygon {
        let rows: Vec<_> = (0..plan.frames).map(|t| scene.frame_attributes(t)).collect();
        let column = |k: usize| rows.iter().map(|r| r[k]).collect();
        frame_attributes =
            FRAME_ATTRIBUTES.iter().enumerate().map(|(k, name)| ((*name).to_string(), column(k))).collect();
        // As the reader of VOT folders has it: sorted, and a sequence has what any of its frames has.
        frame_attributes.sort();
        let ever = frame_attributes.iter().filter(|(_, flags)| flags.contains(&true));
        attributes = ever.map(|(name, _)| name.clone()).collect();
    }
    let frames = Frames::Rendered(Arc::new(move |t| scene.render(t)), plan.frames);
    let size = plan.size.into();
    Sequence { truth, attributes, frame_attributes, frames, size, ..without_frames(&plan.name, plan.frames) }
}
