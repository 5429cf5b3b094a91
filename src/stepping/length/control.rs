//! The choice of the step from a tolerance.
//!
//! One number, the stop of the iteration `ε`, sets everything: the top Legendre coefficient `E` of the joint
//! displacements and of the bodies' rotations over the step is kept near `E_tol = c √ε`, because the local error behaves
//! like `E²`, and the number of iterations `N` near `N*`, where the cost per simulated second is smallest; the number of stages and `c`
//! are chosen in [`crate::length::stage_choice`]:
//!
//! ```text
//!     h ← h · clip( min( (E_tol/E_n)^{.7/(s−1)} (E_{n−1}/E_n)^{.3/(s−1)},  ((N* + 1)/(N + 1))^{1/2} ), 0.3, 2 )
//! ```
//!
//! So that samples inside a step are within the tolerance `T`, nine stages have `E_tol ≤ (T / 2 / 0.35)^{1/1.25} / 3.3`, and five have
//! `E_tol ≤ (T / 2 / 0.25)^{1/1.5} / 1.3⁴`. These bounds are active below 1e-7 m. A step with `E > min(1.3^{s−1}, 3.3) E_tol` is thrown away, and so
//! is a finished one that changes the energy by more than its share of the tolerance. A step near that share does not grow, unless `E` is so small
//! that the change can only come from the iteration, which does not grow with the step. The energy shows errors that the polynomials do not, such as
//! a passage near a singular position. The step after one that was thrown away does not grow either: a motion that has become faster seldom has done
//! so once. Steps in which dampers stop a motion, and steps with dampers that change the energy too much, are iterated to rounding
//! ([`crate::length::beside_dampers`]). The polynomial of an attempt with too large an E is the guess of the next one
//! ([`catena_lobatto::stages::predictor`]). If E does not fall with the step, the motion has a kink, and the energy alone decides. Whatever these say, a
//! step stays within the limit of stability, and a motion that hard dampers are about to stop is stopped in short ones ([`crate::watching::watch`]).
//!
//! If the simplified iteration does not converge, not even from the plain guess, a tree under gravity gets half the step: a step of the exact Newton
//! method costs ten times as much, and is tried after some halvings only. A mechanism with forces tries it at once, because a stiff spring would
//! require shorter steps all along.

use crate::length::stage_choice::StageChoice;
use crate::length::stepper::Stepper;
use crate::length::stride::Stride;
use catena_lobatto::stages::attempt::{Attempt, Guess, StopRule};
use catena_lobatto::step::interface::Step;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::inputs::Inputs;
use catena_mechanism::motion::integrator::{Rejected, StepError, StepOutcome};
use catena_mechanism::motion::state::State;

/// The coarsest stop: with a coarser one the steps are too long for anything to be seen of them.
pub const COARSEST_STOP: f64 = 0.1;

/// `h Ω` of the first step for the stop [`FIRST_STOP`].
const FIRST: f64 = 0.4;
/// The stop at which `h Ω` of the first step is [`FIRST`].
const FIRST_STOP: f64 = 1e-10;
/// The power of the stop with which `h Ω` grows: E lets the steps of nine stages grow with the same power, 1/(2s − 2).
const FIRST_POWER: f64 = 1.0 / 16.0;

/// The largest E of a step that is kept, over the wanted one. Such a step makes one of the largest errors of the run if the motion amplifies errors.
/// A bound of 8 made a chain of ten links end ten times further off than the tolerance in one run of a hundred, 4 in one of eight hundred, and 3 in
/// as many.
const KEPT: f64 = 3.3;

/// The largest error of a sample inside a step, over a power of the largest E that is kept: factor and power for a number of stages, for which they
/// were measured. Dense output has a lower order than the ends of steps (`doc/decisions/005-samples-between-steps.md`).
/// Powers are near (s + 1)/(s − 1), because coefficients fall like powers of one number; three stages have less than that, 2, for caution.
const BETWEEN: [(usize, f64, f64); 3] = [(3, 1.0, 1.5), (5, 0.25, 1.5), (9, 0.35, 1.25)];
/// The part of the tolerance that samples inside steps may be off by.
const BETWEEN_SHARE: f64 = 0.5;
/// Below this tolerance (m) the bound does not shrink, because rounding is larger.
const FINEST_TOLERANCE: f64 = 1e-11;

/// Only steps whose E is above this part of the largest so far are evaluated inside: the error of interpolation grows with E.
const AMONG_LARGEST: f64 = 0.5;

/// The part of the wanted E up to which a step is likely to be kept after one that changed the energy too much.
const LIKELY: f64 = 0.5;

/// After this number of abandoned attempts at a step, early iterates are not used again: E may belong to a kink. And after as many whose E was too
/// large all iterations are in double precision.
const HASTE: usize = 2;

