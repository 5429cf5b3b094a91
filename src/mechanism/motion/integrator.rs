//! The trait of integrators: they make steps, fail with a reason, and give the state at any instant of their last step.

use crate::description::body_state::BodyState;
use crate::description::mechanism::Mechanism;
use crate::forces::total::Exchange;
use crate::motion::contact_point::ContactPoint;
pub use crate::motion::contact_solvers::{ContactSolver, ContactSolvers};
pub use crate::motion::cost::{Cost, Rejected, Rejections};
use crate::motion::event::{Event, JointStatus};
use crate::motion::inputs::Inputs;
use crate::motion::state::State;
pub use crate::motion::step_error::StepError;

/// Properties of an integrator and its steps so far, for reports and logs.
#[derive(Clone, Debug, PartialEq)]
pub struct MethodDescription {
    /// Short name: `lobatto`, `dop853`, `rk4`, `euler`.
    pub name: String,
    /// Number of stages of the scheme.
    pub stages: usize,
    /// Order of convergence.
    pub order: usize,
    /// The fixed step, or the mean accepted step of an adaptive run (s).
    pub step: f64,
    /// Whether the step is chosen from a tolerance.
    pub adaptive: bool,
    /// The tolerance the step is chosen from.
    pub tolerance: Option<f64>,
    /// The nearest that any step came to the limit of linear stability, as far as it was looked at.
    pub frequency_step: Option<FrequencyStep>,
    /// The first step that was too long to stop a motion that dampers stop.
    pub ringing: Option<Ringing>,
    /// The position at which the closures were nearest to a loss of rank, as far as ends of steps show it.
    pub singular: Option<SingularPosition>,
    /// Decimal digits that steps are solved to: 16, or 32.
    pub digits: u32,
    /// How often the symmetry of reversible steps was broken; `None` for steps that are not.
    pub reversible_resets: Option<usize>,
    /// How often the law of contact could not be solved to its accuracy at an event; the run went on with the best that was found.
    pub unsolved_contacts: usize,
    /// How often each contact solver has solved a problem of an event.
    pub contact_solvers: ContactSolvers,
    /// Steps of first order where exact steps cost too much or could not be made, and the time that they took of the motion (s).
    pub first_order_steps: usize,
    pub first_order_time: f64,
    /// How long bodies slept in them: the mean over all bodies (s).
    pub first_order_asleep: f64,
    /// The largest residual of the law of contact in them, as a part of the largest impulse, and the largest overlap that was moved apart (m).
    pub first_order_residual: f64,
    pub first_order_lift: f64,
    /// Steps of second order where slips changed so often that exact steps were dear, and the time that they took of the motion (s).
    pub over_slips_steps: usize,
    pub over_slips_time: f64,
    /// Steps with three stages or five, in spans between given instants that are short beside the steps of the method.
    pub few_stage_steps: usize,
    /// Number of rebounds left out there and in crowds of impacts, and the energy that they would have given back (J).
    pub rebounds_left_out: usize,
    pub rebounds_energy: f64,
}

impl MethodDescription {
    /// A method with steps of `step` seconds and 16 digits, and without other properties.
    pub fn fixed(name: &str, stages: usize, order: usize, step: f64) -> Self {
        MethodDescription {
            name: name.to_string(),
            stages,
            order,
            step,
            adaptive: false,
            tolerance: None,
            frequency_step: None,
            ringing: None,
            singular: None,
            digits: 16,
            reversible_resets: None,
            unsolved_contacts: 0,
            contact_solvers: ContactSolvers::default(),
            first_order_steps: 0,
            first_order_time: 0.0,
            first_order_asleep: 0.0,
            first_order_residual: 0.0,
            first_order_lift: 0.0,
            over_slips_steps: 0,
            over_slips_time: 0.0,
            few_stage_steps: 0,
            rebounds_left_out: 0,
            rebounds_energy: 0.0,
        }
    }

    /// Takes over the stability figures of another part of the run: the step nearest to its limit, and the first ringing.
    pub fn include_stability(&mut self, other: &MethodDescription) {
        let share = |seen: &FrequencyStep| seen.product / seen.limit;
        let seen = self.frequency_step.into_iter().chain(other.frequency_step);
        self.frequency_step = seen.max_by(|a, b| share(a).total_cmp(&share(b)));
        let heard = self.ringing.into_iter().chain(other.ringing);
        self.ringing = heard.min_by(|a, b| a.time.total_cmp(&b.time));
    }
}

