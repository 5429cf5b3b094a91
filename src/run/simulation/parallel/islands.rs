//! Runs of independent mechanisms in parallel: each island with its own integrator. Islands at rest are not integrated.
//!
//! The islands are not coupled ([`crate::mechanism::structure::islands`]). So each has its own loop ([`crate::simulation`]) and steps, as if it were
//! alone. Afterwards their results are merged in order of time:
//!
//! - a sample of the whole consists of the samples of all islands at the same instant, from their own dense outputs;
//! - the figures of a run add up over the ends of all steps of all islands: the energy balance at an instant is the sum of the
//!   balances at each island's last step;
//! - the figures of a sample are those at its instant, because the islands have no common end of a step.
//!
//! Small islands are faster together ([`Plan::grouped`](crate::simulation::parallel::partition::Plan::grouped)). Islands advance in windows of
//! simulated time, in parallel on the available threads. An island depends neither on the windows nor on the others, and merging is in order of time
//! and number. So every result is bit-identical, whatever the windows and the number of threads.

use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::nonsmooth::Motor;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::energy::energy_with_forces;
use crate::mechanism::motion::event::JointStatus;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::{Integrator, MethodDescription};
use crate::mechanism::motion::kinematics::place_bodies;
use crate::mechanism::motion::state::State;
use crate::simulation::method::run_integrator::RunIntegrator;
use crate::simulation::method::step_choice::StepChoice;
use crate::simulation::parallel::groups::Groups;
use crate::simulation::parallel::island::{IslandRun, first_error, frontier};
use crate::simulation::parallel::merged::MergedRun;
use crate::simulation::parallel::partition::Plan;
use crate::simulation::parallel::threads::{Threads, spread};
use crate::simulation::steps::course::{Aim, RunError, RunOptions};
use crate::simulation::steps::observer::Observer;
use crate::simulation::steps::summary::Summary;
use crate::simulation::tolerance::estimated_run::EstimatedRun;
use crate::stepping::integrator::MethodError;
use std::time::Instant;

/// A window should take this long (s of wall time): long against starting threads, short against a user's patience.
const WINDOW: f64 = 0.02;
/// Samples that the run takes without observers, so that a failed run has a last state.
const CHECKPOINTS: f64 = 16.0;

/// The integrators of all islands of a mechanism.
pub struct Islands<'a> {
    pub(super) parts: Vec<IslandRun<'a>>,
    pub(super) threads: Threads,
    /// The window of simulated time for all islands, and the wall time of the last one (s).
    window: f64,
    pub(super) took: f64,
    pub(super) kept: Vec<Rule>,
    /// Which bodies are one group for now, if groups form and fall apart.
    pub(super) groups: Option<Groups<'a>>,
}

/// The figures of an island in a run, for the report.
#[derive(Clone, Debug)]
pub struct IslandFigures {
    /// The bodies that are jointed to the world.
    pub roots: Vec<String>,
    /// Number of its bodies.
    pub bodies: usize,
    /// How it was integrated; `None` if it slept.
    pub method: Option<MethodDescription>,
    /// Accepted steps.
    pub steps: usize,
    /// Their iterations.
    pub iterations: usize,
}

/// A copy of an island in a run: its state, and its integrator if it does not sleep.
#[derive(Clone)]
pub(crate) struct KeptIsland {
    state: State,
    awake: Option<RunIntegrator>,
}

