//! A body in the coupled system: its inertia between all rows and stages, and the screws of its freedoms.
//!
//! ```text
//!     D_ki = B_ki [ m          −m x̂_i                          ]      N = R_i Σ R_kᵀ  [kg m²]
//!                 [ m x̂_k      tr N − N − m x̂_k x̂_i            ]
//!
//!     s_i = (p_i × z_i, z_i) of a rotation about the axis z through p, (e_i, 0) of a translation along e
//! ```
//!
//! about the common origin, x the centre of mass [m]; newton.md §4c of the project's method pages.

use super::{Coupled, Mixing, first_lane};
use crate::lobatto::algebra::{Matrix, Vector};
use crate::lobatto::closure::Moved;
use crate::lobatto::elimination::TWIST;
use crate::lobatto::front::{Fronts, Screws};
use crate::lobatto::lanes::Lanes;
use crate::lobatto::start::{Plan, Start};
use crate::lobatto::sweeps::tilt;
use crate::model::FreeRotation;

impl<V: Lanes> Coupled<V> {
    /// A body's inertia and residual.
    #[inline(always)]
    pub(super) fn own(&mut self, level: usize, start: &Start, body: usize) {
        let mut anchors = [Vector::zero(); 2];
        for side in 0..2 {
            anchors[side] = self.anchor(start, body, side);
        }
        let known = &start.bodies[body];
        own_inertia(
            &mut self.fronts,
            level,
            &self.mixing,
            OwnBody {
                anchors,
                moved: &self.moved[body],
                mass: known.mass,
                com: known.com,
                sigma: known.sigma,
                bias: self.bias[body],
            },
        );
    }

    /// The screw of a freedom at the rows' and the columns' stages; without displacements, at the start.
    #[inline(always)]
    pub(super) fn screws_of(
        &self,
        plan: &Plan,
        start: &Start,
        displacement: &[V],
        body: usize,
        freedom: usize,
    ) -> Screws<V> {
        let mut sides = [[V::zero(); TWIST]; 2];
        for (side, screw) in sides.iter_mut().enumerate() {
            *screw = self.screw(plan, start, displacement, body, freedom, side);
        }
        Screws { columns: sides[0], rows: sides[1] }
    }

    #[inline(always)]
    fn screw(
        &self,
        plan: &Plan,
        start: &Start,
        displacement: &[V],
        body: usize,
        freedom: usize,
        side: usize,
    ) -> [V; TWIST] {
        let plan = &plan.bodies[body];
        let rotations = plan.first_axis + plan.translations;
        let mut axis = Vector::splat(&start.axes[freedom]);
        if freedom < rotations {
            if let Some(parent) = plan.parent {
                axis = self.moved[parent][side].turn.apply_plus(axis, axis);
            }
            let [x, y, z] = axis.0;
            return [x, y, z, V::zero(), V::zero(), V::zero()];
        }
        if plan.rotation == FreeRotation::Ball && !displacement.is_empty() {
            let mut vector = Vector::zero();
            for freedom in rotations..rotations + 3 {
                vector = Vector::splat(&start.axes[freedom]).times_plus(displacement[freedom], vector);
            }
            if side == 1 {
                vector = vector.times(self.mixing.moved);
            }
            axis = tilt(vector, axis);
        }
        let along = self.moved[body][side].turn.apply_plus(axis, axis);
        let linear = self.anchor(start, body, side).cross(along);
        let ([a, b, c], [x, y, z]) = (linear.0, along.0);
        [a, b, c, x, y, z]
    }
}

/// A body at all stages, as its part of the system needs it.
struct OwnBody<'b, V> {
    /// Its anchor from the common origin, at the columns' and the rows' stages.
    anchors: [Vector<V>; 2],
    moved: &'b [Moved<V>; 2],
    mass: f64,
    com: [f64; 3],
    sigma: [f64; 6],
    bias: (Vector<V>, Vector<V>),
}

/// Adds `D_ki` and the right-hand side of a body to the twist part of a front.
#[inline(always)]
fn own_inertia<V: Lanes>(fronts: &mut Fronts<V>, level: usize, mixing: &Mixing<V>, body: OwnBody<V>) {
    let com = Vector::splat(&body.com);
    let turn = &body.moved[0].turn;
    let column = turn.apply_plus(com, com).plus(body.anchors[0]);
    let row = body.moved[1].turn.apply_plus(com, com).plus(body.anchors[1]);
    let [xx, xy, xz, yy, yz, zz] = body.sigma;
    // Row c of R_k Σ is column c of Σ R_kᵀ.
    let spread = spread_rows(&body.moved[1].turn, [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
    let row_center = [row.0[0].to_array(), row.0[1].to_array(), row.0[2].to_array()];
    let right = fronts.right_hand_side();
    let (force, torque) = (body.bias.0.0, body.bias.1.0);
    for component in 0..TWIST {
        let bias = if component < 3 { force[component] } else { torque[component - 3] };
        let bias = bias.to_array();
        let block = fronts.block(level, component, right);
        for k in 0..mixing.active {
            block[k] = block[k] + first_lane::<V>(-bias.as_ref()[k]);
        }
    }
    for k in 0..mixing.active {
        let weight = mixing.mass[k];
        let heavy = weight * V::splat(body.mass);
        let at = [
            V::splat(row_center[0].as_ref()[k]),
            V::splat(row_center[1].as_ref()[k]),
            V::splat(row_center[2].as_ref()[k]),
        ];
        // Column c of N = (1 + turn) Σ R_kᵀ.
        let mut second = [[V::zero(); 3]; 3];
        for c in 0..3 {
            let entry = Vector([
                V::splat(spread[c][0].as_ref()[k]),
                V::splat(spread[c][1].as_ref()[k]),
                V::splat(spread[c][2].as_ref()[k]),
            ]);
            second[c] = turn.apply_plus(entry, entry).0;
        }
        let trace = second[0][0] + second[1][1] + second[2][2];
        let across = column.dot(Vector(at));
        for axis in 0..3 {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            fronts.add(level, axis, axis, k, heavy);
            // −m x̂_i above, m x̂_k below.
            fronts.add(level, axis, 3 + next, k, heavy * column.0[last]);
            fronts.add(level, axis, 3 + last, k, -(heavy * column.0[next]));
            fronts.add(level, 3 + axis, next, k, -(heavy * at[last]));
            fronts.add(level, 3 + axis, last, k, heavy * at[next]);
        }
        for r in 0..3 {
            for c in 0..3 {
                let mut value = -(weight * second[c][r]) - heavy * column.0[r] * at[c];
                if r == c {
                    value = value + weight * trace + heavy * across;
                }
                fronts.add(level, 3 + r, 3 + c, k, value);
            }
        }
    }
}

/// The rows of `(1 + turn) Σ`, as arrays over the stages.
#[inline(always)]
fn spread_rows<V: Lanes>(turn: &Matrix<V>, sigma: [[f64; 3]; 3]) -> [[V::Array; 3]; 3] {
    let mut spread = [[V::zero_array(); 3]; 3];
    for c in 0..3 {
        let second = Vector::splat(&sigma[c]);
        let turned = turn.apply_plus(second, second).0;
        for r in 0..3 {
            spread[r][c] = turned[r].to_array();
        }
    }
    spread
}
