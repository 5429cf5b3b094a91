//! Properties of a mechanism that do not depend on its motion: its plane, its islands, bodies with vanishing terms, massless motions,
//! independent closures.

#[doc(hidden)]
pub mod definiteness;
pub mod islands;
pub mod other_efforts;
pub mod other_tree;
#[doc(hidden)]
pub mod planar_loops;
pub mod plane;
#[doc(hidden)]
pub mod ranks;
#[doc(hidden)]
pub mod renumbering;
pub mod spanning_tree;
#[doc(hidden)]
pub mod special_bodies;
