//! The coupled system in space: the residuals and mass blocks of the bodies, the screws of their freedoms, and the closures.
//!
//! ```text
//!     D_ki = B_ki [ m          −m x̂_i                          ]      N = R_i Σ R_kᵀ  [kg m²]
//!                 [ m x̂_k      tr N − N − m x̂_k x̂_i            ]
//!
//!     s_i = (p_i × z_i, z_i) of a rotation about the axis z through p, (e_i, 0) of a translation along e
//! ```
//!
//! about the common origin of the part of the body ([`crate::equations::origins`]), x the centre of mass (m). D_ki is the derivative of the residual of row k (`equations/residual.rs`) by the twist at stage
//! i, less the curvature.

use crate::coupled::front::{Fronts, Screws, active};
use crate::coupled::mixing::Mixing;
use crate::coupled::system::{Geometry, Screw};
use crate::coupled::touching::Touching;
use crate::equations::loops::evaluate;
use crate::equations::residual::residual_of;
use crate::equations::spatial_loops::{Moved, SpatialLoop};
use crate::numbers::algebra::{Matrix, Vector};
use crate::numbers::euclidean::Euclidean;
use crate::numbers::lanes::Lanes;
use crate::numbers::rotations::Tilt;
use crate::plan::elimination::TWIST;
use crate::plan::tree::Plan;
use crate::stages::coefficients::moved_rows;
use crate::stages::row_geometry::RowGeometry;
use crate::stages::rows::Rows;
use crate::stages::start::Start;
use crate::stages::workspace::Stages;
use crate::tableau::butcher::Tableau;
use catena_mechanism::description::joint::FreeRotation;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::state::State;
use catena_mechanism::structure::islands::first_of_tied;
use nalgebra::Vector3;
use std::ops::Range;

/// Bodies and closures in space.
#[derive(Clone)]
pub struct Space<V> {
    /// The loops, then the lines of the springs.
    closures: Vec<SpatialLoop>,
    loops: usize,
    touching: Touching<V>,
    /// The first body of the part of every body, and the common origin of that part (m).
    firsts: Vec<usize>,
    origins: Vec<[f64; 3]>,
    /// Every body since the start of the step, at the columns' and at the rows' stages.
    moved: Vec<[Moved<V>; 2]>,
    /// Zero where a row has the geometry of the start.
    mask: V,
}

impl<V: Lanes> Space<V> {
    /// The closures of a mechanism: at all stages of a scheme, with the lines of its springs, or without it at one configuration.
    pub fn new(mechanism: &Mechanism, tableau: Option<&Tableau>) -> Self {
        let still = Moved { turn: Matrix::zero(), anchor: Vector::zero() };
        Space {
            closures: SpatialLoop::all(mechanism, tableau.is_some()),
            loops: mechanism.loops.len(),
            touching: Touching::new(mechanism, tableau),
            firsts: first_of_tied(mechanism),
            origins: vec![[0.0; 3]; mechanism.bodies.len()],
            moved: vec![[still; 2]; mechanism.bodies.len()],
            mask: tableau.map_or(V::zero(), |tableau| moved_rows(tableau.stages - 1)),
        }
    }

    /// The bodies at all stages from the poses of a step.
    #[inline(always)]
    fn move_bodies(&mut self, stages: &Stages<V>) {
        let mask = self.mask;
        for (moved, pose) in self.moved.iter_mut().zip(&stages.poses) {
            let turn = pose.increment();
            *moved = [
                Moved { turn, anchor: pose.anchor },
                Moved { turn: turn.times(mask), anchor: pose.anchor.times(mask) },
            ];
        }
    }

    /// Places the bodies at the poses of a step, and writes their residuals `E_k` about the common origin there, after [`Stages::sweep_poses`] and
    /// [`Stages::sweep_applied`]; always with all digits of the coefficients.
    #[inline(always)]
    pub fn place_stages(&mut self, stages: &mut Stages<V>, gravity: &[f64; 3], bias: &mut [Screw<V>]) {
        self.move_bodies(stages);
        if !self.touching.is_empty() {
            self.touching.place(&stages.start, stages.step, &self.moved, &self.origins);
        }
        let square = V::splat(stages.step * stages.step);
        let (_, rows, _) = stages.rows::<true, true>(gravity);
        for (index, plan) in rows.plan.bodies.iter().enumerate() {
            let known = &rows.start.bodies[index];
            let own = residual_of(&rows, index, plan, known, &RowGeometry::new(&rows, index, known));
            let anchor = self.anchor(rows.start, index, 1);
            let (mut force, mut torque) = (own.force, own.torque);
            if let Some(wrench) = rows.wrench(index) {
                force = wrench.0.times_minus(square, force);
                torque = wrench.1.times_minus(square, torque);
            }
            bias[index] = force.joined(anchor.cross_plus(force, torque));
        }
    }

    /// The place of an anchor at the columns' (0) or the rows' (1) stages, from the common origin.
    #[inline(always)]
    pub fn anchor(&self, start: &Start, body: usize, side: usize) -> Vector<V> {
        self.moved[body][side].anchor_from(&start.anchor(body), &self.origins[body])
    }

