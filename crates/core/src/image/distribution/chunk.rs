//! Chunks of eight slots that are processed together.

/// Number of slots in a chunk.
pub(super) const LANES: usize = 8;

/// Eight neighboring slots, aligned so that no vector crosses a cache line.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(32))]
pub(super) struct Chunk(pub(super) [f32; LANES]);

impl Chunk {
    pub(super) const ZERO: Self = Self([0.0; LANES]);

    #[inline(always)]
    pub(super) fn map(self, f: impl Fn(f32) -> f32) -> Self {
        Self(self.0.map(f))
    }

    #[inline(always)]
    fn with(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|l| f(self.0[l], other.0[l])))
    }

    #[inline(always)]
    pub(super) fn plus(self, other: Self) -> Self {
        self.with(other, |a, b| a + b)
    }

    #[inline(always)]
    pub(super) fn minus(self, other: Self) -> Self {
        self.with(other, |a, b| a - b)
    }

    /// `weight * self + sum`, rounded once.
    ///
    /// On processors without a fused instruction, `f64` gives the same result: weights and slots are
    /// multiples of 2^-24 and at most 2, so that products and sums are exact in `f64`.
    #[inline(always)]
    pub(super) fn fused<const FMA: bool>(self, weight: f32, sum: Self) -> Self {
        self.with(sum, |value, sum| {
            if FMA {
                weight.mul_add(value, sum)
            } else {
                (f64::from(weight) * f64::from(value) + f64::from(sum)) as f32
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn both_ways_of_a_fused_multiplication_agree_bit_for_bit(
            pairs in proptest::collection::vec((0..=1_u32 << 24, -(1_i32 << 25)..=1 << 25), 1..64),
        ) {
            let unit = (1_u32 << 24) as f32;
            let (mut fused, mut plain) = (Chunk::ZERO, Chunk::ZERO);
            for (weight, slot) in pairs {
                // Kernels have the sum 1.
                let (weight, slot) = ((weight >> 6) as f32 / unit, Chunk([slot as f32 / unit; LANES]));
                fused = slot.fused::<true>(weight, fused);
                plain = slot.fused::<false>(weight, plain);
                prop_assert_eq!(fused.0.map(f32::to_bits), plain.0.map(f32::to_bits));
            }
        }
    }
}
