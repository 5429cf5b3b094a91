//! Steps of the scheme, one after the other: attempted, finished, accepted or failed. How long they are is decided elsewhere.
//!
//! ```text
//!     state ──attempt(h)──▶ solved stages ──finish──▶ end, energies ──accept──▶ state, the next start
//! ```
//!
//! Between `finish` and `accept` the state has not moved, so that a step can still be thrown away.

use crate::instants::feedback;
use crate::instants::inside::{Inside, has_dampers};
use crate::instants::sampling::LastStep;
use crate::instants::stage_motion::stage_motion;
use crate::length::companion::Companion;
use crate::length::energies::{Energies, pull};
use crate::length::outside::Outside;
use crate::watching::modes::Modes;
use crate::watching::ranks::Ranks;
use crate::watching::standstills::Standstills;
use crate::watching::watch::{Mode, Transient, Watch};
use catena_lobatto::coupled::counted::Counted;
use catena_lobatto::stages::attempt::{Attempt, Guess, StopRule};
use catena_lobatto::step::interface::Step;
use catena_lobatto::tableau::butcher::MAXIMUM_STAGES;
use catena_lobatto::tableau::butcher::Tableau;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::energy::Energy;
use catena_mechanism::motion::inputs::Inputs;
use catena_mechanism::motion::integrator::{Cost, Rejected, SingularPosition, StepError, StepOutcome};
use catena_mechanism::motion::state::State;
use std::sync::Arc;

mod looking;
mod meeting;

/// Why an attempt is thrown away; a solved one for its energy.
pub(crate) fn refusal(attempt: &Attempt) -> Rejected {
    match attempt {
        Attempt::Failed { .. } => Rejected::NotConverged,
        Attempt::TurnedTooFar { .. } => Rejected::TurnedTooFar,
        Attempt::Inaccurate { .. } => Rejected::NotSmooth,
        Attempt::Converged { .. } => Rejected::EnergyJump,
    }
}

/// A mechanism on its way through time.
#[derive(Clone)]
pub(crate) struct Stepper {
    /// Solves the stage equations.
    pub kernel: Box<dyn Step>,
    /// The scheme.
    pub tableau: &'static Tableau,
    /// Looks now and then how near the steps are to the limit of stability.
    pub watch: Watch,
    /// Its source of frequencies.
    modes: Modes,
    /// The fastest mode at the end of the finished step, if that was looked at before it is accepted.
    seen: Option<Mode>,
    /// The fastest mode and what dampers are about to stop where the motion begins, if that was looked at for its first step.
    ahead: Option<Mode>,
    ahead_of_dampers: Option<Option<Transient>>,
    /// Start of the last step, for dense output.
    origin: State,
    /// The end of a step before it is accepted, and then the end of the last one.
    end: State,
    length: f64,
    /// Its inside.
    inside: Inside,
    /// Whether dampers act.
    damped: bool,
    /// Where quadratic drag is not smooth.
    standstills: Standstills,
    ranks: Ranks,
    steps: usize,
    stepped_time: f64,
    /// The time at which the last step ended; another time means that the state was moved from outside.
    left_at: Option<f64>,
    /// Whether `end` is a state that was met, and from which no step has begun yet.
    met: bool,
    /// Gravity and forces that the kernel knows.
    outside: Outside,
    /// Efforts that change in time, at the stages of an attempt.
    changing: Vec<f64>,
    /// Efforts of the last attempt, added up [N or N m].
    efforts: f64,
    /// The ranks of the closures counted at the start of the first step.
    pub counted: Option<Arc<Counted>>,
    /// The companion, if there is one.
    pub companion: Option<Box<Companion>>,
    /// The cost of steps that failed, which no outcome has.
    abandoned: Cost,
}

impl Stepper {
    /// A stepper that has not seen a state yet.
    pub fn new(mechanism: &Mechanism, tableau: &'static Tableau, kernel: Box<dyn Step>) -> Self {
        Stepper {
            kernel,
            watch: Watch::new(tableau, !mechanism.is_unforced()),
            tableau,
            modes: Modes::new(mechanism),
            seen: None,
            ahead: None,
            ahead_of_dampers: None,
            origin: State::zero(mechanism),
            end: State::zero(mechanism),
            length: 0.0,
            inside: Inside::new(tableau, mechanism),
            damped: has_dampers(&mechanism.forces),
            standstills: Standstills::default(),
            ranks: Ranks::default(),
            steps: 0,
            stepped_time: 0.0,
            left_at: None,
            met: false,
            outside: Outside::new(mechanism),
            changing: Vec::new(),
            efforts: 0.0,
            counted: None,
            companion: None,
            abandoned: Cost::default(),
        }
    }

