//! Pixels without files: frames, integer windows on them, filters.

mod decode;
pub mod distribution;
mod encode;
mod frame;
mod window;

pub use decode::{LONGEST_SIDE, decode, size};
pub use encode::encode_png;
pub use frame::{Frame, ImageError};
pub use window::Window;
