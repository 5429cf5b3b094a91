//! Files and folders to write, as arguments.

use anyhow::{Context, anyhow};
use catena::session::folder_of;
use clap::builder::{PathBufValueParser, TypedValueParser};
use std::path::{Path, PathBuf};

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

/// Checks that a folder is there or can be made. Its parent folder must exist, as for a log.
///
/// # Errors
/// An error for a file in its place, and for a folder above it that does not exist.
pub fn check_folder(folder: &Path) -> anyhow::Result<()> {
    if folder.exists() && !folder.is_dir() {
        return Err(anyhow!("cannot write into {}: it is not a folder", folder.display()));
    }
    let above = folder_of(folder);
    if !above.is_dir() {
        return Err(anyhow!("cannot write into {}: there is no folder {}", folder.display(), above.display()));
    }
    Ok(())
}

/// Makes a folder, unless it is there.
///
/// # Errors
/// As of [`check_folder`], and a folder that cannot be made.
pub fn make_folder(folder: &Path) -> anyhow::Result<()> {
    check_folder(folder)?;
    match folder.is_dir() {
        true => Ok(()),
        false => std::fs::create_dir(folder).with_context(|| format!("cannot make the folder {}", folder.display())),
    }
}