/// An end of a step within about a milliradian of a singular position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SingularPosition {
    /// When (s).
    pub time: f64,
    /// How many more equations are redundant there than elsewhere in the run.
    pub extra: usize,
}

/// A motion that dampers stop, in a step that leaves most of it: it rings on, from step to step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ringing {
    /// How fast they stop it [1/s].
    pub decay: f64,
    /// The step (s).
    pub step: f64,
    /// About the longest step that stops it (s).
    pub longest: f64,
    /// When (s).
    pub time: f64,
}

/// The nearest that a run has come to the limit of stability, or the first step beyond it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrequencyStep {
    /// `h ω`: step times frequency of the fastest mode.
    pub product: f64,
    /// The product at which the scheme becomes unstable.
    pub limit: f64,
    /// The step (s).
    pub step: f64,
    /// When (s).
    pub time: f64,
}

impl FrequencyStep {
    /// Whether a step was beyond the limit.
    pub fn is_unstable(&self) -> bool {
        self.product > self.limit
    }

    /// The longest stable step at this time (s); infinite without stiff forces.
    pub fn longest(&self) -> f64 {
        self.step * self.limit / self.product
    }
}

/// One accepted step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepOutcome {
    /// Length of the step (s).
    pub step: f64,
    /// The work for it, with the work of attempts that were thrown away.
    pub cost: Cost,
    /// Whether the stage equations were solved by the exact Newton method, with all stages coupled.
    pub exact: bool,
    /// Energy dissipated in the step, and work put into the mechanism (J).
    pub exchange: Exchange,
}

impl StepOutcome {
    /// A step of this length (s) after this number of iterations, without rejected attempts.
    pub fn new(step: f64, iterations: usize, exchange: Exchange) -> Self {
        StepOutcome { step, cost: Cost::of(iterations), exchange, exact: false }
    }

    /// Takes the outcome of the same step, made again; the work for both counts.
    pub fn take_again(&mut self, again: &StepOutcome) {
        let cost = self.cost;
        *self = *again;
        self.cost.add(&cost);
    }
}

/// A way of advancing the state of a mechanism.
pub trait Integrator {
    /// Makes one step under these inputs that ends at or before `until`, and exactly at `until` if the step reaches it.
    ///
    /// `mechanism` and `inputs` have the forces of this step: forces and gravity may change from step to step.
    ///
    /// # Errors
    /// [`StepError`] if no step could be made; the state is then the end of the last accepted step.
    fn step(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        until: f64,
    ) -> Result<StepOutcome, StepError>;

    /// [`Integrator::step`] of a mechanism without inputs.
    ///
    /// # Errors
    /// As of [`Integrator::step`].
    fn advance(&mut self, mechanism: &Mechanism, state: &mut State, until: f64) -> Result<StepOutcome, StepError> {
        self.step(mechanism, Inputs::NONE, state, until)
    }

    /// The cost of steps that failed since this was asked last: no outcome has it.
    fn take_abandoned(&mut self) -> Cost {
        Cost::default()
    }

    /// Positions and velocities at a `time` inside the last step, from its dense output.
    fn dense(&mut self, mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]);

    /// Poses and velocities of all bodies at the end of the last step, where the step has placed them.
    fn bodies(&self) -> Option<&[BodyState]> {
        None
    }

    /// Whether the steps so far were too coarse for the accuracy that is wanted of the run: the caller begins it again with finer ones.
    fn begins_again(&self) -> bool {
        false
    }

    /// Properties of this integrator.
    fn description(&self) -> MethodDescription;

    /// Hands over the events since this was asked last, in order of time. A smooth motion has no events.
    fn take_events(&mut self, _events: &mut Vec<Event>) {}

    /// The state of a body's joint, if the mechanism has limits, dry friction or motors.
    fn joint_status(&self, _mechanism: &Mechanism, _state: &State, _body: usize) -> JointStatus {
        JointStatus::default()
    }

    /// Adds the closed contacts to `out`, in a state of the last step: at its end, or inside it from [`Integrator::dense`]. Without pairs of shapes
    /// that may touch, this does nothing.
    fn contacts(&self, _mechanism: &Mechanism, _state: &State, _out: &mut Vec<ContactPoint>) {}

    /// Adds the efforts that sampled motors hold [N m or N], inside the last step or from its end on: an entry a motor of the mechanism, `None` for
    /// continuous ones and before the first step.
    fn held_efforts(&self, _inside: bool, _out: &mut Vec<Option<f64>>) {}
}
