//! Integral histograms (Porikli, "Integral histogram: a fast way to extract histograms in Cartesian
//! spaces", CVPR 2005): the histogram of any upright window from four of its corners.
//!
//! ```text
//! H(x, y, u) = number of pixels (i, j), i < x, j < y, with code u
//! count(u) = H(r, b, u) - H(l, b, u) - H(r, t, u) + H(l, t, u)      window of columns [l, r) and rows [t, b)
//! ```
//!
//! Codes are bin numbers from 0; places count whole pixels from the left top corner of the codes. All
//! counts are exact. A corner's bins lie side by side, so that a window reads four runs of memory.

/// Cumulative counts of the codes of an image. The memory is kept between images.
#[derive(Debug, Clone, Default)]
pub struct IntegralHistogram {
    bins: usize,
    width: usize,
    height: usize,
    /// `(height + 1) * (width + 1)` corners of `bins` counts.
    sums: Vec<u32>,
    row: Vec<u32>,
}

impl IntegralHistogram {
    /// Number of counts stored for an image.
    pub fn room(width: usize, height: usize, bins: usize) -> usize {
        (width + 1).saturating_mul(height + 1).saturating_mul(bins)
    }

    /// Counts the codes of an image with `width` codes per row. Codes of `bins` and above are ignored.
    pub fn build(&mut self, codes: &[u16], width: usize, bins: usize) {
        let height = codes.len().checked_div(width).unwrap_or(0);
        (self.bins, self.width, self.height) = (bins, width, height);
        let stride = (width + 1) * bins;
        // The first row and the first column stay 0; everything else is written below.
        self.sums.resize((height + 1) * stride, 0);
        self.sums[..stride].fill(0);
        for (y, codes) in codes.chunks_exact(width.max(1)).enumerate() {
            let (upper, lower) = self.sums[y * stride..(y + 2) * stride].split_at_mut(stride);
            lower[..bins].fill(0);
            self.row.clear();
            self.row.resize(bins, 0);
            let corners =
                upper[bins..].chunks_exact(bins.max(1)).zip(lower[bins..].chunks_exact_mut(bins.max(1)));
            for (&code, (above, here)) in codes.iter().zip(corners) {
                if let Some(count) = self.row.get_mut(usize::from(code)) {
                    *count += 1;
                }
                for ((here, above), count) in here.iter_mut().zip(above).zip(&self.row) {
                    *here = above + count;
                }
            }
        }
    }

    /// Histogram of the columns `[left, right)` and rows `[top, bottom)`, clipped to the image.
    pub fn window(&self, [left, top, right, bottom]: [usize; 4]) -> Counts<'_> {
        let (right, bottom) = (right.min(self.width), bottom.min(self.height));
        let corner = |x: usize, y: usize| &self.sums[(y * (self.width + 1) + x) * self.bins..][..self.bins];
        let (left, top) = (left.min(right), top.min(bottom));
        Counts {
            plus: [corner(right, bottom), corner(left, top)],
            minus: [corner(left, bottom), corner(right, top)],
        }
    }
}

/// Histogram of a window.
#[derive(Debug, Clone, Copy)]
pub struct Counts<'a> {
    plus: [&'a [u32]; 2],
    minus: [&'a [u32]; 2],
}

impl Counts<'_> {
    /// Number of pixels in the window with code `bin`, which must be below the number of bins.
    pub fn of(&self, bin: usize) -> u32 {
        // Sums of two corners may pass 2^32, their difference is a count again.
        let plus = self.plus[0][bin].wrapping_add(self.plus[1][bin]);
        plus.wrapping_sub(self.minus[0][bin].wrapping_add(self.minus[1][bin]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn windows_agree_with_direct_counts(
            (width, codes) in (1_usize..9, 0_usize..9)
                .prop_flat_map(|(w, h)| (Just(w), prop::collection::vec(0_u16..7, w * h))),
            before in prop::collection::vec(0_u16..7, 12),
            places in prop::array::uniform4(0_usize..11),
        ) {
            let [left, top, right, bottom] = places;
            let mut integral = IntegralHistogram::default();
            // An image of another size before this one leaves nothing behind; codes 5 and 6 have no bin.
            integral.build(&before, 4, 5);
            integral.build(&codes, width, 5);
            let counts = integral.window(places);
            for bin in 0..5_u16 {
                let inside = |i: &usize| {
                    (left..right).contains(&(i % width)) && (top..bottom).contains(&(i / width))
                };
                let direct = (0..codes.len()).filter(|i| inside(i) && codes[*i] == bin).count();
                prop_assert_eq!(counts.of(usize::from(bin)) as usize, direct);
            }
        }
    }
}
