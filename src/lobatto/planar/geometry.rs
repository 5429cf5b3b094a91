//! The coupled system of [`crate::coupled::system`] in a plane: twists `η = (v, φ)` of three components about the common origin of the part of a body
//! ([`crate::equations::origins`]).
//!
//! ```text
//!     D_ki = B_ki [ m           m J x_i                                            ]
//!                 [ m (J x_k)ᵀ  I_c ((1 + κ_i)(1 + κ_k) + σ_i σ_k) + m x_k · x_i   ]         [kg], [kg m], [kg m²]
//!
//!     s_i = (−J p_i, 1) of a rotation about the point p, (e_i, 0) of a translation along e
//! ```
//!
//! with the centre of mass x (m), the moment of inertia I_c about it, and the turn `(κ, σ)` since the start of the step. These are the first, second
//! and last component of [`crate::coupled::space::Space`].

use crate::coupled::front::{Fronts, Screws, active};
use crate::coupled::mixing::Mixing;
use crate::coupled::system::{Geometry, Screw};
use crate::equations::loops::{Displaced, evaluate};
use crate::numbers::euclidean::Euclidean;
use crate::numbers::lanes::Lanes;
use crate::plan::elimination::TWIST;
use crate::plan::tree::Plan;
use crate::planar::algebra::Vector2;
use crate::planar::loops::{Moved, PlanarLoop};
use crate::planar::start::{PlanarPlan, PlanarStart};
use crate::planar::sweeps::{own_residual, row_turn};
use crate::planar::workspace::PlanarStages;
use crate::stages::coefficients::{Coefficients, moved_rows};
use crate::tableau::butcher::Tableau;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::state::State;
use catena_mechanism::structure::islands::first_of_tied;
use catena_mechanism::structure::plane::Plane;
use std::ops::Range;

/// Bodies and closures in the plane.
#[derive(Clone)]
pub(crate) struct Flat<V> {
    /// The loops, then the lines of the springs.
    closures: Vec<PlanarLoop>,
    loops: usize,
    /// The first body of the part of every body, and the common origin of that part (m).
    firsts: Vec<usize>,
    origins: Vec<[f64; 2]>,
    /// Every body since the start of the step, at the columns' and at the rows' stages.
    moved: Vec<[Moved<V>; 2]>,
    /// Zero where a row has the geometry of the start.
    mask: V,
}

impl<V: Lanes> Flat<V> {
    /// The closures of a mechanism in its plane: at all stages of a scheme, with the lines of its springs, or without it at one configuration.
    pub fn new(mechanism: &Mechanism, plane: &Plane, tableau: Option<&Tableau>) -> Self {
        let still = Moved { cosine: V::zero(), sine: V::zero(), anchor: Vector2::zero() };
        Flat {
            closures: PlanarLoop::all(mechanism, plane, tableau.is_some()),
            loops: mechanism.loops.len(),
            firsts: first_of_tied(mechanism),
            origins: vec![[0.0; 2]; mechanism.bodies.len()],
            moved: vec![[still; 2]; mechanism.bodies.len()],
            mask: tableau.map_or(V::zero(), |tableau| moved_rows(tableau.stages - 1)),
        }
    }

    /// The bodies at all stages, after [`PlanarStages::sweep_paths`] and [`PlanarStages::sweep_anchors`].
    #[inline(always)]
    fn move_bodies(&mut self, stages: &PlanarStages<V>) {
        let mask = self.mask;
        for ((moved, turned), &anchor) in self.moved.iter_mut().zip(&stages.turned).zip(&stages.anchors) {
            let (cosine, sine) = (turned.cosine, turned.sine);
            *moved = [
                Moved { cosine, sine, anchor },
                Moved { cosine: cosine * mask, sine: sine * mask, anchor: anchor.times(mask) },
            ];
        }
    }

    /// Places the bodies at the present displacements, and writes their residuals `E_k` about the common origin there; always with all digits of the
    /// coefficients.
    #[inline(always)]
    pub fn place_stages(
        &mut self,
        stages: &mut PlanarStages<V>,
        coefficients: &Coefficients<V>,
        gravity: &[f64; 3],
        bias: &mut [Screw<V>],
    ) {
        let sweep = coefficients.residual_sweep(stages.step, gravity);
        stages.sweep_paths::<false, true>(&sweep);
        // Forces between bodies need the anchors, too, and look where they are themselves.
        if stages.plan.forces.is_empty() {
            stages.sweep_anchors();
        }
        if stages.applied.is_some() {
            stages.sweep_applied(coefficients, false);
        }
        self.move_bodies(stages);
        for (index, known) in stages.start.bodies.iter().enumerate() {
            let turned = &stages.turned[index];
            let (_, force, torque) = own_residual(known, turned, row_turn::<V, false>(&sweep, turned));
            let (force, torque) = stages.less_acting(index, &sweep, force, torque);
            let anchor = self.anchor(&stages.start, index, 1);
            bias[index] = force.joined(anchor.cross_plus(force, torque));
        }
    }

