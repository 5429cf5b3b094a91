//! Looking at logs: their content as words, as a table, as curves, or the difference of two.
//!
//! ```text
//!     log → frames → summary | table (CSV) | events | curves → figure (SVG, PNG) | comparison of two
//! ```

pub mod compare;
pub mod curves;
pub mod events;
pub mod joint_values;
pub mod summary;
mod summary_text;
pub mod table;
