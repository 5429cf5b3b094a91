//! A controller that acts at every instant: a law of time and state with its derivatives, part of the equations of every step.
//!
//! ```text
//!     τ(t) = u(t, q, v)         along m of n degrees of freedom [N m or N]
//! ```
//!
//! The efforts are those at each stage, so the order of the scheme is kept. Newton's matrix contains their derivatives and the mass matrix of the
//! whole mechanism, so stiff gains cost iterations, not steps ([`Feedback`]). A controller that acts at fixed instants is a
//! [`Controller`](crate::simulation::Controller).

use crate::instant::dynamics::response::Response;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::forces::total::scalar_coordinate;
use crate::mechanism::motion::inputs::Feedback;
use crate::mechanism::motion::state::State;
use crate::simulation::controller::ControlError;
use crate::simulation::run::Simulation;
use nalgebra::DMatrix;
use std::cell::RefCell;

/// Computes the efforts of a run at every instant.
///
/// The same state must give the same efforts. The states are those at stages, also of steps that are rejected later.
pub trait ContinuousController {
    /// The degrees of freedom that it controls, each once: coordinates of lengths and angles, not the rotations of ball joints.
    fn freedoms(&self, mechanism: &Mechanism) -> Vec<usize>;

    /// The efforts along these freedoms in a state with its time [N m or N] (m). Entries that are not written are zero.
    fn efforts(&self, mechanism: &Mechanism, state: &State, efforts: &mut [f64]);

    /// The derivatives of the efforts with respect to positions and to velocities (m × n each): one column per degree of freedom. Columns of ball
    /// joints belong to rotations about their axes. Entries that are not written are zero. Inaccurate derivatives cost iterations. Without
    /// derivatives steps converge only if the gains are small, and are shortened otherwise.
    fn derivatives(
        &self,
        mechanism: &Mechanism,
        state: &State,
        by_position: &mut DMatrix<f64>,
        by_velocity: &mut DMatrix<f64>,
    );
}

/// The law of a controller on one mechanism, with a workspace for its results.
struct Law<'l> {
    mechanism: &'l Mechanism,
    controller: &'l dyn ContinuousController,
    freedoms: Vec<usize>,
    response: RefCell<Response>,
}

impl Feedback for Law<'_> {
    fn freedoms(&self) -> &[usize] {
        &self.freedoms
    }

    fn efforts(&self, state: &State, efforts: &mut [f64]) {
        efforts.fill(0.0);
        self.controller.efforts(self.mechanism, state, efforts);
    }

    fn derivatives(&self, state: &State, by_position: &mut DMatrix<f64>, by_rate: &mut DMatrix<f64>) {
        self.controller.derivatives(self.mechanism, state, by_position, by_rate);
    }

    fn mobility(&self, state: &State) -> DMatrix<f64> {
        self.response.borrow_mut().matrix(state, &self.freedoms).0
    }
}

impl Simulation<'_> {
    /// Makes steps to the end of the run under a controller that acts at every instant.
    ///
    /// Limits, dry friction, motors and contacts act as in every run. While everything is held, a release by the controller of less than a fifth of a
    /// millisecond may be missed. Here a tolerance is the tolerance of single steps, because the motion beside a run has no controller.
    ///
    /// ```
    /// # use catena::mechanism::description::joint::{Joint, JointKind, Pose};
    /// # use catena::mechanism::description::mechanism::{Body, Mechanism};
    /// # use catena::mechanism::motion::state::State;
    /// # use catena::simulation::{ContinuousController, Simulation, SimulationOptions, StepChoice};
    /// # use nalgebra::{DMatrix, Vector3};
    /// /// Brakes a trolley in proportion to its speed.
    /// struct Brake;
    /// impl ContinuousController for Brake {
    ///     fn freedoms(&self, _: &Mechanism) -> Vec<usize> {
    ///         vec![0]
    ///     }
    ///     fn efforts(&self, _: &Mechanism, state: &State, efforts: &mut [f64]) {
    ///         efforts[0] = -2.0 * state.velocity[0];
    ///     }
    ///     fn derivatives(&self, _: &Mechanism, _: &State, _: &mut DMatrix<f64>, by_velocity: &mut DMatrix<f64>) {
    ///         by_velocity[(0, 0)] = -2.0;
    ///     }
    /// }
    /// # let joint = Joint::new("rail", JointKind::Prismatic, Pose::identity(), Pose::identity());
    /// # let body = Body { name: "trolley".into(), parent: None, mass: 2.0, inertia: Vector3::repeat(0.1), joint };
    /// # let mechanism = Mechanism::new("rail", Vector3::zeros(), vec![body])?;
    /// let mut start = State::zero(&mechanism);
    /// start.velocity[0] = 1.0;
    /// let options = SimulationOptions::new(1.0, StepChoice::Fixed { stages: 9, step: 0.25 });
    /// let mut simulation = Simulation::new(&mechanism, start, options)?;
    /// simulation.run_under_continuous(&Brake)?;
    /// assert!((simulation.state().velocity[0] - (-1.0_f64).exp()).abs() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ControlError`]: the run fails, a freedom cannot be controlled, or a run of several islands has begun.
    pub fn run_under_continuous(&mut self, controller: &dyn ContinuousController) -> Result<(), ControlError> {
        let held = self.mechanism.clone();
        let mechanism: &Mechanism = &held;
        let freedoms = controller.freedoms(mechanism);
        for (place, &freedom) in freedoms.iter().enumerate() {
            let once = !freedoms[..place].contains(&freedom);
            if freedom >= mechanism.velocity_count || scalar_coordinate(mechanism, freedom).is_none() || !once {
                return Err(ControlError::Freedom { freedom, count: mechanism.velocity_count });
            }
        }
        let law = Law { mechanism, controller, freedoms, response: RefCell::new(Response::new(mechanism)) };
        // The efforts may connect islands.
        if !self.join_islands()? {
            return Err(ControlError::Begun);
        }
        Ok(self.run_with_feedback(&law)?)
    }
}