/// The largest E of a kink over the E of other steps.
pub const KINK: f64 = 100.0;

/// After this number of halvings of a step of a tree under gravity that does not converge, the exact Newton method is tried.
const PATIENCE: usize = 3;

/// Once the extrapolated guess has failed where the plain one has led to the solution, the plain one comes first for this number of steps, because the
/// reason seldom ends at once: guesses beside hard dampers are far off in what the dampers have stopped.
const PLAINLY: u8 = 10;

/// The decision on an attempt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Decision {
    /// Keep the step; [`Control::step`] is the length of the next one.
    Accept,
    /// Try again with the new [`Control::step`].
    Retry {
        /// The start of the next attempt.
        guess: Guess,
        /// Why this one was thrown away.
        why: Rejected,
    },
}

/// Chooses steps.
#[derive(Clone)]
pub struct Control {
    pub tolerance: f64,
    pub stages: usize,
    /// ε: where the iteration stops.
    pub(crate) stop: f64,
    /// The stop of steps that given instants end early, over ε.
    pub(crate) bounded: f64,
    /// The wanted E.
    pub wanted: f64,
    /// The largest E of a step that is kept.
    pub limit: f64,
    /// Whether iterates, early ones too, show that a step is too long. False with stiff springs and hard dampers, which disturb iterates.
    pub telling: bool,
    /// How often a step that does not converge is halved before the exact Newton method is tried.
    pub(crate) patience: usize,
    /// The largest E of the steps that were kept.
    pub(crate) largest: f64,
    /// The largest error of samples inside these steps (m), if it is known.
    pub(crate) between: Option<f64>,
    /// Whether stability has bounded a step.
    pub(crate) held: bool,
    /// A step that is shorter than this and does not converge is given up (s).
    pub(crate) given_up_below: f64,
    /// Step (s) and largest kinetic energy (J) to go on with when the motion is forgotten.
    pub(crate) given: Option<(f64, f64)>,
    pub memory: Memory,
}

/// Whether the motion has a kink that shorter steps do not resolve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Kink {
    /// It does not look like it.
    #[default]
    Unseen,
    /// It has: the energy alone decides on the smoothest of the steps, if E is not hundreds of times too large.
    Seen,
    /// It has, but was not to be passed like that.
    Refused,
}

/// The controller's memory of the motion.
#[derive(Clone, Default)]
pub struct Memory {
    /// Length of the next step (s); zero before the first.
    pub step: f64,
    /// E of the last step.
    pub previous: Option<f64>,
    /// Largest kinetic energy at the end of any attempt (J).
    pub kinetic: f64,
    /// Length and change of energy of the first attempt at this step that changed the energy too much.
    pub refused: Option<(f64, f64)>,
    /// Length and E of an attempt at this step whose E was too large: the first, or the last that was well shorter than the one before.
    pub unresolved: Option<(f64, f64)>,
    /// The same of the one with the least E, of trees under gravity.
    pub smoothest: Option<(f64, f64)>,
    /// Whether these attempts show a kink.
    pub kink: Kink,
    /// Number of attempts at the present step that had too large an E.
    pub too_long: usize,
    /// Number of these attempts that were abandoned for it.
    pub broken_off: usize,
    /// Observed change of the energy by rounding alone (J).
    pub rounding: f64,
    /// For how many steps the iteration goes on to rounding beside dampers, which take energy from the rates that it leaves.
    pub polished: usize,
    /// The change of the energy in the last attempt by rates of roundings, which dampers do not take (J).
    pub ringing: f64,
    /// Whether an attempt at the present step was thrown away, and the next one was not as long.
    pub rejected: bool,
    /// For how many steps small changes of the energy are taken for the steps' own, whatever E says.
    pub wary: usize,
    /// While short steps let hard dampers stop a motion: the length (s) from which on steps are as ever.
    settling: Option<f64>,
    /// How often the present step, which does not converge, was halved.
    pub halvings: usize,
    /// For how many more steps the plain guess comes first.
    plainly: u8,
}

/// The largest E with which samples inside a step are within the tolerance (m), where it was measured.
fn largest_between(tolerance: f64, stages: usize) -> f64 {
    let (_, factor, power) = BETWEEN.into_iter().find(|(of, ..)| *of == stages).unwrap_or((stages, 0.0, 1.0));
    (BETWEEN_SHARE * tolerance.max(FINEST_TOLERANCE) / factor).powf(1.0 / power)
}

