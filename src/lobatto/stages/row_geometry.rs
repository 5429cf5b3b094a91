//! How a body has moved in the rows of a sweep, worked out one body early.
//!
//! The sums over the stages ([`crate::equations::residual`]) read their inputs back from memory lane by lane, if that is cheaper than to shuffle them
//! out of registers ([`Rows::EARLY`]). A read of a value just written waits for the store. So while one body is mixed the next one is written.

use crate::numbers::algebra::Vector;
use crate::numbers::arithmetic::Arithmetic;
use crate::plan::tree::Plan;
use crate::stages::rows::Rows;
use crate::stages::start::{BodyStart, Start};

/// How a body has moved.
#[derive(Clone, Copy)]
pub struct RowGeometry<V, A> {
    /// The inputs of the sums over stages.
    pub ahead: A,
    /// Vector from the anchor to the centre of mass, with the geometry of the rows (m).
    pub com: Vector<V>,
}

impl<V: Arithmetic, A> RowGeometry<V, A> {
    /// The geometry of a body that turns.
    #[inline(always)]
    pub fn new<R: Rows<V, Ahead = A>>(rows: &R, body: usize, known: &BodyStart<V::Real>) -> Self {
        let pose = rows.pose(body);
        let turned = pose.turned();
        let com = Vector::splat(&known.com);
        let swing = turned.matrix().apply(com);
        let ahead = rows.ahead(known, swing.plus(pose.anchor), turned);
        RowGeometry { ahead, com: swing.times_plus(rows.moved(), com) }
    }
}

/// The body that is being mixed, and the next; a workspace of sweeps from the leaves to the root.
#[derive(Clone)]
pub struct LookAhead<V, A>([RowGeometry<V, A>; 2]);

impl<V: Arithmetic, A: Copy> LookAhead<V, A> {
    /// For bodies without inputs of sums over stages.
    pub fn new(ahead: A) -> Self {
        LookAhead([RowGeometry { ahead, com: Vector::zero() }; 2])
    }

    /// Works out the last body before `end`, if [`LookAhead::at`] will be asked for it.
    #[inline(always)]
    pub fn prepare<R: Rows<V, Ahead = A>>(&mut self, plans: &Plan, start: &Start<V::Real>, rows: &R, end: usize) {
        let Some(body) = end.checked_sub(1) else { return };
        let plan = &plans.bodies[body];
        if R::EARLY && !plan.slides && plan.pivot.is_none() {
            self.0[body % 2] = RowGeometry::new(rows, body, &start.bodies[body]);
        }
    }

    /// The body that has been prepared, of rows that are [early](Rows::EARLY).
    #[inline(always)]
    pub fn at(&self, body: usize) -> &RowGeometry<V, A> {
        &self.0[body % 2]
    }
}
