//! Groups of bodies that form and fall apart: each has its own steps as long as it meets no other.
//!
//! ```text
//!     x(t_k) ─ Meeting::groups ─▶ groups, L ─▶ runs of new groups go on from what those before hand on
//!     each group ─ its own steps ─▶ t_(k+1) = t_k + L, and how far its bodies have moved ─ Meeting::met ─▶ groups that may have met
//!     these go back to t_k, as one group, and again to t_(k+1); then all are shown up to there
//! ```
//!
//! All groups are at t_k together (s), the end of a step of each. Samples are shown once it is proved that no pair of two groups can have met between t_k
//! and t_(k+1). A run depends on its bodies alone and on the instants t_k, which depend on states: it is the same to the last bit, whatever the threads.
//!
//! Source: B. Mirtich, Timewarp Rigid Body Simulation, SIGGRAPH 2000 (groups go back where they have met).

use crate::instant::moved::Moved;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::integrator::Integrator;
use crate::mechanism::motion::kinematics::{body_states, place_bodies};
use crate::mechanism::motion::state::State;
use crate::mechanism::structure::islands::{Island, group};
use crate::simulation::parallel::groups::{Begins, Division, Groups, hold};
use crate::simulation::parallel::island::{IslandRun, first_error};
use crate::simulation::parallel::islands::{Islands, awake, sampling_rate};
use crate::simulation::parallel::merged::MergedRun;
use crate::simulation::parallel::partition::rests;
use crate::simulation::parallel::threads::spread;
use crate::simulation::steps::course::{Aim, RunError, RunOptions};
use crate::simulation::steps::observer::Observer;
use crate::simulation::tolerance::estimated_run::EstimatedRun;
use crate::simulation::tolerance::handed::{Companion, Fineness, Handed};
use crate::stepping::integrator::MethodError;
use std::time::Instant;

/// A group that would leave less than this part of its time to the end goes on to the end.
const SLIVER: f64 = 1e-6;

/// How far groups that are put together go back.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Back {
    /// They are where all are.
    Nowhere,
    /// To where their present time began: they may have met since.
    ToTheBeginning,
}

impl<'a> Islands<'a> {
    /// Prepares another beginning from a state: groups as fine as the runs of their bodies ask for.
    ///
    /// # Errors
    /// [`MethodError`] for invalid steps.
    pub(crate) fn begin_groups_again(&mut self, mechanism: &Mechanism, state: &State) -> Result<(), MethodError> {
        let Some(mut own) = self.groups.take() else { return Ok(()) };
        // Bodies that have been in one group share their errors.
        let mut fineness: Vec<Option<Fineness>> = vec![None; mechanism.bodies.len()];
        for part in &mut self.parts {
            if let Some(next) = part.awake.as_mut().and_then(EstimatedRun::next_fineness) {
                let kin = own.kin[part.island.body_of_whole(0)];
                let of_kin = fineness.iter_mut().zip(&own.kin).filter(|(_, other)| **other == kin);
                of_kin
                    .for_each(|(known, _)| *known = Some(known.take().map_or(next.clone(), |known| known.with(&next))));
            }
        }
        (own.groups, own.length) = own.meeting.groups(&body_states(mechanism, state), None);
        own.begin(state);
        let count = own.groups.iter().max().map_or(0, |last| last + 1);
        let mut parts = Vec::with_capacity(count);
        for number in 0..count {
            let island = group(mechanism, &own.groups, number);
            let mut part = IslandRun::new(island, state);
            if !rests(&part.island.mechanism, &part.state, &self.kept, None) {
                let all = (0..own.groups.len()).filter(|&body| own.groups[body] == number);
                let finest = all.filter_map(|body| fineness[body].clone()).reduce(|one, other| one.with(&other));
                part.awake = Some(own.first(&part.island.mechanism, finest)?);
            }
            parts.push(part);
        }
        self.parts = parts;
        self.groups = Some(own);
        Ok(())
    }

    /// Makes steps until all groups are at `until` (s) or at the end of the run, and calls the observers with merged results.
    pub(super) fn proceed_in_groups(
        &mut self,
        own: &mut Groups<'a>,
        mechanism: &Mechanism,
        until: f64,
        options: &RunOptions,
        observers: &mut [&mut dyn Observer],
        whole: &mut MergedRun,
    ) -> Result<(), RunError> {
        let end = whole.end.min(until);
        let mut bodies = body_states(mechanism, &own.at);
        while own.at.time < end {
            let next = own.at.time + own.length;
            let next = if end - next < SLIVER * own.length { end } else { next };
            own.see_held(&self.parts, mechanism);
            own.mark_beginning(&mut self.parts);
            loop {
                let ended = self.go_to(next, options);
                if let Err(RunError::BeginsAgain { .. }) = ended {
                    return ended;
                }
                let mut moved = vec![Moved::default(); bodies.len()];
                for part in &self.parts {
                    let way = part.course.as_ref().map_or(&[][..], |course| course.moved());
                    way.iter().enumerate().for_each(|(body, &way)| moved[part.island.body_of_whole(body)] = way);
                }
                let met = own.meeting.met(&bodies, &moved, &own.groups);
                if met.is_empty() {
                    let mut awake = awake(&mut self.parts);
                    if !awake.is_empty() {
                        whole.take(mechanism, &mut awake, observers)?;
                    }
                    ended.map_err(|error| match error {
                        RunError::Interrupted { .. } => RunError::Interrupted { time: whole.state.time },
                        error => error,
                    })?;
                    break;
                }
                let joined = Division::joining(&own.groups, &met);
                self.regroup(own, joined, Back::ToTheBeginning, mechanism, options, whole)?;
                own.mark_beginning(&mut self.parts);
            }
            if self.parts.iter().all(|part| part.awake.is_none()) {
                whole.show_rest(mechanism, next, options, observers)?;
            }
            self.parts.iter_mut().for_each(|part| part.state.time = next);
            self.gather(&mut own.at);
            place_bodies(mechanism, &own.at, &mut bodies);
            let (groups, length) = own.meeting.groups(&bodies, Some(&own.groups));
            own.length = length;
            if next < whole.end && groups != own.groups {
                own.see_held(&self.parts, mechanism);
                self.regroup(own, groups, Back::Nowhere, mechanism, options, whole)?;
            }
        }
        Ok(())
    }

