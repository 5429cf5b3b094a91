//! The estimate of a run that hands on to others where it ends, and of one that goes on from what others hand on.

use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;
use crate::simulation::method::run_integrator::RunIntegrator;
use crate::simulation::tolerance::error_estimate::{BOTH, By, ErrorEstimate};
use crate::simulation::tolerance::handed::{Companion, Fineness, Handed};
use crate::simulation::tolerance::terms::Terms;
use crate::stepping::integrator::MethodError;

/// The least part of the distance that is the error of a group. Its steps end with those of others and where groups change, as steps of its companion do, so
/// that the iterations of both leave errors that differ by less than their stops do.
const OF_GROUPS: f64 = 1.0 / 3.0;

impl<'a> ErrorEstimate<'a> {
    /// Hands on the run where it is, at the end of a step; `None` if it begins again.
    pub(crate) fn hand_on(&mut self, mechanism: &Mechanism, state: &State, run: &mut RunIntegrator) -> Option<Handed> {
        let looked = self.so_far.is_some_and(|so_far| so_far.time == state.time);
        if self.steps > 0 && !looked {
            self.look(mechanism, state, run);
        }
        if self.next.is_some() {
            return None;
        }
        Some(Handed { companion: self.companion_at(state.time), ..self.handed(state.time, run) })
    }

    /// The motion beside the run at an instant (s), if it was there.
    fn companion_at(&mut self, time: f64) -> Option<Companion> {
        match &self.by {
            By::Beside(beside) => {
                let is_finer = beside.is_finer();
                beside.at(time).map(|state| Companion { state: state.clone(), is_finer })
            }
            _ => self.companion.take(),
        }
    }

    /// Hands it on to a run that goes back to an instant (s); `None` if it begins again.
    pub(crate) fn hand_back(&mut self, mechanism: &Mechanism, time: f64, run: &RunIntegrator) -> Option<Handed> {
        if self.next.is_some() {
            return None;
        }
        if let By::Beside(beside) = &mut self.by {
            // One that fails is not handed on.
            let _ = beside.advance(mechanism, &self.terms, time);
        }
        // Errors that were told later are no smaller.
        let mut handed = Handed { companion: self.companion_at(time), ..self.handed(time, run) };
        if let Some(so_far) = &mut handed.so_far {
            so_far.holds_until = if so_far.holds() { time } else { so_far.holds_until.min(time) };
            so_far.time = time;
        }
        Some(handed)
    }

    fn handed(&self, time: f64, run: &RunIntegrator) -> Handed {
        let unseen = self.before + run.error_of_impacts(time) + self.doubt(time, run);
        let beside = match &self.by {
            By::Beside(beside) => Some(&**beside),
            _ => None,
        };
        let own = run.crowds_so_far();
        Handed {
            crowds: [own, beside.map_or(own, |beside| beside.run.crowds_so_far())],
            time,
            steps: self.earlier + self.steps,
            fineness: self.fineness(),
            companion: None,
            share: beside.map_or(0.0, |beside| beside.share_of_first_order(run)).max(self.least_share).min(BOTH),
            so_far: self.so_far,
            largest: self.largest,
            unseen: unseen + self.given.error(time),
            parted: self.parted,
            differ: self.differ.or_else(|| self.difference(run)),
            driven: self.driven,
        }
    }

    /// How fine the run is; if it begins again, how fine it is then.
    pub(crate) fn fineness(&self) -> Fineness {
        let (stop, stages) = self.next.unwrap_or((self.stop, self.stages));
        Fineness {
            stop,
            stages,
            begun: self.begun,
            may_begin_again: self.may_begin_again,
            may_refine: self.may_refine,
            over_events: self.terms.over_events,
            horizon: self.horizon,
        }
    }

    /// How fine the next beginning is, after this run has or has not caused it.
    pub(crate) fn next_fineness(&mut self, run: &RunIntegrator) -> Fineness {
        self.begun += usize::from(self.next.is_some());
        self.horizon.begin_again(self.difference(run).map(|differ| (differ, self.stop)));
        self.fineness()
    }

    /// The estimate of a run that goes on from what others have handed on, and its integrator.
    ///
    /// # Errors
    /// [`MethodError`] for invalid steps.
    pub(crate) fn going_on(
        mechanism: &Mechanism,
        terms: Terms<'a>,
        handed: Handed,
    ) -> Result<(Self, RunIntegrator), MethodError> {
        let Handed { time, steps, mut fineness, companion, share, so_far, largest, .. } = handed;
        let Handed { unseen, crowds, parted, differ, driven, .. } = handed;
        fineness.stop = fineness.stop.min(terms.first_stop(mechanism));
        let (mut estimate, mut run) = Self::as_fine_as(mechanism, terms, fineness)?;
        if companion.is_some() || parted || driven {
            run.leave_companion();
            estimate.by = By::Nothing;
        }
        run.go_on_from(crowds[0]);
        estimate.crowds = crowds[1];
        estimate.earlier = steps;
        estimate.forecast.go_on_from(time);
        // An error counts once: a companion goes on to show it.
        (estimate.shown, estimate.before) =
            if companion.is_some() { (largest, unseen) } else { (0.0, unseen + largest) };
        estimate.least_share = if companion.is_some() { share.max(OF_GROUPS) } else { OF_GROUPS };
        (estimate.companion, estimate.so_far, estimate.largest) = (companion, so_far, estimate.shown);
        (estimate.parted, estimate.differ, estimate.driven) = (parted, differ, driven);
        Ok((estimate, run))
    }
}
