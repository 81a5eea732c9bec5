//! Layers of small convolutional networks, with the same bits on every processor.
//!
//! ```text
//! pointwise    y[o] = f(b[o] + sum_i w[o, i] x[i])                         at every pixel
//! depthwise    y[c, r, s] = f(b[c] + sum_{j, k} w[c, j, k] x[c, stride r + j - pad, stride s + k - pad])
//! excite       y[c] = f(g[c] x[c])                                         g from the channels' means
//! ```
//!
//! Each output is one sum: first the bias, then the products in the order of the indices above, without fused
//! multiplication. So all vector widths and all processors give the same bits. Terms beyond the border are
//! left out.
//!
//! A [`Tensor`] is stored as `[row][channel / 8][column][8]`, so that eight channels are one vector and a row of all
//! channels stays in the fastest cache; numbers of channels are multiples of 8. Weights are stored as
//! models/nanotrack/weights.py writes them.

pub mod nanotrack;

use multiversion::multiversion;
use std::cell::RefCell;

/// Number of channels that are computed side by side.
const LANES: usize = 8;

/// Number of pixels that are computed side by side.
const PIXELS: usize = 4;

/// Eight channels of a pixel, or of a weight.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(32))]
pub struct Lanes(pub [f32; LANES]);

impl Lanes {
    const ZERO: Self = Self([0.0; LANES]);
}

/// Activation function after a layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Activation {
    /// `x`.
    None,
    /// `max(x, 0)`.
    Relu,
    /// `min(max(x, 0), 6)`.
    Relu6,
    /// `x min(max(x / 6 + 1 / 2, 0), 1)`.
    HardSwish,
}

impl Activation {
    #[inline(always)]
    fn of(self, Lanes(mut x): Lanes) -> Lanes {
        match self {
            Self::None => {}
            Self::Relu => x.iter_mut().for_each(|v| *v = clamp(*v, f32::INFINITY)),
            Self::Relu6 => x.iter_mut().for_each(|v| *v = clamp(*v, 6.0)),
            Self::HardSwish => x.iter_mut().for_each(|v| *v *= clamp(*v * (1.0 / 6.0) + 0.5, 1.0)),
        }
        Lanes(x)
    }
}

/// Computes `min(max(v, 0), most)` in two vector operations.
#[inline(always)]
fn clamp(v: f32, most: f32) -> f32 {
    let v = if v > 0.0 { v } else { 0.0 };
    if v < most { v } else { most }
}

thread_local! {
    /// Memory of tensors that are no longer used, for reuse.
    static SPARE: RefCell<Vec<Vec<Lanes>>> = const { RefCell::new(Vec::new()) };
}

/// A tensor: rows of pixels with groups of eight channels.
#[derive(Debug, PartialEq)]
pub struct Tensor {
    height: usize,
    width: usize,
    /// Number of groups of eight channels.
    groups: usize,
    values: Vec<Lanes>,
}

impl Drop for Tensor {
    fn drop(&mut self) {
        let values = std::mem::take(&mut self.values);
        // Beyond the end of a thread its memory is gone.
        let _ = SPARE.try_with(|spare| spare.borrow_mut().push(values));
    }
}

impl Tensor {
    /// Tensor with arbitrary contents.
    fn new(height: usize, width: usize, groups: usize) -> Self {
        let mut values = SPARE.with(|spare| spare.borrow_mut().pop()).unwrap_or_default();
        values.resize(height * width * groups, Lanes::ZERO);
        Self { height, width, groups, values }
    }

    /// Row `y` of a group of channels.
    fn row(&self, y: usize, group: usize) -> &[Lanes] {
        &self.values[(y * self.groups + group) * self.width..][..self.width]
    }

    /// Eight channels of a pixel.
    pub fn at(&self, y: usize, x: usize, group: usize) -> [f32; LANES] {
        self.row(y, group)[x].0
    }

    /// Means of the channels, as a tensor of one pixel.
    fn means(&self) -> Self {
        let mut means = Self::new(1, 1, self.groups);
        let pixels = (self.height * self.width) as f32;
        for group in 0..self.groups {
            let mut sum = [0.0; LANES];
            for y in 0..self.height {
                for x in self.row(y, group) {
                    (0..LANES).for_each(|l| sum[l] += x.0[l]);
                }
            }
            means.values[group] = Lanes(sum.map(|s| s / pixels));
        }
        means
    }

    /// Multiplies each channel by its factor from a tensor of one pixel.
    fn excite(mut self, factors: &Self, activation: Activation) -> Self {
        let row = self.width * self.groups;
        for row in self.values.chunks_exact_mut(row) {
            for (values, Lanes(g)) in row.chunks_exact_mut(self.width).zip(&factors.values) {
                for v in values {
                    *v = activation.of(Lanes(std::array::from_fn(|l| g[l] * v.0[l])));
                }
            }
        }
        self
    }

