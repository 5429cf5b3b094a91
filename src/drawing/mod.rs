//! Figures: data on axes, drawn as SVG and PNG, and tables of comma-separated values.
//!
//! ```text
//!     Figure → axis, legend → render → canvas (SVG, PNG)
//! ```

pub mod axis;
pub mod canvas;
pub mod comma_separated;
pub mod error;
pub mod files;
pub mod legend;
pub mod picture;
pub mod render;
pub mod strokes;
pub mod style;