impl Control {
    /// A controller for a mechanism, an iteration stop `ε` and a number of stages; `tolerance` bounds the change of the energy.
    pub fn new(mechanism: &Mechanism, tolerance: f64, stop: f64, stages: StageChoice) -> Self {
        let stop = stop.clamp(1e-16, COARSEST_STOP);
        let stage_count = stages.count();
        let kept = 1.3_f64.powi(stage_count as i32 - 1).min(KEPT);
        let local = stages.wanted_share() * stop.sqrt();
        let wanted = local.min(largest_between(tolerance, stage_count) / kept);
        Control {
            tolerance,
            stages: stage_count,
            stop,
            bounded: 1.0,
            wanted,
            limit: kept * wanted,
            telling: mechanism.is_unforced(),
            patience: if mechanism.is_plain_tree() { PATIENCE } else { 0 },
            largest: 0.0,
            between: Some(0.0),
            held: false,
            given_up_below: 0.0,
            given: None,
            memory: Memory::default(),
        }
    }

    /// The error of samples inside the steps that were kept (m).
    pub(crate) fn between(&self) -> Option<f64> {
        self.between
    }

    /// Looks at the inside of the last step, which had this E, if it may be among the worst.
    pub(super) fn look_inside(&mut self, stepper: &mut Stepper, mechanism: &Mechanism, legendre: f64) {
        if stepper.is_damped() || legendre >= AMONG_LARGEST * self.largest {
            let error = stepper.look_inside(mechanism, legendre);
            self.between = self.between.zip(error).map(|(worst, error)| worst.max(error));
        }
    }

    /// Takes note of other forces.
    pub fn meet(&mut self, mechanism: &Mechanism) {
        self.telling = mechanism.is_unforced();
        self.patience = if mechanism.is_plain_tree() { PATIENCE } else { 0 };
    }

    /// Whether hard dampers may have left more of a transient at the end of the last step than moves things by the tolerance in a second.
    pub(crate) fn leaves_transient(&self, stepper: &Stepper) -> bool {
        self.memory.previous.is_some_and(|legendre| stepper.left_rate(legendre) > self.tolerance)
    }

    /// Forgets the motion: the next step starts from something else.
    pub fn forget(&mut self) {
        let (step, kinetic) = self.given.take().unwrap_or_default();
        self.memory = Memory { step, kinetic, ..Memory::default() };
    }

    /// When the motion is forgotten next, it goes on with this step (s) and the largest kinetic energy seen (J).
    pub fn keep_pace(&mut self, step: f64, kinetic: f64) {
        self.given = Some((step, kinetic));
    }

    /// The tolerance asked for.
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// The length of the next step (s).
    pub fn step(&self) -> f64 {
        self.memory.step
    }

    /// The stopping rule of the iteration.
    pub fn rule(&self) -> StopRule {
        self.rule_at(self.stop)
    }

    /// The same with another stop.
    fn rule_at(&self, stop: f64) -> StopRule {
        let increment = stop.max(1e-16);
        StopRule {
            increment,
            rounding: increment.max(1e-11),
            unproven: f64::INFINITY,
            iterations: 40,
            legendre: if self.memory.kink == Kink::Seen { KINK * self.limit } else { self.limit },
            early: self.telling
                && self.memory.kink == Kink::Unseen
                && self.memory.previous.is_some()
                && self.memory.broken_off < HASTE,
            rough: self.memory.too_long < HASTE,
            exactly: self.memory.halvings >= self.patience,
        }
    }

    /// The same for a step that a given instant ends early.
    pub(crate) fn bounded_rule(&self) -> StopRule {
        self.rule_at(self.bounded * self.stop)
    }

    /// The same for a step of some length: where the motion is settling, velocities have to be as accurate as in long steps.
    fn rule_for(&mut self, length: f64) -> StopRule {
        let rule = if length < self.memory.step { self.bounded_rule() } else { self.rule() };
        let Some(long) = self.memory.settling else { return rule };
        if length >= long {
            self.memory.settling = None;
            return rule;
        }
        self.rule_at(self.stop * length / long)
    }

    /// Whether a first step has been chosen.
    pub fn started(&self) -> bool {
        self.memory.step > 0.0
    }

    /// Chooses the first step from the velocities and accelerations: `h = 0.4 / Ω (ε/10⁻¹⁰)^{1/16}`, `Ω⁴ = Σ (q̇⁴ + q̈²)`.
    pub fn start(&mut self, mechanism: &Mechanism, state: &State, kernel: &mut dyn Step) {
        let mut accelerations = vec![0.0; mechanism.velocity_count];
        self.memory.kinetic = kernel.energy().kinetic;
        kernel.accelerations(1e-4, &mut accelerations);
        let power: f64 = state
            .velocity
            .iter()
            .zip(&accelerations)
            .map(|(rate, acceleration)| rate.powi(4) + acceleration.powi(2))
            .sum();
        let rate = power.sqrt().sqrt();
        let length = FIRST * (self.stop / FIRST_STOP).powf(FIRST_POWER);
        self.memory.step = if rate.is_finite() { (length / rate.max(1e-3)).min(1.0) } else { 1e-3 };
    }

