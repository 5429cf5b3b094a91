//! How a run was integrated, its estimated error, and the warnings about both.

use crate::mechanism::ground::words::{counted, rounded};
use crate::mechanism::motion::integrator::{FrequencyStep, MethodDescription, Ringing, SingularPosition};
use crate::output::report::rounding::{FarSpring, is_energy_rounding};
use crate::output::report::solvers::SolversReport;
use crate::simulation::{Accuracy, Finished, StepChoice, Summary, UnknownAccuracy};
use serde::Serialize;

/// The scheme of a run.
#[derive(Clone, Debug, Serialize)]
pub struct MethodReport {
    /// Name of the scheme; part of the lines for people alone.
    #[serde(skip)]
    pub name: String,
    /// Number of stages.
    pub stages: usize,
    /// Order of convergence.
    pub order: usize,
    /// The step, or the mean step of an adaptive run (s).
    pub step: f64,
    /// Whether the step is chosen from a tolerance.
    pub adaptive: bool,
    /// The tolerance it is chosen from.
    pub tolerance: Option<f64>,
    /// The nearest that any step came to the limit of linear stability; null if it was not computed, as in a run of a few steps.
    pub max_frequency_step: Option<FrequencyReport>,
    /// Decimal digits that steps were solved to: 16, or 32.
    pub digits: u32,
    /// How often reversible steps had to be set anew, which turning time round would not repeat; null for other steps.
    pub reversible_resets: Option<usize>,
    /// The steps of first order.
    pub crowd: CrowdReport,
    /// Steps with three stages, in spans between given instants such as ticks that are short beside the steps of the tolerance.
    pub few_stage_steps: usize,
    /// How often each contact solver has solved a problem of an event.
    pub contact_solvers: SolversReport,
}

/// The steps of first order, which a run takes where contacts change faster than exact steps could follow.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CrowdReport {
    /// Their number.
    pub steps: usize,
    /// The part of the motion's time that they took.
    pub time_share: f64,
    /// Their order of convergence.
    pub order: usize,
    /// The largest residual of the law of contact in them, as a part of the largest impulse.
    pub worst_residual: f64,
    /// The part of the motion's time in which bodies slept, in the mean over all bodies.
    pub asleep_share: f64,
    /// The largest overlap that they moved apart (m).
    pub lift: f64,
}

/// How near a step came to the limit of linear stability.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct FrequencyReport {
    /// Step times frequency of the fastest mode (rad).
    pub value: f64,
    /// The limit of stability of the scheme (rad).
    pub limit: f64,
    /// The step (s).
    pub step: f64,
    /// When (s).
    pub time: f64,
}

impl MethodReport {
    /// The method as an integrator describes itself after a motion of this duration (s).
    #[doc(hidden)]
    pub fn new(description: &MethodDescription, duration: f64) -> Self {
        MethodReport {
            name: description.name.clone(),
            stages: description.stages,
            order: description.order,
            step: description.step,
            adaptive: description.adaptive,
            tolerance: description.tolerance,
            max_frequency_step: description.frequency_step.map(|seen| FrequencyReport {
                value: seen.product,
                limit: seen.limit,
                step: seen.step,
                time: seen.time,
            }),
            digits: description.digits,
            reversible_resets: description.reversible_resets,
            crowd: CrowdReport::new(description, duration),
            few_stage_steps: description.few_stage_steps,
            contact_solvers: SolversReport(description.contact_solvers),
        }
    }

    /// The warning of a step beyond the limit of stability.
    pub(crate) fn warning(description: &MethodDescription) -> Option<String> {
        let seen = description.frequency_step.filter(FrequencyStep::is_unstable)?;
        let longest = rounded(seen.longest());
        let remedy = if description.adaptive {
            "the steps after it are shorter, but fast motions have grown in it; use a smaller --tolerance if they matter".to_string()
        } else {
            format!("fast motions grow without bound; use --step below {longest} s, more --stages, or --tolerance")
        };
        Some(format!(
            "a step of {} s is beyond the stability limit of {} at t = {} s, where the fastest motion turns by {} rad in it \
             and {} rad is the limit: {remedy}",
            rounded(seen.step),
            counted(description.stages, "stage", "stages"),
            rounded(seen.time),
            rounded(seen.product),
            rounded(seen.limit)
        ))
    }
}

impl CrowdReport {
    fn new(description: &MethodDescription, duration: f64) -> Self {
        let share = |time: f64| if time > 0.0 { time / duration } else { 0.0 };
        CrowdReport {
            steps: description.first_order_steps,
            time_share: share(description.first_order_time),
            order: 1,
            worst_residual: description.first_order_residual,
            asleep_share: share(description.first_order_asleep),
            lift: description.first_order_lift,
        }
    }
}

