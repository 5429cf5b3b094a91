//! Files and folders to write, as arguments.

use clap::builder::{PathBufValueParser, TypedValueParser};
use std::path::PathBuf;

/// A file to write.
///
/// # Errors
/// An error for `-`, by which users mean standard output: a program cannot rename a file to it or seek in it.
pub fn output_file() -> impl TypedValueParser<Value = PathBuf> {
    not_standard_output("standard output is not supported; give a file, ./- if it shall have this name")
}

/// A folder to write into.
///
/// # Errors
/// As for [`output_file`]: several files need a folder.
pub fn output_folder() -> impl TypedValueParser<Value = PathBuf> {
    not_standard_output("several files cannot go to standard output; give a folder, ./- if it shall have this name")
}

fn not_standard_output(otherwise: &'static str) -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(move |path| if path.as_os_str() == "-" { Err(otherwise) } else { Ok(path) })
}
