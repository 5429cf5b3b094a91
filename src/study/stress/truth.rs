//! The reference solution of a case, and its accuracy.
//!
//! Nine stages, iterated to rounding, with steps that shrink by a factor that is no power of two, until two runs in a row agree to rounding or
//! finer steps agree less: the answer is the finer of the two that agree best, and their distance is its doubt.

use crate::chart::{Method as ChartMethod, Setting};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::distance::{PROBES, distance, probes_of_bodies, size};
use crate::mechanism::motion::state::State;
use crate::stress::method::Method;
use crate::stress::problem::{Case, Truth};
use crate::stress::runner::Runner;
use nalgebra::Vector3;
use std::sync::atomic::{AtomicBool, Ordering};

/// An answer whose runs agree worse than this part of the size is discarded.
pub const WORST_DOUBT: f64 = 1e-3;
/// Agreement that cannot be bettered, as a part of the size.
const ROUNDING: f64 = 1e-13;
/// Rough work of all runs for one answer, as a multiple of the budget of a run.
const BUDGET: f64 = 7.5;
/// Steps of the first run, and factor from run to run.
const FIRST: f64 = 14.0;
const FACTOR: f64 = 1.7;
const RUNS: i32 = 18;
/// A run whose steps exceed the expected number by this factor is given up.
const HALVED: f64 = 4.0;

/// The answer of a case, as far as it is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// Probes of the watched bodies at the end; `None` if no two runs agree or there is no answer.
    pub probes: Option<Vec<Vector3<f64>>>,
    /// Distance between the two runs, as a part of the size.
    pub doubt: f64,
    /// Size of the mechanism (m).
    pub size: f64,
    /// The largest kinetic energy seen (J).
    pub kinetic: f64,
    /// Why there is no answer.
    pub refusal: Option<&'static str>,
    /// Its source.
    pub source: String,
}

impl Answer {
    /// Finds the answer of a case; `None` if interrupted.
    pub fn of(case: &Case, interrupt: &AtomicBool) -> Option<Self> {
        let mechanism_size = size(&case.mechanism, &case.start);
        let mut answer = Answer {
            probes: None,
            doubt: f64::INFINITY,
            size: mechanism_size,
            kinetic: 0.0,
            refusal: None,
            source: String::new(),
        };
        match &case.truth {
            Truth::None(reason) => answer.refusal = Some(reason),
            Truth::Converged => answer.converge(&case.mechanism, &case.start, case.duration, case, interrupt)?,
            Truth::Periodic(period) => {
                // The kinetic energy of a whole period, which the rest of the last one may not contain.
                answer.converge(&case.mechanism, &case.start, *period, case, interrupt)?;
                let rest = case.duration % period;
                answer.converge(&case.mechanism, &case.start, rest, case, interrupt)?;
                // The period is known to a rounding, which every period repeats.
                answer.doubt = answer.doubt.max(case.duration / period * 1e-15);
                answer.source = format!("period {period:.15} s, then {}", answer.source);
            }
            Truth::Same(other) => {
                let (mechanism, start) = other.as_ref();
                answer.converge(mechanism, start, case.duration, case, interrupt)?;
                answer.source = format!("{}: {}", mechanism.name, answer.source);
            }
        }
        Some(answer)
    }

    /// Refines until two runs agree.
    fn converge(
        &mut self,
        mechanism: &Mechanism,
        start: &State,
        duration: f64,
        case: &Case,
        interrupt: &AtomicBool,
    ) -> Option<()> {
        let (watched, budget) = (case.watched, BUDGET * case.budget);
        let mut spent = 0.0;
        let mut before: Option<Vec<Vector3<f64>>> = None;
        self.doubt = f64::INFINITY;
        'runs: for rung in 0..RUNS {
            let wanted = FIRST * FACTOR.powi(rung);
            let step = duration / wanted;
            let method = Method::Chart(ChartMethod::Lobatto(9));
            let Ok(mut runner) = Runner::with_first_steps(mechanism, start, method, Setting::Step(step)) else { break };
            let end = start.time + duration;
            let (mut kinetic, mut steps) = (0.0_f64, 0.0);
            while runner.time() < end {
                if interrupt.load(Ordering::Relaxed) {
                    return None;
                }
                let advanced = runner.advance(end).ok();
                steps += 1.0;
                // Steps that are halved again and again are another rung's business.
                let Some(work) = advanced.filter(|_| steps < HALVED * wanted) else {
                    before = None;
                    continue 'runs;
                };
                kinetic = kinetic.max(runner.energy().0);
                spent += work;
                if spent > budget {
                    break 'runs;
                }
            }
            let found = watched_probes(mechanism, &runner, watched);
            // The finest run that arrives is the one that knows best how fast it gets.
            self.kinetic = kinetic.max(f64::MIN_POSITIVE);
            if let Some(before) = &before {
                let doubt = distance(before, &found) / self.size;
                if doubt < self.doubt {
                    self.doubt = doubt;
                    self.probes = (doubt <= WORST_DOUBT).then(|| found.clone());
                    self.source = format!("9 stages, step {step:.3e} s, doubt {doubt:.0e} of the size");
                } else if self.doubt < 1e-9 {
                    break;
                }
                if self.doubt < ROUNDING {
                    break;
                }
            }
            before = Some(found);
        }
        if self.probes.is_none() {
            self.source = "no two runs agree: judged by the energy".to_string();
        }
        Some(())
    }
}

/// The probes of the last bodies where a run is.
pub fn watched_probes(mechanism: &Mechanism, runner: &Runner, watched: usize) -> Vec<Vector3<f64>> {
    let all = probes_of_bodies(mechanism, &runner.bodies());
    all[all.len().saturating_sub(PROBES * watched)..].to_vec()
}
