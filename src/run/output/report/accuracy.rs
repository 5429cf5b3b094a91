//! The accuracy of a run as it estimated it itself, why that ends or is not known, and the warnings about it.

use crate::mechanism::ground::words::rounded;
use crate::output::report::method::first_order_is_felt;
use crate::output::report::rounding::{FarSpring, displaced, is_energy_rounding};
use crate::simulation::{Accuracy, Finished, StepChoice, Summary, UnknownAccuracy};
use serde::Serialize;

/// The accuracy to expect of a run, as it estimated it itself.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct AccuracyReport {
    /// The accuracy asked for (m).
    pub wanted: f64,
    /// The largest error to expect at the end of any step (m).
    pub estimated: f64,
    /// The largest error that interpolation inside the steps adds (m), from the last terms of their polynomials
    /// (`doc/decisions/005-samples-between-steps.md`); half of what a step moves in steps of first order.
    pub between_steps: Option<f64>,
    /// The instant up to which the wanted accuracy is expected to hold (s).
    pub holds_until: f64,
    /// The instant up to which the accuracy is known (s): the end of the run, or a little before if it was interrupted.
    pub told_until: f64,
    /// Whether the estimated error meets the tolerance up to that instant.
    pub reached: bool,
    /// Why the accuracy does not hold to the end, if it does not.
    pub horizon: Option<Horizon>,
    /// How often the run has begun: once, and again with finer steps where errors grew more than was expected; of several parts the most.
    pub begun: usize,
    /// Whether `told_until` is before the end that was asked for.
    #[serde(skip)]
    pub(crate) is_early: bool,
    /// Whether its errors may grow from nearly nothing.
    #[serde(skip)]
    amplifies: bool,
    /// Whether the run ends anywhere: no runs that differ by roundings stay together.
    #[serde(skip)]
    parts: bool,
    /// The time after which runs that differ by little meet other events (s).
    #[serde(skip)]
    events_differ: Option<f64>,
    /// Whether steps of first order took a part of the run that its accuracy feels.
    #[serde(skip)]
    first_order: bool,
    /// Whether it can be told at all.
    #[serde(skip)]
    can_tell: bool,
    /// The relative energy error of the run, if it is more than the wanted accuracy leaves.
    #[serde(skip)]
    unbalanced: Option<f64>,
}

/// Why an accuracy does not hold to the end of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Horizon {
    /// Runs that differ by little meet other events.
    Events,
    /// The errors of its steps, or roundings, have grown beyond it.
    Growth,
}

/// Why the accuracy of a run is not known.
#[derive(Clone, Debug, Serialize)]
pub struct NoAccuracyReport {
    /// The accuracy asked for (m), if one was.
    pub wanted: Option<f64>,
    /// Null: it is not known.
    pub estimated: (),
    /// The reason.
    pub reason: String,
}

impl NoAccuracyReport {
    /// The reason of a run with these steps.
    pub(crate) fn new(choice: StepChoice, reason: &UnknownAccuracy) -> Self {
        NoAccuracyReport { wanted: choice.tolerance(), estimated: (), reason: reason.to_string() }
    }
}

/// If a motion amplifies errors more than [`CALM`] times, finer accuracies than this (m) are among the roundings of the run and of its estimate.
const FINEST: f64 = 1e-11;
/// Energy errors over the wanted accuracy (1/m) beyond which the estimate is not believed: steps are kept within one.
const UNBALANCED: f64 = 10.0;
/// Error at the end over the stop of the iteration.
const CALM: f64 = 100.0;

impl AccuracyReport {
    /// The report of one accuracy.
    pub fn new(wanted: f64, found: &Accuracy) -> Self {
        let reached = found.holds_until >= found.told_until;
        AccuracyReport {
            wanted,
            estimated: found.estimate,
            between_steps: found.between_steps,
            holds_until: found.holds_until,
            told_until: found.told_until,
            reached,
            horizon: (!reached).then(|| found.events_differ.map_or(Horizon::Growth, |_| Horizon::Events)),
            is_early: false,
            begun: found.begun,
            amplifies: found.amplifies,
            parts: found.parted,
            events_differ: found.events_differ,
            first_order: false,
            can_tell: wanted >= 0.99 * FINEST || found.estimate <= CALM * found.stop,
            unbalanced: None,
        }
    }

