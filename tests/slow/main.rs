//! Tests that take long by nature: killed runs, full disks, a real SLURM, a real browser, the papers' experiments.
//! `cargo test --test slow` runs them; `cargo test` alone does not.
//! Shells, links and signals of Unix are used throughout.

#![cfg(unix)]

mod browser;
mod experiments;
mod interruption;
#[cfg(target_os = "linux")]
mod monitor;
mod page;
mod real;
mod site;
mod slurm;
#[path = "../tools/program.rs"]
mod tools;
mod user_page;
