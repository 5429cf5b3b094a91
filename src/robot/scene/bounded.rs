//! The bytes of an input, if it ends and is not too large.
//!
//! A robot or scene of 100 MB is a mistake, such as the name of a log, or of something that never ends. Devices are refused before anything is read;
//! a pipe may be an input, and is read until it ends or has given that much. The input `-` is standard input, read once for all that ask for it.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::sync::OnceLock;

/// Largest input (bytes).
pub const LARGEST: u64 = 100_000_000;

/// The name of standard input.
pub const STANDARD_INPUT: &str = "-";

/// Reads an input.
///
/// # Errors
/// The errors of the file system; an error for a device, and for a file larger than [`LARGEST`].
pub fn read_bounded(path: &Path) -> io::Result<Vec<u8>> {
    if path == Path::new(STANDARD_INPUT) {
        static READ: OnceLock<Result<Vec<u8>, String>> = OnceLock::new();
        let read = READ.get_or_init(|| up_to_the_largest(io::stdin().lock()).map_err(|error| error.to_string()));
        return read.clone().map_err(io::Error::other);
    }
    let file = File::open(path)?;
    let metadata = file.metadata()?;
    if is_device(&metadata) {
        return Err(io::Error::other("it is a device, not a file"));
    }
    if metadata.len() > LARGEST {
        return Err(too_large());
    }
    up_to_the_largest(file)
}

fn up_to_the_largest(input: impl Read) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    input.take(LARGEST + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > LARGEST { Err(too_large()) } else { Ok(bytes) }
}

fn too_large() -> io::Error {
    io::Error::other(format!("it is larger than {} MB", LARGEST / 1_000_000))
}

#[cfg(unix)]
fn is_device(metadata: &std::fs::Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    let kind = metadata.file_type();
    kind.is_char_device() || kind.is_block_device()
}

#[cfg(not(unix))]
fn is_device(_: &std::fs::Metadata) -> bool {
    false
}
