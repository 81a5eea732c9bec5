//! `forward-backward`: follows points of the target to this frame and back. Points that do not return
//! indicate a loss (Kalal, Mikolajczyk and Matas, "Forward-backward error", ICPR 2010; MedianFlow and TLD).
//!
//! ```text
//! p_i   a grid of points in the box of frame t - 1
//! q_i   p_i followed from frame t - 1 to t          r_i   q_i followed from frame t to t - 1
//! e_i = |p_i - r_i|       d_i = q_i - p_i       c_i   correlation of the patches around p_i and q_i
//! error     median e / s                                                            (below: m_e = median e)
//! residual  median over j of |d_j - median d| / s,         j: e_j <= m_e and c_j >= median c
//! inliers   share of all points with e_i <= max_error and c_i >= min_correlation
//! ```
//!
//! Points and distances are in pixels, `s = sqrt(w h)` of the box of frame t - 1; `t` is a 0-based frame. Values lie in
//! [0, 1] and have no unit. High values of `error` and `residual` speak for a failure; of `inliers`, low ones. The first
//! frame has the best value. The box of frame t does not enter the value of frame t, but that of frame t + 1.
//!
//! Points are followed by pyramids of Lucas and Kanade ([`crate::image::flow`]). Points that are lost on the way (out of
//! the image, no texture) are left out of medians; without any point left, `error` and `residual` are 1. Sources of the
//! defaults: 10 x 10 points 5 pixels inside the box, and patches of 10 x 10 pixels, of OpenTLD; a window of 3 x 3 pixels
//! on 5 smaller levels, 20 steps and an `epsilon` of .3 of OpenCV's TrackerMedianFlow, as are the points that enter
//! `residual`. TLD calls the target lost at a median error, MedianFlow at a residual, of more than 10 pixels.
//!
//! Choices: errors are in units of the target, and values above 1 are cut; the margin is at most a quarter of a side;
//! `inliers` has fixed limits, as the share of points that are better than the median hardly varies; points are followed
//! in a part of the frame only, the box and `reach` times `s` on all sides of it, so that time and memory do not depend
//! on the size of frames: an even larger motion is not found. Boxes that leave the frame are shifted inside, larger ones
//! cut to the frame. A frame of another size than the one before has the value of a first frame.

use crate::image::flow::{LucasKanade, MAX_WINDOW, Point, Pyramid};
use crate::image::luma_of;
use crate::num::summary::{correlation, median};
use crate::signal::prelude::*;

pub(crate) const ENTRY: Entry<dyn Signal> = Entry::of::<Params>(
    "forward-backward",
    1,
    "error of points of the target that are followed to this frame and back",
)
.example("{ measure = \"error\" }");

/// Variance of gray values up to which a patch counts as flat.
const FLAT: f64 = 1e-6;

/// Measure of the points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// Median distance between a point and the place to which it returns.
    Error,
    /// Share of points that return and still look similar.
    Inliers,
    /// Median deviation of the points' motions from the median motion.
    Residual,
}

/// Parameters of the signal.
#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Measure of the points.
    #[default(Measure::Error)]
    pub measure: Measure,
    /// Number of points along each side of the box, 1 to 50.
    #[default(10)]
    pub grid: usize,
    /// Distance in pixels between the box and the outer points, 0 to 100.
    #[default(5.0)]
    pub margin: f64,
    /// Side of the window around a point in pixels, odd, 3 to 63.
    #[default(3)]
    pub window: usize,
    /// Number of smaller levels of the pyramid, 0 to 10.
    #[default(5)]
    pub levels: usize,
    /// Most steps of a point on each level, 1 to 100.
    #[default(20)]
    pub iterations: usize,
    /// Length of a step at which a level ends, in pixels of the level, 0 to 10.
    #[default(0.3)]
    pub epsilon: f64,
    /// Size of the search region beyond the box, in units of the box, 0 to 10.
    #[default(1.0)]
    pub reach: f64,
    /// Side of the patches that are compared, in pixels, 2 to 100.
    #[default(10)]
    pub patch: usize,
    /// Largest error of an inlier in pixels, 0 to 100.
    #[default(1.0)]
    pub max_error: f64,
    /// Least correlation of an inlier, -1 to 1.
    #[default(0.5)]
    pub min_correlation: f64,
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[
        Range::within("grid", 1.0, 50.0),
        Range::within("levels", 0.0, 10.0),
        Range::within("iterations", 1.0, 100.0),
        Range::within("patch", 2.0, 100.0),
        Range::within("margin", 0.0, 100.0),
        Range::within("epsilon", 0.0, 10.0),
        Range::within("reach", 0.0, 10.0),
        Range::within("max_error", 0.0, 100.0),
        Range::within("min_correlation", -1.0, 1.0),
        Range::within("window", 3.0, MAX_WINDOW as f64),
    ];

    fn check(&self) -> Result<(), ParamError> {
        ParamError::unless(self.window % 2 == 1, "window", "odd and from 3 to 63", self.window)
    }
}

