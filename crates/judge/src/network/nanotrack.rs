//! Networks of NanoTrack v2 and v3: features of a crop, and the response of a search region to a template.
//!
//! ```text
//! features    first convolution, then blocks: expand (pointwise), depthwise, squeeze and excite, project (pointwise)
//! v2 branch   pixel-wise correlation c[t] = sum_i z_t[i] x[i], excited; six times depthwise 3 x 3, pointwise; logits
//! v3 branch   beside it a depthwise correlation with the middle 4 x 4 pixels of the template; both squeezed together
//! ```
//!
//! Crops are planes of red, green and blue, `0..=255`, of 127 x 127 (template) or 255 x 255 pixels (search region). Of
//! the maps, cell `(i, j)` stands for the place `16 (i - n / 2)`, `16 (j - n / 2)` in pixels from the middle of the search
//! region; `n` is 16 (v2) or 15 (v3). Each has the logits of background and target, and the logarithms of the distances
//! to the left, the top, the right and the bottom side of the box.
//!
//! Source: HonglinChu/SiamTrackers @ 248663f, NanoTrack/models (Apache-2.0, models/nanotrack/LICENSE); v2 is what OpenCV's
//! `TrackerNano` runs. Deviations: none but the order of sums; the largest difference to onnxruntime is in the tests.

use super::Activation::{HardSwish, None as Identity, Relu, Relu6};
use super::{Activation, LANES, Lanes, Tensor, Weights, convolution, depthwise, pointwise};
use serde::{Deserialize, Serialize};
use std::sync::LazyLock;

/// Version of the network.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Version {
    /// The version in OpenCV's `TrackerNano`.
    #[default]
    V2,
    /// A version with a longer backbone and a second correlation.
    V3,
}

/// A network. Its weights are part of the program.
pub struct Network {
    version: Version,
    backbone: Vec<Lanes>,
    template: Vec<Lanes>,
    head: Vec<Lanes>,
}

/// Shape of a block: side and stride of the depthwise kernel, then groups of channels inside the block, of
/// its squeeze (0 without one), and after it; and its activation.
type Block = ([usize; 5], Activation);

/// Blocks after the first one, which has no expansion. v2 lacks the last block.
const BLOCKS: [Block; 8] = [
    ([3, 2, 9, 0, 3], Relu),
    ([3, 1, 11, 0, 3], Relu),
    ([5, 2, 12, 3, 5], HardSwish),
    ([5, 1, 30, 8, 5], HardSwish),
    ([5, 1, 30, 8, 5], HardSwish),
    ([5, 1, 15, 4, 6], HardSwish),
    ([5, 1, 18, 5, 6], HardSwish),
    ([5, 1, 36, 9, 12], HardSwish),
];

/// A target in the form that the head compares: for classes and for distances.
pub struct Template([Kernels; 2]);

/// Template features as weights of a pointwise convolution and, in v3, of a depthwise one.
struct Kernels {
    pixelwise: Vec<Lanes>,
    depthwise: Vec<Lanes>,
}

/// Response of the network at a cell of a search region: logits of background and target, and logarithms of the
/// distances to the left, top, right and bottom side.
pub type Answer = ([f32; 2], [f32; 4]);

const V2_WEIGHTS: &[u8] = include_bytes!("../../models/nanotrack/v2.weights");
const V3_WEIGHTS: &[u8] = include_bytes!("../../models/nanotrack/v3.weights");

static V2: LazyLock<Network> = LazyLock::new(|| Network::read(Version::V2, V2_WEIGHTS));
static V3: LazyLock<Network> = LazyLock::new(|| Network::read(Version::V3, V3_WEIGHTS));

