//! The run of the whole mechanism, merged from the runs of the islands in order of time.

use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::forces::total::Exchange;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::energy::{Energy, energy_with_forces, violation};
use crate::mechanism::motion::event::Event;
use crate::mechanism::motion::gaps::worse;
use crate::mechanism::motion::integrator::StepOutcome;
use crate::mechanism::motion::kinematics::{body_states, place_bodies};
use crate::mechanism::motion::state::State;
use crate::simulation::parallel::island::{IslandRun, frontier, put_held};
use crate::simulation::steps::course::{RunError, RunOptions, held_at};
use crate::simulation::steps::observer::{Observer, Sample, StepEnd, show};
use crate::simulation::steps::summary::{KEPT_EVENTS, Summary, moved_by_motors};
use crate::simulation::tolerance::accuracy_so_far::AccuracySoFar;
use std::collections::VecDeque;
use std::sync::atomic::Ordering;

/// The run of the whole mechanism, merged from the runs of the islands.
pub(crate) struct MergedRun {
    pub(crate) start: f64,
    pub(crate) end: f64,
    /// Whether observers want samples inside the run.
    sampled: bool,
    /// The last sample. Its positions are without the rounded-off parts.
    pub(crate) state: State,
    pub(crate) bodies: Vec<BodyState>,
    pub(crate) summary: Summary,
    /// Sums over the islands at the last step taken over (J).
    kinetic: f64,
    deviation: f64,
    exchange: Exchange,
    /// Whether there are motors.
    driven: bool,
    largest_kinetic: f64,
    largest_deviation: f64,
    /// Total cost of the steps since the last sample, and the number of steps before it.
    since: StepOutcome,
    steps_before: usize,
    /// Steps to be merged, with the numbers of their islands.
    waiting: Vec<(StepEnd, usize)>,
    /// Number of samples after the first that were shown while every island was at rest.
    rested: u64,
    /// The first events.
    pub(crate) events: Vec<Event>,
    /// The contacts of the last sample.
    contacts: Vec<ContactPoint>,
    /// The efforts that sampled motors hold at the last sample, if there are such motors.
    held: Option<Vec<Option<f64>>>,
    /// How the energies of groups that are no more have changed, their exchanges (J), and the CPU time of their steps (s).
    changed: Energy,
    exchanged: Exchange,
    pub(super) spent: f64,
}

impl MergedRun {
    pub(crate) fn new(mechanism: &Mechanism, state: &State, options: &RunOptions) -> Self {
        let bodies = body_states(mechanism, state);
        let summary = Summary::at_start(mechanism, state, &bodies);
        let initial = summary.initial_energy;
        MergedRun {
            start: state.time,
            end: state.time + options.duration,
            sampled: options.rate.is_some(),
            state: State { compensation: vec![0.0; state.position.len()], ..state.clone() },
            summary,
            bodies,
            kinetic: initial.kinetic,
            deviation: 0.0,
            exchange: Exchange::default(),
            driven: !mechanism.nonsmooth.motors.is_empty(),
            largest_kinetic: initial.kinetic,
            largest_deviation: 0.0,
            since: StepOutcome::default(),
            steps_before: 0,
            waiting: Vec::new(),
            rested: 0,
            events: Vec::new(),
            contacts: Vec::new(),
            held: held_at(mechanism, state),
            changed: Energy::default(),
            exchanged: Exchange::default(),
            spent: 0.0,
        }
    }

    /// Takes over the figures of a group that is no more.
    pub(super) fn let_go(&mut self, part: &IslandRun) {
        add_change(&mut self.changed, &part.last.energy, &part.initial);
        self.exchanged += part.last.exchange;
        if let Some(course) = &part.course {
            let summary = course.summary();
            self.spent += summary.solve_cpu_seconds;
            self.summary.see_part(&summary);
        }
    }

    /// Merges everything up to the time that all islands have reached, in order of time.
    pub(crate) fn take(
        &mut self,
        mechanism: &Mechanism,
        awake: &mut [&mut IslandRun],
        observers: &mut [&mut dyn Observer],
    ) -> Result<(), RunError> {
        loop {
            let ready = awake.iter().all(|part| !part.shown.samples.is_empty());
            let until = match awake.first().and_then(|part| part.shown.samples.front()) {
                Some(sample) if ready => sample.time,
                // A rest may be after the end, and counts.
                _ if frontier(awake) >= self.end => f64::INFINITY,
                _ => frontier(awake),
            };
            let mut happened = take_events(awake, until);
            self.take_steps(awake, until, &mut happened, observers);
            self.tell(&mut happened, f64::INFINITY, observers);
            self.take_accuracy(awake, until, observers);
            if !ready {
                return Ok(());
            }
            self.contacts.clear();
            for part in awake.iter_mut() {
                let Some(sample) = part.shown.samples.pop_front() else { continue };
                let island = &part.island;
                self.contacts.extend_from_slice(&sample.contacts);
                if let Some(held) = &mut self.held {
                    put_held(island, &sample.held, &mechanism.nonsmooth.motors, held);
                }
                island.put(&sample.position, &mut self.state.position, |piece| &piece.positions);
                island.put(&sample.velocity, &mut self.state.velocity, |piece| &piece.velocities);
                (part.last_sample, part.at_sample) = (Some(sample), None);
            }
            place_bodies(mechanism, &self.state, &mut self.bodies);
            self.state.time = until;
            self.show(mechanism, observers)?;
        }
    }

