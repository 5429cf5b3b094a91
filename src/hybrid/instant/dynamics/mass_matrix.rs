//! The mass matrix of the tree in joint coordinates.
//!
//! ```text
//!     H_ij = v_i · p_j + ω_i · L_j        p_j = Σ m v_j,   L_j = Σ (R J Rᵀ ω_j + m r × v_j)       [kg, kg m, kg m²]
//! ```
//!
//! with the velocities `(v_i, ω_i)` that freedom i alone gives to the body of freedom j, and the momenta that freedom j alone gives to
//! that body and all beyond it, about its centre of mass: they move with it as one rigid body. Entries of freedoms that are on different
//! branches are zero.

use crate::mechanism::description::body_state::{BodyState, WORLD};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::kinematics::forward_kinematics;
use crate::mechanism::motion::state::State;
use nalgebra::{DMatrix, Vector3};

/// The mass matrix at a state (degrees of freedom × degrees of freedom), symmetric.
pub fn mass_matrix(mechanism: &Mechanism, state: &State) -> DMatrix<f64> {
    let count = mechanism.velocity_count;
    let mut bodies = vec![WORLD; mechanism.bodies.len()];
    let mut unit = vec![0.0; count];
    let mut move_alone = |freedom: usize, bodies: &mut [BodyState]| {
        unit[freedom] = 1.0;
        forward_kinematics(mechanism, &state.position, &unit, bodies);
        unit[freedom] = 0.0;
    };
    let mut momenta: Vec<(usize, Vector3<f64>, Vector3<f64>)> = Vec::with_capacity(count);
    for (owner, body) in mechanism.bodies.iter().enumerate() {
        for freedom in body.joint.velocity_range() {
            move_alone(freedom, &mut bodies);
            let (mut linear, mut angular) = (Vector3::zeros(), Vector3::zeros());
            let moving = |body: usize| {
                bodies[body].velocity != Vector3::zeros() || bodies[body].angular_velocity != Vector3::zeros()
            };
            for (number, body) in mechanism.bodies.iter().enumerate().skip(owner).filter(|(number, _)| moving(*number))
            {
                let at = &bodies[number];
                let momentum = body.mass * at.velocity;
                let spin = at.rotation * body.inertia.component_mul(&(at.rotation.transpose() * at.angular_velocity));
                linear += momentum;
                angular += spin + (at.position - bodies[owner].position).cross(&momentum);
            }
            momenta.push((owner, linear, angular));
        }
    }
    let mut matrix = DMatrix::zeros(count, count);
    mechanism.rotors().for_each(|(freedom, armature)| matrix[(freedom, freedom)] = armature);
    for first in 0..count {
        move_alone(first, &mut bodies);
        for second in first..count {
            let (owner, linear, angular) = &momenta[second];
            let at = &bodies[*owner];
            let entry = at.velocity.dot(linear) + at.angular_velocity.dot(angular);
            // On the diagonal is the rotor of the joint.
            let entry = matrix[(first, second)] + entry;
            (matrix[(first, second)], matrix[(second, first)]) = (entry, entry);
        }
    }
    matrix
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::mechanism::description::joint::{Joint, JointKind, Pose};
    use crate::mechanism::description::mechanism::Body;
    use crate::mechanism::motion::energy::energy;
    use crate::mechanism::motion::kinematics::body_states;
    use nalgebra::{Rotation3, Translation3};

    /// A tree of bodies, each by its parent, its joint and a size (m, kg) that makes all of its numbers differ from the numbers of others.
    pub(crate) fn tree(bodies: &[(Option<usize>, JointKind, f64)]) -> Mechanism {
        let pose = |x: f64, turn: f64| {
            Pose::from_parts(Translation3::new(x, 0.2, -x), Rotation3::from_euler_angles(turn, 0.4, -turn))
        };
        let body = |&(parent, kind, x): &(Option<usize>, JointKind, f64)| Body {
            name: String::new(),
            parent,
            mass: 1.0 + x,
            inertia: Vector3::new(0.1, 0.2 + x, 0.25 + x),
            joint: Joint::new("", kind, pose(x, 0.3), pose(0.5 * x, -0.7)),
        };
        Mechanism::new("tree", Vector3::zeros(), bodies.iter().map(body).collect()).expect("a tree")
    }

    #[test]
    fn its_quadratic_form_is_twice_the_kinetic_energy() {
        let mechanism = tree(&[
            (None, JointKind::Floating, 0.3),
            (Some(0), JointKind::Revolute, 0.5),
            (Some(1), JointKind::Prismatic, 0.1),
            (Some(0), JointKind::Spherical, 0.7),
            (None, JointKind::Planar, 0.9),
        ]);
        let mut state = State::zero(&mechanism);
        let increment: Vec<f64> = (0..mechanism.velocity_count).map(|index| (index as f64).sin()).collect();
        state.displace(&mechanism, &increment);
        for (index, rate) in state.velocity.iter_mut().enumerate() {
            *rate = (2.0 * index as f64).cos();
        }
        let rates = nalgebra::DVector::from_vec(state.velocity.clone());
        let twice = (rates.transpose() * mass_matrix(&mechanism, &state) * &rates)[0];
        let energy = energy(&mechanism, &body_states(&mechanism, &state)).kinetic;
        assert!((twice - 2.0 * energy).abs() < 1e-13 * energy, "{twice} and {energy}");
    }
}
