//! The common origin of the bodies that closures join.
//!
//! ```text
//!     a body of mass m and radius of gyration ρ at the distance d from the origin:     [ m    −m x̂        ]      known to 1e-16 (d/ρ)²
//!                                                                                    [ m x̂  m ρ² − m x̂² ]
//! ```
//!
//! Twists and wrenches of two bodies meet only in the equations of a closure between them, in the lines of their springs and in their joints. So each
//! part of the bodies that these tie ([`catena_mechanism::structure::islands::first_of_tied`]) has an origin of its own, at the anchor of its first body. Far from a common one a small body would lose the
//! digits of its inertia: of 1 cm at 60 m, seven of them.

/// The common origin of the bodies at the ends of a closure, which are of one part, from the origins of all bodies (m). `None` is the world.
pub(crate) fn common_origin<const N: usize>(
    bodies: impl IntoIterator<Item = Option<usize>>,
    origins: &[[f64; N]],
) -> [f64; N] {
    bodies.into_iter().flatten().next().map_or([0.0; N], |body| origins[body])
}
