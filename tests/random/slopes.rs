//! Derivatives of random scenes against differences of their runs.
//!
//! ```text
//!     D(w) = (x(θ + w) − x(θ − w)) / 2w        R = (4 D(w/2) − D(w)) / 3        off = |∂x/∂θ − R| |θ| / max(|R| |θ|, 1e-3)
//! ```
//!
//! The width w is at most a tenth of `valid_within`. A derivative is right if it agrees at one of three widths; it is wrong if it agrees at none,
//! although the differences agree among themselves and all runs have the same events. All runs have the same given steps, so that nothing else differs.

use crate::draw::Draw;
use crate::scene::Scene;
use catena::mechanism::motion::event::{Event, EventKind};
use catena::session::{Error, Model, Sensitivity, Simulation};
use catena::simulation::{Observer, ObserverError, Sample};
use nalgebra::{Quaternion, UnitQuaternion};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

/// Stages and length (s) of steps: differences have the errors of steps as derivatives have them.
const STEPS: (usize, f64) = (7, 0.01);
/// The longest run (s).
const LONGEST: f64 = 0.8;
/// Derivatives and differences agree to this part: runs are solved to 1e-12, and widths are 1e-5 of a number.
const BOUND: f64 = 1e-5;
/// The first width is at most this part of a number; each of the next ones is this part of the one before.
const WIDTH: f64 = 1e-3;
const NARROWER: [f64; 3] = [1.0, 0.1, 0.01];
/// Numbers whose change of this part of themselves is more than the size to which their derivative holds are left out.
const NEAREST: f64 = 1e-7;

/// The most events of a run: a joint that clatters between its limits has hundred thousands.
const MOST: usize = 1000;

/// What a comparison found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// The derivative agrees.
    Agrees,
    /// It does not, and a warning says that it may not.
    Warned,
    /// `valid_within` is too small for differences.
    Near,
    /// There is no derivative by this number, or of this run.
    Refused,
    /// Differences do not converge.
    Rough,
    /// The events of runs that are nearer than a tenth of `valid_within` differ.
    OtherEvents,
    /// The derivative is wrong and nothing says so.
    Wrong,
    /// The scene itself does not run.
    NoRun,
}

/// A comparison, with its reason.
pub struct Found {
    pub verdict: Verdict,
    pub words: String,
}

/// The events of a run, which is ended after too many.
#[derive(Clone)]
struct Events {
    seen: Arc<Mutex<Vec<(EventKind, usize)>>>,
    ends: Arc<AtomicBool>,
}

impl Observer for Events {
    fn sample(&mut self, _sample: &Sample) -> Result<(), ObserverError> {
        Ok(())
    }

    fn event(&mut self, event: &Event) {
        let mut seen = self.seen.lock().expect("no other thread");
        seen.push((event.kind, event.body));
        if seen.len() > MOST {
            self.ends.store(true, Ordering::Relaxed);
        }
    }

    fn skips_samples(&self) -> bool {
        true
    }
}

/// The end of a run.
struct End {
    q: Vec<f64>,
    v: Vec<f64>,
    events: Vec<(EventKind, usize)>,
}

fn simulation(model: &Model, scene: &Scene) -> Simulation {
    // Hard motors and dampers need short steps.
    let step = if scene.is_calm { 0.1 * STEPS.1 } else { STEPS.1 };
    Simulation::new(model).fixed(STEPS.0, step).duration(scene.duration.min(LONGEST)).without_figures()
}

fn ended(model: &Model, scene: &Scene) -> Result<End, Error> {
    let run = simulation(model, scene);
    let events = Events { seen: Arc::default(), ends: run.interrupt() };
    let mut run = run.observe(events.clone());
    run.run()?;
    let (q, v) = run.coordinates()?;
    drop(run);
    let events = std::mem::take(&mut *events.seen.lock().expect("no other thread"));
    Ok(End { q, v, events })
}

/// The motion along v from one q to another, and the change of v (2n).
fn between(model: &Model, from: &End, to: &End) -> Vec<f64> {
    let mut moved = vec![0.0; to.v.len()];
    for joint in model.coordinates().joints() {
        let (one, other) = (&from.q[joint.q.clone()], &to.q[joint.q.clone()]);
        let to = &mut moved[joint.v.clone()];
        let slides = if one.len() == to.len() { one.len() } else { one.len() - 4 };
        (0..slides).for_each(|axis| to[axis] = other[axis] - one[axis]);
        if slides < one.len() {
            let turn = |q: &[f64]| {
                UnitQuaternion::from_quaternion(Quaternion::new(q[slides], q[slides + 1], q[slides + 2], q[slides + 3]))
            };
            to[slides..].copy_from_slice((turn(other) * turn(one).inverse()).scaled_axis().as_slice());
        }
    }
    moved.extend(to.v.iter().zip(&from.v).map(|(to, from)| to - from));
    moved
}

/// One number of the inertias, one of the start, and one of all others, by chance.
fn drawn(model: &Model, seed: u64) -> Vec<(String, f64)> {
    let params = model.params().unwrap_or_default();
    let said: Vec<(String, f64)> = params.into_iter().filter_map(|(key, value)| Some((key, value?))).collect();
    let given = || said.iter().filter(|(_, value)| *value != 0.0 && value.is_finite());
    let inertial = |key: &str| key.contains(".mass") || key.contains(".center_of_mass.") || key.contains(".inertia.");
    let begins = |key: &str| {
        [".positions.", ".velocities.", ".pose.", ".velocity.", "gravity"].iter().any(|part| key.contains(part))
    };
    let mut draw = Draw::new(seed ^ 0x5107);
    let groups: [&dyn Fn(&str) -> bool; 3] = [&inertial, &begins, &|key| !inertial(key) && !begins(key)];
    let of = |group: &&dyn Fn(&str) -> bool| {
        let all: Vec<&(String, f64)> = given().filter(|(key, _)| group(key)).collect();
        (!all.is_empty()).then(|| all[draw.index(all.len())].clone())
    };
    groups.iter().filter_map(of).collect()
}

