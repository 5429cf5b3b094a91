//! The exact Newton method on the stage equations: residual of all bodies and closures, and the coupled solve.

use crate::coupled::space::{Space, joined};
use crate::coupled::system::{Coupled, Geometry};
use crate::equations::residual::residual_of;
use crate::numbers::lanes::{Lanes, in_lanes};
use crate::stages::coefficients::moved_rows;
use crate::stages::row_geometry::RowGeometry;
use crate::stages::rows::Rows;
use crate::stages::workspace::Stages;
use catena_mechanism::description::closure::Coordinate;
use catena_mechanism::description::mechanism::Mechanism;

/// The exact Newton method for one mechanism and scheme.
pub struct Newton<V: Lanes> {
    coupled: Coupled<V>,
    space: Space<V>,
    mimics: Mimics,
}

impl<V: Lanes> Newton<V> {
    /// The workspace.
    pub fn new(mechanism: &Mechanism, tableau: &crate::tableau::butcher::Tableau) -> Self {
        let space = Space::new(mechanism, moved_rows(tableau.stages - 1), true);
        Newton { coupled: Coupled::of_stages(mechanism, &space, tableau), space, mimics: Mimics::new(mechanism) }
    }

    /// Takes the start of a step.
    pub fn begin(&mut self, stages: &Stages<V>) {
        self.space.begin(&stages.plan, &stages.start);
        self.coupled.begin();
    }

    /// Where all bodies and closures are at the present displacements, and the forces there.
    pub fn take_geometry(&mut self, stages: &mut Stages<V>) {
        in_lanes!(V, stages.sweep_poses());
        if stages.applied.is_some() {
            in_lanes!(V, stages.sweep_applied(false));
        }
        let Newton { coupled, space, mimics } = self;
        in_lanes!(V, space.move_bodies(stages));
        in_lanes!(V, coupled.evaluate(space));
        mimics.gaps(coupled, &stages.start.mimic_gaps, &stages.displacement);
    }

    /// What all bodies resist with there, after [`Newton::take_geometry`]; always with all digits of the coefficients.
    #[inline(always)]
    pub fn residual(&mut self, stages: &mut Stages<V>, gravity: &[f64; 3]) {
        let Newton { coupled, space, .. } = self;
        let square = V::splat(stages.step * stages.step);
        let (_, rows, _) = stages.rows::<true, true>(gravity);
        for (index, plan) in rows.plan.bodies.iter().enumerate() {
            let known = &rows.start.bodies[index];
            let own = residual_of(&rows, index, plan, known, &RowGeometry::new(&rows, index, known));
            let anchor = space.anchor(rows.start, index, 1);
            let (mut force, mut torque) = (own.force, own.torque);
            if let Some(wrench) = rows.wrench(index) {
                force = wrench.0.times_minus(square, force);
                torque = wrench.1.times_minus(square, torque);
            }
            coupled.bias[index] = joined(force, anchor.cross_plus(force, torque));
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
        let Newton { coupled, space, .. } = self;
        in_lanes!(V, coupled.push());
        coupled.solve(space, &stages.plan, &stages.start, &stages.displacement, &mut stages.increment);
        in_lanes!(V, coupled.advance_multipliers());
        in_lanes!(V, stages.largest_increment())
    }
}

/// Follower, leader and ratio of every mimic.
pub(crate) struct Mimics(Vec<(Coordinate, Coordinate, f64)>);

impl Mimics {
    /// Those of a mechanism.
    pub fn new(mechanism: &Mechanism) -> Self {
        let mimics = mechanism.mimics.iter().map(|mimic| (mimic.follower, mimic.leader, mimic.multiplier));
        Mimics(mimics.collect())
    }

    /// Their gaps at all stages, from those at the start of the step and the displacements since.
    pub fn gaps<V: Lanes>(&self, coupled: &mut Coupled<V>, start: &[f64], displacement: &[V]) {
        for (row, (&gap, (follower, leader, ratio))) in coupled.mimic_rows().zip(start.iter().zip(&self.0)) {
            let (follows, leads) = (displacement[follower.freedom], displacement[leader.freedom]);
            coupled.gaps[row] = leads.neg_mul_add(V::splat(*ratio), follows + V::splat(gap));
        }
    }
}