impl Signal for Params {
    fn facts(&self) -> Facts {
        let direction = match self.measure {
            Measure::Inliers => Direction::HigherIsBetter,
            Measure::Error | Measure::Residual => Direction::LowerIsBetter,
        };
        Facts::of(direction, (0.0, 1.0))
    }

    fn start(&self, _: &RunContext<'_>) -> Result<Box<dyn Session>, TrackerError> {
        Ok(Box::new(Following { params: self.clone(), past: None }))
    }
}

/// Session of one track, which remembers the last frame.
struct Following {
    params: Params,
    past: Option<Past>,
}

/// Data of the last frame.
struct Past {
    /// Width and height of the last frame.
    frame: (usize, usize),
    /// Window of the target.
    target: Window,
    /// Part of the frame that is searched, which contains the target.
    search: Window,
    image: Pyramid,
}

/// A point that was followed forward and back.
struct Followed {
    from: Point,
    to: Point,
    error: f64,
}

impl Session for Following {
    fn push(&mut self, observation: &Observation<'_>) -> Result<Vec<f64>, TrackerError> {
        let Observation { frame, state, .. } = *observation;
        let size = (frame.width(), frame.height());
        let value = match &self.past {
            Some(past) if past.frame == size => self.value(past, frame),
            _ => f64::from(u8::from(self.params.measure == Measure::Inliers)),
        };
        let target = Window::on_frame(&state.region.rect(), frame);
        let reach = (self.params.reach * side(&target)).ceil() as i64;
        let grown = |length: usize| length + 2 * reach as usize;
        let around =
            Window { x: target.x - reach, y: target.y - reach, w: grown(target.w), h: grown(target.h) };
        let search = around.clipped(frame).unwrap_or(target);
        let image = self.pyramid(frame, &search);
        self.past = Some(Past { frame: size, target, search, image });
        Ok(vec![value])
    }

    fn save(&self) -> Option<Vec<u8>> {
        let part = |past: &Past| (past.frame, past.target, past.search, past.image.values().to_vec());
        saved::to_bytes(&self.past.as_ref().map(part))
    }

    fn restore(&mut self, saved: &[u8]) -> bool {
        type Part = ((usize, usize), Window, Window, Vec<u8>);
        let Some(part) = saved::from_bytes::<Option<Part>>(saved) else { return false };
        let Some((frame, target, search, values)) = part else { return true };
        let lies_on_frame = |w: &Window| {
            let within = |start: i64, length: usize, room: usize| {
                let start = usize::try_from(start).ok();
                length > 0 && start.and_then(|start| start.checked_add(length)).is_some_and(|end| end <= room)
            };
            within(w.x, w.w, frame.0) && within(w.y, w.h, frame.1)
        };
        let is_image = search.w.checked_mul(search.h) == Some(values.len());
        if !is_image || !lies_on_frame(&target) || !lies_on_frame(&search) {
            return false;
        }
        let Params { levels, window, .. } = self.params;
        let image = Pyramid::new(search.w, search.h, values, levels, window);
        self.past = Some(Past { frame, target, search, image });
        true
    }
}

/// Geometric mean of the sides of a window.
fn side(window: &Window) -> f64 {
    ((window.w * window.h) as f64).sqrt()
}

