//! Runs of crowds, and their faults: heaps of bodies and limp robots, which no run follows exactly to the end.
//!
//! | verdict | fault |
//! |---|---|
//! | `panic`, `failed` | the run panics, or ends before its end with an error |
//! | `bits` | the same run twice ends in other bits |
//! | `overlap` | shapes that touch are inside each other where a step ends |
//! | `energy` | the energy grows from one instant to the next |
//! | `cone`, `limit` | forces outside cones, joints beyond limits |
//! | `residual` | the law of contact is not solved |
//! | `tolerance` | two tolerances disagree before the horizon of either |
//! | `slow` | some hundred times as many steps as usual |

use crate::judge::Fault;
use crate::overlap::Convex;
use crate::scene::Scene;
use crate::watch::{ATTEMPTS, Seen, Watch};
use catena::output::report::Report;
use catena::session::{Error, Model, Simulation};
use nalgebra::{IsometryMatrix3, Rotation3, Translation3};
use std::path::Path;
use std::sync::Arc;

/// Tolerances of the runs that are compared (m): the usual one of such scenes, and a finer one.
const COARSE: f64 = 1e-3;
const FINE: f64 = 1e-4;
/// How far they may be apart where both are said to hold (m): ten times the coarser one, as its estimate is an order of magnitude.
const APART: f64 = 1e-2;
/// Steps end at these instants, which are looked at (s).
const EVERY: f64 = 4e-3;
/// The most that shapes may be inside each other where a step ends (m), and joints beyond their limits (rad, m).
const DEEP: f64 = 1e-9;
/// The largest residual of a step as a part of the largest impulse.
const RESIDUAL: f64 = 1e-4;
/// The part of the energies by which one may grow: of exact steps, whose local errors are below the tolerance.
const GAIN: f64 = 1e-6;

/// A run that has ended.
struct Run {
    trace: Trace,
    report: Report,
    seen: Seen,
}

/// A run as it is at each instant.
#[derive(Default)]
struct Trace {
    instants: Vec<f64>,
    /// q and v.
    numbers: Vec<Vec<f64>>,
    /// Origin and axes of each link (m, 1).
    places: Vec<Vec<f64>>,
    /// Kinetic and potential energy (J).
    energies: Vec<[f64; 2]>,
    overlap: Option<(f64, String)>,
    outside_limit: Option<(f64, String)>,
}

/// The faults of a scene.
pub fn judge(scene: &Arc<Scene>, path: &Path, faults: &mut Vec<Fault>) {
    let mut add = |verdict, words: String| faults.push(Fault { verdict, words });
    let coarse = match run(scene, path, COARSE) {
        Ok(run) => run,
        Err(error) => return add("failed", error),
    };
    alone(&coarse, &mut add);
    if coarse.seen.slow.is_some() {
        return;
    }
    match run(scene, path, COARSE) {
        Ok(again) if bits(&again) == bits(&coarse) => {}
        Ok(_) => add("bits", "the same run ends in other bits".to_string()),
        Err(error) => add("failed", format!("again: {error}")),
    }
    let fine = match run(scene, path, FINE) {
        Ok(run) => run,
        Err(error) => return add("failed", format!("at {FINE:e}: {error}")),
    };
    alone(&fine, &mut add);
    let holds = |run: &Run| run.report.accuracy.as_ref().map_or(0.0, |accuracy| accuracy.holds_until);
    let horizon = holds(&coarse).min(holds(&fine));
    for ((instant, one), other) in coarse.trace.instants.iter().zip(&coarse.trace.places).zip(&fine.trace.places) {
        let apart = one.iter().zip(other).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
        if *instant <= horizon && apart > APART {
            add("tolerance", format!("{apart:.1e} m apart at {instant:.3} s, before the horizon at {horizon:.3} s"));
            break;
        }
    }
}

fn bits(run: &Run) -> Vec<u64> {
    run.trace.numbers.iter().flatten().map(|number| number.to_bits()).collect()
}

