//! Sweeps: many runs of one scene, in which numbers vary; a row of a table for each.
//!
//! ```text
//!     sweep.toml ─ definition ─▶ Sweep: scene, variation (index → numbers), kept quantities
//!              ─ variation, random ─▶ the numbers of the run of an index, from the index alone
//!              ─ one_run ─▶ Row         scene with these numbers → model → simulation → what is kept (quantities, watch)
//!              ─ work ─▶ rows of all threads, to one writer
//!              ─ folder, journal ─▶ on the disk, and only then counted as done
//!              ─ rows_csv, rows_parquet ─▶ a file of rows in the order of their index, once all of them are there
//!              ─ merge ─▶ the folders of all shards as one
//! ```
//!
//! What a row says depends on the sweep and its index alone: not on threads, on the order of work, on shards, or on how often it was stopped. So do
//! the files, byte for byte.
//!
//! A folder of a sweep holds
//!
//! | file | what it is |
//! |---|---|
//! | `sweep.json` | which sweep it is, written first |
//! | `sweep.lock` | held by the process that writes |
//! | `rows-FIRST-LAST.csv` or `.parquet` | rows of a range of indices, complete; never changed again |
//! | `rows-FIRST-LAST.journal` | rows of a range that is being worked on, in the order in which they came |

pub mod definition;
pub mod error;
pub mod folder;
pub mod index_ranges;
mod journal;
mod lists;
pub mod manifest;
pub mod merge;
mod one_run;
mod quantities;
mod random;
pub mod rows;
mod rows_csv;
#[cfg(feature = "parquet")]
mod rows_parquet;
mod schema;
pub mod trial;
mod variation;
mod vary;
mod watch;
mod whole_file;
pub mod work;

pub use definition::{Sweep, read_sweep};
pub use error::SweepError;
pub use folder::Folder;
pub use index_ranges::Shard;
pub use manifest::Format;
pub use merge::merge;
pub use work::{Done, Work};
