//! Limits of double precision: lengths of springs with an end far away, and the balance of energies far larger than the energies of the motion.
//!
//! ```text
//!     δ = ε max(ℓ, |P_a − x_a|, |P_b − x_b|)     (m)      of the ends of a spring, ε = 2⁻⁵²
//!     δV = 1e-12 V                               (J)      of stored energies V, over a run
//!     W = F 1e-12 m                              (J)      of what all forces push with, F (N; N m), over roundings of places
//! ```

use crate::mechanism::description::closure::Attachment;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::ground::words::rounded;
use crate::mechanism::motion::integrator::MethodDescription;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::simulation::Summary;

/// Changes of the energy by this part of it, and by what forces do over this distance (m), are rounding.
const ROUNDING: f64 = 1e-12;

/// A tolerance of at least this number of roundings of places takes no more steps than with springs nearby.
const ENOUGH: f64 = 100.0;

/// The spring whose ends are rounded most.
#[derive(Clone, Debug, PartialEq)]
pub struct FarSpring {
    name: String,
    /// Its length, or the length of an arm of it (m).
    distance: f64,
}

impl FarSpring {
    /// The farthest spring of a mechanism in a state; `None` without springs between points.
    pub(crate) fn of(mechanism: &Mechanism, state: &State) -> Option<Self> {
        let bodies = body_states(mechanism, state);
        let arm = |end: &Attachment| end.body.map_or(0.0, |_| end.frame.translation.vector.norm());
        let springs = mechanism.forces.point_springs.iter().map(|spring| FarSpring {
            name: spring.name.clone(),
            distance: spring.line(&bodies).length.max(arm(&spring.a)).max(arm(&spring.b)),
        });
        springs.max_by(|a, b| a.distance.total_cmp(&b.distance))
    }

    /// The rounding of its ends (m).
    pub(crate) fn rounding(&self) -> f64 {
        f64::EPSILON * self.distance
    }

    /// The warning of a rounding that exceeds the wanted accuracy (m).
    pub(crate) fn warning(&self, wanted: f64) -> Option<String> {
        let (FarSpring { name, distance }, rounding) = (self, self.rounding());
        (rounding > wanted).then(|| {
            format!(
                "spring {name:?} reaches {distance:.1e} m, where places are rounded by {rounding:.1e} m, so that an accuracy of {wanted:e} m \
                 cannot be reached; move its far end nearer, or use --tolerance {:.0e}",
                ENOUGH * rounding
            )
        })
    }
}

/// Whether the rounding of stored numbers explains the whole error of the energy balance of a run.
pub(super) fn is_energy_rounding(summary: &Summary) -> bool {
    stored_rounding(summary) || summary.max_relative_energy_error * summary.largest_kinetic <= ROUNDING * summary.pushes
}

/// Whether the rounding of stored energies alone explains it.
fn stored_rounding(summary: &Summary) -> bool {
    let rounding = ROUNDING * summary.initial_energy.total().abs().max(summary.final_energy.total().abs());
    summary.max_relative_energy_error * summary.largest_kinetic <= rounding
}

/// The work that may be missing in the balance of motors at an accuracy (J). Springs that are hardly stretched store little, yet a displacement by the accuracy
/// does work against them, and the efforts of their dampers oscillate in longer steps.
pub(super) fn displaced(summary: &Summary, wanted: f64) -> f64 {
    DISPLACED * wanted * summary.pulled
}

/// The warning of an energy that does not balance, or whose balance is unknown. Springs may store far more energy than a motion that creeps has; that is
/// said where there is a spring between points, because its end may be far away.
pub(crate) fn balance_warning(
    description: &MethodDescription,
    summary: &Summary,
    far: Option<&FarSpring>,
) -> Option<String> {
    let error = summary.max_relative_energy_error;
    if error > COARSE && is_energy_rounding(summary) {
        let (stored, kinetic) = (summary.initial_energy.total(), rounded(summary.largest_kinetic));
        if !stored_rounding(summary) {
            return Some(format!(
                "what forces of {} N do over roundings of places hides the energy of the motion, {kinetic} J: the energy balance says nothing of this \
                 run",
                rounded(summary.pushes)
            ));
        }
        let FarSpring { name, distance } = far?;
        return Some(format!(
            "rounding of the total energy, {stored:.1e} J, hides that of the motion, {kinetic} J: the energy balance says nothing of this run; \
             move the far end of spring {name:?} nearer, which is {distance:.1e} m long"
        ));
    }
    let is_displaced = |wanted: f64| summary.max_energy_error <= displaced(summary, wanted);
    if description.tolerance.is_some_and(is_displaced) { None } else { energy_warning(description, error) }
}

/// The work along displacements of this many times the accuracy may be missing in the balance.
const DISPLACED: f64 = 10.0;

/// Energy errors beyond this part of the kinetic energy are said to the user: a digit or two are right at best.
pub(crate) const COARSE: f64 = 1e-2;

/// The warning of an energy that does not balance.
pub fn energy_warning(description: &MethodDescription, relative_error: f64) -> Option<String> {
    // NaN does not balance either.
    if relative_error <= COARSE {
        return None;
    }
    let remedy =
        if description.adaptive { "a smaller --tolerance" } else { "a smaller --step, more --stages, or --tolerance" };
    if !relative_error.is_finite() {
        return Some(format!(
            "energies are beyond what a double holds, so nothing is known of the accuracy; use {remedy}"
        ));
    }
    Some(format!(
        "the energy balance is off by {} % of the largest kinetic energy: the steps are too long for this motion; use {remedy}",
        rounded(100.0 * relative_error)
    ))
}
