//! How far the bodies of a mechanism move for a small displacement of each degree of freedom: one for a slide [m/m], and for a rotation a distance
//! from the origin of its joint (m).
//!
//! ```text
//!     own(b)   = max( |c_b| + ρ_b,  max_children |a_child − a_b| )                         ρ² = tr(J) / (2 m)
//!     reach(b) = max( |c_b| + ρ_b,  max_children |a_child − a_b| + reach(child) )
//!     lever(b) = max( own(b), min(reach(b), 1) )
//! ```
//!
//! with the anchors `a` and the arm `c` from the anchor to the centre of mass, as [`catena_mechanism::motion::distance`] probes bodies. The reach is
//! the reach of a stretched chain, and counts up to a metre: a ring of a hundred links is seldom as wide as its links are long together. Slides may
//! carry bodies further away by an unknown distance; the reach is then a metre at least.

use catena_mechanism::description::mechanism::{Body, Mechanism};

/// One entry a degree of freedom.
pub(crate) fn levers(mechanism: &Mechanism) -> Vec<f64> {
    let mut levers = vec![1.0; mechanism.velocity_count];
    // For each body the distance to the joints of its children, and to the furthest body they carry.
    let mut arms = vec![[0.0_f64; 2]; mechanism.bodies.len()];
    for (index, body) in mechanism.bodies.iter().enumerate().rev() {
        let (joint, anchor) = (&body.joint, body.joint.on_child.translation.vector);
        let [own, reach] = arms[index].map(|arm| arm.max(anchor.norm() + radius(body)));
        let slides = joint.kind.translation_axes().len();
        levers[joint.velocity_range()][slides..].fill(own.max(reach.min(1.0)));
        if let Some(parent) = body.parent {
            let from = mechanism.bodies[parent].joint.on_child.translation.vector;
            let arm = (joint.on_parent.translation.vector - from).norm();
            let beyond = if slides > 0 { (arm + reach).max(1.0) } else { arm + reach };
            let [own, reach] = arms[parent];
            arms[parent] = [own.max(arm), reach.max(beyond)];
        }
    }
    levers
}

/// The distance at which the mass of a body sits on average (m); zero without mass.
fn radius(body: &Body) -> f64 {
    if body.mass > 0.0 { (0.5 * body.inertia.sum() / body.mass).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use catena_mechanism::description::joint::{Joint, JointKind, Pose};
    use nalgebra::{Translation3, Vector3};

    /// Rods of 0.2 m on joints at their ends, whose mass sits at 0.01 m from their middles on average.
    fn rods(kinds: &[JointKind]) -> Mechanism {
        let along = |at: f64| Pose::from(Translation3::new(at, 0.0, 0.0));
        let bodies = kinds.iter().enumerate().map(|(index, &kind)| {
            let joint = Joint::new("joint", kind, along(if index == 0 { 0.0 } else { 0.1 }), along(-0.1));
            let parent = index.checked_sub(1);
            Body { name: "rod".into(), parent, mass: 2.0, inertia: Vector3::new(1e-4, 1e-4, 2e-4), joint }
        });
        Mechanism::new("rods", Vector3::zeros(), bodies.collect()).expect("a mechanism")
    }

    #[test]
    fn a_rotation_moves_what_hangs_on_it_by_its_distance_and_a_slide_by_itself() {
        use JointKind::{Planar, Prismatic, Revolute};
        let of = |kinds: &[JointKind]| levers(&rods(kinds));
        let close = |found: Vec<f64>, expected: &[f64]| {
            assert_eq!(found.len(), expected.len());
            // Some roundings of sums of three numbers.
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14), "{found:?}, not {expected:?}");
        };
        close(of(&[Revolute, Revolute]), &[0.31, 0.11]);
        close(of(&[Planar, Revolute]), &[1.0, 1.0, 0.31, 0.11]);
        // Twenty rods are 4 m long, of which one counts.
        close(of(&[Revolute; 20])[..1].to_vec(), &[1.0]);
        // The distance of bodies behind a slide is unknown.
        close(of(&[Revolute, Prismatic, Revolute]), &[1.0, 1.0, 0.11]);
    }
}