    /// The accuracy of a run.
    ///
    /// # Errors
    /// [`UnknownAccuracy`] if the run has no estimate.
    #[doc(hidden)]
    pub fn of(choice: StepChoice, run: &Finished) -> Result<Self, UnknownAccuracy> {
        let wanted = choice.tolerance().ok_or(UnknownAccuracy::NotAsked)?;
        let here = run.end.min(run.state.time);
        let report = |found: &Accuracy| AccuracyReport {
            is_early: found.told_until < run.end,
            ..AccuracyReport::new(wanted, found)
        };
        let islands: Vec<_> =
            run.accuracy.iter().map(|found| found.as_ref().map(report).map_err(Clone::clone)).collect();
        let report = match &islands[..] {
            [alone] if run.parts == (1, 0) => alone.clone(),
            _ => AccuracyReport::together(wanted, here, &islands),
        };
        Ok(AccuracyReport { first_order: first_order_is_felt(&run.method), ..report? })
    }

    /// Combines the reports of islands, in a run that has reached the time `here` (s).
    /// Sleeping islands have no error.
    ///
    /// # Errors
    /// The first reason why the accuracy of an island is not known.
    pub(crate) fn together(
        wanted: f64,
        here: f64,
        islands: &[Result<AccuracyReport, UnknownAccuracy>],
    ) -> Result<Self, UnknownAccuracy> {
        let all: Vec<AccuracyReport> = islands.iter().cloned().collect::<Result<_, _>>()?;
        let told_until = all.iter().map(|one| one.told_until).reduce(f64::min).unwrap_or(here);
        Ok(AccuracyReport {
            wanted,
            estimated: all.iter().map(|one| one.estimated).fold(0.0, f64::max),
            between_steps: all.iter().map(|one| one.between_steps).try_fold(0.0, |most: f64, one| Some(most.max(one?))),
            holds_until: all.iter().map(|one| one.holds_until).fold(told_until, f64::min),
            told_until,
            reached: all.iter().all(|one| one.reached),
            horizon: all.iter().min_by(|a, b| a.holds_until.total_cmp(&b.holds_until)).and_then(|one| one.horizon),
            begun: all.iter().map(|one| one.begun).max().unwrap_or(1),
            amplifies: all.iter().any(|one| !one.reached && one.amplifies),
            parts: all.iter().any(|one| one.parts),
            events_differ: all.iter().filter_map(|one| one.events_differ).min_by(f64::total_cmp),
            first_order: false,
            can_tell: all.iter().all(|one| one.can_tell),
            is_early: all.iter().any(|one| one.is_early),
            unbalanced: None,
        })
    }

    /// Sees how the ends of springs are rounded: what that hides cannot be told.
    pub(crate) fn see_rounding(&mut self, far: &FarSpring) {
        self.estimated = self.estimated.max(far.rounding());
        if far.rounding() > self.wanted {
            self.falls_short();
        }
    }

    /// The accuracy does not hold to the end.
    fn falls_short(&mut self) {
        self.reached = false;
        self.horizon.get_or_insert(Horizon::Growth);
    }

    /// Sees how the run kept its energy: steps that change it by more than the tolerance are not as accurate as is estimated.
    pub(crate) fn see_energy(&mut self, summary: &Summary) {
        let error = summary.max_relative_energy_error;
        let allowed = UNBALANCED * self.wanted.max(FINEST);
        // Hard dampers take with next to no motion what springs, weights and motors have stored: a displacement changes those energies, too.
        let moved = summary.exchange.dissipated.abs() + summary.held;
        // An energy that is not a number does not balance either.
        let balances =
            error <= allowed || summary.max_energy_error <= allowed * moved + displaced(summary, self.wanted);
        if self.reached && !is_energy_rounding(summary) && !balances {
            self.falls_short();
            self.unbalanced = Some(error);
        }
    }

    /// The warning of a run whose energy does not agree with the wanted accuracy.
    pub(crate) fn energy_warning(&self) -> Option<String> {
        let (error, wanted) = (self.unbalanced?, self.wanted);
        Some(format!(
            "the energy balance is off by {error:.1e} of the largest kinetic energy, more than an accuracy of {wanted:e} m allows: whether it is \
             reached is not known; compare with a run of a smaller --tolerance"
        ))
    }

