//! Motors that hold their joints where a run starts, as a model has them. Their targets are known when the start is.

/// A motor whose target is the position of its joint at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtStart {
    /// The motor, by its number in the mechanism.
    pub motor: usize,
    /// Natural frequency (rad/s) from which its gains follow; `None` where they are given.
    pub frequency: Option<f64>,
}