    /// The place of an anchor at the columns' (0) or the rows' (1) stages, from the common origin.
    #[inline(always)]
    pub fn anchor(&self, start: &PlanarStart, body: usize, side: usize) -> Vector2<V> {
        let position = &start.bodies[body].position;
        let origin = &self.origins[body];
        let from_origin = [position[0] - origin[0], position[1] - origin[1]];
        Vector2::splat(&from_origin).plus(self.moved[body][side].anchor)
    }
}

impl<V: Lanes> Geometry<V> for Flat<V> {
    type Plan = PlanarPlan;
    type Start = PlanarStart;
    const WIDTH: usize = 3;

    fn tree(plan: &PlanarPlan) -> &Plan {
        &plan.tree
    }

    fn start(mechanism: &Mechanism) -> PlanarStart {
        PlanarStart::new(mechanism)
    }

    fn place(plan: &PlanarPlan, start: &mut PlanarStart, mechanism: &Mechanism, state: &State) {
        start.set(plan, mechanism, state);
    }

    fn mimic_gaps(start: &PlanarStart) -> &[f64] {
        &start.mimic_gaps
    }

    fn mimic_rates(start: &PlanarStart) -> &[f64] {
        &start.mimic_rates
    }

    fn rows(&self) -> Vec<usize> {
        self.closures[..self.loops].iter().map(|closure| closure.start.equations.len()).collect()
    }

    fn begin(&mut self, _: &PlanarPlan, start: &PlanarStart) {
        for (origin, &first) in self.origins.iter_mut().zip(&self.firsts) {
            *origin = start.bodies[first].position;
        }
        for closure in &mut self.closures {
            closure.begin(&start.bodies, &self.origins);
        }
    }

    #[inline(always)]
    fn evaluate(&self, rows_of_loop: &[Range<usize>], gaps: &mut [V], gradients: &mut [[Screw<V>; 2]]) {
        let closures = self.closures.iter().map(|closure| &closure.start);
        evaluate(closures, &self.moved, rows_of_loop, gaps, gradients);
    }

    #[inline(always)]
    fn screws(&self, plan: &PlanarPlan, start: &PlanarStart, _: &[V], body: usize, freedom: usize) -> Screws<V> {
        let tree = &plan.tree.bodies[body];
        let mut sides = [[V::zero(); TWIST]; 2];
        for (side, screw) in sides.iter_mut().enumerate() {
            if freedom < tree.first_axis + tree.translations {
                let axis = &start.axes[freedom];
                let along = tree.parent.map_or(Vector2::splat(axis), |parent| self.moved[parent][side].turn(axis));
                [screw[0], screw[1]] = along.0;
            } else {
                let sign = V::splat(plan.bodies[body].sign);
                let [x, y] = self.anchor(start, body, side).times(sign).0;
                [screw[0], screw[1], screw[2]] = [y, -x, sign];
            }
        }
        Screws { columns: sides[0], rows: sides[1] }
    }

    #[inline(always)]
    fn own(&self, start: &PlanarStart, body: usize, mixing: &Mixing<V>, fronts: &mut Fronts<V>, level: usize) {
        let known = &start.bodies[body];
        let [columns, rows] = &self.moved[body];
        let anchors = [self.anchor(start, body, 0), self.anchor(start, body, 1)];
        // Mass times the arm of the centre of mass from the anchor, and from the origin.
        let mass = V::splat(known.mass);
        let heavy = columns.turn(&known.heavy);
        let moment = anchors[0].times_plus(mass, heavy);
        let row_heavy = rows.turn(&known.heavy);
        let row_moment = anchors[1].times_plus(mass, row_heavy);
        let one = V::splat(1.0);
        let (cosine, sine) = (columns.cosine + one, columns.sine);
        let (anchor, arm, lever) = (arrays(anchors[1]), arrays(row_heavy), arrays(row_moment));
        let inertia = V::splat(known.inertia);
        let turn = arrays(Vector2([(rows.cosine + one) * inertia, rows.sine * inertia]));
        for k in 0..active::<V>(mixing.active) {
            let weight = mixing.mass[k];
            // About the anchor I cos(φ_i − φ_k), and the contribution of the anchor's own place.
            let ([along, across], [mx, my]) = (of_row::<V>(&turn, k).0, of_row::<V>(&lever, k).0);
            let turning = across.mul_add(sine, along * cosine);
            let carried = of_row(&anchor, k).dot_plus(moment, of_row(&arm, k).dot_plus(anchors[0], turning));
            for axis in 0..2 {
                fronts.add(level, axis, axis, k, weight * mass);
            }
            fronts.add(level, 0, 2, k, -(weight * moment.0[1]));
            fronts.add(level, 1, 2, k, weight * moment.0[0]);
            fronts.add(level, 2, 0, k, -(weight * my));
            fronts.add(level, 2, 1, k, weight * mx);
            fronts.add(level, 2, 2, k, weight * carried);
        }
    }
}

/// A vector as arrays over the stages.
#[inline(always)]
fn arrays<V: Lanes>(vector: Vector2<V>) -> [V::Array; 2] {
    [vector.0[0].to_array(), vector.0[1].to_array()]
}

/// The vector of one row, in every lane.
#[inline(always)]
fn of_row<V: Lanes>(arrays: &[V::Array; 2], k: usize) -> Vector2<V> {
    Vector2([V::splat(arrays[0].as_ref()[k]), V::splat(arrays[1].as_ref()[k])])
}
