//! The common origin of the bodies that closures join.
//!
//! ```text
//!     a body of mass m and radius of gyration ρ at the distance d from the origin:     [ m    −m x̂        ]      known to 1e-16 (d/ρ)²
//!                                                                                    [ m x̂  m ρ² − m x̂² ]
//! ```
//!
//! Twists and wrenches of two bodies meet only in the equations of a closure between them, in the lines of their springs and in their joints. So each
//! part of the bodies that these join has an origin of its own, at the anchor of its first body. Far from a common one a small body would lose the
//! digits of its inertia: of 1 cm at 60 m, seven of them.

use catena_mechanism::description::mechanism::Mechanism;

/// The first body of the part of every body.
pub(crate) fn first_of_parts(mechanism: &Mechanism) -> Vec<usize> {
    let mut first: Vec<usize> = (0..mechanism.bodies.len()).collect();
    let mut join = |bodies: &[usize]| {
        if let Some(least) = bodies.iter().map(|&body| first[body]).min() {
            for &body in bodies {
                let before = first[body];
                first.iter_mut().filter(|of| **of == before).for_each(|of| *of = least);
            }
        }
    };
    for (index, body) in mechanism.bodies.iter().enumerate() {
        body.parent.iter().for_each(|&parent| join(&[parent, index]));
    }
    let springs = mechanism.forces.point_springs.iter().map(|spring| [&spring.a, &spring.b]);
    for ends in mechanism.closing_ends().chain(springs) {
        join(&ends.iter().filter_map(|end| end.body).collect::<Vec<_>>());
    }
    mechanism.touches.iter().for_each(|touch| join(&touch.reeved_bodies()));
    first
}

/// The common origin of the bodies at the ends of a closure, which are of one part, from those of all bodies (m). `None` is the world.
pub(crate) fn common_origin<const N: usize>(
    bodies: impl IntoIterator<Item = Option<usize>>,
    origins: &[[f64; N]],
) -> [f64; N] {
    bodies.into_iter().flatten().next().map_or([0.0; N], |body| origins[body])
}
