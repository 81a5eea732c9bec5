//! Tests that take long by nature: killed runs, full disks, a real SLURM, a real browser, the papers' experiments.
//! `cargo test --test slow` runs them; `cargo test` alone does not.

#[cfg(unix)]
mod browser;
mod experiments;
mod interruption;
#[cfg(target_os = "linux")]
mod monitor;
#[cfg(unix)]
mod page;
mod real;
#[cfg(unix)]
mod site;
#[cfg(unix)]
mod slurm;
#[path = "../tools/program.rs"]
mod tools;
#[cfg(unix)]
mod user_page;
