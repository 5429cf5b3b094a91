//! The integrator: a sequence of steps of the scheme.
//!
//! A step is made, judged and kept in [`crate::length::stepper`]; how long it is comes from [`crate::length::fixed`], [`crate::length::control`] or
//! [`crate::length::reversible`].

use crate::length::companion::Companion;
use crate::length::control::Control;
use crate::length::fixed::FixedSteps;
use crate::length::reversible::Reversible;
use crate::length::span::Beginning;
use crate::length::stepper::Stepper;
use crate::step_maker::{StepFigures, StepMaker, StepPace};
use catena_kernels::{precise_step_for, step_for};
use catena_lobatto::numbers::lanes::Isa;
use catena_mechanism::description::body_state::BodyState;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::description::rules::Rule;
use catena_mechanism::motion::distance::{probes, probes_of_bodies};
use catena_mechanism::motion::inputs::Inputs;
use catena_mechanism::motion::integrator::{
    ContactSolvers, Cost, Integrator, MethodDescription, StepError, StepOutcome,
};
use catena_mechanism::motion::state::State;
use nalgebra::Vector3;

mod methods;

pub use methods::MethodError;

/// The constrained Lobatto IIIA–IIIB scheme as an [`Integrator`].
///
/// ```
/// use catena_stepping::integrator::Lobatto;
/// use catena_mechanism::description::mechanism::{Body, Mechanism};
/// use catena_mechanism::description::joint::{Joint, JointKind, Pose};
/// use catena_mechanism::motion::integrator::Integrator;
/// use catena_mechanism::motion::state::State;
/// use nalgebra::{Translation3, Vector3};
///
/// // A rod of 1 m and 1 kg on a hinge, released from the horizontal.
/// let hinge = Joint::new("hinge", JointKind::Revolute, Pose::identity(), Translation3::new(-0.5, 0.0, 0.0).into());
/// let rod = Body { name: "rod".into(), parent: None, mass: 1.0, inertia: Vector3::new(0.0, 1.0 / 12.0, 1.0 / 12.0), joint: hinge };
/// let mechanism = Mechanism::new("pendulum", Vector3::new(0.0, -9.81, 0.0), vec![rod])?;
/// let mut state = State::zero(&mechanism);
/// let mut lobatto = Lobatto::fixed(&mechanism, 9, 0.1)?;
/// while state.time < 1.0 {
///     lobatto.advance(&mechanism, &mut state, 1.0)?;
/// }
/// let energy = 0.5 / 3.0 * state.velocity[0].powi(2) + 0.5 * 9.81 * state.position[0].sin();
/// assert!(energy.abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Lobatto {
    stepper: Stepper,
    mode: Mode,
    isa: Isa,
    /// Whether steps are solved to 32 digits.
    precise: bool,
    /// Disabled simplification rules.
    kept: Vec<Rule>,
}

/// How the lengths of the steps come about.
#[derive(Clone)]
enum Mode {
    Fixed(FixedSteps),
    Chosen(Box<Control>),
    Reversible(Reversible),
}

impl Lobatto {
    /// The companion of the run.
    pub fn companion(&self) -> Option<&Companion> {
        self.stepper.companion.as_deref()
    }
}

impl StepMaker for Lobatto {
    fn figures(&self) -> StepFigures {
        let (between, held_by_stability) = match &self.mode {
            Mode::Chosen(control) => (control.between(), control.was_held()),
            Mode::Fixed(_) | Mode::Reversible(_) => (None, false),
        };
        StepFigures { between, ringing: self.stepper.ringing_inside(), held_by_stability }
    }

    /// Chosen steps of trees: the companion has their errors removed.
    fn accompany(&mut self, mechanism: &Mechanism) -> bool {
        if mechanism.has_closures() {
            return false;
        }
        self.stepper.companion = Some(Box::new(Companion::new(mechanism, self.stepper.tableau)));
        true
    }

    fn leave_companion(&mut self) {
        self.stepper.companion = None;
    }

    fn place_companion(&self, state: &mut State) -> bool {
        let Some(companion) = self.companion() else { return false };
        state.copy_from(companion.state());
        true
    }

    fn companion_probes(&self, mechanism: &Mechanism, _state: &State) -> Option<Vec<Vector3<f64>>> {
        let companion = self.companion()?;
        // The kernel has placed its bodies, if it has made a step.
        let placed = if companion.has_begun() { self.stepper.kernel.carried_bodies() } else { None };
        Some(placed.map_or_else(|| probes(mechanism, companion.state()), |bodies| probes_of_bodies(mechanism, bodies)))
    }
}

