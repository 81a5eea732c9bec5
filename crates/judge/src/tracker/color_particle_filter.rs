//! A color-based particle filter on ellipses: the tracker whose posterior the uncertainty methods of
//! SanMiguel and Cavallaro (CVIU 131, 2015) judge, after Nummiaro, Koller-Meier and Van Gool ("An adaptive
//! color-based particle filter", Image and Vision Computing 21, 2003).
//!
//! ```text
//! x[t] = x[t-1] + n,  n ~ N(0, diag(d)^2)              state (x, y, Hx, Hy, theta), N particles
//! p_u(x) = f sum k(r_i) [bin(i) = u]                   over the pixels i inside the ellipse of x
//! k(r) = 1 - r^2                                       r: distance in half axes, r < 1; sum_u p_u = 1
//! rho(x) = sum_u sqrt(p_u(x) q_u)                      q: the histogram of the first ellipse
//! L(x) = exp((rho(x) - 1) / (2 sigma_c^2))             in (0, 1], high is good
//! w[t] = w[t-1] L(x[t]),  normalized to sum 1
//! m = sum w x,  C = sum w (x - m)(x - m)'              the estimate and its covariance
//! resampled when 1 / sum w^2 < 0.6 N, afterwards w = 1/N
//! ```
//!
//! `x`, `y` is the center, `Hx`, `Hy` are half axes, all in pixels, 0-based as in [`crate::region`]; a pixel is
//! inside when its center is. `theta` is in radians from the x axis towards the y axis, which points down.
//! Frames go in the order propagate, weigh, estimate, resample: mean, covariance and effective number of
//! samples are those *before* resampling, with the weights carried over from frames without. The region is the
//! rectangle around the mean's ellipse along its axes. The posterior's likelihood is that of the mean, without the
//! factor `1 / (sqrt(2 pi) sigma_c)`.
//!
//! The start is the annotation: half its width and height with `theta = 0`, of a turned quadrilateral its
//! mean sides and its angle; all particles are there unless `initial_spread` is above 0, so the first
//! covariance is 0 and the effective number N. One random stream a track, from its seed, is drawn from in a fixed
//! order (start, particles in order, resampling).
//!
//! From the paper (experimental setup): the state, 8 x 8 x 8 bins, RGB for pedestrians and cars and HSV
//! for faces, N = 400, the five noise numbers, `sigma_c = 0.2`. Choices that it leaves open:
//! - The paper calls the noise numbers variances but writes them as deviations in pixels and degrees; they are
//!   deviations here, unless `noise_is_variance`.
//! - Kernel and its pixels (all inside, instead of random points), resampling rule and scheme, no update
//!   of `q`, particles on the annotation at the start: see the parameters. With `kernel = "points"`, colors are
//!   interpolated before they become HSV, since a mean of hues means nothing.
//! - Half axes stay between `minimum_axis` and the frame's longer side (a larger target is tracked as one of
//!   that size), which bounds the time of a frame.
//! - `theta` is not wrapped: its mean and variance are linear, and particles on both sides of a seam would have
//!   a wrong mean. A round target lets it drift.
//! - An ellipse without a pixel in the frame has `rho = 0`, as has every ellipse when the first one had none:
//!   all particles are then equal and wander. When all weights underflow they are made equal.

mod histogram;
#[cfg(test)]
mod tests;

use super::Moments;
use crate::num::particles::{Cloud, Posterior, Resampling};
use crate::num::seed;
use crate::tracker::prelude::*;
use histogram::{Binning, Ellipse, Grid, Histogram, MAX_BINS, Model};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// Attribute of sequences with faces.
const FACE: &str = "target-face";
/// Likelihood of the estimate above which `model_update` takes place.
const UPDATE_ABOVE: f64 = 0.5;

