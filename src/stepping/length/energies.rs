//! Energies at the end of a step, and the sizes of what acts, by which roundings of energies are told.

use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::state::State;

/// Energies at the end of a finished step (J).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Energies {
    /// Change of the total energy over the step, but for what was dissipated and put in.
    pub change: f64,
    /// Kinetic energy at the end.
    pub kinetic: f64,
    /// Size of the potential energies at the end.
    pub potential: f64,
    /// What joint springs pull with at the end, added up [N m or N], and their stiffness [N m/rad or N/m]: of motors that follow their laws. Zero
    /// where nothing is driven.
    pub pull: (f64, f64),
    /// What all forces on a mechanism with closures push with, added up [N or N m]; zero without closures, where joints hold to rounding whatever the
    /// iteration leaves.
    pub pushes: f64,
}

/// What joint springs pull with in a state, and their stiffness, added up.
pub(crate) fn pull(mechanism: &Mechanism, state: &State) -> (f64, f64) {
    mechanism.forces.joint_springs.iter().fold((0.0, 0.0), |(pull, stiffness), spring| {
        (pull + spring.effort(state.position[spring.coordinate.position]).abs(), stiffness + spring.stiffness)
    })
}
