//! What the header of a log and its last metadata record are called.

/// With this begins what a log of ours says of the program that wrote it.
pub(crate) const LIBRARY: &str = "catena ";

/// What it says.
pub(crate) const LIBRARY_VERSION: &str = concat!("catena ", env!("CARGO_PKG_VERSION"));

/// The name of the metadata record that says how a run ended.
pub(crate) const END: &str = "end";

/// The entry of [`END`] that says it in a word.
pub(crate) const OUTCOME: &str = "outcome";

/// The word for a run that reached its end.
pub(crate) const FINISHED: &str = "finished";
