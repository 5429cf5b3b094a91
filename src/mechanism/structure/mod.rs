//! What can be known of a mechanism before it moves: its plane, its islands, bodies with vanishing terms, massless motions,
//! independent closures.

#[doc(hidden)]
pub mod definiteness;
pub mod islands;
#[doc(hidden)]
pub mod planar_loops;
pub mod plane;
#[doc(hidden)]
pub mod ranks;
#[doc(hidden)]
pub mod special_bodies;
