//! Forces at all stages at once, by the forced (Lagrange–d'Alembert) version of the scheme.
//!
//! Row k of the stage equations gets `h² F_k`, the end momentum `h b_s F_s`, with F at the geometry and the velocity of the stage. A force that
//! depends on a velocity depends on the rate of one scalar y: a joint displacement, or the length of a spring. Its rate at stage j is the rate of the
//! scheme itself,
//!
//! ```text
//!     ẏ_j = ẏ₀ + h⁻¹ Σ_i (Ā B)_ji (y_i − y₀ − h c_i ẏ₀),     j = 1..s
//! ```
//!
//! which is (2.5.11) with y as one more coordinate, without mass, tied to the others by the constraint `y = y(q)`: its multiplier hands the force on.
//! So the order stays 2s − 2, and a damper does not act on a rigid motion of both its ends. Velocities of the embedding, `u·(V_b − V_a)`, would not
//! guarantee that: they leave the constraints at the inner stages. Note that ẏ₁ is not ẏ₀: the first column of Ā is b₁, not zero. That makes damping
//! implicit also at the start, and the scheme stable for any damper.
//!
//! A ball joint has three such coordinates in a step, the components of its rotation vector θ since the start; the
//! damper acts on `ω = T(θ) θ̇`, `T = 1 − k₁ θ̂ + k₂ θ̂²`, and the effort along θ is `Tᵀ τ`.
//!
//! In Newton's matrix a damper along a freedom is `h c Σ_i (Ā B)_ki`, which mixes the stages. The simplified iteration,
//! `δ_i = Σ_k Â_ik α_k`, takes `κ h c` in its place, on the diagonal of `H(q_k)`. It converges for every c if
//! `|μ − κ| < κ` for all eigenvalues μ of `Â Ā B` (rows and columns 1 … s−1 of Ā), fastest for large c with
//!
//! ```text
//!     κ = max |μ|² / Re μ           ½, ⅓, 0.272, 0.2375, … 0.176 for s = 2, 3, 4, 5, … 9; exact for s = 2
//! ```
//!
//! The energy that dampers dissipate, and the work of torques without potential, are summed by the quadrature of the scheme, `h Σ_k b_k P_k`.
//!
//! Sources: the forced scheme: J. E. Marsden, M. West, "Discrete mechanics and variational integrators", Acta Numerica
//! 2001, section 3.2; its order with constraints: L. O. Jay, "Structure preservation for constrained dynamics with super
//! partitioned additive Runge–Kutta methods", SIAM J. Sci. Comput. 20 (1998).

use crate::equations::holding::add_holding;
use crate::equations::loads::{LoadedBodies, add_loads};
use crate::equations::springs::{BodiesAtStages, add_springs};
use crate::numbers::algebra::{Matrix, Vector};
use crate::numbers::lanes::Lanes;
use crate::numbers::rotations::{Tilt, rotate_increment};
use crate::stages::force_motion::{Motion, Place};
use crate::stages::forces::Applied;
use crate::stages::pose::{StagePose, Turned};
use crate::stages::workspace::Stages;
use catena_mechanism::forces::total::Exchange;

impl<V: Lanes> Stages<V> {
    /// After [`Stages::sweep_poses`]: the forces of the rows, into [`Stages::applied`]; for a solved step, the forces at its `end`, in the last
    /// active lane, with the energy exchanged in the step. Does nothing without forces.
    #[inline(always)]
    pub fn sweep_applied(&mut self, end: bool) {
        if let Some(mut applied) = self.applied.take() {
            applied.evaluate_places(
                self.step,
                end,
                #[inline(always)]
                |applied, place, at_end| applied.evaluate(self, place, at_end, end),
            );
            if end {
                applied.exchange.work += applied.driven_work(&self.displacement, self.coefficients.active);
            }
            self.applied = Some(applied);
        }
    }
}

impl<V: Lanes> Applied<V> {
    /// The forces of the rows, as `evaluate` finds them in a place; for a solved step the forces at its `end`, too, with the energy exchanged in the
    /// step, of which `evaluate` returns the power (W).
    #[inline(always)]
    pub(crate) fn evaluate_places(
        &mut self,
        step: f64,
        end: bool,
        mut evaluate: impl FnMut(&mut Self, &Place<V>, bool) -> Exchange,
    ) {
        let (mut dissipated, mut work) = (0.0, 0.0);
        // One call in a loop, so that there is one copy of it.
        for at_end in [false, true] {
            if at_end && !end {
                break;
            }
            let place = if at_end { self.end } else { self.rows };
            let powers = evaluate(self, &place, at_end);
            dissipated += step * powers.dissipated;
            work += step * powers.work;
        }
        if end {
            self.exchange = Exchange { dissipated, work, ..Exchange::default() };
        }
    }