/// The warning of steps that are too long for a damper to stop a motion.
pub(crate) fn ringing_warning(description: &MethodDescription) -> Option<String> {
    let Ringing { decay, step, longest, time } = description.ringing?;
    let remedy = if description.adaptive {
        "no step of useful length is short enough".to_string()
    } else {
        format!("use --step below {} s, or --tolerance", rounded(longest))
    };
    Some(format!(
        "step too long for a damper near t = {} s: its time constant is {} s, the step {} s; velocities and efforts oscillate from step to \
         step, positions hardly do; {remedy}",
        rounded(time),
        rounded(1.0 / decay),
        rounded(step)
    ))
}

/// The warning of closures whose rank was lower somewhere in the run than elsewhere.
pub(crate) fn singular_warning(description: &MethodDescription) -> Option<String> {
    let SingularPosition { time, extra } = description.singular?;
    let (equations, are) = if extra == 1 { ("constraint", "is") } else { ("constraints", "are") };
    Some(format!(
        "the mechanism passes a singular position near t = {} s: {extra} more {equations} {are} redundant there, and inertia alone \
         decides the branch",
        rounded(time)
    ))
}

/// The warning of contacts that were too many or too contradictory for the solver in a run of this duration (s).
pub(crate) fn unsolved_warning(description: &MethodDescription, duration: f64) -> Option<String> {
    let &MethodDescription { unsolved_contacts: unsolved, first_order_steps: steps, first_order_time: time, .. } =
        description;
    let asleep = description.first_order_asleep;
    let crowded = (steps > 0).then(|| {
        let steps = counted(steps, "first-order step", "first-order steps");
        format!(
            "contacts changed faster than steps could follow: the run took {steps}, {} % of its time{}",
            rounded(100.0 * time / duration),
            if asleep > 0.0 {
                format!(", of which bodies slept {} %", rounded(100.0 * asleep / time))
            } else {
                String::new()
            }
        )
    });
    let inexact = (unsolved > 0).then(|| {
        let instants = counted(unsolved, "instant", "instants");
        format!("the law of contact could not be solved exactly at {instants}: the run took the best that was found")
    });
    let rebounds = (description.rebounds_left_out > 0).then(|| {
        let rebounds = counted(description.rebounds_left_out, "rebound was", "rebounds were");
        format!(
            "{rebounds} left out where impacts crowd, which would have given back about {:.2e} J",
            description.rebounds_energy
        )
    });
    let said: Vec<String> = crowded.into_iter().chain(inexact).chain(rebounds).collect();
    (!said.is_empty()).then(|| format!("{}; compare it with a run of another step or tolerance", said.join("; ")))
}

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
        match &islands[..] {
            [alone] if run.parts == (1, 0) => alone.clone(),
            _ => AccuracyReport::together(wanted, here, &islands),
        }
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
        let balances = error <= allowed || summary.max_energy_error <= allowed * moved;
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
            if !self.amplifies {
                return Some(format!(
                    "{wanted:e} m holds until t = {until} s; later the estimated error is {:.1e} m: compare with a run of another --tolerance",
                    self.estimated
                ));
            }
            let holds = format!("chaotic motion: {wanted:e} m holds until t = {until} s");
            return Some(if let Some(differ) = self.events_differ {
                format!(
                    "{holds}; from t = {} s on runs that differ by little meet other events (impacts, sticking, motors at their bounds)",
                    rounded(differ)
                )
            } else if self.parts {
                format!("{holds}; later the trajectory is physical but not reproducible to that accuracy")
            } else {
                format!("{holds}; later rounding errors grow to {:.1e} m", self.estimated)
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
    fn contacts_that_are_not_solved_are_said_beside_steps_of_first_order_and_without_them() {
        let warning = |unsolved_contacts: usize, first_order_steps: usize| {
            let method = MethodDescription::fixed("lobatto", 3, 4, 0.01);
            unsolved_warning(
                &MethodDescription { unsolved_contacts, first_order_steps, first_order_time: 0.25, ..method },
                2.0,
            )
        };
        assert_eq!(warning(0, 0), None);
        let contains = |warning: Option<String>, parts: [&str; 2]| {
            let said = warning.expect("a warning");
            parts.map(|part| said.contains(part))
        };
        let parts = ["5 first-order steps, 12.5 % of its time", "not be solved exactly at 2 instants"];
        assert_eq!(contains(warning(0, 5), parts), [true, false]);
        assert_eq!(contains(warning(2, 5), parts), [true, true]);
        assert_eq!(contains(warning(2, 0), parts), [false, true]);
    }

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
