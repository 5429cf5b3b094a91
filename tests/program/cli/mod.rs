//! The command line as scripts see it: exit codes, what is printed where, and what happens to files.

mod contact;
mod errors;
mod joints;
mod report;
mod runs;
mod warnings;
