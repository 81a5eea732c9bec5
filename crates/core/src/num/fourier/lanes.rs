//! Numbers in groups of four that are transformed together.
//!
//! The algorithms of `rustfft` are generic over the number type. With a group of four as the number, one
//! transform handles four lines: each operation works on a vector register and never mixes lines. So the
//! results have the same bits on all processors, unlike those of the crate's own AVX kernels.

use rustfft::num_complex::Complex;
use rustfft::num_traits::{FromPrimitive, Num, One, Signed, Zero};
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Rem, Sub, SubAssign};

/// Number of lines that are transformed together, the size of a vector register on all x86-64 and aarch64
/// processors.
pub const LANES: usize = 4;

/// One value for each of four lines.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(16))]
pub struct Lanes(pub [f32; LANES]);

impl Lanes {
    /// Zero in all lines.
    pub const ZERO: Lanes = Lanes([0.0; LANES]);

    /// The same value in all lines.
    #[inline(always)]
    pub fn splat(value: f32) -> Self {
        Self([value; LANES])
    }
}

/// Zero in all lines.
pub const ZEROS: Complex<Lanes> = Complex { re: Lanes::ZERO, im: Lanes::ZERO };

macro_rules! operator {
    ($($operation:ident :: $function:ident, $with:tt;)*) => {$(
        impl $operation for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self(std::array::from_fn(|lane| self.0[lane] $with other.0[lane]))
            }
        }
    )*};
}

macro_rules! assignment {
    ($($operation:ident :: $function:ident, $with:tt;)*) => {$(
        impl $operation for Lanes {
            #[inline(always)]
            fn $function(&mut self, other: Self) {
                *self = *self $with other;
            }
        }
    )*};
}

operator! { Add::add, +; Sub::sub, -; Mul::mul, *; Div::div, /; Rem::rem, %; }
assignment! { AddAssign::add_assign, +; SubAssign::sub_assign, -; MulAssign::mul_assign, *; }

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|value| -value))
    }
}

impl Zero for Lanes {
    fn zero() -> Self {
        Self::ZERO
    }

    fn is_zero(&self) -> bool {
        *self == Self::ZERO
    }
}

impl One for Lanes {
    fn one() -> Self {
        Self([1.0; LANES])
    }
}

impl FromPrimitive for Lanes {
    fn from_i64(value: i64) -> Option<Self> {
        Some(Self([value as f32; LANES]))
    }

    fn from_u64(value: u64) -> Option<Self> {
        Some(Self([value as f32; LANES]))
    }

    fn from_f64(value: f64) -> Option<Self> {
        Some(Self([value as f32; LANES]))
    }
}

impl Num for Lanes {
    type FromStrRadixErr = <f32 as Num>::FromStrRadixErr;

    fn from_str_radix(text: &str, radix: u32) -> Result<Self, Self::FromStrRadixErr> {
        <f32 as Num>::from_str_radix(text, radix).map(|value| Self([value; LANES]))
    }
}

impl Signed for Lanes {
    fn abs(&self) -> Self {
        Self(self.0.map(f32::abs))
    }

    fn abs_sub(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|lane| (self.0[lane] - other.0[lane]).max(0.0)))
    }

    fn signum(&self) -> Self {
        Self(self.0.map(f32::signum))
    }

    fn is_positive(&self) -> bool {
        self.0.iter().all(|value| value.is_sign_positive())
    }

    fn is_negative(&self) -> bool {
        self.0.iter().all(|value| value.is_sign_negative())
    }
}
