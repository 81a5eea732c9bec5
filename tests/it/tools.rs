//! Helpers of these tests.

#[cfg(unix)]
#[path = "../tools/page.rs"]
pub mod page;
#[path = "../tools/program.rs"]
mod program;

#[cfg(target_os = "linux")]
pub use program::resident;
pub use program::trackfail;
pub use trackfail_testing::{assert_same_files, files, needs, rows};

/// Runs the program with arguments and gives exit code, stdout and stderr.
pub fn output(arguments: &[&str]) -> (i32, String, String) {
    let output = trackfail().args(arguments).output().expect("the program starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().unwrap_or(-1), text(&output.stdout), text(&output.stderr))
}
