//! The program as a user meets it: commands, files, exit codes.

mod bad_data;
mod detect;
mod errors;
mod real;
mod synthetic;
mod tools;
