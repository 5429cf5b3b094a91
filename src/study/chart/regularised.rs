//! The comparators on mechanisms with limits, friction and motors: in joint coordinates with the usual regularisations
//! ([`crate::reduced::regularised`]), as stiff as the setting allows.
//!
//! ```text
//!     step h          k = J (π / 4 h)²         an impact takes four steps
//!                     v₀ = τ_f h / J           the friction's rate τ_f / J v₀ is 1/h, within every explicit method's stability
//!     tolerance ε     k = J (v / ε)²           an impact at the speed v goes ε deep, v = 1 rad/s or m/s
//!                     v₀ = ε                   a stuck joint creeps by ε a second
//!     d = 2 ζ (J k)^½,   ζ = −ln e / (π² + ln² e)^½                  for the restitution e, 1 for e = 0
//! ```
//!
//! with the inertia `J = 1 / Y_ii` at the start that an effort along the coordinate alone meets. Motors are evaluated at every stage.
//!
//! Source of d: the ratio of two maxima of a damped oscillation half a period apart, exp(−π ζ / (1 − ζ²)^½) = e.

use crate::instant::dynamics::response::Response;
use crate::instant::holding::elements::Elements;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;
use crate::reduced::{ReducedOde, Regularised, SoftFriction, SoftLimit};
use std::f64::consts::PI;

/// Steps that an impact takes.
const STEPS: f64 = 4.0;
/// The speed at which an impact goes as deep as the tolerance [rad/s or m/s].
const SPEED: f64 = 1.0;

/// The quantity that determines the stiffness of a regularisation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Softness {
    /// Fixed steps (s).
    Step(f64),
    /// A tolerance [m, rad].
    Tolerance(f64),
}

/// The reduced system of a mechanism with limits, friction or motors, for a run from `start`; `None` for motors that are sampled, which it does not
/// know.
pub(crate) fn regularised_system(mechanism: &Mechanism, start: &State, softness: Softness) -> Option<ReducedOde> {
    (!mechanism.nonsmooth.samples())
        .then(|| ReducedOde::with_regularised(mechanism, regularised(mechanism, start, softness)))
}

/// The elements of a mechanism, as stiff as the setting allows.
fn regularised(mechanism: &Mechanism, start: &State, softness: Softness) -> Regularised {
    let elements = Elements::new(mechanism);
    let freedoms = elements.joints.iter().map(|joint| joint.coordinate.freedom);
    let mobilities = Response::new(mechanism).diagonal(start, freedoms);
    let mut soft = Regularised { motors: elements.motors, ..Regularised::default() };
    for (joint, mobility) in elements.joints.iter().zip(mobilities) {
        let freedom = joint.coordinate.freedom;
        let inertia = 1.0 / mobility;
        let (rate, speed) = match softness {
            Softness::Step(step) => (PI / (STEPS * step), joint.friction * step / inertia),
            Softness::Tolerance(tolerance) => (SPEED / tolerance, tolerance),
        };
        if joint.friction > 0.0 {
            soft.friction.push(SoftFriction { freedom, effort: joint.friction, speed });
        }
        if joint.lower.is_finite() || joint.upper.is_finite() {
            let lost = joint.restitution.ln();
            let damping = if joint.restitution > 0.0 { -lost / PI.hypot(lost) } else { 1.0 };
            soft.limits.push(SoftLimit {
                coordinate: joint.coordinate,
                range: (joint.lower, joint.upper),
                stiffness: inertia * rate * rate,
                damping: 2.0 * damping * inertia * rate,
            });
        }
    }
    soft
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanism::description::closure::{Coordinate, JointLimit};
    use crate::mechanism::description::joint::{Joint, JointKind, Pose};
    use crate::mechanism::description::mechanism::Body;
    use crate::mechanism::motion::integrator::Integrator;
    use crate::reduced::Rk4;
    use nalgebra::Vector3;

    #[test]
    fn a_soft_limit_gives_back_the_restitution() {
        let joint = Joint::new("slide", JointKind::Prismatic, Pose::identity(), Pose::identity());
        let body = Body { name: "block".into(), parent: None, mass: 3.0, inertia: Vector3::repeat(1.0), joint };
        let mut mechanism = Mechanism::new("slide", Vector3::zeros(), vec![body]).expect("a tree");
        let coordinate = Coordinate { body: 0, position: 0, freedom: 0 };
        mechanism.nonsmooth.limits =
            vec![JointLimit { coordinate, lower: -1.0, upper: f64::INFINITY, restitution: 0.8 }];
        let mut state = State::zero(&mechanism);
        state.velocity[0] = -2.0;
        let system = regularised_system(&mechanism, &state, Softness::Step(1e-4)).expect("no motor is sampled");
        let mut rk4 = Rk4::of_system(system, 1e-4);
        while state.time < 0.6 {
            rk4.advance(&mechanism, &mut state, 0.6).expect("a step");
        }
        // The limit lets go a little early, where it would begin to pull.
        assert!((state.velocity[0] - 1.6).abs() < 0.05, "{}", state.velocity[0]);
    }
}
