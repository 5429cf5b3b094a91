//! Compressed chunks: records packed by Zstandard, or samples by what repeats in them.
//!
//! Zstandard packs the constant parts, descriptions and geometry: they are written once and may be most of the log. Packing samples with it would
//! cost as much as everything else about them (doc/decisions/020-log-container.md), so it is done on request only. [`Repetitions`] packs them by
//! default, which costs hardly more than the bytes that it saves. Equal meshes of one robot may be megabytes apart. So large chunks that never change
//! are searched for matches from end to end, which costs some megabytes of tables and would not pay for small ones.

use crate::output::log::storage::batch::Batch;
use crate::output::log::storage::repetition;
use crate::output::log::storage::repetition::Repetitions;
use std::io;
use zstd::bulk::Compressor;
use zstd::zstd_safe::CParameter;

/// The name of Zstandard in the file.
const NAME: &str = "zstd";

/// The level of large chunks that never change, and of all others.
const LARGE_LEVEL: i32 = 6;
const LEVEL: i32 = 1;

/// Bytes of a large chunk.
const LARGE: usize = 1 << 20;

/// Farthest match in large chunks, as a power of two in bytes; decoders accept no more by default.
const WINDOW: u32 = 27;

/// How the records of chunks are packed.
pub(crate) enum Packing {
    /// Packed by Zstandard.
    Searched(Packer),
    /// Packed by the repetitions in messages of the same channel.
    Repeated(Repetitions),
}

impl Packing {
    /// Packing by Zstandard, or by repetitions.
    pub(crate) fn new(searched: bool) -> io::Result<Self> {
        Ok(if searched { Packing::Searched(Packer::new()?) } else { Packing::Repeated(Repetitions::default()) })
    }

    /// The name of the compression and the packed records of a batch; `None` if it is better left as it is.
    pub(crate) fn pack(&mut self, batch: &Batch) -> io::Result<Option<(&'static str, &[u8])>> {
        Ok(match self {
            Packing::Searched(packer) => Some((NAME, packer.pack(batch.from(0).1)?)),
            Packing::Repeated(repetitions) => repetitions.pack(batch).map(|packed| (repetition::NAME, packed)),
        })
    }
}

/// Packs the records of chunks by Zstandard.
pub(crate) struct Packer {
    compressor: Compressor<'static>,
    packed: Vec<u8>,
}

impl Packer {
    /// A packer for chunks of any size.
    fn new() -> io::Result<Self> {
        Ok(Packer { compressor: Compressor::new(LEVEL)?, packed: Vec::new() })
    }

    /// The records, packed.
    fn pack(&mut self, records: &[u8]) -> io::Result<&[u8]> {
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
