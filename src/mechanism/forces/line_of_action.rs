//! The points on its line of action at which a spring's two forces act.
//!
//! Equal and opposite forces F along the line through their points a and b have the same moments wherever on the line they act:
//!
//! ```text
//!     r_a × F = (P_b − O_a) × F      for F ∥ P_b − P_a        r_a = P_a − O_a (m), O_a: about which the torque on the body of a is taken
//! ```
//!
//! Both act at one end where the arm of the other is far longer. This avoids the rounding of a product that is far larger than the resulting torque:
//! for an end 1e10 m outside its body, with a tension of 1e15 N, torques would be rounded by 1e9 N m.

use nalgebra::SVector;

/// An arm is long if it is by this factor longer than its replacement.
const LONG: f64 = 1e3;

/// The end at which both forces act and the arm of the other body from there (m); `None` if each acts at its own end. `places` are the ends and
/// `origins` the points of reference of torques (m), `None` on the world.
pub fn common_end<const D: usize>(
    places: [SVector<f64, D>; 2],
    origins: [Option<SVector<f64, D>>; 2],
) -> Option<(usize, SVector<f64, D>)> {
    let square = |end: usize, side: usize| origins[side].map_or(0.0, |origin| (places[end] - origin).norm_squared());
    (0..2).find_map(|side| {
        let (origin, common) = (origins[side]?, 1 - side);
        let is_long = square(side, side) > LONG * LONG * (square(common, side) + square(common, common));
        is_long.then(|| (common, places[common] - origin))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn forces_act_at_the_end_that_is_near_both_bodies_where_the_other_is_far() {
        let (near, far) = (Vector3::new(0.0, 0.0, 0.5), Vector3::new(0.0, 1e4, 0.0));
        let origins = [Some(Vector3::zeros()), Some(Vector3::new(0.0, 0.0, 1.0))];
        assert_eq!(common_end([near, far], origins), Some((0, near - Vector3::z())));
        assert_eq!(common_end([far, near], origins), Some((1, near)));
        assert_eq!(common_end([near, Vector3::new(0.0, 10.0, 0.0)], origins), None);
        // In the world no arm is long.
        assert_eq!(common_end([near, far], [origins[0], None]), None);
        assert_eq!(common_end([near, far], [None, origins[1]]), Some((0, near - Vector3::z())));
    }

    #[test]
    fn moments_are_those_of_each_force_at_its_own_end() {
        let (near, far) = (Vector3::new(0.3, -0.1, 0.5), Vector3::new(0.2, 1e4, 0.4));
        let origin = Vector3::new(-0.2, 0.1, 0.1);
        let force = (far - near) * 3.0;
        let (end, arm) = common_end([near, far], [None, Some(origin)]).expect("a long arm");
        assert_eq!(end, 0);
        // Products of 3e8 N m, each rounded.
        assert!(((far - origin).cross(&force) - arm.cross(&force)).amax() < 1e-6);
    }
}
