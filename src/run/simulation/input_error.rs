//! Why a run does not take efforts and targets.

/// Why efforts or targets cannot be taken.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InputError {
    /// Their number.
    #[error("{given} efforts for {wanted} degrees of freedom: give one for each, in the order of the velocities")]
    Count {
        /// How many were given.
        given: usize,
        /// How many are wanted.
        wanted: usize,
    },
    /// There is no such motor.
    #[error("motor {motor} of {count}: give the number of a motor, from 0")]
    NoMotor {
        /// The given number.
        motor: usize,
        /// How many there are.
        count: usize,
    },
    /// A target is not a finite number.
    #[error("the target of the motor of joint {joint:?} is {target}: give a finite number")]
    Target {
        /// The joint.
        joint: String,
        /// What was given.
        target: f64,
    },
    /// One of them is not a finite number.
    #[error("the effort on joint {joint:?} is {effort}: give a finite number")]
    NotFinite {
        /// The joint.
        joint: String,
        /// The given effort [N m or N].
        effort: f64,
    },
}
