//! What every layer of trackfail uses: regions, pixels, numerics, and lists of plugins.
//!
//! | module | holds |
//! |---|---|
//! | [`region`] | rectangles and polygons, their overlap |
//! | [`mod@image`] | frames, color and gradient features, distribution fields, warps |
//! | [`direction`] | whether larger or smaller is better |
//! | [`num`] | filters, time series models, distributions, mixtures, comparisons of methods, seeds |
//! | [`plugin`] | an entry for each plugin of a list, checked parameters, nearest words |

pub mod direction;
pub mod image;
pub mod num;
pub mod plugin;
pub mod region;