    /// Counts events up to `until`, and passes them to the observers.
    fn tell(&mut self, happened: &mut VecDeque<Event>, until: f64, observers: &mut [&mut dyn Observer]) {
        // A time that is not a number is the last.
        let count = happened.iter().take_while(|event| until == f64::INFINITY || event.time <= until).count();
        for event in happened.drain(..count) {
            self.summary.events.count(event.kind);
            observers.iter_mut().for_each(|observer| observer.event(&event));
            if self.events.len() < KEPT_EVENTS {
                self.events.push(event);
            }
        }
    }

    /// Takes the accuracies of the islands up to `until`, and passes the accuracy of the whole to the observers.
    fn take_accuracy(&mut self, awake: &mut [&mut IslandRun], until: f64, observers: &mut [&mut dyn Observer]) {
        let mut has_news = false;
        for part in awake.iter_mut() {
            let count = part.shown.told.partition_point(|so_far| so_far.time <= until);
            if let Some(so_far) = part.shown.told.drain(..count).next_back() {
                (part.so_far, has_news) = (Some(so_far), true);
            }
        }
        if !has_news || awake.iter().any(|part| part.so_far.is_none()) {
            return;
        }
        if let Some(so_far) = AccuracySoFar::together(awake.iter().filter_map(|part| part.so_far)) {
            observers.iter_mut().for_each(|observer| observer.accuracy(&so_far));
        }
    }

    /// Merges all steps that end at or before `until`, and passes those with events to the observers, after the events.
    fn take_steps(
        &mut self,
        awake: &mut [&mut IslandRun],
        until: f64,
        happened: &mut VecDeque<Event>,
        observers: &mut [&mut dyn Observer],
    ) {
        for (number, part) in awake.iter_mut().enumerate() {
            let steps = &mut part.shown.steps;
            let count = steps.partition_point(|end| end.time <= until);
            self.waiting.extend(steps.drain(..count).map(|end| (end, number)));
        }
        // Stable: what ends at the same time stays in the order of the islands.
        self.waiting.sort_by(|(a, _), (b, _)| a.time.total_cmp(&b.time));
        let mut waiting = std::mem::take(&mut self.waiting);
        let mut rest = waiting.as_slice();
        while let Some((first, _)) = rest.first() {
            let (instant, later) = rest.split_at(rest.partition_point(|(end, _)| end.time <= first.time).max(1));
            rest = later;
            let impacts = instant.iter().map(|(end, _)| end.outcome.exchange.impacts.max(0.0)).sum::<f64>();
            instant.iter().for_each(|(end, number)| self.take_step(awake[*number], end));
            // The energy balance is complete when all steps that end at the same time are merged.
            self.largest_kinetic = self.largest_kinetic.max(self.kinetic + impacts);
            self.summary.largest_kinetic = self.largest_kinetic;
            self.largest_deviation = worse(self.largest_deviation, self.deviation.abs());
            if happened.iter().any(|event| event.time == first.time) && !observers.is_empty() {
                self.tell(happened, first.time, observers);
                let end = self.whole_end(awake, instant, later);
                observers.iter_mut().for_each(|observer| observer.step(&end));
            }
        }
        waiting.clear();
        self.waiting = waiting;
        let moved = if self.driven { moved_by_motors(&self.exchange, &self.summary.initial_energy) } else { 0.0 };
        let scale = self.largest_kinetic.max(moved);
        self.summary.max_energy_error = self.largest_deviation;
        self.summary.max_relative_energy_error =
            if scale > 0.0 { self.largest_deviation / scale } else { self.largest_deviation };
        self.summary.exchange = self.exchange;
    }

    /// Takes one step of an island into the sums.
    fn take_step(&mut self, part: &mut IslandRun, end: &StepEnd) {
        let (before, deviation) = (part.last, part.deviation);
        part.take(end);
        let after = part.last;
        self.kinetic += after.energy.kinetic - before.energy.kinetic;
        self.deviation += part.deviation - deviation;
        self.exchange.dissipated += after.exchange.dissipated - before.exchange.dissipated;
        self.exchange.work += after.exchange.work - before.exchange.work;
        self.exchange.friction += after.exchange.friction - before.exchange.friction;
        self.exchange.impacts += after.exchange.impacts - before.exchange.impacts;
        self.summary.count(&end.outcome, end.violation);
        self.since.step += end.outcome.step;
        self.since.cost.add(&end.outcome.cost);
        self.since.exchange.dissipated += end.outcome.exchange.dissipated;
        self.since.exchange.work += end.outcome.exchange.work;
    }

