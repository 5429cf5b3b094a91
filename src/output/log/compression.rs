//! Compressed chunks: records packed by Zstandard.
//!
//! What never changes, descriptions and geometry, is always compressed: it is written once and may be most of the log. Samples are
//! compressed on request only, because that costs as much as everything else about them (benches/README.md).
//! Equal meshes of one robot may be megabytes apart. So large chunks that never change are searched for matches from end to end, which costs
//! some megabytes of tables and would not pay for small ones.

use std::io;
use zstd::bulk::Compressor;
use zstd::zstd_safe::CParameter;

/// The name of the compression in the file.
pub(crate) const NAME: &str = "zstd";

/// The level of large chunks that never change, and of all others.
const LARGE_LEVEL: i32 = 6;
const LEVEL: i32 = 1;

/// Bytes of a large chunk.
const LARGE: usize = 1 << 20;

/// Matches in large chunks are looked for so many bytes back (a power of two); decoders accept no more by default.
const WINDOW: u32 = 27;

/// Packs the records of chunks.
pub(crate) struct Packer {
    compressor: Compressor<'static>,
    packed: Vec<u8>,
}

impl Packer {
    /// Of chunks of any size.
    pub(crate) fn new() -> io::Result<Self> {
        Ok(Packer { compressor: Compressor::new(LEVEL)?, packed: Vec::new() })
    }

    /// The records, packed.
    pub(crate) fn pack(&mut self, records: &[u8]) -> io::Result<&[u8]> {
        if records.len() > LARGE {
            self.compressor.set_parameter(CParameter::CompressionLevel(LARGE_LEVEL))?;
            self.compressor.set_parameter(CParameter::EnableLongDistanceMatching(true))?;
            self.compressor.set_parameter(CParameter::WindowLog(WINDOW))?;
        }
        self.packed.clear();
        self.packed.reserve(zstd::zstd_safe::compress_bound(records.len()));
        self.compressor.compress_to_buffer(records, &mut self.packed)?;
        Ok(&self.packed)
    }
}
