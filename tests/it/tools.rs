//! Helpers of these tests.

#[cfg(unix)]
#[path = "../tools/page.rs"]
pub mod page;
#[path = "../tools/program.rs"]
mod program;

#[cfg(unix)]
pub use program::trackfail;
pub use program::{Place, Ran, Row, number, words};
#[cfg(target_os = "linux")]
pub use program::{memory, resident};
pub use trackfail_testing::{assert_same_files, files, needs, rows};