    /// The place of the second end of a loop at the start, from the common origin (m).
    pub fn end_point(&self, closure: usize) -> [f64; 3] {
        self.closures[closure].start.points[1]
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
    ) -> Screw<V> {
        let plan = &plan.bodies[body];
        let rotations = plan.first_axis + plan.translations;
        let mut axis = Vector::splat(&start.axes[freedom]);
        if freedom < rotations {
            if let Some(parent) = plan.parent {
                axis = self.moved[parent][side].turn.apply_plus(axis, axis);
            }
            return axis.joined(Vector::zero());
        }
        if plan.rotation == FreeRotation::Ball && !displacement.is_empty() {
            let mut vector = Vector::zero();
            for freedom in rotations..rotations + 3 {
                vector = Vector::splat(&start.axes[freedom]).times_plus(displacement[freedom], vector);
            }
            if side == 1 {
                vector = vector.times(self.mask);
            }
            axis = Tilt::of(vector).of_axis(axis);
        }
        let along = self.moved[body][side].turn.apply_plus(axis, axis);
        self.anchor(start, body, side).cross(along).joined(along)
    }
}

impl<V: Lanes> Geometry<V> for Space<V> {
    type Plan = Plan;
    type Start = Start;
    const WIDTH: usize = TWIST;

    fn tree(plan: &Plan) -> &Plan {
        plan
    }

    fn start(mechanism: &Mechanism) -> Start {
        Start::new(mechanism)
    }

    fn place(_: &Plan, start: &mut Start, mechanism: &Mechanism, state: &State) {
        start.set(mechanism, state);
    }

    fn mimic_gaps(start: &Start) -> &[f64] {
        &start.mimic_gaps
    }

    fn mimic_rates(start: &Start) -> &[f64] {
        &start.mimic_rates
    }

    fn rows(&self) -> Vec<usize> {
        let loops = self.closures[..self.loops].iter().map(|closure| closure.start.equations.len());
        loops.chain(self.touching.rows()).collect()
    }

    fn begin(&mut self, _: &Plan, start: &Start) {
        for (origin, &first) in self.origins.iter_mut().zip(&self.firsts) {
            *origin = start.anchor(first);
        }
        for closure in &mut self.closures {
            closure.begin(start, &self.origins);
        }
        self.touching.begin(start, &self.origins);
    }

    #[inline(always)]
    fn evaluate(&self, rows_of_loop: &[Range<usize>], gaps: &mut [V], gradients: &mut [[Screw<V>; 2]]) {
        let closures = self.closures.iter().map(|closure| &closure.start);
        if self.touching.is_empty() {
            evaluate(closures, &self.moved, rows_of_loop, gaps, gradients);
            return;
        }
        let (loops, rest) = rows_of_loop.split_at(self.loops);
        let (touches, rest) = rest.split_at(self.touching.len());
        let (springs, rubbing) = rest.split_at(self.closures.len() - self.loops);
        evaluate(closures.clone(), &self.moved, loops, gaps, gradients);
        evaluate(closures.skip(self.loops), &self.moved, springs, gaps, gradients);
        self.touching.write(touches, rubbing, gaps, gradients);
    }

    fn leverage(&self, start: &Start, body: usize, direction: &[f64; TWIST]) -> f64 {
        let known = &start.bodies[body];
        let anchor = start.anchor(body);
        let com = Vector3::from_fn(|axis, _| anchor[axis] - self.origins[body][axis] + known.com[axis]);
        let [force, torque] = [0, 3].map(|first: usize| Vector3::from_column_slice(&direction[first..first + 3]));
        let [xx, _, _, yy, _, zz] = known.sigma;
        // The trace of J = tr Σ 1 − Σ is twice the trace of the second moments Σ.
        let moment = (xx + yy + zz) * (2.0 / 3.0);
        if moment > 0.0 { known.mass * (torque - com.cross(&force)).norm_squared() / moment } else { 0.0 }
    }

    fn touching(&self) -> Option<&Touching<V>> {
        (!self.touching.is_empty()).then_some(&self.touching)
    }

    fn touching_mut(&mut self) -> Option<&mut Touching<V>> {
        (!self.touching.is_empty()).then_some(&mut self.touching)
    }

    #[inline(always)]
    fn screws(&self, plan: &Plan, start: &Start, displacement: &[V], body: usize, freedom: usize) -> Screws<V> {
        let mut sides = [[V::zero(); TWIST]; 2];
        for (side, screw) in sides.iter_mut().enumerate() {
            *screw = self.screw(plan, start, displacement, body, freedom, side);
        }
        Screws { columns: sides[0], rows: sides[1] }
    }

    #[inline(always)]
    fn own(&self, start: &Start, body: usize, mixing: &Mixing<V>, fronts: &mut Fronts<V>, level: usize) {
        let known = &start.bodies[body];
        let anchors = [self.anchor(start, body, 0), self.anchor(start, body, 1)];
        let own = OwnBody { anchors, moved: &self.moved[body], mass: known.mass, com: known.com, sigma: known.sigma };
        own_inertia(fronts, level, mixing, own);
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
}

/// Adds `D_ki` of a body to the twist part of a front.
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
    for k in 0..active::<V>(mixing.active) {
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