impl Network {
    /// Network of a version, loaded at the first call.
    pub fn of(version: Version) -> &'static Self {
        match version {
            Version::V2 => &V2,
            Version::V3 => &V3,
        }
    }

    /// Version of the network.
    pub fn version(&self) -> Version {
        self.version
    }

    fn read(version: Version, file: &[u8]) -> Self {
        let (counts, weights) = file.split_at(12);
        let mut groups = weights.as_chunks::<4>().0.as_chunks::<LANES>().0.iter();
        let [backbone, template, head] = std::array::from_fn(|i| {
            let count = counts.as_chunks::<4>().0[i];
            let part = groups.by_ref().take(u32::from_le_bytes(count) as usize);
            part.map(|group| Lanes(group.map(f32::from_le_bytes))).collect()
        });
        Self { version, backbone, template, head }
    }

    /// Features of a crop of `side` x `side` pixels: 8 x 8 for a template, 16 x 16 for a search region.
    pub fn features(&self, planes: &[f32], side: usize) -> Tensor {
        let mut w = Weights(&self.backbone);
        let (bias, weight) = (w.take(2), w.take(2 * 27));
        let x = convolution(planes, side, bias, weight, HardSwish);
        let x = w.depthwise(&x, 3, 2, Relu);
        let x = w.squeeze(x, 1, Identity);
        let mut x = w.pointwise(&x, 2, Identity);
        let blocks = if self.version == Version::V2 { BLOCKS.len() - 1 } else { BLOCKS.len() };
        for &([side, stride, inside, squeeze, groups], activation) in &BLOCKS[..blocks] {
            let y = w.pointwise(&x, inside, activation);
            let y = if squeeze == 0 {
                w.depthwise(&y, side, stride, activation)
            } else {
                let y = w.depthwise(&y, side, stride, Identity);
                w.squeeze(y, squeeze, activation)
            };
            let (bias, weight) = (w.take(groups), w.take(groups * y.groups * LANES));
            let rest = (stride == 1 && x.groups == groups).then_some(&x);
            x = pointwise(&y, bias, weight, rest, Identity);
        }
        x
    }

    /// Features of a template from their [numbers](Tensor::flat); `None` if the number of values is wrong.
    pub fn features_of_template(&self, values: &[f32]) -> Option<Tensor> {
        let groups = if self.version == Version::V2 { 6 } else { 12 };
        let (values, rest) = values.as_chunks::<LANES>();
        let mut z = Tensor::new(8, 8, groups);
        if !rest.is_empty() || values.len() != z.values.len() {
            return None;
        }
        z.values.iter_mut().zip(values).for_each(|(z, v)| *z = Lanes(*v));
        Some(z)
    }

    /// Template from features of 8 x 8 pixels.
    pub fn template(&self, z: &Tensor) -> Template {
        let mut w = Weights(&self.template);
        let middle = (self.version == Version::V3).then(|| middle(z));
        Template([(); 2].map(|()| {
            let projected = w.pointwise(z, z.groups, Identity);
            // Pixel t of the template is output channel t, its channels are the inputs.
            let lane =
                |y: usize, i: usize| Lanes(std::array::from_fn(|x| projected.at(y, x, i / LANES)[i % LANES]));
            let pixelwise =
                (0..8).flat_map(|y| (0..LANES * z.groups).map(move |i| (y, i))).map(|(y, i)| lane(y, i));
            let pixelwise = pixelwise.collect();
            let depthwise = middle.as_ref().map_or_else(Vec::new, |middle| {
                let projected = w.pointwise(middle, z.groups, Identity);
                (0..z.groups)
                    .flat_map(|group| (0..4).flat_map(move |y| (0..4).map(move |x| (group, y, x))))
                    .map(|(group, y, x)| Lanes(projected.at(y, x, group)))
                    .collect()
            });
            Kernels { pixelwise, depthwise }
        }))
    }

    /// Response of search region features (16 x 16 pixels) to a template, cell by cell, in as many rows as columns.
    pub fn compare(&self, Template([classes, distances]): &Template, x: &Tensor) -> Vec<Answer> {
        let mut w = Weights(&self.head);
        let classes = self.branch(&mut w, classes, x);
        let distances = self.branch(&mut w, distances, x);
        let answer = |(classes, distances): (&Lanes, &Lanes)| {
            let [background, target, ..] = classes.0;
            let [left, top, right, bottom, ..] = distances.0;
            ([background, target], [left, top, right, bottom])
        };
        classes.values.iter().zip(&distances.values).map(answer).collect()
    }

    fn branch(&self, w: &mut Weights<'_>, template: &Kernels, x: &Tensor) -> Tensor {
        let zero = [Lanes::ZERO; 12];
        let projected = w.pointwise(x, x.groups, Identity);
        let c = pointwise(&projected, &zero[..8], &template.pixelwise, None, Identity);
        let factors = w.pointwise(&c.means(), 8, Relu);
        let factors = w.pointwise(&factors, 8, Identity).map(|v| sigmoid(f64::from(v)) as f32);
        let c = c.excite(&factors, Identity);
        let mut y = c;
        if self.version == Version::V3 {
            let c = w.depthwise(&y, 2, 1, Relu6);
            let c = w.pointwise(&c, 8, Identity);
            let projected = w.pointwise(x, x.groups, Identity);
            let d = depthwise::<4, 1>(&projected, &zero, &template.depthwise, 1, Identity);
            y = w.pointwise(&c.beside(&d), 12, Identity);
        }
        let (after_depthwise, after_pointwise) = match self.version {
            Version::V2 => (Identity, Relu6),
            Version::V3 => (Relu6, Identity),
        };
        for _ in 0..6 {
            y = w.depthwise(&y, 3, 1, after_depthwise);
            y = w.pointwise(&y, 12, after_pointwise);
        }
        w.pointwise(&y, 1, Identity)
    }
}