/// Faults of one run.
fn alone(run: &Run, add: &mut dyn FnMut(&'static str, String)) {
    let Run { trace, report, seen } = run;
    if let Some(time) = seen.not_finite {
        return add("failed", format!("numbers that are not finite at {time} s"));
    }
    if let Some(slow) = seen.slow {
        return add("slow", format!("more than {ATTEMPTS} attempts up to {slow:.3} s"));
    }
    let worst = [("overlap", &trace.overlap), ("limit", &trace.outside_limit), ("cone", &seen.outside_cone)];
    for (verdict, found) in worst {
        if let Some((_, words)) = found {
            add(verdict, words.clone());
        }
    }
    let residual = report.method.first_order_residual;
    if residual > RESIDUAL {
        add("residual", format!("{residual:.1e} of the largest impulse"));
    }
    let scale = trace.energies.iter().map(|[kinetic, _]| *kinetic).fold(1e-3, f64::max);
    for (number, two) in trace.energies.windows(2).enumerate() {
        let gained = two[1][0] + two[1][1] - two[0][0] - two[0][1];
        if gained > GAIN * scale {
            let time = trace.instants[number + 1];
            return add("energy", format!("{gained:.1e} J are gained up to {time:.3} s, of {scale:.1e} J"));
        }
    }
}

/// Runs a scene with steps that end at the instants.
fn run(scene: &Arc<Scene>, path: &Path, tolerance: f64) -> Result<Run, String> {
    let model = Model::load(path).map_err(|error| error.to_string())?;
    let simulation = Simulation::new(&model).tolerance(tolerance);
    let (watch, seen) = Watch::new(scene, &model, simulation.interrupt());
    let mut simulation = simulation.observe(watch);
    let mut trace = Trace::default();
    for number in 1..=(scene.duration / EVERY) as usize {
        let instant = EVERY * number as f64;
        match simulation.step_to(instant) {
            Err(Error::Run(_)) if seen.lock().expect("one thread at a time").slow.is_some() => break,
            ended => ended.map_err(|error| error.to_string())?,
        }
        trace.look(scene, &model, &simulation, instant).map_err(|error| error.to_string())?;
    }
    let report = simulation.finish().map_err(|error| error.to_string())?;
    let seen = seen.lock().expect("the run has ended").clone();
    Ok(Run { trace, report, seen })
}

impl Trace {
    /// Looks at a run where a step has ended.
    fn look(&mut self, scene: &Scene, model: &Model, simulation: &Simulation, instant: f64) -> Result<(), Error> {
        let (q, v) = simulation.coordinates()?;
        let energy = simulation.energy()?;
        self.instants.push(instant);
        self.numbers.push(q.into_iter().chain(v).collect());
        self.energies.push([energy.kinetic, energy.total() - energy.kinetic]);
        let (mut places, mut sets) = (Vec::new(), Vec::new());
        for solid in &scene.solids {
            sets.push(match solid.pose {
                Some(pose) => Convex::of(&solid.shape, &pose),
                None => {
                    let at = simulation.link(&solid.name)?;
                    places.extend(at.position.iter().chain(at.rotation.iter()).copied());
                    let rotation = Rotation3::from_matrix_unchecked(at.rotation);
                    let pose = IsometryMatrix3::from_parts(Translation3::from(at.position), rotation);
                    Convex::of(&solid.shape, &pose)
                }
            });
        }
        self.places.push(places);
        let nonsmooth = &model.description().mechanism.nonsmooth;
        let solid =
            |collider: usize| scene.solids.iter().position(|solid| solid.name == nonsmooth.colliders[collider].name);
        for pair in nonsmooth.pairs.iter() {
            let (Some(a), Some(b)) = (solid(pair.a), solid(pair.b)) else { continue };
            for (one, other) in sets[a].iter().flat_map(|one| sets[b].iter().map(move |other| (one, other))) {
                let deep = one.depth(other, DEEP);
                if deep > self.overlap.as_ref().map_or(0.0, |(most, _)| *most) {
                    let [a, b] = [a, b].map(|solid| &scene.solids[solid].name);
                    self.overlap = Some((deep, format!("{a} and {b} overlap by {deep:.1e} m at {instant:.3} s")));
                }
            }
        }
        for (name, lower, upper) in &scene.limits {
            let at = simulation.position(name)?[0];
            let outside = (lower - at).max(at - upper);
            if outside > DEEP.max(self.outside_limit.as_ref().map_or(0.0, |(most, _)| *most)) {
                let words = format!("{name} is {outside:.1e} outside its limit at {instant:.3} s");
                self.outside_limit = Some((outside, words));
            }
        }
        Ok(())
    }
}
