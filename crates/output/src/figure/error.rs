//! Errors of drawing.

/// A figure that cannot be drawn.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FigureError {
    /// The figure has neither panels nor stills, or its curves have no point.
    #[error("the figure has nothing to draw: {0}")]
    Empty(&'static str),
    /// The lower and upper end of a fixed range are not finite, not in order, or not above 0 on a logarithmic axis.
    #[error("{0} to {1} is no range for an axis")]
    Range(f64, f64),
    /// The figure has more rows or columns than a picture can hold.
    #[error("the figure would be {width} x {height} units; at most {limit} in either direction are drawn")]
    TooLarge {
        /// Width in units.
        width: u32,
        /// Height in units.
        height: u32,
        /// Limit in units.
        limit: u32,
    },
    /// plotters, resvg, krilla or the PNG encoder failed.
    #[error("the figure could not be drawn: {0}")]
    Draw(String),
}

/// Wraps an error of a writer.
pub fn failed(e: impl std::fmt::Display) -> FigureError {
    FigureError::Draw(e.to_string())
}