    /// Concatenates the channels of two tensors of the same size.
    fn beside(&self, other: &Self) -> Self {
        let mut both = Self::new(self.height, self.width, self.groups + other.groups);
        let (left, right) = (self.width * self.groups, self.width * other.groups);
        for (y, row) in both.values.chunks_exact_mut(left + right).enumerate() {
            row[..left].copy_from_slice(&self.values[y * left..][..left]);
            row[left..].copy_from_slice(&other.values[y * right..][..right]);
        }
        both
    }
}

/// Weights that no layer has taken yet. Each layer takes its weights from the front.
pub struct Weights<'a>(pub &'a [Lanes]);

impl<'a> Weights<'a> {
    fn take(&mut self, count: usize) -> &'a [Lanes] {
        let (taken, rest) = self.0.split_at(count);
        self.0 = rest;
        taken
    }

    /// Pointwise convolution to `groups` times eight channels.
    fn pointwise(&mut self, x: &Tensor, groups: usize, activation: Activation) -> Tensor {
        let (bias, weight) = (self.take(groups), self.take(groups * x.groups * LANES));
        pointwise(x, bias, weight, None, activation)
    }

    /// Depthwise convolution of `side` x `side` pixels, padded so that stride 1 keeps the size.
    fn depthwise(&mut self, x: &Tensor, side: usize, stride: usize, activation: Activation) -> Tensor {
        let (bias, weight) = (self.take(x.groups), self.take(x.groups * side * side));
        let pad = (side - 1) / 2;
        match (side, stride) {
            (2, _) => depthwise::<2, 1>(x, bias, weight, pad, activation),
            (3, 1) => depthwise::<3, 1>(x, bias, weight, pad, activation),
            (3, _) => depthwise::<3, 2>(x, bias, weight, pad, activation),
            (_, 1) => depthwise::<5, 1>(x, bias, weight, pad, activation),
            _ => depthwise::<5, 2>(x, bias, weight, pad, activation),
        }
    }
}

/// Computes `activation(bias + weight x)`, plus `rest` if given.
#[multiversion(targets("x86_64+avx2"))]
fn pointwise(
    x: &Tensor,
    bias: &[Lanes],
    weight: &[Lanes],
    rest: Option<&Tensor>,
    activation: Activation,
) -> Tensor {
    let mut y = Tensor::new(x.height, x.width, bias.len());
    let inputs = x.groups * LANES;
    for row in 0..x.height {
        let source = &x.values[row * x.groups * x.width..][..x.groups * x.width];
        // Two groups at a time: the sums of three and what they are made of do not fit into the registers.
        for (pair, bias) in bias.chunks(2).enumerate() {
            let (group, together) = (2 * pair, bias.len());
            let weight = &weight[group * inputs..][..together * inputs];
            let at = (row * y.groups + group) * y.width;
            let target = &mut y.values[at..][..together * x.width];
            let rest = rest.map(|rest| &rest.values[at..][..together * x.width]);
            match together {
                2 => across::<2>(source, x.width, bias, weight, rest, activation, target),
                _ => across::<1>(source, x.width, bias, weight, rest, activation, target),
            }
        }
    }
    y
}

/// Computes one row of `G` groups of a pointwise convolution.
#[inline(always)]
fn across<const G: usize>(
    source: &[Lanes],
    width: usize,
    bias: &[Lanes],
    weight: &[Lanes],
    rest: Option<&[Lanes]>,
    activation: Activation,
    target: &mut [Lanes],
) {
    if width < PIXELS {
        for x in 0..width {
            tile::<G, 1>(source, width, x, bias, weight, rest, activation, target);
        }
        return;
    }
    // The last pixels are computed twice where the width is no multiple.
    for x in (0..width).step_by(PIXELS) {
        let x = x.min(width - PIXELS);
        tile::<G, PIXELS>(source, width, x, bias, weight, rest, activation, target);
    }
}

#[inline(always)]
#[expect(clippy::too_many_arguments)]
fn tile<const G: usize, const P: usize>(
    source: &[Lanes],
    width: usize,
    x: usize,
    bias: &[Lanes],
    weight: &[Lanes],
    rest: Option<&[Lanes]>,
    activation: Activation,
    target: &mut [Lanes],
) {
    let inputs = weight.len() / G;
    let mut sums: [[[f32; LANES]; P]; G] = std::array::from_fn(|g| [bias[g].0; P]);
    for (i, row) in source.chunks_exact(width).enumerate() {
        let Some(pixels) = row[x..].first_chunk::<P>() else { return };
        let w: [&[Lanes]; G] = std::array::from_fn(|g| &weight[g * inputs + i * LANES..][..LANES]);
        for l in 0..LANES {
            for g in 0..G {
                let w = w[g][l].0;
                for p in 0..P {
                    let v = pixels[p].0[l];
                    for o in 0..LANES {
                        sums[g][p][o] += w[o] * v;
                    }
                }
            }
        }
    }
    for (g, sums) in sums.iter().enumerate() {
        for (p, sum) in sums.iter().enumerate() {
            let at = g * width + x + p;
            let mut value = activation.of(Lanes(*sum));
            if let Some(rest) = rest {
                (0..LANES).for_each(|o| value.0[o] += rest[at].0[o]);
            }
            target[at] = value;
        }
    }
}

