//! The exact Newton method on the stage equations in a plane: [`crate::coupled::newton`] with three equations a body.

use crate::coupled::newton::Mimics;
use crate::coupled::system::{Coupled, Geometry};
use crate::numbers::lanes::{Lanes, in_lanes};
use crate::planar::geometry::Flat;
use crate::planar::sweeps::{own_residual, row_turn};
use crate::planar::workspace::PlanarStages;
use crate::stages::coefficients::{Coefficients, moved_rows};
use crate::tableau::butcher::Tableau;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::structure::plane::Plane;

/// The exact Newton method for one mechanism in its plane, and a scheme.
pub(crate) struct PlanarNewton<V: Lanes> {
    coupled: Coupled<V>,
    flat: Flat<V>,
    mimics: Mimics,
}

impl<V: Lanes> PlanarNewton<V> {
    /// The workspace.
    pub fn new(mechanism: &Mechanism, plane: &Plane, tableau: &Tableau) -> Self {
        let flat = Flat::new(mechanism, plane, moved_rows(tableau.stages - 1), true);
        PlanarNewton { coupled: Coupled::of_stages(mechanism, &flat, tableau), flat, mimics: Mimics::new(mechanism) }
    }

    /// Takes the start of a step.
    pub fn begin(&mut self, stages: &PlanarStages<V>) {
        self.flat.begin(&stages.plan, &stages.start);
        self.coupled.begin();
    }

    /// One iteration: fills the increments of the freedoms, advances the multipliers; returns the largest increment.
    pub fn iterate(&mut self, stages: &mut PlanarStages<V>, coefficients: &Coefficients<V>) -> f64 {
        let PlanarNewton { coupled, flat, mimics } = self;
        in_lanes!(V, {
            residual(coupled, flat, stages, coefficients);
            coupled.evaluate(flat);
        });
        mimics.gaps(coupled, &stages.start.mimic_gaps, &stages.displacement);
        coupled.step = stages.step;
        in_lanes!(V, coupled.push());
        coupled.solve(flat, &stages.plan, &stages.start, &[], &mut stages.increment);
        in_lanes!(V, coupled.advance_multipliers());
        in_lanes!(V, stages.largest_increment())
    }
}

/// Where all bodies are at the present displacements, and what they resist with there; always with all digits of the coefficients.
#[inline(always)]
fn residual<V: Lanes>(
    coupled: &mut Coupled<V>,
    flat: &mut Flat<V>,
    stages: &mut PlanarStages<V>,
    coefficients: &Coefficients<V>,
) {
    let gravity = stages.plan.gravity;
    let sweep = coefficients.residual_sweep(stages.step, &gravity);
    stages.sweep_paths::<false, true>(&sweep);
    // Forces between bodies need the anchors, too, and look where they are themselves.
    if stages.plan.forces.is_empty() {
        stages.sweep_anchors();
    }
    if stages.applied.is_some() {
        stages.sweep_applied(coefficients, false);
    }
    flat.move_bodies(stages);
    let square = sweep.forces;
    for (index, known) in stages.start.bodies.iter().enumerate() {
        let turned = &stages.turned[index];
        let (_, mut force, mut torque) = own_residual(known, turned, row_turn::<V, false>(&sweep, turned));
        if let Some((pull, turn)) = stages.acting.get(index) {
            force = pull.times_minus(square, force);
            torque = turn.neg_mul_add(square, torque);
        }
        let anchor = flat.anchor(&stages.start, index, 1);
        let ([x, y], zero) = (force.0, V::zero());
        coupled.bias[index] = [x, y, anchor.cross_plus(force, torque), zero, zero, zero];
    }
    if let Some(applied) = &stages.applied {
        for (scaled, &effort) in coupled.efforts.iter_mut().zip(&applied.efforts) {
            *scaled = effort * square;
        }
    }
}
