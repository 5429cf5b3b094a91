//! The factors of the Newton step: computed by the sweep from the leaves to the root, used by the sweep back.
//!
//! ```text
//!     α = α₀ − (A s)ᵀ η / d        for every eliminated degree of freedom, η = (a, φ) the twist of the body
//! ```

use crate::numbers::algebra::Vector;
use crate::numbers::arithmetic::Arithmetic;
use crate::plan::tree::Plan;
use crate::stages::articulated::{Articulated, Eliminated};
/// Factors that the sweep from the leaves leaves for the one back, and the slots of branching bodies.
#[derive(Clone)]
pub struct Factors<V> {
    /// One entry a degree of freedom.
    pub eliminated: Vec<Eliminated<V>>,
    /// Arm from the parent's anchor at the rows' stages; one entry a body.
    pub arms: Vec<Vector<V>>,
    /// Sums of the children's inertias, by [`Plan::below`]: first the slots of branching bodies, then the slot of an only child, and last a zero.
    pub slots: Vec<Articulated<V>>,
    /// Twist of the branching bodies on the way back.
    pub(crate) twists: Vec<(Vector<V>, Vector<V>)>,
}

impl<V: Arithmetic> Factors<V> {
    /// Room for the factors of a tree.
    pub fn new(plan: &Plan, freedoms: usize) -> Self {
        Factors {
            eliminated: vec![Eliminated::zero(); freedoms],
            arms: vec![Vector::zero(); plan.bodies.len()],
            slots: vec![Articulated::zero(); plan.slots + 2],
            twists: vec![(Vector::zero(), Vector::zero()); plan.slots],
        }
    }
}
