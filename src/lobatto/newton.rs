//! The exact Newton method on the stage equations: residual of all bodies and closures, and the coupled solve.

use super::coupled::Coupled;
use super::lanes::{Lanes, in_lanes};
use super::residual::{Sweep, body_residual};
use super::stage::Stages;
use crate::model::{Coordinate, Mechanism};

/// The exact Newton method for one mechanism and scheme.
pub struct Newton<V: Lanes> {
    coupled: Coupled<V>,
    /// Follower, leader and ratio of every mimic.
    mimics: Vec<(Coordinate, Coordinate, f64)>,
}

impl<V: Lanes> Newton<V> {
    /// The workspace.
    pub fn new(mechanism: &Mechanism, tableau: &super::tableau::Tableau) -> Self {
        let mimics = mechanism.mimics.iter().map(|mimic| (mimic.follower, mimic.leader, mimic.multiplier));
        Newton { coupled: Coupled::of_stages(mechanism, tableau), mimics: mimics.collect() }
    }

    /// Takes the start of a step.
    pub fn begin(&mut self, stages: &Stages<V>) {
        self.coupled.begin(&stages.start);
    }

    /// Where all bodies and closures are at the present displacements, and the forces there.
    pub fn take_geometry(&mut self, stages: &mut Stages<V>) {
        in_lanes!(V, stages.sweep_poses());
        if stages.applied.is_some() {
            in_lanes!(V, stages.sweep_applied(false));
        }
        let coupled = &mut self.coupled;
        in_lanes!(V, coupled.move_bodies(stages));
        in_lanes!(V, coupled.evaluate_closures());
        for (row, (&gap, (follower, leader, ratio))) in
            coupled.mimic_rows().zip(stages.start.mimic_gaps.iter().zip(&self.mimics))
        {
            let (follows, leads) = (stages.displacement[follower.freedom], stages.displacement[leader.freedom]);
            coupled.gaps[row] = leads.neg_mul_add(V::splat(*ratio), follows + V::splat(gap));
        }
    }

    /// What all bodies resist with there, after [`Newton::take_geometry`]; always with all digits of the coefficients.
    #[inline(always)]
    pub fn residual(&mut self, stages: &mut Stages<V>, gravity: &[f64; 3]) {
        let coupled = &mut self.coupled;
        let columns = stages.coefficients.residual;
        let rest = stages.coefficients.residual_rest;
        let sweep = Sweep::of_residual(&stages.coefficients, &columns, &rest, stages.step, gravity);
        let square = V::splat(stages.step * stages.step);
        for (index, plan) in stages.plan.bodies.iter().enumerate() {
            let known = &stages.start.bodies[index];
            let (own, _) = body_residual::<V, false, true>(&sweep, plan, known, &stages.poses[index]);
            let anchor = coupled.row_anchor(&stages.start, index);
            let (mut force, mut torque) = (own.force, own.torque);
            if let Some(applied) = &stages.applied {
                let wrench = applied.wrenches[index];
                force = wrench.0.times_minus(square, force);
                torque = wrench.1.times_minus(square, torque);
            }
            coupled.bias[index] = (force, anchor.cross_plus(force, torque));
        }
        if let Some(applied) = &stages.applied {
            for (index, effort) in applied.efforts.iter().enumerate() {
                coupled.efforts[index] = *effort * square;
            }
        }
        coupled.step = stages.step;
    }

    /// The Newton step: fills the increments of the freedoms, advances the multipliers; returns the largest increment.
    pub fn solve(&mut self, stages: &mut Stages<V>) -> f64 {
        let coupled = &mut self.coupled;
        in_lanes!(V, coupled.push());
        coupled.solve(&stages.plan, &stages.start, &stages.displacement, &mut stages.increment);
        in_lanes!(V, coupled.advance_multipliers());
        in_lanes!(V, stages.largest_increment())
    }
}