    /// Counts the cost of a step that fails.
    pub fn abandon(&mut self, cost: &Cost) {
        self.abandoned.add(cost);
        self.abandoned.kept += self.kernel.take_kept();
    }

    /// The cost of steps that failed since this was asked last.
    pub fn take_abandoned(&mut self) -> Cost {
        std::mem::take(&mut self.abandoned)
    }

    /// Attempts a step of `length` seconds from `state` under these inputs.
    pub fn attempt(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &State,
        length: f64,
        rule: &StopRule,
        guess: Guess,
    ) -> Attempt {
        self.efforts = inputs.efforts.iter().map(|effort| effort.abs()).sum();
        if let Some(feedback) = inputs.feedback {
            let kernel = self.kernel.as_mut();
            let (attempt, efforts) =
                feedback::attempt(kernel, self.tableau, mechanism, feedback, state, length, rule, guess);
            self.efforts += efforts;
            return attempt;
        }
        if let Some(changing) = inputs.changing {
            let nodes = &self.tableau.nodes;
            self.changing.clear();
            for entry in 0..changing.freedoms().len() {
                self.changing.extend(nodes.iter().map(|node| changing.effort(entry, state.time + node * length)));
            }
            let at_end = self.changing.iter().skip(nodes.len() - 1).step_by(nodes.len());
            self.efforts += at_end.map(|effort| effort.abs()).sum::<f64>();
            self.kernel.change(changing.freedoms(), &self.changing);
        }
        self.kernel.attempt(mechanism, length, rule, guess)
    }

    /// Makes the last step again from its start with another length (s), near the first: moves `state` to the new end.
    ///
    /// # Errors
    /// [`StepError`] where the equations cannot be solved to rounding; the state is then the start of the step.
    pub fn again(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        length: f64,
    ) -> Result<StepOutcome, StepError> {
        self.kernel.retract();
        self.companion = None;
        state.copy_from(&self.origin);
        self.left_at = None;
        self.steps -= 1;
        self.stepped_time -= self.length;
        let mut outcome = StepOutcome::default();
        for guess in [Guess::Longer(self.length), Guess::Plain] {
            let attempt = self.attempt(mechanism, inputs, state, length, &StopRule::ROUNDING, guess);
            outcome.cost.iterations += attempt.iterations();
            if let Attempt::Converged { exact, .. } = attempt {
                outcome.exact = exact;
                self.finish(mechanism, state);
                let end = state.time + length;
                self.accept(mechanism, state, length, end, &mut outcome)?;
                if self.damped {
                    self.look_inside(mechanism, 0.0);
                }
                return Ok(outcome);
            }
            outcome.cost.reject(refusal(&attempt));
            if guess == Guess::Plain {
                self.abandon(&outcome.cost);
                return Err(self.failure(mechanism, state.time, length, &attempt));
            }
        }
        Ok(outcome)
    }

    /// Rates of a scalar coordinate at all stages of the last step [m/s or rad/s], as dampers feel them: `ẏ_j` of
    /// [`catena_lobatto::equations::forces`].
    pub fn stage_rates(&self, freedom: usize, rates: &mut [f64]) {
        let mut displacements = [0.0; MAXIMUM_STAGES];
        let stages = self.tableau.stages;
        let step = (self.length, self.origin.velocity[freedom]);
        stage_motion(self.kernel.as_ref(), self.tableau, freedom, step, &mut displacements[..stages], rates);
    }

    /// The state at the start of the last step.
    pub fn origin(&self) -> &State {
        &self.origin
    }

    /// The guess of the first attempt at a step.
    pub fn first_guess(&self) -> Guess {
        if self.kernel.has_past() { Guess::Past } else { Guess::Plain }
    }

    /// Finishes the solved step, without moving `state`; returns the energies at its end, with the unexplained change.
    pub fn finish(&mut self, mechanism: &Mechanism, state: &State) -> Energies {
        self.seen = None;
        if let Some(companion) = &mut self.companion {
            companion.wait();
        }
        self.end.copy_from(state);
        let before = self.kernel.energy();
        let after = self.kernel.finish(mechanism, &mut self.end);
        self.energies(mechanism, before, after)
    }

    /// The same of a step to `time` (s) that is likely to be kept: the companion goes through it, too, if there is one and both can at once.
    pub fn finish_both(&mut self, mechanism: &Mechanism, state: &State, time: f64) -> Energies {
        self.seen = None;
        let Stepper { companion, kernel, end, .. } = self;
        if let Some(companion) = companion {
            end.copy_from(state);
            let before = kernel.energy();
            if let Some(after) = companion.finish(kernel.as_mut(), mechanism, state, end, time) {
                return self.energies(mechanism, before, after);
            }
        }
        self.finish(mechanism, state)
    }

