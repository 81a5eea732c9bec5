//! Starts the program as the tests do.

use assert_cmd::Command;

/// The program, in an environment without the user's settings.
pub fn trackfail() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_trackfail"));
    command.env_remove("TRACKFAIL_DATA").env_remove("TRACKFAIL_PLUGINS").env_remove("HOME");
    command
}