/// Requests of the location of events to the steps.
impl Lobatto {
    /// Makes the last step again from its start with another length (s), near the first, solved to rounding: moves `state` to the new end. The inputs
    /// are the inputs of the step.
    ///
    /// # Errors
    /// [`StepError`] where the equations cannot be solved; the state is then the start of the step.
    pub fn again(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        length: f64,
    ) -> Result<StepOutcome, StepError> {
        let driven = self.stepper.driven();
        let since = self.stepper.origin().time;
        self.stepper.kernel.clock(since);
        self.stepper.again(driven.as_deref().unwrap_or(mechanism), inputs, state, length)
    }

    /// Positions and velocities at a time inside the last step (s), as interpolated: closures may be off by as much as that errs.
    pub fn interpolate(&mut self, mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        self.stepper.sample(mechanism, time, position, velocity);
    }

    /// Rates of a scalar coordinate at all stages of the last step [m/s or rad/s], with the weights of the stages: a damper along it has turned
    /// `h Σ_k b_k c ẏ_k²` into heat.
    pub fn stage_rates(&self, freedom: usize, rates: &mut [f64]) -> &'static [f64] {
        self.stepper.stage_rates(freedom, rates);
        &self.stepper.tableau.weights
    }

    /// The mean square of the rate of a scalar coordinate over the last step [(m/s)² or (rad/s)²]; `rates` is room.
    pub fn mean_square_rate(&self, freedom: usize, rates: &mut Vec<f64>) -> f64 {
        rates.resize(self.stages(), 0.0);
        let weights = self.stage_rates(freedom, rates);
        weights.iter().zip(rates).map(|(weight, rate)| weight * *rate * *rate).sum()
    }

    /// Writes the forces (N) on the second ends of the closures, loops and then contacts, at all stages of the last step but its end, stage after stage
    /// of each; whether it solved for them.
    pub fn closure_forces(&self, forces: &mut Vec<[f64; 3]>) -> bool {
        self.stepper.kernel.closure_forces(forces)
    }

    /// Whether hard dampers may have left more of a transient at the end of the last step than its tolerance allows.
    pub fn leaves_transient(&self) -> bool {
        match &self.mode {
            Mode::Chosen(control) => control.leaves_transient(&self.stepper),
            Mode::Fixed(_) | Mode::Reversible(_) => false,
        }
    }

    /// Number of stages.
    pub fn stages(&self) -> usize {
        self.stepper.tableau.stages
    }

    /// The state at the start of the last step.
    pub fn origin(&self) -> &State {
        self.stepper.origin()
    }

    /// Goes on at the pace of another, which made steps of the same motion up to `time` (s): on its grid, or with its step.
    pub fn keep_pace(&mut self, pace: StepPace, time: f64) {
        match (&mut self.mode, pace) {
            (Mode::Fixed(fixed), StepPace::Grid { origin }) => fixed.lay(origin, time),
            (Mode::Chosen(control), StepPace::Step { length, kinetic }) => control.keep_pace(length, kinetic),
            _ => {}
        }
    }

    /// Number of steps so far.
    pub fn step_count(&self) -> usize {
        self.stepper.step_count()
    }

    /// Looks at the fastest mode in the state from which the first step of a motion begins, instead of the state after that step.
    pub(crate) fn look_ahead(&mut self, mechanism: &Mechanism, state: &State) {
        let driven = self.stepper.driven();
        self.stepper.look_ahead(driven.as_deref().unwrap_or(mechanism), state);
    }

    /// Makes one step exactly to `until` (s), with chosen steps, if it is accepted at once.
    ///
    /// # Errors
    /// The cost of a refused attempt, which leaves the state as it is.
    pub(crate) fn span(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        until: f64,
        begins: Beginning,
    ) -> Result<StepOutcome, Cost> {
        // A force that jumps in between ends a step.
        if mechanism.next_instant(state.time) < until || self.meet(mechanism, inputs, state).is_err() {
            return Err(Cost::default());
        }
        let driven = self.stepper.driven();
        let Mode::Chosen(control) = &mut self.mode else { return Err(Cost::default()) };
        control.span(&mut self.stepper, driven.as_deref().unwrap_or(mechanism), inputs, state, until, begins)
    }

    /// Gives up chosen steps that are shorter than this (s) and do not converge, from now on.
    pub fn give_up_below(&mut self, length: f64) {
        if let Mode::Chosen(control) = &mut self.mode {
            control.given_up_below = length;
        }
    }

    /// The pace of the steps, for one who goes on; `origin` is where a grid began (s).
    pub fn step_pace(&self, origin: f64) -> StepPace {
        match &self.mode {
            Mode::Chosen(control) => StepPace::Step { length: control.memory.step, kinetic: control.memory.kinetic },
            Mode::Fixed(_) | Mode::Reversible(_) => StepPace::Grid { origin },
        }
    }
}

