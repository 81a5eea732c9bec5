//! Helpers of these tests.

#[cfg(unix)]
#[path = "../tools/page.rs"]
pub mod page;
#[path = "../tools/program.rs"]
mod program;

#[cfg(target_os = "linux")]
pub use program::memory;
pub use program::{Place, Ran, Row, trackfail};
pub use trackfail_testing::{assert_same_files, needs, real_data};