    /// The figures of the whole at an instant at which steps end, with those that end later.
    fn whole_end(
        &self,
        awake: &mut [&mut IslandRun],
        instant: &[(StepEnd, usize)],
        later: &[(StepEnd, usize)],
    ) -> StepEnd {
        let (mut end, _) = instant[instant.len() - 1];
        (end.energy, end.exchange, end.so_far) = (self.summary.initial_energy, self.exchanged, self.summary.counts());
        end.deviation = self.deviation;
        add_change(&mut end.energy, &self.changed, &Energy::default());
        end.outcome.exchange.impacts = instant.iter().map(|(end, _)| end.outcome.exchange.impacts).sum();
        for (number, part) in awake.iter_mut().enumerate() {
            let waits = later.iter().find(|(_, of)| *of == number).map(|(next, _)| *next);
            let next = waits.or_else(|| part.shown.steps.front().copied());
            let own = part.between(end.time, next.as_ref());
            // Islands that sleep keep their energies of the start.
            add_change(&mut end.energy, &own.energy, &part.initial);
            end.exchange += own.exchange;
        }
        end
    }

    /// Passes the last sample to the observers, if they want it, with the figures of its instant.
    pub(crate) fn show(&mut self, mechanism: &Mechanism, observers: &mut [&mut dyn Observer]) -> Result<(), RunError> {
        let time = self.state.time;
        let wanted = self.sampled || time == self.start || time == self.end;
        if observers.is_empty() || !wanted {
            return Ok(());
        }
        let mut outcome = std::mem::take(&mut self.since);
        let so_far = self.summary.counts();
        let steps = so_far.steps;
        outcome.step /= (steps - std::mem::replace(&mut self.steps_before, steps)).max(1) as f64;
        let step = StepEnd {
            time,
            energy: energy_with_forces(mechanism, &self.state.position, &self.bodies),
            exchange: self.exchange,
            deviation: self.deviation,
            violation: violation(mechanism, &self.state, &self.bodies),
            outcome,
            so_far,
        };
        if !mechanism.nonsmooth.pairs.is_empty() {
            // Stable: several points of a pair stay in their order.
            self.contacts.sort_by_key(|point| point.pair);
            observers.iter_mut().for_each(|observer| observer.contacts(&self.contacts));
        }
        if let Some(held) = &self.held {
            observers.iter_mut().for_each(|observer| observer.held_efforts(held));
        }
        let State { position, velocity, .. } = &self.state;
        show(observers, &Sample { time, position, velocity, step: &step }).map_err(RunError::Observer)
    }

    /// Passes samples of a run without motion to the observers, up to `until` (s).
    pub(crate) fn show_rest(
        &mut self,
        mechanism: &Mechanism,
        until: f64,
        options: &RunOptions,
        observers: &mut [&mut dyn Observer],
    ) -> Result<(), RunError> {
        let end = self.end.min(until);
        while self.state.time < end {
            if options.interrupt.is_some_and(|flag| flag.load(Ordering::Relaxed)) {
                return Err(RunError::Interrupted { time: self.state.time });
            }
            let next =
                options.rate.map_or(self.end, |rate| (self.start + (self.rested + 1) as f64 / rate).min(self.end));
            if next > end {
                self.state.time = end;
                return Ok(());
            }
            self.rested += 1;
            self.state.time = next;
            self.show(mechanism, observers)?;
        }
        Ok(())
    }
}

/// Adds the change of energies from `before` to `after` (J).
fn add_change(sum: &mut Energy, after: &Energy, before: &Energy) {
    sum.kinetic += after.kinetic - before.kinetic;
    sum.potential += after.potential - before.potential;
    sum.spring += after.spring - before.spring;
    sum.load += after.load - before.load;
}

/// Takes all events of the islands up to `until`, in the order of their times.
fn take_events(awake: &mut [&mut IslandRun], until: f64) -> VecDeque<Event> {
    let mut happened = Vec::new();
    for IslandRun { island, shown, .. } in awake.iter_mut().map(|part| &mut **part) {
        let of_whole = |event: &Event| Event { body: island.body_of_whole(event.body), ..*event };
        // A rest after infinitely many impacts is told before it happens: later events may be earlier.
        shown.events.retain(|event| {
            let waits = event.time > until;
            happened.extend((!waits).then(|| of_whole(event)));
            waits
        });
    }
    // The sort is stable: events of one instant stay in the order of the islands.
    happened.sort_by(|a, b| a.time.total_cmp(&b.time));
    happened.into()
}
