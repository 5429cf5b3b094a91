//! A program acts on a run: efforts on its joints, and targets of its motors, from now on.

use crate::simulation::input_error::InputError;
use crate::simulation::integrators::Integrators;
use crate::simulation::run::Simulation;

impl Simulation<'_> {
    /// Efforts on the joints from now on, besides the forces of the mechanism: one entry a degree of freedom [N m or N].
    ///
    /// # Errors
    /// [`InputError`] for another number of efforts and for what is not finite.
    pub fn set_efforts(&mut self, efforts: &[f64]) -> Result<(), InputError> {
        let wanted = self.mechanism.velocity_count;
        if efforts.len() != wanted {
            return Err(InputError::Count { given: efforts.len(), wanted });
        }
        if let Some(freedom) = efforts.iter().position(|effort| !effort.is_finite()) {
            let joint = self.mechanism.joint_of_freedom(freedom).to_string();
            return Err(InputError::NotFinite { joint, effort: efforts[freedom] });
        }
        self.efforts.clear();
        self.efforts.extend_from_slice(efforts);
        Ok(())
    }

    /// Gives a motor of the mechanism a target from now on, until it is given another: rad or m, rad/s or m/s, N m or N. A motor that works out its
    /// effort at ticks sees it at the next tick.
    ///
    /// # Errors
    /// [`InputError`] for a motor that does not exist and for what is not finite.
    pub fn set_target(&mut self, motor: usize, value: f64) -> Result<(), InputError> {
        let motors = &self.mechanism.nonsmooth.motors;
        let Some(driven) = motors.get(motor) else {
            return Err(InputError::NoMotor { motor, count: motors.len() });
        };
        let freedom = driven.coordinate.freedom;
        if !value.is_finite() {
            let joint = self.mechanism.joint_of_freedom(freedom).to_string();
            return Err(InputError::Target { joint, target: value });
        }
        self.settle();
        self.known_start.forget();
        match &mut self.integrators {
            Integrators::Whole(making) => making.aim(motor, value),
            Integrators::Islands { islands, .. } => islands.aim(freedom, value),
        }
        Ok(())
    }
}
