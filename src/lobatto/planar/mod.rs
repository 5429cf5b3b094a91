//! The equations of a mechanism that moves in a plane: three coordinates a body instead of six.
//!
//! ```text
//!     φ: turn since the start (rad),   κ = cos φ − 1,   σ = sin φ,   J (x, y) = (−y, x)
//! ```
//!
//! What space mixes for every body, the plane adds up along the path from the root ([`sweeps`], which has the equations): another algorithm, and the
//! reason why these sweeps are not those of space over another type. Their headers have the figures.

pub mod algebra;
pub mod articulated;
pub mod body;
pub mod force_plan;
pub mod forces;
pub mod geometry;
pub mod kept_factors;
pub mod loops;
pub mod start;
pub mod sweeps;
pub mod workspace;
