//! What can be known of a mechanism before it moves: its plane, its islands, bodies with vanishing terms, massless motions.

pub mod definiteness;
pub mod islands;
pub mod planar_loops;
pub mod plane;
pub mod special_bodies;
