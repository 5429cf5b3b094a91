//! The exact Newton method on the stage equations: residual of all bodies and closures, and the coupled solve.

use super::coupled::Coupled;
use super::lanes::Lanes;
use super::residual::body_residual;
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

    /// What all bodies and closures resist with, at the present displacements and multipliers.
    #[inline(always)]
    pub fn residual<const REFINED: bool>(&mut self, stages: &mut Stages<V>, gravity: &[f64; 3]) {
        stages.sweep_poses();
        stages.sweep_applied(false);
        let coupled = &mut self.coupled;
        coupled.move_bodies(stages);
        coupled.evaluate_closures();
        for (row, (&gap, (follower, leader, ratio))) in
            coupled.mimic_rows().zip(stages.start.mimic_gaps.iter().zip(&self.mimics))
        {
            let (follows, leads) = (stages.displacement[follower.freedom], stages.displacement[leader.freedom]);
            coupled.gaps[row] = leads.neg_mul_add(V::splat(*ratio), follows + V::splat(gap));
        }
        let columns = stages.coefficients.residual;
        let rest = stages.coefficients.residual_rest;
        let sweep = stages.residual_sweep(&columns, &rest, gravity);
        for (index, plan) in stages.plan.bodies.iter().enumerate() {
            let known = &stages.start.bodies[index];
            let (own, _) = body_residual::<V, false, REFINED>(&sweep, plan, known, &stages.poses[index]);
            let anchor = coupled.row_anchor(&stages.start, index);
            let (mut force, mut torque) = (own.force, own.torque);
            if let Some(applied) = &stages.applied {
                let wrench = applied.wrenches[index];
                let square = V::splat(stages.step * stages.step);
                force = wrench.0.times_minus(square, force);
                torque = wrench.1.times_minus(square, torque);
            }
            coupled.bias[index] = (force, anchor.cross_plus(force, torque));
        }
        if let Some(applied) = &stages.applied {
            for (scaled, effort) in coupled.efforts.iter_mut().zip(&applied.efforts) {
                *scaled = *effort * V::splat(stages.step * stages.step);
            }
        }
        coupled.step = stages.step;
        coupled.push();
    }

    /// The Newton step: fills the increments of the freedoms, advances the multipliers; returns the largest increment.
    #[inline(always)]
    pub fn solve(&mut self, stages: &mut Stages<V>) -> f64 {
        let coupled = &mut self.coupled;
        coupled.solve(&stages.plan, &stages.start, &stages.displacement, &mut stages.increment);
        coupled.advance_multipliers();
        let mut largest = V::zero();
        for increment in &stages.increment {
            largest = increment.max_abs(largest);
        }
        largest.largest()
    }
}