    /// The warning of an accuracy that does not hold to the end, or that is unknown.
    #[doc(hidden)]
    pub fn warning(&self) -> Option<String> {
        let wanted = self.wanted;
        if !self.reached {
            let until = rounded(self.holds_until);
            if !self.parts && wanted < FINEST && self.estimated <= FINEST {
                return Some(format!(
                    "rounding is the limit: {wanted:e} m holds until t = {until} s; double precision leaves an error of {:.1e} m, however short the \
                     steps",
                    self.estimated
                ));
            }
            // Their errors are not told apart from a growth of roundings.
            let by_first_order = self.first_order && self.events_differ.is_none() && !self.parts;
            if !self.amplifies || by_first_order {
                let first_order = if by_first_order { ", to which steps of first order contribute" } else { "" };
                return Some(format!(
                    "{wanted:e} m holds until t = {until} s; later the estimated error is {:.1e} m{first_order}: compare with a run of another \
                     --tolerance",
                    self.estimated
                ));
            }
            let holds = format!("{wanted:e} m holds until t = {until} s");
            let other_events = self.events_differ.map(|differ| {
                format!(
                    "from t = {} s on runs that differ by little meet other events (impacts, sticking, motors at their bounds)",
                    rounded(differ)
                )
            });
            return Some(match (other_events, self.parts) {
                (Some(other_events), true) => format!("chaotic motion: {holds}; {other_events}"),
                // They are near each other all the same: no error grows without end.
                (Some(other_events), false) => format!(
                    "{holds}; {other_events}, and the estimated error is {:.1e} m: compare with a run of another --tolerance",
                    self.estimated
                ),
                (None, true) => format!(
                    "chaotic motion: {holds}; later the trajectory is physical but not reproducible to that accuracy"
                ),
                (None, false) => {
                    format!("chaotic motion: {holds}; later rounding errors grow to {:.1e} m", self.estimated)
                }
            });
        }
        (!self.can_tell).then(|| {
            format!(
                "chaotic motion: rounding errors grow too, so that it cannot be told whether the accuracy of {wanted:e} m is \
                 reached; the error may be a hundred times larger"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stepping::length::stage_choice::StageChoice;

    #[test]
    fn an_accuracy_finer_than_roundings_is_no_chaos() {
        let warning = |wanted: f64, estimate: f64, parted: bool| {
            let found = Accuracy {
                stop: 1e-16,
                stages: StageChoice::Many,
                estimate,
                between_steps: None,
                holds_until: 0.0,
                told_until: 2.0,
                parted,
                amplifies: true,
                events_differ: None,
                begun: 1,
            };
            AccuracyReport::new(wanted, &found).warning().expect("a warning")
        };
        let said = warning(1e-20, 5.6e-14, false);
        assert!(said.starts_with("rounding is the limit: 1e-20 m") && said.contains("5.6e-14 m"), "{said}");
        // A motion that has amplified roundings to a tenth of a millimetre is chaotic, whatever was asked for.
        assert!(warning(1e-20, 1e-4, false).starts_with("chaotic motion"));
        assert!(warning(1e-20, 1.0, true).starts_with("chaotic motion"));
        assert!(warning(1e-10, 1e-9, false).starts_with("chaotic motion"));
    }

    #[test]
    fn accuracies_among_the_roundings_of_a_motion_that_amplifies_them_are_not_said_to_be_reached_without_a_word() {
        let warning = |wanted: f64, amplification: f64| {
            let stop = 1e-15;
            let stages = StageChoice::Many;
            let estimate = amplification * stop;
            let found = Accuracy {
                stop,
                stages,
                estimate,
                between_steps: None,
                holds_until: 2.0,
                told_until: 2.0,
                parted: false,
                amplifies: true,
                events_differ: None,
                begun: 1,
            };
            AccuracyReport::new(wanted, &found).warning()
        };
        assert!(warning(1e-12, 2e4).is_some_and(|words| words.contains("cannot be told")));
        assert_eq!(warning(1e-12, 3.0), None, "a calm motion");
        assert_eq!(warning(1e-11, 2e4), None, "an accuracy that can be told");
    }
}