/// Depthwise convolution of `K` x `K` pixels.
#[multiversion(targets("x86_64+avx2"))]
fn depthwise<const K: usize, const S: usize>(
    x: &Tensor,
    bias: &[Lanes],
    weight: &[Lanes],
    pad: usize,
    activation: Activation,
) -> Tensor {
    let size = |side: usize| (side + 2 * pad - K) / S + 1;
    let mut y = Tensor::new(size(x.height), size(x.width), x.groups);
    let weight = weight.as_chunks::<K>().0;
    for row in 0..y.height {
        for group in 0..x.groups {
            // Rows of the kernel that are inside, and the rows under them.
            let (from, to) = (pad.saturating_sub(S * row), (x.height + pad - S * row).min(K));
            let first_line = (S * row + from - pad) * x.groups + group;
            let weight = &weight[group * K + from..group * K + to];
            let line = |j: usize| &x.values[(first_line + j * x.groups) * x.width..][..x.width];
            let at = (row * y.groups + group) * y.width;
            let target = &mut y.values[at..][..y.width];
            // Columns whose terms are all inside.
            let (first, last) = (pad.div_ceil(S), (x.width + pad - K) / S + 1);
            let mut column = 0;
            while column < y.width {
                if column >= first && column + PIXELS <= last {
                    let mut sums = [bias[group].0; PIXELS];
                    for (j, w) in weight.iter().enumerate() {
                        let source = &line(j)[S * column - pad..][..S * (PIXELS - 1) + K];
                        for (k, w) in w.iter().enumerate() {
                            let w = w.0;
                            for p in 0..PIXELS {
                                let v = source[S * p + k].0;
                                for l in 0..LANES {
                                    sums[p][l] += w[l] * v[l];
                                }
                            }
                        }
                    }
                    for p in 0..PIXELS {
                        target[column + p] = activation.of(Lanes(sums[p]));
                    }
                    column += PIXELS;
                    continue;
                }
                let mut sum = bias[group].0;
                for (j, w) in weight.iter().enumerate() {
                    let source = line(j);
                    for (k, w) in w.iter().enumerate() {
                        let from = (S * column + k).checked_sub(pad).and_then(|from| source.get(from));
                        if let Some(from) = from {
                            (0..LANES).for_each(|l| sum[l] += w.0[l] * from.0[l]);
                        }
                    }
                }
                target[column] = activation.of(Lanes(sum));
                column += 1;
            }
        }
    }
    y
}

/// Convolution of 3 x 3 pixels with stride 2, from three planes of `side` x `side` values to 16 channels,
/// with zeros beyond the border.
#[multiversion(targets("x86_64+avx2"))]
fn convolution(
    planes: &[f32],
    side: usize,
    bias: &[Lanes],
    weight: &[Lanes],
    activation: Activation,
) -> Tensor {
    const GROUPS: usize = 2;
    const TERMS: usize = 27;
    let out = side.div_ceil(2);
    let mut y = Tensor::new(out, out, GROUPS);
    // Three rows of each plane, between zeros.
    let padded = 2 * out + 1;
    let mut lines = vec![0.0_f32; 9 * padded];
    for row in 0..out {
        for (i, line) in lines.chunks_exact_mut(padded).enumerate() {
            let (plane, from) = (i / 3, (2 * row + i % 3).checked_sub(1).filter(|from| *from < side));
            match from {
                Some(from) => line[1..=side].copy_from_slice(&planes[(plane * side + from) * side..][..side]),
                None => line.fill(0.0),
            }
        }
        let target = &mut y.values[row * GROUPS * out..][..GROUPS * out];
        for x in (0..out).step_by(PIXELS) {
            let mut sums: [[[f32; LANES]; PIXELS]; GROUPS] = std::array::from_fn(|g| [bias[g].0; PIXELS]);
            for (i, line) in lines.chunks_exact(padded).enumerate() {
                let source = &line[2 * x..][..2 * PIXELS + 1];
                for k in 0..3 {
                    for g in 0..GROUPS {
                        let w = weight[g * TERMS + 3 * i + k].0;
                        for p in 0..PIXELS {
                            let v = source[2 * p + k];
                            for l in 0..LANES {
                                sums[g][p][l] += w[l] * v;
                            }
                        }
                    }
                }
            }
            for g in 0..GROUPS {
                for p in 0..PIXELS {
                    target[g * out + x + p] = activation.of(Lanes(sums[g][p]));
                }
            }
        }
    }
    y
}
