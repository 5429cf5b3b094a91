//! The integrator: steps of the scheme strung together, with fixed or chosen length.
//!
//! Fixed steps stay on the grid `t₀ + n h`: a step that does not converge is tried again without the past, then
//! halved, and the grid is met again afterwards. Chosen steps follow [`super::control`].

use super::control::{Control, Energies, Verdict};
use super::dense::DenseRule;
use super::dispatch::step_for;
use super::lanes::Isa;
use super::reversible::Reversible;
use super::sampling::LastStep;
use super::stability::Watch;
use super::step::{Attempt, Step, StopRule};
use super::tableau::{Tableau, TableauError};
use crate::model::{Mechanism, Rule};
use crate::simulation::{Integrator, MethodDescription, SingularPosition, StepError, StepOutcome};
use crate::state::State;

/// A step is halved at most this often before the integrator gives up.
const HALVINGS: i32 = 14;

/// A step of a closed mechanism that changes the energy by this part of the kinetic energy has solved its equations on another
/// branch of a singular position: it is tried again, and shortened.
const ANOTHER_MOTION: f64 = 0.25;

/// The constrained Lobatto IIIA–IIIB scheme as an [`Integrator`].
///
/// ```
/// use catena::lobatto::Lobatto;
/// use catena::model::{Body, Joint, JointKind, Mechanism, Pose};
/// use catena::simulation::Integrator;
/// use catena::state::State;
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
pub struct Lobatto {
    kernel: Box<dyn Step>,
    tableau: Tableau,
    isa: Isa,
    dense: DenseRule,
    /// Room for what dense output sums over the stages.
    dense_sums: Vec<[f64; 2]>,
    mode: Mode,
    watch: Watch,
    /// The states at both ends of the last step, for dense output; `end` is also where a step is finished before it is
    /// accepted.
    origin: State,
    end: State,
    ranks: Ranks,
    last_step: f64,
    steps: usize,
    stepped_time: f64,
    /// What the last call left behind; anything else means that somebody moved the state.
    left_at: Option<f64>,
}

/// Numbers of redundant equations at ends of steps.
#[derive(Clone, Copy, Debug, Default)]
struct Ranks {
    fewest: Option<usize>,
    most: usize,
    most_at: f64,
}

impl Ranks {
    fn see(&mut self, redundant: usize, time: f64) {
        self.fewest = Some(self.fewest.map_or(redundant, |fewest| fewest.min(redundant)));
        if redundant > self.most {
            (self.most, self.most_at) = (redundant, time);
        }
    }

    fn singular(&self) -> Option<SingularPosition> {
        let extra = self.most.saturating_sub(self.fewest?);
        (extra > 0).then_some(SingularPosition { time: self.most_at, extra })
    }
}

/// Where fixed steps end: `origin + points · step`, counted, so that no sum of steps can drift.
struct Grid {
    origin: f64,
    points: u64,
}

enum Mode {
    Fixed { step: f64, grid: Grid, rule: StopRule },
    Adaptive(Control),
    Reversible(Reversible),
}

/// Why a method cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MethodError {
    /// The number of stages.
    #[error(transparent)]
    Tableau(#[from] TableauError),
    /// Reversible steps need a motion that is reversible itself and whose pace is known.
    #[error("reversible steps are for trees of joints under gravity alone; this one has loops, mimic joints or forces")]
    NotReversible,
}

impl Lobatto {
    /// Fixed steps of `step` seconds with `stages` stages, iterated to rounding.
    ///
    /// # Errors
    /// [`TableauError`] if the number of stages is not from 2 to 16.
    pub fn fixed(mechanism: &Mechanism, stages: usize, step: f64) -> Result<Self, TableauError> {
        Self::fixed_with(mechanism, stages, step, StopRule::ROUNDING, Isa::detect())
    }

    /// Fixed steps with a stop rule and vector instructions of one's own choice (for experiments and tests).
    ///
    /// # Errors
    /// [`TableauError`] if the number of stages is not from 2 to 16.
    pub fn fixed_with(
        mechanism: &Mechanism,
        stages: usize,
        step: f64,
        rule: StopRule,
        isa: Isa,
    ) -> Result<Self, TableauError> {
        let mode = Mode::Fixed { step, grid: Grid { origin: 0.0, points: 0 }, rule };
        Ok(Self::with_tableau(mechanism, Tableau::new(stages)?, mode, isa))
    }

