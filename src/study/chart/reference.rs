//! The reference solution at the end of the run, by two formulations, and its accuracy. They share no code but what springs, dampers and
//! loads exert in a given state, and where a state places the bodies.
//!
//! The first formulation is the Lobatto scheme in maximal coordinates: with 32 digits for trees under gravity, and with 14 to 16 stages elsewhere.
//! The second is DOP853 in joint coordinates near the end of double precision. Each runs at several settings, so that rounding falls differently.
//! DOP853 knows no contacts, so scenes with contacts have the first formulation alone, with steps that three tolerances choose. Their end points give:
//!
//! - the *scatter* of a formulation: the largest distance of one of its runs from their mean;
//! - the *agreement*: the distance between the two means.
//!
//! The reference is the mean of the formulation with the smaller scatter. Down to the agreement an error is vouched
//! for by both formulations; between agreement and scatter by one alone; below the scatter it is noise.

use crate::chart::ladder::whole_step;
use crate::chart::method::{Method, Setting};
use crate::chart::scene::Scene;
use crate::chart::timing::{Effort, Ended, timed_run};
use crate::drawing::error::ChartError;
use crate::mechanism::motion::distance::{distance, mean, probes};
use nalgebra::Vector3;
use std::sync::atomic::AtomicBool;

/// The end points an error is measured from.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Probes of all bodies at the end ([`crate::mechanism::motion::distance`]).
    pub probes: Vec<Vector3<f64>>,
    /// Which formulation it is from.
    pub source: &'static str,
    /// Distance between the two formulations (m); `None` if only one of them could run the scene.
    pub agreement: Option<f64>,
    /// Scatter of the chosen formulation (m).
    pub scatter: f64,
    /// Mean step of DOP853 at a tolerance of 1e-6 (s), with contacts a quarter of ours: the scene's own scale of time.
    pub time_scale: f64,
    /// CPU time of the slowest reference run of DOP853 (s), with contacts of ours: the scene's own scale of cost.
    pub cost_scale: f64,
    /// A description of every reference run, and its distance from the reference (m).
    pub runs: Vec<(String, f64)>,
}

impl Reference {
    /// The level below which an error is noise of the reference (m).
    pub fn floor(&self) -> f64 {
        self.scatter
    }

    /// The level down to which both formulations vouch for an error (m); infinite if there is only one.
    pub fn vouched(&self) -> f64 {
        self.agreement.unwrap_or(f64::INFINITY).max(self.scatter)
    }
}

/// Methods of the first formulation and their steps in mean steps of DOP853 at a tolerance of 1e-6: on trees under gravity with 32
/// digits, where neither rounding nor the order leaves anything,
const PRECISE: [(Method, f64); 3] = [(Method::Precise(9), 0.2), (Method::Precise(9), 0.18), (Method::Precise(9), 0.16)];
/// and elsewhere with few and large steps, because rounding grows with their number.
const LARGE: [(Method, f64); 3] = [(Method::Lobatto(16), 0.83), (Method::Lobatto(15), 0.7), (Method::Lobatto(14), 0.6)];

/// and with contacts, where some spans between events need shorter steps than others.
const CHOSEN: [f64; 3] = [1e-9, 3e-10, 1e-10];

/// The mean step of our tolerance mode is about this multiple of the step of DOP853.
const OURS: f64 = 4.0;
/// One run, however long.
const ONCE: Effort = Effort { cap: f64::INFINITY, total: 0.0, repeats: 1, enough: 0.0 };
/// A run whose cost grows by this factor over the one before it rejects steps because of rounding.
const CAP_GROWTH: f64 = 5.0;
/// Runs of a formulation that make its mean.
const KEPT: usize = 3;

/// Runs of one formulation.
struct Family {
    source: &'static str,
    answers: Vec<Vec<Vector3<f64>>>,
    names: Vec<String>,
    failure: Option<String>,
}

