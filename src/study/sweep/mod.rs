//! Sweeps: many runs of one scene with varied numbers; one table row per run.
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
//! A row depends only on the sweep and its index: not on threads, the order of work, shards, or interruptions. The same holds for the files, byte
//! for byte.
//!
//! A folder of a sweep holds
//!
//! | file | what it is |
//! |---|---|
//! | `sweep.json` | the definition of the sweep, written first |
//! | `sweep.lock` | locked by the process that writes |
//! | `rows-FIRST-LAST.csv` or `.parquet` | rows of a range of indices, complete; never changed again |
//! | `rows-FIRST-LAST.journal` | rows of an unfinished range, in order of completion |

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
