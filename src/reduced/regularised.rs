//! Limits, dry friction and motors as ordinary forces in joint coordinates: the usual regularisations, for comparison.
//!
//! ```text
//!     limit       τ = max(0, k δ + d δ̇) into the allowed range        δ > 0: depth beyond the limit (rad or m)
//!     friction    τ = −τ_f tanh(q̇ / v₀)
//!     motor       τ = its law, within its bound
//! ```
//!
//! [N m or N]. A stuck joint creeps at up to v₀, and an impact takes about `π (J/k)^½` for the inertia J that the limit stops.

use catena_mechanism::description::closure::Coordinate;
use catena_mechanism::description::nonsmooth::Motor;

/// A limit as a spring and damper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftLimit {
    /// The coordinate.
    pub coordinate: Coordinate,
    /// Smallest and largest position (rad or m).
    pub range: (f64, f64),
    /// k [N m/rad or N/m].
    pub stiffness: f64,
    /// d [N m s/rad or N s/m].
    pub damping: f64,
}

/// Dry friction without a jump.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftFriction {
    /// The degree of freedom.
    pub freedom: usize,
    /// τ_f [N m or N].
    pub effort: f64,
    /// v₀ [rad/s or m/s].
    pub speed: f64,
}

/// All regularised elements of a mechanism.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Regularised {
    /// Limits.
    pub limits: Vec<SoftLimit>,
    /// Dry friction.
    pub friction: Vec<SoftFriction>,
    /// Motors.
    pub motors: Vec<Motor>,
}

impl Regularised {
    /// Whether a motor has a target that changes.
    pub fn depends_on_time(&self) -> bool {
        self.motors.iter().any(|motor| !motor.target.is_constant())
    }

    /// Adds the efforts in a state at a time (s).
    pub fn add_efforts(&self, time: f64, position: &[f64], velocity: &[f64], efforts: &mut [f64]) {
        for limit in &self.limits {
            let (place, rate) = (position[limit.coordinate.position], velocity[limit.coordinate.freedom]);
            let (lower, upper) = limit.range;
            for (depth, inward) in [(lower - place, 1.0), (place - upper, -1.0)] {
                if depth > 0.0 {
                    let push = limit.stiffness * depth - limit.damping * inward * rate;
                    efforts[limit.coordinate.freedom] += inward * push.max(0.0);
                }
            }
        }
        for friction in &self.friction {
            efforts[friction.freedom] -= friction.effort * (velocity[friction.freedom] / friction.speed).tanh();
        }
        for motor in &self.motors {
            let at = motor.coordinate;
            efforts[at.freedom] += motor.effort(time, position[at.position], velocity[at.freedom]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_soft_limit_pushes_inwards_and_never_pulls() {
        let coordinate = Coordinate { body: 0, position: 0, freedom: 0 };
        let limit = SoftLimit { coordinate, range: (-1.0, 2.0), stiffness: 100.0, damping: 3.0 };
        let all = Regularised { limits: vec![limit], ..Regularised::default() };
        let effort = |position: f64, rate: f64| {
            let mut efforts = [0.0];
            all.add_efforts(0.0, &[position], &[rate], &mut efforts);
            efforts[0]
        };
        assert_eq!([effort(0.0, 5.0), effort(-1.5, 0.0), effort(2.5, 0.0)], [0.0, 50.0, -50.0]);
        assert_eq!([effort(2.5, 1.0), effort(2.5, -100.0), effort(-1.5, 100.0)], [-53.0, 0.0, 0.0]);
    }
}