/// Color space of the histograms.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ColorSpace {
    /// HSV for sequences with the attribute `target-face`, RGB for others.
    Auto,
    /// Red, green, blue.
    Rgb,
    /// Hue, saturation and value, each in `[0, 1]`; hue of grays 0.
    Hsv,
}

/// Weight of a pixel in the histogram of an ellipse.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Kernel {
    /// Weight `1 - r^2`.
    Epanechnikov,
    /// No pixels but random points, new ones for each particle, at uniform radius and angle (hence
    /// denser towards the center).
    Points,
}

/// Parameters.
#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Number of particles N, from 2 to 10000.
    #[default(400)]
    pub particles: usize,
    /// Color space of the histograms.
    #[default(ColorSpace::Auto)]
    pub color_space: ColorSpace,
    /// Numbers of bins in the three channels, each from 1 to 16.
    #[default([8; 3])]
    pub bins: [u8; 3],
    /// Weight of a pixel in a histogram.
    #[default(Kernel::Epanechnikov)]
    pub kernel: Kernel,
    /// Number of points for the kernel `points`, from 1 to 10000.
    #[default(120)]
    pub points: u32,
    /// Standard deviation of the center's noise in x and in y, in pixels per frame, from 0 to 1000.
    #[default(5.0)]
    pub sigma_position: f64,
    /// Standard deviation of the noise of each half axis, in pixels per frame, from 0 to 1000.
    #[default(0.75)]
    pub sigma_axes: f64,
    /// Standard deviation of the orientation's noise, in degrees per frame, from 0 to 180.
    #[default(4.0)]
    pub sigma_orientation: f64,
    /// True to read the three numbers above as variances (square pixels, square degrees).
    pub noise_is_variance: bool,
    /// Standard deviation `sigma_c` of the color likelihood, from 0.01 to 10.
    #[default(0.2)]
    pub sigma_color: f64,
    /// Share of N below which the effective number triggers resampling, from 0 (never) to 1.
    #[default(0.6)]
    pub resample_below: f64,
    /// Scheme by which the next generation is drawn.
    #[default(Resampling::Systematic)]
    pub resampling: Resampling,
    /// Share of the estimate's histogram in the next `q` (Nummiaro et al.'s update), 0 (fixed) to 1. Only frames in
    /// which the estimate's likelihood is above 0.5 update it.
    pub model_update: f64,
    /// Deviation of the particles around the annotation at the start, in multiples of a frame's noise,
    /// from 0 to 100.
    pub initial_spread: f64,
    /// Least half axis, in pixels, from 1 to 1000.
    #[default(3.0)]
    pub minimum_axis: f64,
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[
        Range::within("sigma_position", 0.0, 1000.0),
        Range::within("sigma_axes", 0.0, 1000.0),
        Range::within("sigma_orientation", 0.0, 180.0),
        Range::within("sigma_color", 0.01, 10.0),
        Range::within("resample_below", 0.0, 1.0),
        Range::within("model_update", 0.0, 1.0),
        Range::within("initial_spread", 0.0, 100.0),
        Range::within("minimum_axis", 1.0, 1000.0),
        Range::within("particles", 2.0, 10_000.0),
        Range::within("points", 1.0, 10_000.0),
        Range::within("bins", 1.0, MAX_BINS as f64),
    ];
}

impl Params {
    /// Standard deviations of a frame's noise; that of the angle in radians.
    fn deviations(&self) -> Ellipse {
        let p = self;
        let [position, axes, turn] = [p.sigma_position, p.sigma_axes, p.sigma_orientation]
            .map(|s| if p.noise_is_variance { s.sqrt() } else { s });
        [position, position, axes, axes, turn.to_radians()]
    }
}

/// The color particle filter in the list of trackers.
pub const ENTRY: Entry<dyn TrackerConfig> = Entry::of::<Params>(
    "color-particle-filter",
    1,
    "particles that are ellipses, weighed by color histograms",
);

impl TrackerConfig for Params {
    fn facts(&self) -> Facts {
        Facts::SAMPLES
    }

