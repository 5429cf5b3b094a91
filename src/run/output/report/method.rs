//! How a run was integrated, and the warnings about that.

use crate::mechanism::ground::words::{counted, rounded};
use crate::mechanism::motion::integrator::{FrequencyStep, MethodDescription, Ringing, SingularPosition};
use crate::output::report::solvers::SolversReport;
use crate::simulation::StepChoice;
use serde::Serialize;

/// Steps of first order that take less of the motion than this part of the accuracy, over 1 m/s, are not felt.
const FELT: f64 = 1e-3;
/// The same in a run whose estimate tells that it keeps to the accuracy.
const FELT_BESIDE_AN_ESTIMATE: f64 = 1.0;

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
    /// The steps over slips.
    pub over_slips: OverSlipsReport,
    /// Steps with three stages or five, in spans between given instants such as ticks that are short beside the steps of the tolerance.
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

/// The steps that keep to the tolerance by an estimate of their own, where slips change so often that exact steps are dear.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct OverSlipsReport {
    /// Their number.
    pub steps: usize,
    /// The part of the motion's time that they took.
    pub time_share: f64,
    /// Their order of convergence.
    pub order: usize,
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
            over_slips: OverSlipsReport {
                steps: description.over_slips_steps,
                time_share: share(description.over_slips_time, duration),
                order: 2,
            },
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
        CrowdReport {
            steps: description.first_order_steps,
            time_share: share(description.first_order_time, duration),
            order: 1,
            worst_residual: description.first_order_residual,
            asleep_share: share(description.first_order_asleep, duration),
            lift: description.first_order_lift,
        }
    }
}

/// The part of a duration that a time is; zero of an empty run.
fn share(time: f64, duration: f64) -> f64 {
    if time > 0.0 && duration > 0.0 { time / duration } else { 0.0 }
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

/// Whether the accuracy of a run feels its steps of first order: what moves at 1 m/s goes on by more than a thousandth of it in them. Given steps have
/// none, and feel all, unless they are to be of first order.
pub(crate) fn first_order_is_felt(description: &MethodDescription) -> bool {
    first_order_moves_more_than(FELT, description)
}

/// Whether a body with 1 m/s goes on in steps of first order by more than this part of the accuracy.
fn first_order_moves_more_than(part: f64, description: &MethodDescription) -> bool {
    // Bodies that sleep stay where they are.
    let time = description.first_order_time - description.first_order_asleep;
    description.first_order_steps > 0
        && description.stages != StepChoice::OVER_EVENTS
        && time > description.tolerance.map_or(0.0, |tolerance| part * tolerance)
}

/// The warning of contacts that were too many or too contradictory for the solver in a run of this duration (s), which has `reached` its accuracy as far as
/// it is known.
pub(crate) fn unsolved_warning(description: &MethodDescription, duration: f64, reached: bool) -> Option<String> {
    let &MethodDescription { unsolved_contacts: unsolved, first_order_steps: steps, first_order_time: time, .. } =
        description;
    let asleep = description.first_order_asleep;
    let felt = if reached { FELT_BESIDE_AN_ESTIMATE } else { FELT };
    let crowded = first_order_moves_more_than(felt, description).then(|| {
        let steps = counted(steps, "first-order step", "first-order steps");
        format!(
            "exact steps would have cost too much, or could not be made: the run took {steps}, {} % of its time{}",
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contacts_that_are_not_solved_are_said_beside_steps_of_first_order_and_without_them() {
        let warning = |unsolved_contacts: usize, first_order_steps: usize| {
            let method = MethodDescription::fixed("lobatto", 3, 4, 0.01);
            unsolved_warning(
                &MethodDescription { unsolved_contacts, first_order_steps, first_order_time: 0.25, ..method },
                2.0,
                false,
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
    fn steps_of_first_order_in_which_nothing_moves_as_far_as_the_accuracy_are_not_said() {
        let said_of = |[first_order_time, first_order_asleep]: [f64; 2], tolerance: Option<f64>, reached: bool| {
            let method = MethodDescription::fixed("lobatto", 3, 4, 0.01);
            let method = MethodDescription { first_order_steps: 1, first_order_time, first_order_asleep, ..method };
            unsolved_warning(&MethodDescription { tolerance, ..method }, 2.0, reached).is_some()
        };
        let said = |time: f64, tolerance: Option<f64>, reached: bool| said_of([time, 0.0], tolerance, reached);
        // 1 m/s moves 1e-12 m in 1e-12 s, a part of 1e-6 of the accuracy.
        assert!(!said(1e-12, Some(1e-6), false));
        assert!(said(1e-8, Some(1e-6), false), "a hundredth of it");
        assert!(!said(1e-6, Some(1e-6), true), "an estimate tells that no more comes of it");
        assert!(said(2e-6, Some(1e-6), true), "more than the accuracy");
        assert!(said(1e-12, None, false), "given steps have no accuracy");
        assert!(!said_of([1.9, 1.9], Some(1e-6), false) && !said_of([1.9, 1.9], None, false), "all bodies sleep");
    }
}