impl Lobatto {
    /// Takes the forces and the state where a step begins, which may be another one than the last step left.
    fn meet(&mut self, mechanism: &Mechanism, inputs: Inputs, state: &State) -> Result<(), StepError> {
        self.meet_as(mechanism, inputs, state, Stepper::meet)
    }

    /// Takes them before the step, which does not do so again.
    pub(crate) fn meet_before(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &State,
    ) -> Result<(), StepError> {
        self.meet_as(mechanism, inputs, state, Stepper::meet_before)
    }

    fn meet_as(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &State,
        meet: impl FnOnce(&mut Stepper, &Mechanism, &State) -> bool,
    ) -> Result<(), StepError> {
        if !self.stepper.knows(mechanism, inputs) {
            self.renew(mechanism, inputs, state.time)?;
        }
        let driven = self.stepper.driven();
        let mechanism = driven.as_deref().unwrap_or(mechanism);
        if mechanism.forces.driven {
            self.stepper.kernel.drive(inputs.efforts);
        }
        if mechanism.changes() {
            self.stepper.kernel.clock(state.time);
        }
        if meet(&mut self.stepper, mechanism, state) {
            match &mut self.mode {
                Mode::Fixed(fixed) => fixed.begin_at(state.time),
                Mode::Chosen(control) => control.forget(),
                // A run that somebody turns round goes back in the same steps.
                Mode::Reversible(_) => {}
            }
        }
        Ok(())
    }

    /// Makes a kernel for the present gravity, forces and inputs.
    fn renew(&mut self, mechanism: &Mechanism, inputs: Inputs, time: f64) -> Result<(), StepError> {
        let now = self.stepper.learn(mechanism, inputs);
        let tableau = self.stepper.tableau;
        let kernel = match &mut self.mode {
            _ if self.precise && !now.is_plain_tree() => {
                return Err(StepError::NotPlain { time, method: "steps with 32 digits" });
            }
            Mode::Reversible(_) if !now.is_plain_tree() => {
                return Err(StepError::NotPlain { time, method: "reversible steps" });
            }
            _ if self.precise => precise_step_for(&now, tableau, &self.kept),
            Mode::Chosen(control) => {
                control.meet(&now);
                step_for(&now, tableau, self.isa, &self.kept)
            }
            Mode::Fixed(_) | Mode::Reversible(_) => step_for(&now, tableau, self.isa, &self.kept),
        };
        self.stepper.replace_kernel(kernel);
        self.prepare(&now);
        Ok(())
    }
}

impl Integrator for Lobatto {
    fn step(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        until: f64,
    ) -> Result<StepOutcome, StepError> {
        self.meet(mechanism, inputs, state)?;
        let driven = self.stepper.driven();
        let mechanism = driven.as_deref().unwrap_or(mechanism);
        let until = until.min(mechanism.next_instant(state.time));
        match &mut self.mode {
            Mode::Fixed(fixed) => fixed.advance(&mut self.stepper, mechanism, inputs, state, until),
            Mode::Chosen(control) => control.advance(&mut self.stepper, mechanism, inputs, state, until),
            Mode::Reversible(reversible) => reversible.advance(&mut self.stepper, mechanism, state, until),
        }
    }

    fn take_abandoned(&mut self) -> Cost {
        self.stepper.take_abandoned()
    }

    fn dense(&mut self, mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        self.interpolate(mechanism, time, position, velocity);
        self.stepper.kernel.close(mechanism, time, position, velocity);
    }

    fn bodies(&self) -> Option<&[BodyState]> {
        self.stepper.kernel.bodies()
    }

    fn description(&self) -> MethodDescription {
        let stepper = &self.stepper;
        let (adaptive, tolerance, step, resets) = match &self.mode {
            Mode::Fixed(fixed) => (false, None, fixed.step(), None),
            Mode::Chosen(control) => (true, Some(control.tolerance()), stepper.mean_step(), None),
            Mode::Reversible(reversible) => (false, None, stepper.mean_step(), Some(reversible.resets())),
        };
        MethodDescription {
            name: "lobatto".to_string(),
            stages: stepper.tableau.stages,
            order: stepper.tableau.order(),
            step,
            adaptive,
            tolerance,
            frequency_step: stepper.watch.nearest(),
            ringing: stepper.watch.ringing(),
            singular: stepper.singular(),
            digits: if self.precise { 32 } else { 16 },
            reversible_resets: resets,
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
}