    fn start(&self, context: &RunContext<'_>, frame: &Frame, region: &Region) -> StartResult {
        let annotated = ellipse(region);
        if annotated.iter().any(|v| !v.is_finite()) {
            return Err(TrackerError::no_region("color-particle-filter"));
        }
        let hsv = match self.color_space {
            ColorSpace::Auto => context.sequence.attributes().iter().any(|a| a == FACE),
            ColorSpace::Rgb => false,
            ColorSpace::Hsv => true,
        };
        let (deviations, mut rng) = (self.deviations(), seed::rng(context.seed));
        let limits = EllipseLimits::new(self, frame);
        let first = limits.keep(annotated);
        let mut cloud = Cloud::new(first, self.particles);
        if self.initial_spread > 0.0 {
            let wide = deviations.map(|d| d * self.initial_spread);
            cloud.diffuse(&wide, |e| limits.keep(e), || rng.sample(StandardNormal));
        }
        let binning = Binning::new(hsv, self.bins);
        let (kernel, points, histogram) = (self.kernel, self.points, Histogram::new(binning.len()));
        let mut colors = Colors { kernel, points, binning, grid: Grid::default(), histogram };
        colors.grid.look(frame, &colors.binning, [&first]);
        let histogram = colors.histogram(frame, &first, &mut rng);
        let shares = histogram.shares();
        let model = Model::new(&shares);
        let moments = moments(self, &cloud, &cloud.posterior(), histogram.likeness(&model));
        let state = TrackerState { posterior: Some(moments), ..TrackerState::initialized(region.clone()) };
        let params = self.clone();
        let tracker = Tracking { params, deviations, rng, colors, cloud, shares, model };
        Ok((Box::new(tracker), state))
    }
}

#[derive(Clone)]
struct Tracking {
    params: Params,
    deviations: Ellipse,
    rng: ChaCha8Rng,
    colors: Colors,
    cloud: Cloud<5>,
    /// Shares of `q`; the comparison with `q` is prepared from them.
    shares: Vec<f64>,
    model: Model,
}

impl Tracker for Tracking {
    fn update(&mut self, frame: &Frame) -> Result<TrackerState, TrackerError> {
        let Self { params, deviations, rng, colors, cloud, shares, model } = self;
        let limits = EllipseLimits::new(params, frame);
        cloud.diffuse(deviations, |e| limits.keep(e), || rng.sample(StandardNormal));
        colors.grid.look(frame, &colors.binning, &cloud.states);
        let likeness = |state: &Ellipse| colors.histogram(frame, state, rng).likeness(model);
        let rho: Vec<f64> = cloud.states.iter().map(likeness).collect();
        cloud.weigh(relative_likelihoods(&rho, params.sigma_color));
        let posterior = cloud.posterior();
        let histogram = colors.histogram(frame, &posterior.mean, rng);
        let moments = moments(params, cloud, &posterior, histogram.likeness(model));
        let rate = params.model_update;
        if rate > 0.0 && moments.likelihood > UPDATE_ABOVE {
            for (q, p) in shares.iter_mut().zip(histogram.shares()) {
                *q = (1.0 - rate) * *q + rate * p;
            }
            *model = Model::new(shares);
        }
        if moments.effective_samples < params.resample_below * cloud.states.len() as f64 {
            cloud.resample(params.resampling, rng);
        }
        let region = region(&posterior.mean);
        Ok(TrackerState { posterior: Some(moments), ..TrackerState::tracked(region) })
    }

    fn fork(&self, seed: Option<u64>) -> Option<Box<dyn Tracker>> {
        Some(Box::new(Self { rng: seed::fork(&self.rng, seed), ..self.clone() }))
    }
}

/// Computes color histograms of ellipses on a frame.
#[derive(Clone)]
struct Colors {
    kernel: Kernel,
    points: u32,
    binning: Binning,
    /// Bins of the pixels of the newest frame.
    grid: Grid,
    histogram: Histogram,
}

