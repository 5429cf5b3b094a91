//! Energy error against time, one run for each method.
//!
//! ```text
//!     e(t) = |T + V + D − W − T₀ − V₀| / max T                                 no unit
//! ```
//!
//! D is the energy dissipated by dampers, and W the work of torques without a potential. The error is taken at the end of every step, relative to the
//! largest kinetic energy of the scene. Steps are gathered in intervals of time, and the largest error of each interval is kept: the error passes
//! through zero too often for a curve of single steps, which would be a comb.

use crate::chart::method::{Method, Setting};
use crate::chart::scene::Scene;
use crate::chart::table::Measurement;
use crate::drawing::picture::{Band, Panel, Picture, Scale, Series};
use crate::drawing::style::look;
use crate::mechanism::forces::total::Exchange;
use crate::mechanism::motion::energy::energy_with_forces;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;

/// The accuracy at which the methods are compared [m].
const WANTED_ERROR: f64 = 1e-6;
/// Intervals of time along a run.
const INTERVALS: usize = 160;
/// Errors below this are drawn here, because smaller ones are below the resolution of a double.
const LEAST: f64 = 1e-17;

/// Energy error of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct EnergyHistory {
    /// The method.
    pub method: Method,
    /// Its setting.
    pub setting: Setting,
    /// Time at the end of each interval (s) and the largest relative energy error in it.
    pub points: Vec<(f64, f64)>,
}

/// The run whose end error is nearest to 1e-6 m on a logarithmic scale, as a place in `measurements` of one method.
pub fn representative(measurements: &[Measurement]) -> Option<usize> {
    let distance = |measurement: &Measurement| (measurement.error.max(LEAST).ln() - WANTED_ERROR.ln()).abs();
    let finite = measurements.iter().enumerate().filter(|(_, measurement)| measurement.error.is_finite());
    finite.min_by(|(_, a), (_, b)| distance(a).total_cmp(&distance(b))).map(|(place, _)| place)
}

impl EnergyHistory {
    /// Runs a method once more and looks at the energy after every step; `None` if the run fails.
    pub fn of(scene: &Scene, method: Method, setting: Setting) -> Option<Self> {
        let (mut intervals, mut largest_kinetic) = (vec![None::<f64>; INTERVALS], 0.0_f64);
        let first = energies(scene, &scene.start);
        let mut lost = 0.0;
        walk(scene, method, setting, |state, exchange| {
            let (kinetic, total) = energies(scene, state);
            lost += exchange.lost();
            largest_kinetic = largest_kinetic.max(kinetic);
            let fraction = (state.time - scene.start.time) / scene.duration;
            let interval = ((fraction * INTERVALS as f64).ceil() as usize).clamp(1, INTERVALS) - 1;
            let error = (total + lost - first.1).abs();
            intervals[interval] = Some(intervals[interval].map_or(error, |largest| largest.max(error)));
        })?;
        let scale = largest_kinetic.max(first.0).max(f64::MIN_POSITIVE);
        let time = |interval: usize| scene.duration * (interval + 1) as f64 / INTERVALS as f64;
        let points = intervals.iter().enumerate();
        let points =
            points.filter_map(|(interval, error)| error.map(|error| (time(interval), error / scale))).collect();
        Some(EnergyHistory { method, setting, points })
    }
}

/// The largest kinetic energy of the scene (J), from a run of moderate accuracy; the start's own if that fails.
pub fn largest_kinetic(scene: &Scene) -> f64 {
    let mut largest = energies(scene, &scene.start).0;
    walk(scene, Method::Dop853, Setting::Tolerance(1e-6), |state, _| largest = largest.max(energies(scene, state).0));
    largest
}

/// Kinetic and total energy [J].
fn energies(scene: &Scene, state: &State) -> (f64, f64) {
    let energy = energy_with_forces(&scene.mechanism, &state.position, &body_states(&scene.mechanism, state));
    (energy.kinetic, energy.total())
}

/// Shows the end of every step and the energy exchanged in it; `None` if the run did not reach its end.
fn walk(scene: &Scene, method: Method, setting: Setting, mut see: impl FnMut(&State, Exchange)) -> Option<()> {
    let mut integrator = method.integrator(&scene.mechanism, &scene.start, setting)?;
    let mut state = scene.start.clone();
    let end = state.time + scene.duration;
    while state.time < end {
        let outcome = integrator.advance(&scene.mechanism, &mut state, end).ok()?;
        see(&state, outcome.exchange);
    }
    Some(())
}

/// The picture of all histories of a scene.
pub fn energy_picture(
    scene: &str,
    duration: f64,
    histories: &[EnergyHistory],
    measurements: &[Measurement],
) -> Picture {
    let error_of = |history: &EnergyHistory| {
        let (id, setting) = (history.method.id(), history.setting.to_string());
        measurements
            .iter()
            .find(|measurement| measurement.method == id && measurement.setting == setting)
            .map_or(String::new(), |measurement| format!(" · {:.0e} m", measurement.error))
    };
    let series = |ours: bool| -> Vec<Series> {
        histories
            .iter()
            .filter(|history| history.method.is_ours() == ours)
            .map(|history| Series {
                label: format!("{}{}", history.method.label().replace(", tolerance", ""), error_of(history)),
                look: look(&history.method.id(), 0),
                points: history.points.iter().map(|&(time, error)| (time, error.max(LEAST))).collect(),
                markers_every: (history.points.len() / 8).max(1),
            })
            .collect()
    };
    Picture {
        title: format!("{scene}: energy error along the run"),
        subtitle: "each method at the setting whose end error is nearest to 10⁻⁶ m (in the legend)".to_string(),
        x: Scale::Linear { label: "simulated time [s]".to_string(), range: (0.0, duration) },
        y: Scale::Log { label: "energy error / largest kinetic energy".to_string(), least: LEAST, most: 10.0 },
        bands: Vec::<Band>::new(),
        panels: vec![
            Panel { heading: "catena".to_string(), series: series(true) },
            Panel { heading: "joint coordinates".to_string(), series: series(false) },
        ],
        notes: Vec::new(),
        marks: Vec::new(),
    }
}
