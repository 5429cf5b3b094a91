//! A mode: what every element does between two events.
//!
//! | element | state | effort on the joint |
//! |---|---|---|
//! | joint | free, sliding with sign σ | `−σ τ_f` |
//! | joint | held by friction | whatever holds it, `λ ∈ [−τ_f, τ_f]` |
//! | joint | held on its lower limit | `λ ∈ [−τ_f, ∞)` |
//! | joint | held on its upper limit | `λ ∈ (−∞, τ_f]` |
//! | motor | unbounded | `kp (r − q) + kd (ṙ − q̇)` |
//! | motor | at its bound | `± bound` |
//! | motor | sampled | as worked out at the last tick |

use crate::instant::elements::{ElementJoint, Elements};
use crate::mechanism::motion::event::Side;
use crate::mechanism::motion::state::State;

/// What a joint does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum JointMode {
    /// It moves; its friction, if it has any, against this direction.
    Free {
        /// σ: 1 or −1; 0 without friction.
        sliding: i8,
    },
    /// It is held, by friction alone or on a limit.
    Held {
        /// The limit.
        on: Option<Side>,
    },
}

/// What a motor does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum MotorMode {
    /// Its law without bound.
    Unbounded,
    /// At its bound, with this sign.
    Saturated(i8),
    /// A given effort, until the next tick [N m or N].
    Given(f64),
}

/// What all do.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Mode {
    pub joints: Vec<JointMode>,
    pub motors: Vec<MotorMode>,
}

impl Mode {
    /// Whether the joint of each body is held.
    pub fn held_bodies(&self, elements: &Elements, bodies: usize) -> Vec<bool> {
        let mut held = vec![false; bodies];
        for (joint, mode) in elements.joints.iter().zip(&self.joints) {
            for member in &joint.members {
                held[member.coordinate.body] |= matches!(mode, JointMode::Held { .. });
            }
        }
        held
    }

    /// The efforts that are constant while the mode lasts, added to `efforts`: of friction that slides, and of motors at their bounds or between
    /// ticks.
    pub fn add_constant_efforts(&self, elements: &Elements, efforts: &mut [f64]) {
        for (joint, mode) in elements.joints.iter().zip(&self.joints) {
            if let JointMode::Free { sliding } = mode {
                efforts[joint.coordinate.freedom] -= f64::from(*sliding) * joint.friction;
            }
        }
        for (motor, mode) in elements.motors.iter().zip(&self.motors) {
            let freedom = motor.coordinate.freedom;
            match *mode {
                MotorMode::Unbounded => {}
                MotorMode::Saturated(sign) => efforts[freedom] += f64::from(sign) * motor.max_effort,
                MotorMode::Given(effort) => efforts[freedom] += effort,
            }
        }
    }

    /// The efforts of motors that follow their laws, at a time (s) and state, added to `efforts`; their targets are those of the piece that
    /// begins at or before `since` (s).
    pub fn add_motor_efforts(&self, elements: &Elements, since: f64, time: f64, state: &State, efforts: &mut [f64]) {
        for (motor, mode) in elements.motors.iter().zip(&self.motors) {
            if *mode == MotorMode::Unbounded {
                let at = motor.coordinate;
                let position = state.position[at.position] + state.compensation[at.position];
                efforts[at.freedom] += motor.unbounded(since, time, position, state.velocity[at.freedom]);
            }
        }
    }
}

impl JointMode {
    /// The efforts that can hold a joint: λ from … to [N m or N].
    pub fn holding(self, joint: &ElementJoint) -> (f64, f64) {
        match self {
            JointMode::Held { on } => joint.holding(on),
            JointMode::Free { .. } => joint.holding(None),
        }
    }
}