    /// The forces on scalar coordinates in one place, at the `end` of the step or at its rows; returns the power they dissipate, and the power of
    /// efforts that change in time.
    #[inline(always)]
    pub(crate) fn evaluate_scalars(&mut self, motion: &Motion<V>, place: &Place<V>, end: bool) -> (V, V) {
        let (mut dissipated, mut work) = (V::zero(), V::zero());
        self.efforts.fill(V::zero());
        for &(freedom, coefficient) in &self.plan.dampers {
            let rate = motion.rate(place, motion.displacement[freedom], motion.rates[freedom]);
            let effort = rate * V::splat(coefficient);
            self.efforts[freedom] = self.efforts[freedom] - effort;
            dissipated = effort.mul_add(rate, dissipated);
        }
        for (&(freedom, stiffness), &extension) in self.plan.springs.iter().zip(motion.extensions) {
            let extension = motion.displacement[freedom].mul_add(place.moved, V::splat(extension));
            self.efforts[freedom] = extension.neg_mul_add(V::splat(stiffness), self.efforts[freedom]);
        }
        for &(freedom, effort) in &self.plan.loads {
            self.efforts[freedom] = self.efforts[freedom] + V::splat(effort);
        }
        for &(freedom, effort) in &self.plan.driven {
            self.efforts[freedom] = self.efforts[freedom] + V::splat(effort);
        }
        for (freedom, effort, course) in &self.plan.courses {
            let (freedom, effort) = (*freedom, motion.factor(place, course) * V::splat(*effort));
            self.efforts[freedom] = self.efforts[freedom] + effort;
            work = effort.mul_add(motion.rate(place, motion.displacement[freedom], motion.rates[freedom]), work);
        }
        for changing in &self.changing {
            let (freedom, effort) = (changing.freedom, if end { changing.end } else { changing.rows });
            self.efforts[freedom] = self.efforts[freedom] + effort;
            work = effort.mul_add(motion.rate(place, motion.displacement[freedom], motion.rates[freedom]), work);
        }
        if let Some(rotors) = &mut self.rotors {
            rotors.evaluate(motion, end);
        }
        (dissipated, work)
    }

    /// The forces in one place; where one has to `account` for them, their powers, weighted. At the `end` of the step efforts on
    /// ball joints are along the axes of the body, not along the rotation vector.
    #[inline(always)]
    fn evaluate(&mut self, stages: &Stages<V>, place: &Place<V>, end: bool, account: bool) -> Exchange {
        let times = stages.coefficients.nodes * V::splat(stages.step);
        let inverse = V::splat(1.0 / stages.step);
        let start = &stages.start;
        let motion = Motion {
            displacement: &stages.displacement,
            rates: &start.rates,
            extensions: &start.applied.extensions,
            times,
            inverse,
            step: stages.step,
            since: self.time,
            coefficients: &stages.coefficients,
        };
        let (mut dissipated, mut work) = self.evaluate_scalars(&motion, place, end);
        for ball in &self.plan.balls {
            let vector = stages.rotation_vector(ball.first).times(place.moved);
            let tilt = Tilt::of(vector);
            let axes: [Vector<V>; 3] = std::array::from_fn(|axis| Vector::splat(&start.axes[ball.first + axis]));
            let mut turning = Vector::zero();
            for (axis, direction) in axes.iter().enumerate() {
                let freedom = ball.first + axis;
                turning = direction
                    .times_plus(motion.rate(place, stages.displacement[freedom], start.rates[freedom]), turning);
            }
            let spin = tilt.of_axis(turning);
            let mut torque = Vector::zero();
            for (axis, direction) in axes.iter().enumerate() {
                let rate = direction.dot(spin);
                let braking = rate * V::splat(ball.coefficients[axis]);
                let driving = V::splat(ball.efforts[axis] + ball.driven[axis]);
                torque = direction.times_plus(driving - braking, torque);
                dissipated = braking.mul_add(rate, dissipated);
                work = driving.mul_add(rate, work);
            }
            for (axis, direction) in axes.iter().enumerate() {
                let along = if end { *direction } else { tilt.of_axis(*direction) };
                self.efforts[ball.first + axis] = along.dot(torque);
            }
        }

        if !self.plan.lines.is_empty() || !self.plan.wrenches.is_empty() || !self.plan.on_bodies.is_empty() {
            self.wrenches.fill((Vector::zero(), Vector::zero()));
        }
        let springs =
            self.plan.lines.iter().zip(&start.applied.lines).map(|(line, known)| (line.ends, &line.law, known));
        dissipated = add_springs(stages, springs, &motion, place, &mut self.wrenches, dissipated);
        for (wrench, arm) in self.plan.wrenches.iter().zip(&start.applied.arms) {
            let pose = &stages.poses[wrench.body];
            let lever = stages.swing(wrench.body, arm).times_plus(place.moved, Vector::splat(arm));
            let (force, torque) = (Vector::splat(&wrench.force), Vector::splat(&wrench.torque));
            let sum = &mut self.wrenches[wrench.body];
            sum.0 = sum.0.plus(force);
            sum.1 = lever.cross_plus(force, sum.1.plus(torque));
            if account && wrench.torque != [0.0; 3] {
                let spin = Vector::splat(&start.bodies[wrench.body].spin);
                work = torque.dot_plus(angular_velocity(pose, spin, times, inverse, place), work);
            }
        }
        let holding = self.plan.holding.iter().zip(&start.applied.holding);
        work = add_holding(stages, holding, &self.plan.gravity, &motion, place, &mut self.efforts, work);
        let loads = self.plan.on_bodies.iter().zip(&start.applied.loads);
        (dissipated, work) = add_loads(stages, loads, &motion, place, &mut self.wrenches, (dissipated, work));
        if account {
            let [dissipated, work] = [dissipated, work].map(|power| (power * place.weights).sum());
            Exchange { dissipated, work, ..Exchange::default() }
        } else {
            Exchange::default()
        }
    }
}

