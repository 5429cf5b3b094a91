//! Joints of a tree at rest that gravity alone moves for certain: a sum over the bodies, where the accelerations of
//! [`crate::instant::exerting::rest`] take the elimination of all joints.
//!
//! Gravity does this along the axis `s` of a hinge at `p`, or of a slide, for the bodies `b` beyond the joint,
//!
//! ```text
//!     τ = s · Σ (x_b − p) × m_b ĝ,     f = s · Σ m_b ĝ                                       [kg m, kg]      ĝ = g/|g|
//! ```
//!
//! and with accelerations `a_b` and `α_b` it equals the inertial resistance of these bodies. If all of them are roundings, `|a_b|, k_b |α_b| ≤ ε
//! |g|`, then
//!
//! ```text
//!     |τ| ≤ ε Σ m_b (|x_b| + |p| + 2 k_b),     |f| ≤ ε Σ m_b                                 k = (½ tr J / m)^½
//! ```
//!
//! because the largest moment of inertia is at most `tr J = 2 m k²`. A joint that exceeds this bound a million times moves for certain.

use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::joint::JointKind;
use crate::mechanism::description::mechanism::Mechanism;
use nalgebra::Vector3;

/// ε: a million times what counts as rest in a tree of a thousand bodies.
const BEYOND_ROUNDING: f64 = 1e-6;

/// The bodies beyond a joint.
#[derive(Clone, Copy, Default)]
struct Beyond {
    mass: f64,
    /// `Σ m x` [kg m].
    moment: Vector3<f64>,
    /// `Σ m (|x| + 2 k)` [kg m].
    reach: f64,
}

/// Whether a joint of a tree under gravity alone that is at rest, with its bodies in these places, moves for certain. If this is false it may still
/// move.
pub(crate) fn moves_for_certain(mechanism: &Mechanism, bodies: &[BodyState]) -> bool {
    let strength = mechanism.gravity.amax();
    if !mechanism.is_plain_tree() || strength == 0.0 {
        return false;
    }
    let pull = mechanism.gravity / strength;
    let mut beyond = vec![Beyond::default(); bodies.len()];
    for (index, (body, state)) in mechanism.bodies.iter().zip(bodies).enumerate().rev() {
        let joint = &body.joint;
        let own = &mut beyond[index];
        own.mass += body.mass;
        own.moment += body.mass * state.position;
        own.reach += body.mass * state.position.norm() + (2.0 * body.mass * body.inertia.sum()).sqrt();
        let Beyond { mass, moment, reach } = *own;
        let axis = || state.rotation * joint.on_child.rotation.matrix().column(2);
        let moves = match joint.kind {
            JointKind::Revolute => {
                let place = state.position + state.rotation * joint.on_child.translation.vector;
                let torque = axis().dot(&(moment - mass * place).cross(&pull));
                torque.abs() > BEYOND_ROUNDING * (reach + mass * place.norm())
            }
            JointKind::Prismatic => axis().dot(&pull).abs() > BEYOND_ROUNDING && mass > 0.0,
            JointKind::Floating => mass > 0.0,
            JointKind::Planar | JointKind::Spherical => false,
        };
        if moves {
            return true;
        }
        if let Some(parent) = body.parent {
            let Beyond { mass: parent_mass, moment: parent_moment, reach: parent_reach } = &mut beyond[parent];
            *parent_mass += mass;
            *parent_moment += moment;
            *parent_reach += reach;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instant::exerting::rest::nothing_accelerates;
    use crate::mechanism::description::joint::{Joint, Pose};
    use crate::mechanism::description::mechanism::Body;
    use crate::mechanism::motion::kinematics::body_states;
    use crate::mechanism::motion::state::State;
    use nalgebra::{Rotation3, Translation3};

    /// Three bodies, one below the other, which lean by `askew` or more (rad), and hang straight down without that.
    fn chain(kinds: [JointKind; 3], askew: f64) -> Mechanism {
        let bodies = kinds.iter().enumerate().map(|(index, &kind)| {
            // The axis, z of the frame, is −y of the world, about which it leans.
            let turn = Rotation3::from_euler_angles(std::f64::consts::FRAC_PI_2, askew * (1.0 + index as f64), 0.0);
            let place = if index == 0 { Translation3::new(0.3, 0.2, 0.0) } else { Translation3::new(0.0, 0.0, -0.5) };
            let on_parent = Pose::from_parts(place, turn);
            let turn = Rotation3::from_euler_angles(std::f64::consts::FRAC_PI_2, 0.0, 0.0);
            let on_child = Pose::from_parts(Translation3::new(0.0, 0.0, 0.5), turn);
            let joint = Joint::new(&format!("joint {index}"), kind, on_parent, on_child);
            let (parent, inertia) = (index.checked_sub(1), Vector3::new(0.05, 0.06, 0.02));
            Body { name: format!("body {index}"), parent, mass: 1.0 + index as f64, inertia, joint }
        });
        Mechanism::new("chain", Vector3::new(0.0, 0.0, -9.81), bodies.collect()).expect("a mechanism")
    }

    #[test]
    fn what_moves_for_certain_accelerates_and_what_hangs_straight_down_is_left_to_accelerations() {
        use JointKind::{Floating, Planar, Prismatic, Revolute, Spherical};
        let chains = [
            [Revolute; 3],
            [Prismatic, Revolute, Revolute],
            [Revolute, Revolute, Prismatic],
            [Spherical, Revolute, Planar],
            [Planar, Revolute, Spherical],
        ];
        for kinds in chains {
            let mut certain = 0;
            for askew in [0.0, 1e-9, 1e-3, 0.4, -2.0, std::f64::consts::PI] {
                let mechanism = chain(kinds, askew);
                let state = State::zero(&mechanism);
                let bodies = body_states(&mechanism, &state);
                let moves = moves_for_certain(&mechanism, &bodies);
                let accelerates = !nothing_accelerates(&mechanism, &state, &bodies, None);
                assert!(accelerates || !moves, "{kinds:?}, {askew} rad");
                certain += usize::from(moves);
                if askew == 0.0 {
                    assert!(!moves, "{kinds:?} hangs straight down");
                }
            }
            assert!(certain >= 3, "{kinds:?}: {certain} of the leaning ones");
        }
        let thrown = chain([Floating, Revolute, Revolute], 0.0);
        assert!(moves_for_certain(&thrown, &body_states(&thrown, &State::zero(&thrown))), "it falls");
    }

    #[test]
    fn without_gravity_and_under_other_forces_nothing_is_certain() {
        let mut mechanism = chain([JointKind::Revolute; 3], 0.4);
        let bodies = body_states(&mechanism, &State::zero(&mechanism));
        assert!(moves_for_certain(&mechanism, &bodies));
        mechanism.forces.driven = true;
        assert!(!moves_for_certain(&mechanism, &bodies), "driven");
        mechanism.forces.driven = false;
        mechanism.gravity = Vector3::zeros();
        assert!(!moves_for_certain(&mechanism, &bodies), "nothing pulls");
    }
}