    /// Makes steps of all groups to a time (s); an error is the first one.
    fn go_to(&mut self, next: f64, options: &RunOptions) -> Result<(), RunError> {
        let mut awake = awake(&mut self.parts);
        awake.retain(|part| part.state.time < next);
        let clock = Instant::now();
        let threads = self.threads.for_work_of(self.took);
        // The largest group comes first, because a large one started last would delay the end.
        awake.sort_by_key(|part| std::cmp::Reverse(part.island.mechanism.bodies.len()));
        spread(&mut awake, threads, |part| part.proceed(Aim { horizon: next, until: next }, options));
        self.took = clock.elapsed().as_secs_f64();
        first_error(&mut awake).map_or(Ok(()), Err)
    }

    /// Makes the runs of these groups from the old ones; groups that are the same stay.
    fn regroup(
        &mut self,
        own: &mut Groups<'a>,
        groups: Vec<usize>,
        back: Back,
        mechanism: &Mechanism,
        options: &RunOptions,
        whole: &mut MergedRun,
    ) -> Result<(), RunError> {
        let Division { members, stays } = Division::new(&own.groups, &groups);
        let mut old: Vec<Option<IslandRun>> = std::mem::take(&mut self.parts).into_iter().map(Some).collect();
        let mut handed = HandedOn { by: old.iter().map(|_| None).collect(), companion: own.at.clone(), again: false };
        for &one in members.iter().zip(&stays).filter(|(_, stays)| !**stays).flat_map(|(members, _)| members) {
            if let Some(part) = &mut old[one] {
                handed.take(one, part, back, own.at.time);
            }
        }
        if handed.again {
            self.parts = old.into_iter().flatten().collect();
            return Err(RunError::BeginsAgain { time: own.at.time });
        }
        own.set(groups);
        for (number, (members, stays)) in members.iter().zip(stays).enumerate() {
            if stays && let Some(part) = old[members[0]].take() {
                self.parts.push(part);
                continue;
            }
            let mut island = group(mechanism, &own.groups, number);
            hold(&mut island, mechanism, &own.held, own.at.time);
            let mut part = IslandRun::new(island, &own.at);
            let begins = handed.to(members, &part.island);
            let made = (own.make)(&part.island.mechanism, begins);
            part.awake = Some(made.map_err(|error| RunError::Observer(error.into()))?);
            if !own.efforts.is_empty() {
                part.set_efforts(&own.efforts);
            }
            own.aimed.iter().for_each(|&(freedom, value)| part.aim(freedom, value));
            part.begin_within(whole.start, options.duration, sampling_rate(options))?;
            self.parts.push(part);
        }
        for (number, part) in old.iter().enumerate() {
            let Some(part) = part else { continue };
            whole.let_go(part);
            if let Some(run) = &part.awake {
                let mut method = run.description();
                own.take_times(number, &part.island, &mut method, back == Back::ToTheBeginning);
                own.gone = own.gone.take().into_iter().chain([(method, part.steps)]).reduce(Islands::add);
            }
        }
        Ok(())
    }

    /// Puts the states of all groups together.
    fn gather(&self, whole: &mut State) {
        for IslandRun { island, state, .. } in &self.parts {
            island.put_state(state, whole);
            whole.time = state.time;
        }
    }
}

/// The handed-on parts of groups that are no more.
struct HandedOn {
    /// By the numbers of the groups.
    by: Vec<Option<Handed>>,
    /// The motions beside them, put together; the runs themselves for those without.
    companion: State,
    /// Whether one of them was too coarse: the run begins again.
    again: bool,
}

impl HandedOn {
    /// Takes a group over at an instant (s).
    fn take(&mut self, number: usize, part: &mut IslandRun, back: Back, time: f64) {
        let IslandRun { island, state, awake: Some(run), .. } = part else { return };
        if self.by[number].is_some() {
            return;
        }
        let given = match back {
            Back::Nowhere => run.hand_on(&island.mechanism, state),
            Back::ToTheBeginning => run.hand_back(&island.mechanism, time),
        };
        if let Some(at) = given.as_ref().and_then(|given| given.companion.as_ref()) {
            island.put_state(&at.state, &mut self.companion);
        }
        self.again |= given.is_none();
        self.by[number] = given;
    }

    /// The beginning of a group of bodies of these groups.
    fn to(&self, members: &[usize], island: &Island) -> Begins {
        let mut all = members.iter().filter_map(|&one| self.by[one].as_ref());
        let Some(mut given) = all.next().cloned() else { return Begins::First(None) };
        let mut is_finer = given.companion.as_ref().map(|companion| companion.is_finer);
        for other in all {
            given.add(other);
            is_finer = is_finer.max(other.companion.as_ref().map(|companion| companion.is_finer));
        }
        given.companion = is_finer.map(|is_finer| Companion { state: island.state(&self.companion), is_finer });
        Begins::GoingOn(Box::new(given))
    }
}
