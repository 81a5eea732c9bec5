//! The program as a user meets it: commands, files, exit codes.

mod archives;
mod bad_data;
mod detect;
mod download;
mod errors;
mod fetch;
mod packed;
mod real;
mod server;
mod synthetic;
mod tools;
