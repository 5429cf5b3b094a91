//! The command line as scripts see it: exit codes, what is printed where, and what happens to files.

mod beginnings;
mod contact;
mod errors;
mod joints;
mod linearize;
mod pieces;
mod report;
mod runs;
mod warnings;