impl Family {
    /// Runs settings from coarse to fine and keeps the finest three; stops where more effort only stirs rounding.
    fn run(source: &'static str, scene: &Scene, runs: &[(Method, Setting)], interrupt: &AtomicBool) -> (Self, f64) {
        let mut family = Family { source, answers: Vec::new(), names: Vec::new(), failure: None };
        let (mut cap, mut slowest) = (f64::INFINITY, 0.0_f64);
        for &(method, setting) in runs {
            let once = Effort { cap, ..ONCE };
            let run = timed_run(&scene.mechanism, &scene.start, scene.duration, method, setting, &once, interrupt);
            match run.ended {
                Ended::Done => {
                    family.answers.push(probes(&scene.mechanism, &run.end));
                    family.names.push(format!("{} {setting}", method.id()));
                    slowest = slowest.max(run.cpu_seconds);
                    cap = CAP_GROWTH * run.cpu_seconds.max(0.01);
                }
                Ended::Cut { .. } => break,
                ended => family.failure = Some(format!("{} at {setting} {ended}", method.id())),
            }
        }
        let superfluous = family.answers.len().saturating_sub(KEPT);
        family.answers.drain(..superfluous);
        family.names.drain(..superfluous);
        (family, slowest)
    }

    fn scatter(&self) -> f64 {
        let middle = mean(&self.answers);
        let spread = self.answers.iter().map(|answer| distance(answer, &middle)).fold(0.0, f64::max);
        // The scatter of one run alone is unknown.
        if self.answers.len() < 2 { f64::INFINITY } else { spread }
    }
}

/// Computes the reference of a scene.
///
/// # Errors
/// [`ChartError::Reference`] if neither formulation reaches the end, [`ChartError::Interrupted`] if asked to stop.
pub fn reference(scene: &Scene, interrupt: &AtomicBool, told: &mut dyn FnMut(&str)) -> Result<Reference, ChartError> {
    let stopped = || interrupt.load(std::sync::atomic::Ordering::Relaxed);
    let interrupted = || ChartError::Interrupted { scene: scene.name.clone() };
    let (mechanism, duration) = (&scene.mechanism, scene.duration);
    told("time scale");
    let rival = Method::Dop853.knows(mechanism);
    let (method, steps) = if rival { (Method::Dop853, 1.0) } else { (Method::LobattoTolerance, OURS) };
    let coarse = timed_run(mechanism, &scene.start, duration, method, Setting::Tolerance(1e-6), &ONCE, interrupt);
    let time_scale = match coarse.ended {
        Ended::Interrupted => return Err(interrupted()),
        Ended::Done => coarse.mean_step / steps,
        _ => duration / 100.0,
    };

    told("reference in joint coordinates");
    let tolerances = [1e-12, 1e-13, 3e-14, 1e-14].map(|tolerance| (Method::Dop853, Setting::Tolerance(tolerance)));
    let tolerances = if rival { &tolerances[..] } else { &[] };
    let (reduced, slowest_reduced) = Family::run("DOP853 in joint coordinates", scene, tolerances, interrupt);
    if stopped() {
        return Err(interrupted());
    }

    told("reference in maximal coordinates");
    let finest = if mechanism.is_plain_tree() && mechanism.nonsmooth.is_empty() { PRECISE } else { LARGE };
    let steps = if rival {
        finest.map(|(method, fraction)| (method, Setting::Step(whole_step(duration, fraction * time_scale))))
    } else {
        CHOSEN.map(|tolerance| (Method::LobattoUnestimated, Setting::Tolerance(tolerance)))
    };
    let (maximal, slowest) = Family::run("Lobatto in maximal coordinates", scene, &steps, interrupt);
    if stopped() {
        return Err(interrupted());
    }

    let cost_scale = if rival { slowest_reduced } else { slowest };

    let both = !reduced.answers.is_empty() && !maximal.answers.is_empty();
    let agreement = both.then(|| distance(&mean(&reduced.answers), &mean(&maximal.answers)));
    let (chosen, other) = if maximal.scatter() <= reduced.scatter() && !maximal.answers.is_empty() {
        (&maximal, &reduced)
    } else {
        (&reduced, &maximal)
    };
    let chosen = if chosen.answers.is_empty() { other } else { chosen };
    if chosen.answers.is_empty() {
        let reasons: Vec<String> = [reduced.failure, maximal.failure].into_iter().flatten().collect();
        return Err(ChartError::Reference { scene: scene.name.clone(), reason: reasons.join("; ") });
    }
    let points = mean(&chosen.answers);
    let runs = [&maximal, &reduced]
        .into_iter()
        .flat_map(|family| family.names.iter().zip(&family.answers))
        .map(|(name, answer)| (name.clone(), distance(answer, &points)))
        .collect();
    // Two identical answers still carry the rounding of the numbers themselves.
    let size = points.iter().map(|point| point.norm()).fold(0.0, f64::max);
    let scatter = chosen.scatter().max(f64::EPSILON * size);
    Ok(Reference { source: chosen.source, agreement, scatter, time_scale, cost_scale, runs, probes: points })
}
