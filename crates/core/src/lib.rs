//! Foundations that every layer of trackfail uses: regions, pixels, numerics, and lists of plugins.
//!
//! | module | holds |
//! |---|---|
//! | [`region`] | rectangles and polygons, their overlap |
//! | [`mod@image`] | frames, color and gradient features, distribution fields, warps |
//! | [`direction`] | direction in which values are better |
//! | [`sequence`] | facts about a sequence for trackers and signals |
//! | [`num`] | filters, time series models, distributions, mixtures, comparisons of methods, seeds |
//! | [`plugin`] | lists of plugins, checked parameters, suggestions for misspelled words |

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

pub mod direction;
pub mod image;
pub mod num;
pub mod plugin;
pub mod region;
pub mod sequence;
#[cfg(test)]
mod testing;
