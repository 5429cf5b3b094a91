//! A log read back: records, channels and messages, frames, meshes; and one that was cut, completed.

pub mod decode;
pub mod frame_stream;
pub mod frames;
pub mod meshes;
pub mod reader;
pub mod records;
pub mod recovery;