impl Weights<'_> {
    /// Squeeze and excitation with `groups` groups of channels.
    fn squeeze(&mut self, x: Tensor, groups: usize, activation: Activation) -> Tensor {
        let factors = self.pointwise(&x.means(), groups, Relu);
        let factors = self.pointwise(&factors, x.groups, Identity);
        x.excite(&factors.map(|v| super::clamp(v * (1.0 / 6.0) + 0.5, 1.0)), activation)
    }
}

impl Tensor {
    /// All numbers: by row, then by groups of eight channels, then by column.
    pub fn flat(&self) -> Vec<f32> {
        self.values.iter().flat_map(|v| v.0).collect()
    }

    fn map(mut self, of: impl Fn(f32) -> f32) -> Self {
        self.values.iter_mut().for_each(|v| v.0 = v.0.map(&of));
        self
    }
}

/// Middle 4 x 4 of 8 x 8 pixels.
fn middle(z: &Tensor) -> Tensor {
    let mut middle = Tensor::new(4, 4, z.groups);
    for (i, row) in middle.values.chunks_exact_mut(4).enumerate() {
        row.copy_from_slice(&z.row(2 + i / z.groups, i % z.groups)[2..6]);
    }
    middle
}

/// Logistic function `1 / (1 + exp(-x))`, with an exponential that gives the same bits on all processors.
pub fn sigmoid(x: f64) -> f64 {
    1.0 / (1.0 + libm::exp(-x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use sha2::{Digest, Sha256};
    use trackfail_testing::assert_near;

    /// Planes of `side` x `side` pixels with edges and slopes: `(x y / 16 + 5 x + 3 y + 40 c) mod 256`.
    fn pattern(side: usize) -> Vec<f32> {
        let pixel = |c: usize, y: usize, x: usize| ((x * y / 16 + 5 * x + 3 * y + 40 * c) % 256) as f32;
        (0..3 * side * side).map(|i| pixel(i / (side * side), i / side % side, i % side)).collect()
    }

    fn answers(version: Version) -> Vec<Answer> {
        let network = Network::of(version);
        let template = network.template(&network.features(&pattern(127), 127));
        network.compare(&template, &network.features(&pattern(255), 255))
    }

    /// Reference maps are from benches/peers/nanotrack.py: one line per cell, with two classes and four
    /// distances (not their logarithms).
    #[test]
    fn maps_are_those_of_onnxruntime() {
        for (version, oracle) in [
            (Version::V2, include_str!("nanotrack/onnxruntime_v2.txt")),
            (Version::V3, include_str!("nanotrack/onnxruntime_v3.txt")),
        ] {
            let (cells, lines) = (answers(version), oracle.lines());
            assert_eq!(lines.clone().count(), cells.len());
            for (k, ((classes, distances), line)) in cells.into_iter().zip(lines).enumerate() {
                let want: Vec<f64> = line.split(' ').map(|v| v.parse().unwrap()).collect();
                assert_near(classes.map(f64::from), &want[..2], 1e-5, format!("{version:?} {k}"));
                let shares = distances.iter().zip(&want[2..]).map(|(got, want)| f64::from(*got).exp() / want);
                assert_near(shares, [1.0; 4], 1e-5, format!("{version:?} {k}"));
            }
        }
    }

    /// The maps have the same bits on all processors, with all optimizations.
    #[test]
    fn bits_are_always_the_same() {
        let digest = |version| {
            let mut hash = Sha256::new();
            for (classes, distances) in answers(version) {
                classes.iter().chain(&distances).for_each(|v| hash.update(v.to_le_bytes()));
            }
            crate::num::hexadecimal(&hash.finalize()[..8])
        };
        let want = ["153382f471c4ba76", "f0c681d4351ca0ba"];
        assert_eq!([Version::V2, Version::V3].map(digest), want);
    }

    #[test]
    fn weights_are_the_known_files() {
        for (version, file, want) in [
            (Version::V2, V2_WEIGHTS, "c7e3a9b0343664705a38618e128d93f5c72c39d9ef52d1bc2c886476bb11f07a"),
            (Version::V3, V3_WEIGHTS, "0b12a3c6c8ee198e460f0926789eca0ece9006b6e03b9a626b1d5cdbf1e9148e"),
        ] {
            assert_eq!(crate::num::hexadecimal(&Sha256::digest(file)), want);
            let network = Network::of(version);
            let groups = network.backbone.len() + network.template.len() + network.head.len();
            assert_eq!(12 + 32 * groups, file.len());
        }
    }
}