/// Words without numbers and names, by which reasons are counted.
pub fn reason(words: &str) -> String {
    let mut outside = String::new();
    for (index, part) in words.split('"').enumerate() {
        outside += if index % 2 == 0 { part } else { "…" };
    }
    let is_number = |word: &str| word.chars().next().is_some_and(|first| first.is_ascii_digit() || first == '-');
    let plain = outside.split_whitespace().filter(|word| !is_number(word)).collect::<Vec<_>>().join(" ");
    plain.chars().take(110).collect()
}

/// Compares the derivatives of a scene by some of its numbers.
pub fn compare(scene: &Scene, seed: u64, folder: &Path) -> Vec<Found> {
    let one = |verdict, words: String| vec![Found { verdict, words }];
    let model = match Model::load(scene.write(folder)) {
        Ok(model) => model,
        Err(error) => return one(Verdict::NoRun, error.to_string()),
    };
    let here = match ended(&model, scene) {
        Ok(here) => here,
        Err(error) => return one(Verdict::NoRun, error.to_string()),
    };
    let (mut keys, mut all) = (drawn(&model, seed), Vec::new());
    while !keys.is_empty() {
        let names: Vec<&str> = keys.iter().map(|(key, _)| key.as_str()).collect();
        match simulation(&model, scene).sensitivity(&names) {
            Ok(run) => {
                let compared =
                    keys.iter().enumerate().map(|(column, of)| judged(&model, scene, &here, &run, column, of));
                all.extend(compared);
                return all;
            }
            Err(error) => {
                let words = error.to_string();
                let own = keys.iter().position(|(key, _)| words.starts_with(key.as_str()));
                // Another number may have a derivative.
                match own {
                    Some(own) => {
                        let (key, _) = keys.remove(own);
                        all.push(Found { verdict: Verdict::Refused, words: words[key.len() + 2..].to_string() });
                    }
                    None => {
                        all.extend(keys.drain(..).map(|_| Found { verdict: Verdict::Refused, words: words.clone() }));
                    }
                }
            }
        }
    }
    all
}

fn judged(
    model: &Model,
    scene: &Scene,
    here: &End,
    run: &Sensitivity,
    column: usize,
    (key, value): &(String, f64),
) -> Found {
    let found = |verdict, words: String| Found { verdict, words };
    let within = run.valid_within[column];
    let size = value.abs();
    let widest = (0.1 * within).min(WIDTH * size);
    if widest < NEAREST * size {
        return found(Verdict::Near, run.bounded_by[column].clone());
    }
    let own: Vec<f64> = [&run.dq, &run.dv]
        .iter()
        .flat_map(|of| of.last().expect("steps").column(column).iter().copied().collect::<Vec<_>>())
        .collect();
    let (mut best, mut rough) = (f64::INFINITY, f64::INFINITY);
    let mut others = None;
    let mut estimates: Vec<Vec<f64>> = Vec::new();
    let widths = NARROWER.map(|narrower| widest * narrower);
    for width in widths.into_iter().filter(|width| *width >= NEAREST * size) {
        let at = |by: f64| -> Result<(Vec<f64>, bool), String> {
            let model = model.with_params([(key.as_str(), value + by)]).map_err(|error| error.to_string())?;
            let end = ended(&model, scene).map_err(|error| error.to_string())?;
            Ok((between(&model, here, &end), end.events == here.events))
        };
        let ends: Result<Vec<(Vec<f64>, bool)>, String> =
            [1.0, -1.0, 0.5, -0.5].map(|part| at(part * width)).into_iter().collect();
        let ends = match ends {
            Ok(ends) => ends,
            Err(error) => return found(Verdict::Rough, format!("a run nearby fails: {error}")),
        };
        if ends.iter().any(|(_, same)| !same) {
            others = Some(width);
            continue;
        }
        let wanted: Vec<f64> = (0..own.len())
            .map(|row| {
                let [wide, narrow] = [(0, 1.0), (2, 0.5)]
                    .map(|(first, part)| (ends[first].0[row] - ends[first + 1].0[row]) / (2.0 * part * width));
                (4.0 * narrow - wide) / 3.0
            })
            .collect();
        let scale = wanted.iter().fold(1e-3 / size, |most, entry| f64::max(most, entry.abs()));
        let apart = |one: &[f64]| {
            one.iter().zip(&wanted).fold(0.0, |most, (one, other)| f64::max(most, (one - other).abs())) / scale
        };
        let off = apart(&own);
        if off <= BOUND {
            return found(Verdict::Agrees, String::new());
        }
        best = best.min(off);
        rough = estimates.iter().fold(rough, |least, other| least.min(apart(other)));
        estimates.push(wanted);
    }
    let words = format!("{key} = {value:e}: off by {best:.1e}, differences by {rough:.1e}, valid within {within:.1e}");
    if !run.warnings.is_empty() {
        return found(Verdict::Warned, format!("{}; {words}", run.warnings[0]));
    }
    match others {
        Some(width) if best.is_infinite() => {
            found(Verdict::OtherEvents, format!("other events within {width:.1e}; {words}; {}", run.bounded_by[column]))
        }
        _ if rough < 0.2 * best => found(Verdict::Wrong, words),
        _ => found(Verdict::Rough, words),
    }
}
