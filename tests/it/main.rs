//! The program as a user meets it: commands, files, exit codes.
//! Shells, links and signals of Unix are used throughout.

#![cfg(unix)]

mod archives;
mod bad_data;
mod beside;
mod detect;
mod detect_inputs;
mod detect_output;
mod docs;
mod download;
mod engine;
mod errors;
mod explain;
mod failed_tracks;
mod fetch;
mod frame_measures;
mod hostile;
mod learning;
mod monitor;
mod needs;
#[cfg(target_os = "linux")]
mod outputs;
mod outside;
mod packed;
mod parquet;
mod process;
mod readings;
mod restarts;
mod sent;
mod slurm;
mod synthetic;
mod tables;
#[path = "../tools/program.rs"]
mod tools;
mod track_quality;
mod user_suites;
mod verbs;