    /// Steps of varying length for very long runs, the first of `step` seconds, iterated to rounding: a run that is turned
    /// round retraces itself ([`super::reversible`]).
    ///
    /// # Errors
    /// [`MethodError`] if the number of stages is not from 2 to 16, or if there is more than a tree under gravity.
    pub fn reversible(mechanism: &Mechanism, stages: usize, step: f64) -> Result<Self, MethodError> {
        let tableau = Tableau::new(stages)?;
        if !mechanism.is_plain_tree() {
            return Err(MethodError::NotReversible);
        }
        Ok(Self::with_tableau(mechanism, tableau, Mode::Reversible(Reversible::new(step)), Isa::detect()))
    }

    /// Steps chosen for a wanted position accuracy [m or rad], with the iteration stop that suits motions of moderate
    /// amplification; [`crate::calibration`] finds the one for the motion at hand.
    pub fn adaptive(mechanism: &Mechanism, tolerance: f64) -> Self {
        Self::adaptive_with_stop(mechanism, tolerance, 1e-4 * tolerance)
    }

    /// Steps chosen for an iteration stop, the local accuracy of joint displacements [m or rad]; `tolerance` bounds the
    /// change of the energy relative to the kinetic energy.
    pub fn adaptive_with_stop(mechanism: &Mechanism, tolerance: f64, stop: f64) -> Self {
        let isa = Isa::detect();
        let control = Control::new(tolerance, stop, isa);
        let tableau = control.tableau();
        Self::with_tableau(mechanism, tableau, Mode::Adaptive(control), isa)
    }

    fn with_tableau(mechanism: &Mechanism, tableau: Tableau, mode: Mode, isa: Isa) -> Self {
        Lobatto {
            kernel: step_for(mechanism, &tableau, isa, &[]),
            dense: DenseRule::new(&tableau),
            dense_sums: vec![[0.0; 2]; mechanism.velocity_count],
            watch: Watch::new(&tableau, !mechanism.forces.is_empty()),
            tableau,
            isa,
            ranks: Ranks::default(),
            mode,
            origin: State::zero(mechanism),
            end: State::zero(mechanism),
            last_step: 0.0,
            steps: 0,
            stepped_time: 0.0,
            left_at: None,
        }
    }

    /// The same without some rules by which it would do less: without [`Rule::Planar`] every body has six coordinates, without
    /// [`Rule::Translation`], [`Rule::Points`] and [`Rule::Spheres`] all of their equations.
    #[must_use]
    pub fn keeping(mut self, mechanism: &Mechanism, switched_off: &[Rule]) -> Self {
        if !switched_off.is_empty() {
            self.kernel = step_for(mechanism, &self.tableau, self.isa, switched_off);
            self.left_at = None;
        }
        self
    }

    /// Finishes the solved step into `self.end`; returns the energies there, with the change that nothing accounts for.
    fn finish(&mut self, mechanism: &Mechanism, state: &State) -> Energies {
        let before = self.kernel.energy();
        self.end.copy_from(state);
        let after = self.kernel.finish(mechanism, &mut self.end);
        let exchange = self.kernel.exchange();
        Energies {
            change: after.total() - before.total() + (exchange.dissipated - exchange.work),
            kinetic: after.kinetic,
            potential: after.potential.abs() + after.spring + after.load.abs(),
        }
    }

    /// Accepts the finished step of length `step`: moves `state` to its end, at time `time`.
    fn accept(&mut self, mechanism: &Mechanism, state: &mut State, step: f64, time: f64) {
        if let Some(redundant) = self.kernel.redundant() {
            self.ranks.see(redundant, time);
        }
        self.kernel.accept();
        self.origin.copy_from(state);
        self.end.time = time;
        state.copy_from(&self.end);
        self.last_step = step;
        self.steps += 1;
        self.stepped_time += step;
        self.left_at = Some(time);
        if let Some(iterations) = self.watch.due() {
            self.look(mechanism, state, iterations, step);
        }
    }

    /// Looks how near a step of this length is to the limit of stability.
    fn look(&mut self, mechanism: &Mechanism, state: &State, iterations: usize, step: f64) {
        let mode = self.kernel.fastest_mode(mechanism, state, iterations);
        self.watch.see(mode, step, state.time);
    }

    /// Why a step failed: because of its length alone, if that is beyond the limit of stability.
    fn failure(&self, mechanism: &Mechanism, time: f64, step: f64, attempt: &Attempt) -> StepError {
        match self.watch.latest() {
            Some(seen) if seen.is_unstable() && seen.time == time => {
                StepError::Unstable { time, step: seen.step, stages: self.tableau.stages, longest: seen.longest() }
            }
            _ => failure_of(mechanism, time, step, attempt),
        }
    }

