//! The order in which a mechanism with loops is eliminated: planned once, on the graph alone.
//!
//! The unknowns are the freedoms of the tree's joints and the multipliers of the equations that the tree cannot say. A
//! *front* is a dense block over the twist of one body and the multipliers that are still open below it (multifrontal elimination: I. Duff, J. Reid,
//! ACM TOMS 9 (1983) 302). Bodies come leaf first, so that on a tree this is the articulated recursion. A loop is eliminated at the body at which its
//! two branches meet, or at the world if it ends there. Before that its block may have no full rank, however many freedoms are gone: hinges are
//! parallel, knees straight, and other loops need them, too.
//!
//! In a step, a compliant connection of a body to the world is eliminated at that body, before any freedom. Springs and the friction of contacts
//! give, and so do contacts with the world, by their proximal term ε alone. Such a contact is a 6 × 6 block that the body's inertia takes up,
//!
//! ```text
//!     D_ki ← D_ki + J_kᵀ (B_ki/ε) J_i
//! ```
//!
//! The block does not depend on the number of touching points, and the bodies below in the tree are not affected.
//!
//! The number of multipliers in a front, and with it the cost, stays bounded on ladders whose rungs are numbered
//! along them; it grows with the number of loops that pass over one body.

/// One operation on the front on top of the stack.
#[derive(Clone, Debug)]
pub enum Operation {
    /// Put an empty front on the stack.
    Open,
    /// Clear these slots for multipliers that come in; the right-hand sides of `gaps` (row, slot) come in with them.
    Enter { slots: Vec<usize>, present: Vec<usize>, gaps: Vec<(usize, usize)> },
    /// Add a body's inertia and residual, and its ends of loops: (row, slot, sign). The gradient of an end is that of its row; at a rope through
    /// several points the first number is that of a gradient of its own, after all rows.
    Own { body: usize, ends: Vec<(usize, usize, f64)> },
    /// Eliminate a freedom: the twist of the body becomes the twist of its parent. `direct`: (row, slot, coefficient).
    Freedom { body: usize, freedom: usize, columns: Vec<Column>, direct: Vec<(usize, usize, f64)> },
    /// Eliminate a multiplier in `slot`; `measure` are the rows of all closures that go with it and their slots, whose mobilities
    /// are measured before the first of them goes.
    Multiplier { row: usize, slot: usize, columns: Vec<Column>, measure: Vec<(usize, usize)> },
    /// Add the top front to the one below and take it off: slots from and to, after clearing the slots that `enter` there; without the twist if it is
    /// the twist of the world.
    Merge { slots: Vec<(usize, usize)>, enter: Vec<usize>, present: Vec<usize>, twist: bool },
}

/// A column of a front that is left after an elimination, and the unknown it stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Column {
    /// Its slot in the front.
    pub slot: usize,
    /// The unknown that it multiplies.
    pub unknown: Unknown,
}

/// An unknown of the linear system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unknown {
    /// A component of the twist of a body about the common origin. A freedom of its own joint multiplies the twist before that freedom and the later
    /// ones are added.
    Twist { body: usize, component: usize },
    /// The multiplier of a row.
    Multiplier(usize),
}

/// Largest number of components of a twist.
pub const TWIST: usize = 6;

/// The elimination of a mechanism: constant.
#[derive(Clone, Debug)]
pub struct Elimination {
    /// Number of components of a twist, which are the first slots of every front: six in space, three in a plane.
    pub width: usize,
    /// In this order, with a stack of fronts.
    pub operations: Vec<Operation>,
    /// For every equation the closure it belongs to: the loops first, then the mimics, then the point springs.
    pub closure_of_row: Vec<usize>,
    /// For every equation whether it goes at its only body: its pivot is its own term alone.
    pub given: Vec<bool>,
    /// Largest number of slots of any front.
    pub slots: usize,
    /// Largest number of fronts on the stack.
    pub levels: usize,
}

impl Elimination {
    /// The work of a solve: the squares of the fronts at every unknown that is eliminated, added up.
    pub fn work(&self) -> usize {
        let of = |operation: &Operation| match operation {
            Operation::Freedom { columns, .. } | Operation::Multiplier { columns, .. } => (columns.len() + 1).pow(2),
            _ => 0,
        };
        self.operations.iter().map(of).sum()
    }
}
