//! Figures: data on axes, drawn as SVG and PNG, and tables of comma-separated values.
//!
//! ```text
//!     Figure → axis, legend → render → canvas (SVG, PNG)
//! ```

#![deny(unsafe_code)]

#[cfg(feature = "plot")]
pub mod axis;
#[cfg(feature = "plot")]
pub mod canvas;
pub mod comma_separated;
pub mod error;
pub mod files;
#[cfg(feature = "plot")]
pub mod legend;
pub mod picture;
#[cfg(feature = "plot")]
pub mod render;
#[cfg(feature = "plot")]
pub mod strokes;
pub mod style;