    fn energies(&self, mechanism: &Mechanism, before: Energy, after: Energy) -> Energies {
        let exchange = self.kernel.exchange();
        let (closed, dampers) = (mechanism.has_closures(), &mechanism.forces.joint_dampers);
        Energies {
            change: after.total() - before.total() + exchange.lost(),
            kinetic: after.kinetic,
            potential: after.potential.abs() + after.spring + after.load.abs(),
            pull: if mechanism.forces.driven { pull(mechanism, &self.end) } else { (0.0, 0.0) },
            damping: if closed { 0.0 } else { dampers.iter().map(|damper| damper.coefficient).sum() },
            pushes: if closed { self.outside.pushes.with(after.spring, self.efforts) } else { 0.0 },
        }
    }

    /// Accepts the finished step of `length` seconds: moves `state` to its end, at time `time`, and completes its `outcome`.
    ///
    /// # Errors
    /// [`StepError::NotFinite`], without moving the state, if a velocity at the end is not a number.
    pub fn accept(
        &mut self,
        mechanism: &Mechanism,
        state: &mut State,
        length: f64,
        time: f64,
        outcome: &mut StepOutcome,
    ) -> Result<(), StepError> {
        let accepted = self.keep(mechanism, state, length, time, outcome);
        if accepted.is_err() {
            self.abandon(&outcome.cost);
        }
        accepted
    }

    /// The same; an error leaves the cost in the outcome.
    pub fn keep(
        &mut self,
        mechanism: &Mechanism,
        state: &mut State,
        length: f64,
        time: f64,
        outcome: &mut StepOutcome,
    ) -> Result<(), StepError> {
        if let Some(freedom) = self.end.velocity.iter().position(|rate| !rate.is_finite()) {
            let joint = mechanism.joint_of_freedom(freedom).to_string();
            return Err(StepError::NotFinite { time: state.time, step: length, joint });
        }
        outcome.step = length;
        outcome.exchange = self.kernel.exchange();
        outcome.cost.kept += self.kernel.take_kept();
        if let Some(redundant) = self.kernel.redundant() {
            self.ranks.see(redundant, mechanism, &self.end, time);
        }
        if let Some(companion) = &mut self.companion {
            companion.follow(self.kernel.as_mut(), mechanism, state, outcome.exact, time);
        }
        self.kernel.accept();
        self.origin.copy_from(state);
        self.end.time = time;
        state.copy_from(&self.end);
        self.length = length;
        self.steps += 1;
        self.stepped_time += length;
        self.left_at = Some(time);
        if let Some(iterations) = self.watch.due() {
            self.look(mechanism, state, iterations, length);
        }
        Ok(())
    }

    /// Why a step failed: because of its length alone, if that is beyond the limit of stability.
    pub fn failure(&self, mechanism: &Mechanism, time: f64, step: f64, attempt: &Attempt) -> StepError {
        if let Some(seen) = self.watch.latest().filter(|seen| seen.is_unstable() && seen.time == time) {
            let longest = seen.longest();
            return StepError::Unstable { time, step: seen.step, stages: self.tableau.stages, longest };
        }
        let joint = |freedom| mechanism.joint_of_freedom(freedom).to_string();
        match *attempt {
            Attempt::Converged { .. } | Attempt::Inaccurate { .. } => StepError::NotAccurate { time, step },
            Attempt::TurnedTooFar { freedom, .. } => StepError::TurnedTooFar { time, step, joint: joint(freedom) },
            Attempt::Failed { freedom, increment, .. } => {
                StepError::NotConverged { time, step, joint: joint(freedom), increment }
            }
        }
    }

    /// Positions and velocities at a time inside the last step (s), but for closures.
    pub fn sample(&mut self, mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        let Stepper { kernel, tableau, origin, end, length, inside, .. } = self;
        let (inner, length) = (tableau.stages - 1, *length);
        let last = LastStep { kernel: kernel.as_ref(), inner, origin, end, length };
        inside.sample(mechanism, &last, (time - origin.time) / length, position, velocity);
    }

    /// Number of steps so far.
    pub fn step_count(&self) -> usize {
        self.steps
    }

    /// Mean length of the steps so far (s).
    pub fn mean_step(&self) -> f64 {
        self.stepped_time / self.steps.max(1) as f64
    }

    /// The position at which equations of the loops became redundant, if there was one.
    pub fn singular(&self) -> Option<SingularPosition> {
        self.ranks.singular()
    }
}
