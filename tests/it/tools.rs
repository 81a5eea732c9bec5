//! Helpers of these tests.

#[cfg(unix)]
#[path = "../tools/page.rs"]
pub mod page;
#[path = "../tools/program.rs"]
mod program;

pub use program::{Place, Ran, Row, number, trackfail, words};
#[cfg(target_os = "linux")]
pub use program::{memory, resident};
pub use trackfail_testing::{assert_same_files, files, needs, rows};

/// Runs the program with arguments and gives exit code, stdout and stderr.
pub fn output(arguments: &[&str]) -> (i32, String, String) {
    let ran = Ran::of(trackfail().args(arguments));
    (ran.code.unwrap_or(-1), ran.out, ran.err)
}