    fn fixed_step(&mut self, mechanism: &Mechanism, state: &mut State, until: f64) -> Result<StepOutcome, StepError> {
        let Mode::Fixed { step, grid, rule } = &mut self.mode else { return Ok(StepOutcome::default()) };
        let (nominal, rule) = (*step, *rule);
        // A grid point this close is where rounding left us, not a step to make.
        while grid.origin + grid.points as f64 * nominal <= state.time + 1e-7 * nominal {
            grid.points += 1;
        }
        let mut target = grid.origin + grid.points as f64 * nominal;
        if target > until || until - target < 1e-7 * nominal {
            target = until;
        }
        let mut outcome = StepOutcome::default();
        let mut length = target - state.time;
        for halving in 0..=HALVINGS {
            for plain in [false, true] {
                match self.kernel.attempt(mechanism, length, &rule, plain) {
                    Attempt::Converged { iterations, .. } => {
                        outcome.iterations += iterations;
                        outcome.step = length;
                        let before = self.kernel.energy().kinetic;
                        let energies = self.finish(mechanism, state);
                        let allowed = ANOTHER_MOTION * before.max(energies.kinetic) + 1e-9 * energies.potential;
                        let last = halving == HALVINGS && plain;
                        if mechanism.has_closures() && energies.change.abs() > allowed && !last {
                            outcome.rejected += 1;
                            continue;
                        }
                        outcome.exchange = self.kernel.exchange();
                        finite(mechanism, &self.end, length)?;
                        self.accept(mechanism, state, length, if halving == 0 { target } else { state.time + length });
                        return Ok(outcome);
                    }
                    failure => {
                        outcome.iterations += failure.iterations();
                        outcome.rejected += 1;
                        if halving == 0 && plain {
                            self.look(mechanism, state, self.watch.iterations_after_failure(), length);
                        }
                        if halving == HALVINGS && plain {
                            return Err(self.failure(mechanism, state.time, length, &failure));
                        }
                    }
                }
            }
            length *= 0.5;
        }
        Ok(outcome)
    }

    fn adaptive_step(
        &mut self,
        mechanism: &Mechanism,
        state: &mut State,
        until: f64,
    ) -> Result<StepOutcome, StepError> {
        let Mode::Adaptive(control) = &mut self.mode else { return Ok(StepOutcome::default()) };
        let mut outcome = StepOutcome::default();
        if !control.started() {
            control.start(mechanism, state, self.kernel.as_mut());
        }
        let mut plain = false;
        loop {
            let Mode::Adaptive(control) = &mut self.mode else { return Ok(outcome) };
            let remaining = until - state.time;
            let reaches = control.step() >= remaining * (1.0 - 1e-9);
            let length = if reaches { remaining } else { control.step() };
            let attempt = self.kernel.attempt(mechanism, length, &control.rule(), plain);
            outcome.iterations += attempt.iterations();
            let energies = match attempt {
                Attempt::Converged { .. } => Some(self.finish(mechanism, state)),
                _ => None,
            };
            let Mode::Adaptive(control) = &mut self.mode else { return Ok(outcome) };
            match control.judge(&attempt, energies, length, plain) {
                Verdict::Accept => {
                    finite(mechanism, &self.end, length)?;
                    outcome.step = length;
                    outcome.exchange = self.kernel.exchange();
                    self.accept(mechanism, state, length, if reaches { until } else { state.time + length });
                    if let Mode::Adaptive(control) = &mut self.mode {
                        control.keep_below(self.watch.safe_step());
                    }
                    return Ok(outcome);
                }
                Verdict::Retry { without_past } => {
                    outcome.rejected += 1;
                    plain = without_past;
                    // Below this the step vanishes against the time itself.
                    if control.step() < 1e-13 * state.time.abs().max(1e-3) {
                        return Err(self.failure(mechanism, state.time, length, &attempt));
                    }
                }
            }
        }
    }