impl Colors {
    /// The histogram of an ellipse; the kernel that weighs pixels needs [`Grid::look`] before.
    fn histogram(&mut self, frame: &Frame, ellipse: &Ellipse, rng: &mut ChaCha8Rng) -> &Histogram {
        match self.kernel {
            Kernel::Epanechnikov => self.histogram.sum_inside(&self.grid, ellipse),
            Kernel::Points => self.histogram.sum_points(frame, &self.binning, ellipse, self.points, rng),
        }
        &self.histogram
    }
}

fn moments(params: &Params, cloud: &Cloud<5>, posterior: &Posterior<5>, likeness: f64) -> Moments {
    let likelihood = likelihood(likeness, params.sigma_color);
    Moments::of(posterior, &cloud.weights, &[0, 1, 2, 3, 4], likelihood)
}

/// Bounds on ellipses.
#[derive(Debug, Clone, Copy)]
struct EllipseLimits {
    /// Least half axis in pixels.
    shortest: f64,
    /// Largest half axis in pixels, at least `shortest`.
    longest: f64,
}

impl EllipseLimits {
    fn new(params: &Params, frame: &Frame) -> Self {
        let shortest = params.minimum_axis;
        let longest = (frame.width().max(frame.height()) as f64).max(shortest);
        Self { shortest, longest }
    }

    /// Ellipse clamped to the bounds.
    fn keep(&self, [x, y, hx, hy, theta]: Ellipse) -> Ellipse {
        let axis = |h: f64| h.min(self.longest).max(self.shortest);
        [x, y, axis(hx), axis(hy), theta]
    }
}

/// Likelihood `exp((rho - 1) / (2 sigma^2))` of a histogram with Bhattacharyya coefficient `rho`.
pub(super) fn likelihood(rho: f64, sigma: f64) -> f64 {
    ((rho - 1.0) / (2.0 * sigma * sigma)).exp()
}

/// Likelihoods divided by the best one, so that a small `sigma` does not underflow.
pub(super) fn relative_likelihoods(rho: &[f64], sigma: f64) -> impl Iterator<Item = f64> {
    let best = rho.iter().fold(0.0, |a: f64, &b| a.max(b));
    rho.iter().map(move |r| likelihood(1.0 + r - best, sigma))
}

/// Ellipse that touches the sides of a rectangle or rotated quadrilateral; for other polygons, of their
/// upright bounds. `Hx` is the axis nearer to the x axis.
fn ellipse(region: &Region) -> Ellipse {
    let rect = region.rect();
    let (x, y) = rect.center();
    let theta = match region {
        Region::Polygon(p) if p.len() == 4 => {
            // The rule of `Region::rect`: the side nearer to the x axis is the width.
            let first = if (p[1].0 - p[0].0).abs() >= (p[1].1 - p[0].1).abs() { 0 } else { 1 };
            let along = |a: usize, b: usize| (p[b % 4].0 - p[a % 4].0, p[b % 4].1 - p[a % 4].1);
            let (one, other) = (along(first, first + 1), along(first + 3, first + 2));
            let (dx, dy) = (one.0 + other.0, one.1 + other.1);
            // A direction and its opposite are the same axis.
            if dx < 0.0 { (-dy).atan2(-dx) } else { dy.atan2(dx) }
        }
        _ => 0.0,
    };
    [x, y, rect.w / 2.0, rect.h / 2.0, theta]
}

/// The rectangle around an ellipse along its axes.
pub(super) fn region(&[x, y, hx, hy, theta]: &Ellipse) -> Region {
    let (sin, cos) = theta.sin_cos();
    let corner = |u: f64, v: f64| (x + cos * u - sin * v, y + sin * u + cos * v);
    Region::Polygon(vec![corner(-hx, -hy), corner(hx, -hy), corner(hx, hy), corner(-hx, hy)])
}
