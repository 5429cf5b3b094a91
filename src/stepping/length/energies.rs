//! Energies at the end of a step, and the sizes of the forces, which bound roundings of energies.

use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::state::State;

/// Energies at the end of a finished step (J).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Energies {
    /// Change of the total energy over the step, without dissipation and work.
    pub change: f64,
    /// Kinetic energy at the end.
    pub kinetic: f64,
    /// Size of the potential energies at the end.
    pub potential: f64,
    /// Sum of the efforts of joint springs at the end [N m or N], and of their stiffness [N m/rad or N/m]: springs of motors that follow their laws.
    /// Zero without motors.
    pub pull: (f64, f64),
    /// Sum of the sizes of all forces on a mechanism with closures [N or N m]; zero without closures, because the joints of trees hold to rounding
    /// whatever the iteration leaves.
    pub pushes: f64,
    /// Sum of the coefficients of joint dampers [N m s/rad or N s/m]; zero with closures, which are solved further than trees.
    pub damping: f64,
}

/// Sums of the efforts of joint springs in a state, and of their stiffness.
pub(crate) fn pull(mechanism: &Mechanism, state: &State) -> (f64, f64) {
    mechanism.forces.joint_springs.iter().fold((0.0, 0.0), |(pull, stiffness), spring| {
        (pull + spring.effort(state.position[spring.coordinate.position]).abs(), stiffness + spring.stiffness)
    })
}
