//! Why a run does not take efforts.

/// Why efforts cannot be taken.
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
    /// One of them is not a finite number.
    #[error("the effort on joint {joint:?} is {effort}: give a finite number")]
    NotFinite {
        /// The joint.
        joint: String,
        /// The given effort [N m or N].
        effort: f64,
    },
}