impl<V: Lanes> BodiesAtStages<V> for Stages<V> {
    type Vector = Vector<V>;

    #[inline(always)]
    fn swing(&self, body: usize, arm: &[f64; 3]) -> Vector<V> {
        let pose = &self.poses[body];
        rotate_increment(pose.w, pose.u, Vector::splat(arm))
    }

    #[inline(always)]
    fn anchor(&self, body: usize) -> Vector<V> {
        self.poses[body].anchor
    }
}

impl<V: Lanes> LoadedBodies<V> for Stages<V> {
    type Torque = [f64; 3];

    #[inline(always)]
    fn torque(&self, body: usize, torque: &[f64; 3], turns: bool, place: &Place<V>) -> Vector<V> {
        let start = Vector::splat(torque);
        if turns { self.swing(body, torque).times_plus(place.moved, start) } else { start }
    }

    #[inline(always)]
    fn spin(&self, body: usize, motion: &Motion<V>, place: &Place<V>) -> Vector<V> {
        let spin = Vector::splat(&self.start.bodies[body].spin);
        angular_velocity(&self.poses[body], spin, motion.times, motion.inverse, place)
    }

    #[inline(always)]
    fn scaled(axial: Vector<V>, factor: V) -> Vector<V> {
        axial.times(factor)
    }

    #[inline(always)]
    fn sum(a: Vector<V>, b: Vector<V>) -> Vector<V> {
        a.plus(b)
    }

    #[inline(always)]
    fn along(a: Vector<V>, b: Vector<V>, start: V) -> V {
        a.dot_plus(b, start)
    }
}

/// `½ vee(Ω (1 + N)ᵀ − (1 + N) Ωᵀ)` with `Ω = ω̂₀ + h⁻¹ Σ_i (Ā B)_ji (N_i − h c_i ω̂₀)`: the angular velocity at the
/// places, exact where Ω (1 + N)ᵀ is skew.
#[inline(always)]
fn angular_velocity<V: Lanes>(
    pose: &StagePose<V>,
    start: Vector<V>,
    times: V,
    inverse: V,
    place: &Place<V>,
) -> Vector<V> {
    let turned = pose.turned();
    let turn = turned.matrix().times(place.moved);
    let mix = |value: V| value.mix(&place.velocity) * inverse;
    let ahead = start.times_minus(times, Vector(turned.vector));
    let rates = Turned { products: turned.products.map(mix), vector: ahead.0.map(mix) }.matrix();
    let rates = {
        // ω̂₀ joins the skew part.
        let ([[a, b, c], [d, e, f], [g, h, i]], [p, q, r]) = (rates.0, start.0);
        Matrix([[a, b - r, c + q], [d + r, e, f - p], [g - q, h + p, i]])
    };
    let (rows, turned_rows) = (rates.rows(), turn.rows());
    // Entry (i, j) of Ω (1 + N)ᵀ is row i of Ω against row j of 1 + N.
    let entry = |i: usize, j: usize| rows[i].dot_plus(turned_rows[j], rates.0[i][j]);
    let half = V::splat(0.5);
    Vector([(entry(2, 1) - entry(1, 2)) * half, (entry(0, 2) - entry(2, 0)) * half, (entry(1, 0) - entry(0, 1)) * half])
}