    fn reversible_step(
        &mut self,
        mechanism: &Mechanism,
        state: &mut State,
        until: f64,
    ) -> Result<StepOutcome, StepError> {
        let mut outcome = StepOutcome::default();
        let mut halvings = 0;
        loop {
            let Mode::Reversible(rule) = &mut self.mode else { return Ok(outcome) };
            if !rule.started()
                && let Some(pace) = self.kernel.pace(mechanism, state)
            {
                rule.start(&pace);
            }
            let remaining = until - state.time;
            let reaches = rule.step() >= remaining * (1.0 - 1e-9);
            let length = if reaches { remaining } else { rule.step() };
            for plain in [false, true] {
                let attempt = self.kernel.attempt(mechanism, length, &StopRule::ROUNDING, plain);
                outcome.iterations += attempt.iterations();
                if let Attempt::Converged { .. } = attempt {
                    self.finish(mechanism, state);
                    finite(mechanism, &self.end, length)?;
                    outcome.step = length;
                    self.accept(mechanism, state, length, if reaches { until } else { state.time + length });
                    // A step that was cut off at the end of the run says nothing about the next.
                    if let (false, Mode::Reversible(rule), Some(pace)) =
                        (reaches, &mut self.mode, self.kernel.pace(mechanism, state))
                    {
                        rule.follow(&pace);
                    }
                    return Ok(outcome);
                }
                outcome.rejected += 1;
                let Mode::Reversible(rule) = &mut self.mode else { return Ok(outcome) };
                if plain {
                    rule.fail();
                    halvings += 1;
                    self.look(mechanism, state, self.watch.iterations_after_failure(), length);
                    if halvings > HALVINGS {
                        return Err(self.failure(mechanism, state.time, length, &attempt));
                    }
                }
            }
        }
    }
}

impl Integrator for Lobatto {
    fn advance(&mut self, mechanism: &Mechanism, state: &mut State, until: f64) -> Result<StepOutcome, StepError> {
        // Anything but the end of the last step means that somebody moved the state.
        if self.left_at != Some(state.time) || *state != self.end {
            self.kernel.begin(mechanism, state);
            if let Mode::Fixed { grid, .. } = &mut self.mode {
                *grid = Grid { origin: state.time, points: 0 };
            }
        }
        match self.mode {
            Mode::Fixed { .. } => self.fixed_step(mechanism, state, until),
            Mode::Adaptive(_) => self.adaptive_step(mechanism, state, until),
            Mode::Reversible(_) => self.reversible_step(mechanism, state, until),
        }
    }

    fn dense(&mut self, mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        let weights = self.dense.weights((time - self.origin.time) / self.last_step);
        let last = LastStep {
            kernel: self.kernel.as_ref(),
            inner: self.tableau.stages - 1,
            origin: &self.origin,
            end: &self.end,
            length: self.last_step,
        };
        last.sample(mechanism, &weights, &mut self.dense_sums, position, velocity);
        self.kernel.close(mechanism, position, velocity);
    }

    fn description(&self) -> MethodDescription {
        let mean = self.stepped_time / self.steps.max(1) as f64;
        let (adaptive, tolerance, step, resets) = match &self.mode {
            Mode::Fixed { step, .. } => (false, None, *step, None),
            Mode::Adaptive(control) => (true, Some(control.tolerance()), mean, None),
            Mode::Reversible(rule) => (false, None, mean, Some(rule.resets())),
        };
        MethodDescription {
            name: "lobatto".to_string(),
            stages: self.tableau.stages,
            order: self.tableau.order(),
            step,
            adaptive,
            tolerance,
            frequency_step: self.watch.nearest(),
            singular: self.ranks.singular(),
            reversible_resets: resets,
        }
    }
}

fn joint_of_freedom(mechanism: &Mechanism, freedom: usize) -> String {
    mechanism
        .bodies
        .iter()
        .find(|body| body.joint.velocity_range().contains(&freedom))
        .map_or_else(String::new, |body| body.joint.name.clone())
}

fn failure_of(mechanism: &Mechanism, time: f64, step: f64, attempt: &Attempt) -> StepError {
    let joint = |freedom| joint_of_freedom(mechanism, freedom);
    match *attempt {
        Attempt::Converged { .. } | Attempt::Inaccurate { .. } => StepError::NotAccurate { time, step },
        Attempt::TurnedTooFar { freedom, .. } => StepError::TurnedTooFar { time, step, joint: joint(freedom) },
        Attempt::Failed { freedom, increment, .. } => {
            StepError::NotConverged { time, step, joint: joint(freedom), increment }
        }
    }
}

fn finite(mechanism: &Mechanism, state: &State, step: f64) -> Result<(), StepError> {
    match state.velocity.iter().position(|rate| !rate.is_finite()) {
        None => Ok(()),
        Some(freedom) => {
            Err(StepError::NotFinite { time: state.time, step, joint: joint_of_freedom(mechanism, freedom) })
        }
    }
}