    /// The guess of the first attempt at a step.
    fn first_guess(&self, stepper: &Stepper) -> Guess {
        if self.memory.plainly > 0 { Guess::Plain } else { stepper.first_guess() }
    }

    /// One step of the length that this controller chooses.
    pub(crate) fn advance(
        &mut self,
        stepper: &mut Stepper,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        until: f64,
    ) -> Result<StepOutcome, StepError> {
        let mut outcome = StepOutcome::default();
        if !self.started() {
            self.start(mechanism, state, stepper.kernel.as_mut());
        } else if let Some(settling) = stepper.settling_at_start(mechanism, state, self.memory.step, self.tolerance) {
            self.settle(self.memory.step, settling);
        }
        let mut guess = self.first_guess(stepper);
        let mut misled = false;
        let longest = self.memory.step.min(until - state.time);
        let resolved = mechanism.resolved_step(state.time, longest, until);
        let mut until = if resolved < longest { state.time + resolved } else { until };
        loop {
            let Stride { length, end, .. } = Stride::towards(until, state.time, self.memory.step);
            let rule = self.rule_for(length);
            let rule = self.beside_dampers(rule, stepper.decay(mechanism), length);
            let attempt = stepper.attempt(mechanism, inputs, state, length, &rule, guess);
            outcome.cost.iterations += attempt.iterations();
            let energies = match attempt {
                Attempt::Converged { exact, legendre, .. } => {
                    outcome.exact = exact;
                    if let Some(companion) = &mut stepper.companion {
                        companion.see(length, legendre, self.limit, self.wanted, self.stop);
                    }
                    Some(if !exact && self.is_likely_kept(legendre) {
                        stepper.finish_both(mechanism, state, end)
                    } else {
                        stepper.finish(mechanism, state)
                    })
                }
                _ => None,
            };
            let mut decision = self.judge(&attempt, energies, length, guess);
            if decision == Decision::Accept
                && let Some(longest) = stepper.too_long_for_stability(mechanism, length)
            {
                self.keep_below(longest);
                decision = Decision::Retry { guess: Guess::Longer(length), why: Rejected::NotSmooth };
            }
            if decision == Decision::Accept
                && let Some(longest) = stepper.too_long_for_drag(mechanism, state, length, self.stop)
            {
                outcome.cost.reject(Rejected::NotSmooth);
                until = state.time + longest;
                guess = Guess::Longer(length);
                continue;
            }
            match decision {
                Decision::Accept => {
                    stepper.accept(mechanism, state, length, end, &mut outcome)?;
                    outcome.exchange.dissipated -= self.memory.ringing;
                    self.memory.plainly = if misled { PLAINLY } else { self.memory.plainly.saturating_sub(1) };
                    if let Attempt::Converged { legendre, .. } = attempt {
                        self.look_inside(stepper, mechanism, legendre);
                    }
                    self.keep_below(stepper.watch.safe_step());
                    if let Some(settling) = stepper.watch.take_settling(state.time, self.tolerance) {
                        self.settle(length, settling);
                    }
                    return Ok(outcome);
                }
                Decision::Retry { guess: next, why } => {
                    outcome.cost.reject(why);
                    // The plain guess is tried with the same length.
                    self.memory.rejected |= next != Guess::Plain;
                    misled = next == Guess::Plain;
                    guess = if next == Guess::Past { self.first_guess(stepper) } else { next };
                    let given_up = matches!(attempt, Attempt::Failed { .. })
                        && next != Guess::Plain
                        && length <= self.given_up_below;
                    // Below this the step vanishes against the time itself.
                    if given_up || self.memory.step < 1e-13 * state.time.abs().max(1e-3) {
                        stepper.abandon(&outcome.cost);
                        return Err(stepper.failure(mechanism, state.time, length, &attempt));
                    }
                }
            }
        }
    }

    /// Goes on with steps of `settling` seconds, and as accurately as ever from steps of `long` seconds on.
    fn settle(&mut self, long: f64, settling: f64) {
        self.memory.settling = Some(long);
        self.memory.step = self.memory.step.min(settling);
    }

    /// Whether a solved step with this E is likely to be kept, by its energy, too: the work of a companion in a rejected step is lost. After a step
    /// that changed the energy too much, steps with a large E often do so again.
    pub(crate) fn is_likely_kept(&self, legendre: f64) -> bool {
        legendre <= if self.memory.wary > 0 { LIKELY * self.wanted } else { self.limit }
    }

    /// Bounds the next step by one that is known to be stable (s).
    pub fn keep_below(&mut self, longest: f64) {
        self.held |= longest < self.memory.step;
        self.memory.step = self.memory.step.min(longest);
    }

    /// Whether stability has ever bounded a step.
    pub fn was_held(&self) -> bool {
        self.held
    }
}