/// `count` places on a side of `length` pixels that begins at pixel `start`, with `margin` at both ends; in
/// coordinates from pixel centers.
fn places(start: i64, length: usize, margin: f64, count: usize) -> impl Iterator<Item = f64> + Clone {
    let margin = margin.min(length as f64 / 4.0);
    let (first, room) = (start as f64 - 0.5 + margin, length as f64 - 2.0 * margin);
    let parts = count.saturating_sub(1).max(1) as f64;
    let place = move |i: usize| if count == 1 { 0.5 } else { i as f64 / parts };
    (0..count).map(move |i| first + room * place(i))
}

impl Following {
    fn pyramid(&self, frame: &Frame, part: &Window) -> Pyramid {
        let Params { levels, window, .. } = self.params;
        Pyramid::new(part.w, part.h, luma_of(frame, part), levels, window)
    }

    fn value(&self, past: &Past, frame: &Frame) -> f64 {
        let now = self.pyramid(frame, &past.search);
        let followed = self.follow(past, &now);
        let similar = || self.correlations(&past.image, &now, &followed);
        let relative = |error: Option<f64>| error.map_or(1.0, |error| (error / side(&past.target)).min(1.0));
        match self.params.measure {
            Measure::Error => relative(median(&mut followed.iter().map(|f| f.error).collect::<Vec<_>>())),
            Measure::Inliers => {
                let Params { max_error, min_correlation, grid, .. } = self.params;
                let pairs = followed.iter().zip(similar());
                let inliers = pairs.filter(|(f, c)| f.error <= max_error && *c >= min_correlation);
                inliers.count() as f64 / (grid * grid) as f64
            }
            Measure::Residual => relative(residual(&followed, &similar())),
        }
    }

    /// Points that are found in this frame and again in the last one.
    fn follow(&self, past: &Past, now: &Pyramid) -> Vec<Followed> {
        let Params { grid, margin, window, iterations, epsilon, .. } = self.params;
        let Past { target, search, .. } = past;
        let columns = places(target.x - search.x, target.w, margin, grid);
        let rows = places(target.y - search.y, target.h, margin, grid);
        let points: Vec<Point> = rows.flat_map(|y| columns.clone().map(move |x| (x, y))).collect();
        let method = LucasKanade { window, iterations, epsilon };
        let there = method.follow(&past.image, now, &points);
        let pairs: Vec<(Point, Point)> =
            points.into_iter().zip(there).filter_map(|(from, to)| Some((from, to?))).collect();
        let ends: Vec<Point> = pairs.iter().map(|(_, to)| *to).collect();
        let back = method.follow(now, &past.image, &ends);
        let followed = |((from, to), back): ((Point, Point), Option<Point>)| {
            back.map(|back| Followed { from, to, error: length((back.0 - from.0, back.1 - from.1)) })
        };
        pairs.into_iter().zip(back).filter_map(followed).collect()
    }

    /// Correlation of the patches around each point in the last frame and now.
    fn correlations(&self, before: &Pyramid, now: &Pyramid, followed: &[Followed]) -> Vec<f64> {
        let patch = |image: &Pyramid, (x, y): Point| image.patch(x, y, self.params.patch);
        followed.iter().map(|f| correlation(&patch(before, f.from), &patch(now, f.to), FLAT)).collect()
    }
}

fn length((x, y): Point) -> f64 {
    (x * x + y * y).sqrt()
}

/// Median distance of the better points' motions from their median; `None` without such points.
fn residual(followed: &[Followed], similar: &[f64]) -> Option<f64> {
    let max_error = median(&mut followed.iter().map(|f| f.error).collect::<Vec<_>>())?;
    let min_correlation = median(&mut similar.to_vec())?;
    let pairs = followed.iter().zip(similar);
    let returned = pairs.filter(|(f, c)| f.error <= max_error && **c >= min_correlation);
    let motions: Vec<Point> = returned.map(|(f, _)| (f.to.0 - f.from.0, f.to.1 - f.from.1)).collect();
    let dx = median(&mut motions.iter().map(|d| d.0).collect::<Vec<_>>())?;
    let dy = median(&mut motions.iter().map(|d| d.1).collect::<Vec<_>>())?;
    median(&mut motions.iter().map(|d| length((d.0 - dx, d.1 - dy))).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests;
