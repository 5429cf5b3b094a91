//! Stability maps: for which steps and difficulties each method finishes, and whether its result is right.
//!
//! A [`Problem`] is a family of mechanisms of increasing difficulty ([`problems`]). Every [`Method`] runs it over a range of steps or tolerances
//! ([`runner`]; [`baumgarte`] is the integrator of the textbooks, `regularised` the comparators on limits, friction and motors). Each run is a
//! [`Cell`] with a [`Verdict`] by comparison with a correct result ([`truth`]). The work of a cell is bounded, so that one cell cannot delay the
//! others. A failure is a result like any other.
//!
//! ```text
//!     Problem → Case ┬→ Answer ──────────┐
//!                    └→ Runner (method) ─┴→ Cell → Map → picture (SVG, PNG), table (CSV), page (HTML)
//! ```

pub mod baumgarte;
pub mod cell;
pub mod map;
pub mod method;
mod page;
mod picture;
pub mod problem;
pub mod problems;
pub mod report;
pub mod runner;
pub mod table;
pub mod truth;

pub use cell::{Cell, Ended, Verdict};
pub use map::{Map, StressError};
pub use method::Method;
pub use problem::{Case, Problem, ThinnedProblem};
pub use truth::Answer;
