//! Starts the program as the tests do.

use assert_cmd::Command;

/// The program, in an environment without the user's settings.
pub fn trackfail() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_trackfail"));
    command.env_remove("TRACKFAIL_DATA").env_remove("TRACKFAIL_PLUGINS").env_remove("HOME");
    command
}

/// Resident memory of a process in KiB.
#[cfg(target_os = "linux")]
pub fn resident(id: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{id}/status")).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    line.trim().trim_end_matches(" kB").parse().unwrap()
}
