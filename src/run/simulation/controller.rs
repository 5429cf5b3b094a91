//! A controller with a fixed period: it is given the state and returns efforts, at fixed instants.
//!
//! ```text
//!     t_k = t₀ + k T,   τ(t) = u(t_k, q_k, v_k)   for t_k ≤ t < t_{k+1}         T: the period (s)
//! ```
//!
//! Steps end at these instants exactly. The state there is the state of the end of a step, not of the dense output, whose order is lower. Between
//! them the efforts are constant. So every piece is smooth, and the order of the scheme is kept. A law that acts at every instant is a
//! [`ContinuousController`](crate::simulation::ContinuousController), or along one coordinate a
//! [`Motor`](crate::mechanism::description::nonsmooth::Motor).

use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;
use crate::simulation::input_error::InputError;
use crate::simulation::run::Simulation;
use crate::simulation::steps::course::RunError;
use crate::stepping::integrator::MethodError;

/// Computes the efforts of a run at fixed instants.
///
/// For a reproducible run the same state must give the same efforts.
pub trait Controller {
    /// How long efforts are held (s): greater than zero.
    fn period(&self) -> f64;

    /// The efforts from this state on, one entry per degree of freedom [N m or N]. Entries that are not written are zero.
    fn efforts(&mut self, mechanism: &Mechanism, state: &State, efforts: &mut [f64]);
}

/// Why a controlled run ended early.
#[derive(Debug, thiserror::Error)]
pub enum ControlError {
    /// The run failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The efforts are invalid.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The period is invalid.
    #[error("a controller's period of {0} s: give a finite time that is longer than zero")]
    Period(f64),
    /// The run cannot be made with other steps.
    #[error(transparent)]
    Method(#[from] MethodError),
    /// A continuous controller cannot control this degree of freedom.
    #[error(
        "a continuous controller drives degree of freedom {freedom} of {count}: name lengths and angles, each once, and no rotation of a ball joint"
    )]
    Freedom {
        /// The freedom, from 0.
        freedom: usize,
        /// The number of degrees of freedom.
        count: usize,
    },
    /// Islands of the run have already been integrated separately.
    #[error("independent parts of the mechanism already run separately; start the continuous controller with the run")]
    Begun,
}

impl Simulation<'_> {
    /// Makes steps to the end of the run under a controller, called now and after each of its periods.
    ///
    /// ```
    /// # use catena::mechanism::description::joint::{Joint, JointKind, Pose};
    /// # use catena::mechanism::description::mechanism::{Body, Mechanism};
    /// # use catena::mechanism::motion::state::State;
    /// # use catena::simulation::{Controller, Simulation, SimulationOptions, StepChoice};
    /// # use nalgebra::Vector3;
    /// /// Brakes a trolley in proportion to its speed, a hundred times a second.
    /// struct Brake;
    /// impl Controller for Brake {
    ///     fn period(&self) -> f64 {
    ///         0.01
    ///     }
    ///     fn efforts(&mut self, _: &Mechanism, state: &State, efforts: &mut [f64]) {
    ///         efforts[0] = -2.0 * state.velocity[0];
    ///     }
    /// }
    /// # let joint = Joint::new("rail", JointKind::Prismatic, Pose::identity(), Pose::identity());
    /// # let body = Body { name: "trolley".into(), parent: None, mass: 2.0, inertia: Vector3::repeat(0.1), joint };
    /// # let mechanism = Mechanism::new("rail", Vector3::zeros(), vec![body])?;
    /// let mut start = State::zero(&mechanism);
    /// start.velocity[0] = 1.0;
    /// let options = SimulationOptions::new(1.0, StepChoice::Tolerance(1e-9));
    /// let mut simulation = Simulation::new(&mechanism, start, options)?;
    /// simulation.run_under(&mut Brake)?;
    /// assert!((simulation.state().velocity[0] - 0.99_f64.powi(100)).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ControlError`]: the run fails, an effort is not finite, or the period is invalid.
    pub fn run_under(&mut self, controller: &mut dyn Controller) -> Result<(), ControlError> {
        let (begin, period) = (self.state().time, controller.period());
        if !(period > 0.0 && period.is_finite()) {
            return Err(ControlError::Period(period));
        }
        let mut efforts = vec![0.0; self.mechanism().velocity_count];
        self.together(|run| {
            for tick in 1_u64.. {
                if run.state().time >= run.end() {
                    break;
                }
                efforts.fill(0.0);
                controller.efforts(run.mechanism(), run.state(), &mut efforts);
                run.set_efforts(&efforts)?;
                run.step_to((begin + tick as f64 * period).min(run.end()))?;
            }
            Ok(())
        })
    }
}