impl<'a> Islands<'a> {
    /// Makes the integrators of the awake islands, each with a note for the caller, in the order of these islands.
    ///
    /// # Errors
    /// The first error of `make`, in the order of the islands.
    pub fn new<I: Into<EstimatedRun<'a>>, N, E>(
        plan: Plan,
        state: &State,
        threads: Threads,
        make: impl Fn(&Mechanism, &State) -> Result<(I, N), E>,
    ) -> Result<(Self, Vec<N>), E> {
        let kept = plan.kept;
        let (mut parts, mut notes) = (Vec::with_capacity(plan.islands.len()), Vec::new());
        for (island, asleep) in plan.islands {
            let mut part = IslandRun::new(island, state);
            if !asleep {
                let (integrator, note) = make(&part.island.mechanism, &part.state)?;
                part.awake = Some(integrator.into());
                notes.push(note);
            }
            parts.push(part);
        }
        Ok((Islands { parts, threads, window: 0.0, took: 0.0, kept, groups: None }, notes))
    }

    /// The same, whose groups form and fall apart.
    #[must_use]
    pub(crate) fn regrouped(self, groups: Groups<'a>) -> Self {
        Islands { groups: Some(groups), ..self }
    }

    /// The run of all groups together, if they form and fall apart; from the start of the run on.
    pub(crate) fn joined(&self, mechanism: &Mechanism) -> Option<Result<EstimatedRun<'a>, MethodError>> {
        self.groups.as_ref().map(|groups| groups.first(mechanism, None))
    }

    /// Whether groups form and fall apart.
    pub(crate) fn are_regrouped(&self) -> bool {
        self.groups.is_some()
    }

    /// Gives the motor along this freedom of the whole a target from now on.
    pub(crate) fn aim(&mut self, freedom: usize, value: f64) {
        if let Some(groups) = &mut self.groups {
            groups.aimed.retain(|(other, _)| *other != freedom);
            groups.aimed.push((freedom, value));
        }
        self.parts.iter_mut().for_each(|part| part.aim(freedom, value));
    }

    /// A copy of all islands; `None` if they estimate their errors, or if groups form and fall apart.
    pub(crate) fn keep(&self) -> Option<Vec<KeptIsland>> {
        if self.groups.is_some() {
            return None;
        }
        let kept = self.parts.iter().map(|part| {
            let awake = match &part.awake {
                None => None,
                Some(run) => Some(run.alone()?.clone()),
            };
            Some(KeptIsland { state: part.state.clone(), awake })
        });
        kept.collect()
    }

    /// Goes on from a copy; stays as it is and returns `false` if the copy is of other islands.
    pub(crate) fn restore(&mut self, kept: &[KeptIsland]) -> bool {
        let alike = |(part, kept): (&IslandRun, &KeptIsland)| part.state.velocity.len() == kept.state.velocity.len();
        if self.groups.is_some() || self.parts.len() != kept.len() || !self.parts.iter().zip(kept).all(alike) {
            return false;
        }
        for (part, kept) in self.parts.iter_mut().zip(kept) {
            part.state.copy_from(&kept.state);
            part.awake = kept.awake.clone().map(EstimatedRun::from);
            part.course = None;
        }
        true
    }

    /// The combined method of the awake islands, and of groups that are no more; `None` if all sleep.
    ///
    /// It has the largest number of stages, the mean step, and the smallest margin of stability of all islands.
    pub fn description(&self) -> Option<MethodDescription> {
        let gone = self.groups.as_ref().and_then(|groups| groups.gone.clone());
        let own = self.parts.iter().filter_map(|part| {
            let mut method = part.awake.as_ref()?.description();
            self.groups.iter().for_each(|groups| groups.add_times(&part.island, &mut method));
            Some((method, part.steps))
        });
        gone.into_iter().chain(own).reduce(Self::add).map(|(together, _)| together)
    }

    /// Two methods as one, each with the number of its steps.
    pub(super) fn add(
        (mut together, count): (MethodDescription, usize),
        (one, other): (MethodDescription, usize),
    ) -> (MethodDescription, usize) {
        let steps = count + other;
        if steps > 0 {
            together.step = (together.step * count as f64 + one.step * other as f64) / steps as f64;
        }
        together.stages = together.stages.max(one.stages);
        together.order = together.order.max(one.order);
        together.include_stability(&one);
        together.singular = together.singular.into_iter().chain(one.singular).max_by_key(|seen| seen.extra);
        together.unsolved_contacts += one.unsolved_contacts;
        together.contact_solvers.add(&one.contact_solvers);
        together.first_order_steps += one.first_order_steps;
        together.over_slips_steps += one.over_slips_steps;
        together.over_slips_time = together.over_slips_time.max(one.over_slips_time);
        together.few_stage_steps += one.few_stage_steps;
        together.rebounds_left_out += one.rebounds_left_out;
        together.rebounds_energy += one.rebounds_energy;
        together.first_order_residual = together.first_order_residual.max(one.first_order_residual);
        together.first_order_lift = together.first_order_lift.max(one.first_order_lift);
        together.first_order_asleep = together.first_order_asleep.max(one.first_order_asleep);
        together.first_order_time = together.first_order_time.max(one.first_order_time);
        together.reversible_resets = together.reversible_resets.zip(one.reversible_resets).map(|(a, b)| a + b);
        (together, steps)
    }

    /// The status of each body's joint (free, held, on a limit).
    pub(crate) fn joint_statuses(&self, bodies: usize) -> Vec<JointStatus> {
        let mut statuses = vec![JointStatus::default(); bodies];
        for IslandRun { island, state, awake, .. } in &self.parts {
            for body in 0..island.mechanism.bodies.len() {
                let status = awake.as_ref().map(|own| own.joint_status(&island.mechanism, state, body));
                statuses[island.body_of_whole(body)] = status.unwrap_or_default();
            }
        }
        statuses
    }

    /// Adds the closed contacts of all islands, in the order of their pairs.
    pub(crate) fn contacts(&self, out: &mut Vec<ContactPoint>) {
        for IslandRun { island, state, awake, .. } in &self.parts {
            awake.iter().for_each(|own| own.contacts(&island.mechanism, state, out));
        }
        // Stable: several points of a pair stay in their order.
        out.sort_by_key(|point| point.pair);
    }

    /// Puts the efforts that sampled motors hold from the present state on in their places of the whole, an entry a motor.
    pub(crate) fn held_efforts(&self, motors: &[Motor], whole: &mut [Option<f64>]) {
        self.parts.iter().for_each(|part| part.put_held(motors, whole));
    }

    /// Calls a function with each island that moves, and its state.
    pub(crate) fn each(&mut self, mut work: impl FnMut(&Mechanism, &State, &mut EstimatedRun)) {
        for IslandRun { island, state, awake, .. } in &mut self.parts {
            if let Some(run) = awake {
                work(&island.mechanism, state, run);
            }
        }
    }

    /// The figures of each island.
    pub fn figures(&self) -> impl Iterator<Item = IslandFigures> {
        self.parts.iter().map(|part| IslandFigures {
            roots: part.island.roots().map(str::to_string).collect(),
            bodies: part.island.mechanism.bodies.len(),
            method: part.awake.as_ref().map(Integrator::description),
            steps: part.steps,
            iterations: part.iterations,
        })
    }

    /// Runs all islands from their present states for `options.duration`, and calls the observers.
    ///
    /// `state` is moved to the end of the run, or, if it ends early, to the last sample that all islands have reached. The summary
    /// is filled in up to there.
    pub fn run(
        &mut self,
        mechanism: &Mechanism,
        state: &mut State,
        options: &RunOptions,
        observers: &mut [&mut dyn Observer],
    ) -> (Summary, Result<(), RunError>) {
        let mut whole = MergedRun::new(mechanism, state, options);
        let ended = self
            .begin_with(mechanism, state, options, observers, &mut whole)
            .and_then(|()| self.proceed(mechanism, f64::INFINITY, options, observers, &mut whole));
        self.settle(mechanism, state, &mut whole, ended.is_ok());
        (whole.summary, ended)
    }

    /// Begins a run from a state, and passes it to the observers.
    pub(crate) fn begin(
        &mut self,
        mechanism: &Mechanism,
        state: &State,
        options: &RunOptions,
        observers: &mut [&mut dyn Observer],
    ) -> Result<MergedRun, RunError> {
        let mut whole = MergedRun::new(mechanism, state, options);
        self.begin_with(mechanism, state, options, observers, &mut whole)?;
        Ok(whole)
    }

    fn begin_with(
        &mut self,
        mechanism: &Mechanism,
        state: &State,
        options: &RunOptions,
        observers: &mut [&mut dyn Observer],
        whole: &mut MergedRun,
    ) -> Result<(), RunError> {
        // The first window is one step of each island, to measure its time.
        (self.window, self.took) = (0.0, 0.0);
        if let Some(groups) = &mut self.groups {
            groups.begin(state);
        }
        for part in &mut self.parts {
            part.state = part.island.state(state);
            part.begin(options.duration, sampling_rate(options))?;
        }
        let mut awake = awake(&mut self.parts);
        if awake.is_empty() {
            return whole.show(mechanism, observers);
        }
        whole.take(mechanism, &mut awake, observers)
    }

    /// Sets the external efforts on each island, and wakes sleeping islands on which efforts act.
    pub(crate) fn wake(
        &mut self,
        inputs: Inputs,
        choice: StepChoice,
        whole: &MergedRun,
        options: &RunOptions,
    ) -> Result<(), RunError> {
        if let Some(groups) = &mut self.groups {
            groups.efforts = if inputs.is_none() { Vec::new() } else { inputs.efforts.to_vec() };
        }
        for part in &mut self.parts {
            if inputs.is_none() {
                part.efforts.clear();
            } else {
                part.set_efforts(inputs.efforts);
            }
            let driven = part.efforts.iter().any(|&effort| effort != 0.0);
            if part.awake.is_none() && driven {
                let Ok(integrator) = choice.integrator(&part.island.mechanism, &self.kept) else { continue };
                part.awake = Some(integrator.into());
                part.state.time = whole.state.time;
                part.begin_within(whole.start, options.duration, sampling_rate(options))?;
            }
        }
        Ok(())
    }

    /// Moves `state` to the present time of the run, or, after an error, to the last sample that all islands have reached.
    pub(crate) fn settle(&mut self, mechanism: &Mechanism, state: &mut State, whole: &mut MergedRun, together: bool) {
        let times = self.parts.iter().filter_map(|part| Some(part.course.as_ref()?.summary().solve_cpu_seconds));
        whole.summary.solve_cpu_seconds = times.fold(whole.spent, |sum, time| sum + time);
        for part in self.parts.iter().filter_map(|part| part.course.as_ref()) {
            whole.summary.see_part(&part.summary());
        }
        if together {
            for IslandRun { island, state: own, .. } in &self.parts {
                island.put_state(own, state);
            }
            let moving = self.parts.iter().filter(|part| part.awake.is_some()).map(|part| part.state.time);
            state.time = moving.reduce(f64::min).unwrap_or(whole.state.time);
        } else {
            state.copy_from(&whole.state);
        }
        place_bodies(mechanism, state, &mut whole.bodies);
        whole.summary.final_energy = energy_with_forces(mechanism, &state.position, &whole.bodies);
    }

    /// Makes steps until all islands are at `until` (s) or at the end of the run, and calls the observers with merged results.
    pub(crate) fn proceed(
        &mut self,
        mechanism: &Mechanism,
        until: f64,
        options: &RunOptions,
        observers: &mut [&mut dyn Observer],
        whole: &mut MergedRun,
    ) -> Result<(), RunError> {
        if let Some(mut groups) = self.groups.take() {
            let ended = self.proceed_in_groups(&mut groups, mechanism, until, options, observers, whole);
            self.groups = Some(groups);
            return ended;
        }
        let mut awake = awake(&mut self.parts);
        if awake.is_empty() {
            return whole.show_rest(mechanism, until, options, observers);
        }
        let end = whole.end.min(until);
        while frontier(&awake) < end {
            let begin = frontier(&awake);
            let aim = Aim { horizon: (begin + self.window).max(begin.next_up()), until };
            let clock = Instant::now();
            let threads = self.threads.for_work_of(self.took);
            // The largest island comes first, because a large one started last would delay the end.
            awake.sort_by_key(|part| std::cmp::Reverse(part.island.mechanism.bodies.len()));
            spread(&mut awake, threads, |part| part.proceed(aim, options));
            awake.sort_by_key(|part| part.island.pieces.first().map(|piece| piece.bodies.start));
            self.took = clock.elapsed().as_secs_f64();
            whole.take(mechanism, &mut awake, observers)?;
            if let Some(error) = first_error(&mut awake) {
                return Err(match error {
                    RunError::Interrupted { .. } => RunError::Interrupted { time: whole.state.time },
                    error => error,
                });
            }
            self.window = self.window.max(frontier(&awake) - begin) * (WINDOW / self.took).clamp(0.25, 4.0);
        }
        Ok(())
    }
}

/// The islands that move.
pub(super) fn awake<'p, 'a>(parts: &'p mut [IslandRun<'a>]) -> Vec<&'p mut IslandRun<'a>> {
    parts.iter_mut().filter(|part| part.awake.is_some()).collect()
}

/// Samples of each island per simulated second.
pub(super) fn sampling_rate(options: &RunOptions) -> f64 {
    options.rate.unwrap_or(CHECKPOINTS / options.duration)
}
