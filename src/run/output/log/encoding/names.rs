//! The names in the header of a log and of its metadata records.

use mcap::records::Metadata;

/// The beginning of the library entry of our logs, before the version of the program.
pub(crate) const LIBRARY: &str = "catena ";

/// The whole entry.
pub(crate) const LIBRARY_VERSION: &str = concat!("catena ", env!("CARGO_PKG_VERSION"));

/// The name of the metadata record that says how a run was made.
pub(crate) const SIMULATION: &str = "simulation";

/// The entry of [`SIMULATION`] with the time of the log at the start of the run, in nanoseconds; zero in logs that do not have it.
pub const START: &str = "start";

/// The name of the metadata record that says how a run ended.
pub(crate) const END: &str = "end";

/// The entry of [`END`] that says it in a word.
pub(crate) const OUTCOME: &str = "outcome";

/// The time of the log at the start of the run (ns), if this is the record that says it.
pub(crate) fn start_of(metadata: &Metadata) -> Option<u64> {
    let said = (metadata.name == SIMULATION).then(|| metadata.metadata.get(START))?;
    said.and_then(|start| start.parse().ok())
}
