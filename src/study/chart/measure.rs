//! One scene, all methods, all settings.
//!
//! The ladders are climbed down together, one rung of every method after the other. A budget that runs out then cuts all curves at about the same
//! rung. A method leaves its ladder when a run is cut for its cost. A method with fixed steps also leaves when two rungs in a row bring no smaller
//! error: its rounding floor. Tolerances are few, and their errors need not fall from one to the next; they are all tried.

use crate::chart::energy::{EnergyHistory, largest_kinetic, representative};
use crate::chart::ladder::ladder;
use crate::chart::method::{Method, Setting};
use crate::chart::reference::{Reference, reference};
use crate::chart::scene::Scene;
use crate::chart::table::Measurement;
use crate::chart::timing::{Effort, Ended, TimedRun, timed_run};
use crate::drawing::error::ChartError;
use crate::mechanism::motion::distance::{distance, probes};
use crate::mechanism::motion::energy::energy_with_forces;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use cpu_time::ThreadTime;
use std::sync::atomic::{AtomicBool, Ordering};

/// How much work to put into a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Shorter ladders and fewer repetitions.
    pub quick: bool,
    /// CPU time for the measurements of the scene (s); the reference is not counted.
    pub budget: f64,
}

/// All that is known of a scene.
#[derive(Clone, Debug)]
pub struct SceneChart {
    /// Name of the scene.
    pub name: String,
    /// Simulated time (s).
    pub duration: f64,
    /// Degrees of freedom and bodies.
    pub size: (usize, usize),
    /// The reference from which errors are measured.
    pub reference: Reference,
    /// Every run, method by method, coarse settings first.
    pub measurements: Vec<Measurement>,
    /// Energy against time for one setting of each method.
    pub energies: Vec<EnergyHistory>,
    /// Whether the motion has events: the mechanism has limits, dry friction, motors or contacts.
    pub has_events: bool,
    /// Whether shapes may touch, which no comparator knows.
    pub has_contacts: bool,
    /// Whether the budget ran out before the ladders ended.
    pub out_of_budget: bool,
    /// Whether the user stopped it.
    pub interrupted: bool,
}

/// A method on its way down.
struct Climb {
    method: Method,
    settings: Vec<Setting>,
    runs: Vec<(Setting, TimedRun)>,
    measurements: Vec<Measurement>,
    best: f64,
    without_progress: usize,
    finished: bool,
}

impl Climb {
    /// The floor is reached when two rungs in a row gain less than a fifth, somewhere below this error [m].
    const FLOOR_BELOW: f64 = 1e-6;

    fn see(&mut self, measurement: &Measurement) {
        if matches!(measurement.ended, Ended::Cut { .. }) {
            self.finished = true;
        }
        if measurement.error < 0.8 * self.best {
            self.best = measurement.error;
            self.without_progress = 0;
        } else if self.best < Self::FLOOR_BELOW && matches!(self.settings.first(), Some(Setting::Step(_))) {
            self.without_progress += 1;
            self.finished |= self.without_progress == 2;
        }
    }
}

/// Measures a scene. `told` hears which run is being made, and the fraction of the work that is behind.
///
/// # Errors
/// [`ChartError`] if there is no reference; an interruption after that is no error but a shorter chart.
pub fn measure(
    scene: &Scene,
    plan: &Plan,
    interrupt: &AtomicBool,
    told: &mut dyn FnMut(&str, f64),
) -> Result<SceneChart, ChartError> {
    let reference = reference(scene, interrupt, &mut |what| told(what, 0.0))?;
    let effort = if plan.quick {
        Effort { cap: 0.5, total: 0.005, repeats: 2, enough: 0.1 }
    } else {
        // A rival is cut at a hundred times the cost of full accuracy: slower runs are of no interest.
        Effort { cap: (100.0 * reference.cost_scale).clamp(0.02, 5.0), total: 0.02, repeats: 5, enough: 1.0 }
    };
    let mut climbs: Vec<Climb> = Method::of(&scene.mechanism)
        .map(|method| Climb {
            method,
            settings: ladder(method, scene.duration, reference.time_scale, plan.quick),
            runs: Vec::new(),
            measurements: Vec::new(),
            best: f64::INFINITY,
            without_progress: 0,
            finished: false,
        })
        .collect();
    let kinetic = largest_kinetic(scene);
    let clock = ThreadTime::now();
    let rungs = climbs.iter().map(|climb| climb.settings.len()).max().unwrap_or(0);
    let mut out_of_budget = false;
    let stopped = || interrupt.load(Ordering::Relaxed);
    'ladders: for rung in 0..rungs {
        for climb in &mut climbs {
            let Some(&setting) = climb.settings.get(rung) else { continue };
            if climb.finished {
                continue;
            }
            out_of_budget = clock.elapsed().as_secs_f64() > plan.budget;
            if out_of_budget || stopped() {
                break 'ladders;
            }
            told(&format!("{} at {setting}", climb.method.id()), rung as f64 / rungs as f64);
            let (mechanism, start) = (&scene.mechanism, &scene.start);
            let run = timed_run(mechanism, start, scene.duration, climb.method, setting, &effort, interrupt);
            if run.ended == Ended::Interrupted {
                break 'ladders;
            }
            let measurement = describe(scene, &reference, kinetic, climb.method, setting, &run);
            climb.see(&measurement);
            climb.measurements.push(measurement);
            climb.runs.push((setting, run));
        }
    }
    told("energy", 1.0);
    let energies = climbs
        .iter()
        .filter_map(|climb| {
            let chosen = representative(&climb.measurements)?;
            (!stopped()).then(|| EnergyHistory::of(scene, climb.method, climb.runs[chosen].0)).flatten()
        })
        .collect();
    Ok(SceneChart {
        name: scene.name.clone(),
        duration: scene.duration,
        size: (scene.mechanism.velocity_count, scene.mechanism.bodies.len()),
        reference,
        measurements: climbs.into_iter().flat_map(|climb| climb.measurements).collect(),
        energies,
        has_events: !scene.mechanism.nonsmooth.is_empty(),
        has_contacts: !scene.mechanism.nonsmooth.pairs.is_empty(),
        out_of_budget,
        interrupted: stopped(),
    })
}

fn describe(
    scene: &Scene,
    reference: &Reference,
    kinetic: f64,
    method: Method,
    setting: Setting,
    run: &TimedRun,
) -> Measurement {
    let mechanism = &scene.mechanism;
    let total = |state: &State| energy_with_forces(mechanism, &state.position, &body_states(mechanism, state)).total();
    let lost = run.exchange.lost();
    // Only a run that came to its end has an error and a cost.
    let if_done = |value: f64| if run.ended == Ended::Done { value } else { f64::NAN };
    Measurement {
        scene: scene.name.clone(),
        method: method.id(),
        setting: setting.to_string(),
        error: if_done(distance(&probes(mechanism, &run.end), &reference.probes)),
        cpu_seconds_per_simulated_second: if_done(run.cpu_seconds / scene.duration),
        steps: Some(run.steps),
        iterations: Some(run.iterations),
        rejected_steps: Some(run.rejected),
        energy_error: if_done((total(&run.end) + lost - total(&scene.start)).abs() / kinetic.max(f64::MIN_POSITIVE)),
        ended: run.ended.clone(),
    }
}
