//! Runs of a scene, and their faults.
//!
//! | verdict | fault |
//! |---|---|
//! | `panic`, `failed` | the run panics, or ends before its end with an error |
//! | `energy` | the balance of energies is off, friction or impacts give energy, or a scene without losses loses some |
//! | `limit`, `overlap`, `cone` | joints beyond limits, shapes inside each other, forces outside cones, in any sample |
//! | `closed form` | another end, start or number of impacts than a formula gives |
//! | `tolerance` | two tolerances that are both said to be reached disagree |
//! | `steps` | given steps are far from both, without a warning |
//! | `chaos` | a motion that cannot amplify errors is called chaotic |
//! | `twin` | the same scene written otherwise moves otherwise |
//! | `slow` | some hundred times as many steps as usual |

use crate::crowd;
use crate::scene::{Answer, Scene};
use crate::watch::{ATTEMPTS, Seen, Watch};
use catena::output::report::{Numbers, Report};
use catena::session::{Error, Model, Simulation};
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::{Arc, Once};

/// Tolerances of the two runs that are compared (m).
const COARSE: f64 = 1e-6;
const FINE: f64 = 1e-8;
/// How far they may be apart where both are said to be reached (m): ten times the coarser one, as its estimate is an order of magnitude.
const APART: f64 = 1e-5;
/// How far given steps may be off without a warning (m).
const GIVEN_APART: f64 = 1e-3;
/// Stages and length of given steps (s).
const GIVEN: (usize, f64) = (5, 5e-3);
/// Samples per second: at 10 m/s a body of 6 cm is seen in anything that it passes through.
const RATE: f64 = 240.0;
/// The part of the largest kinetic energy by which a balance may be off: at 1e-6 m of scenes of about a metre, ten times as much.
const BALANCE: f64 = 1e-5;

/// One thing that is wrong.
#[derive(Clone, Debug)]
pub struct Fault {
    pub verdict: &'static str,
    pub words: String,
}

/// A run that has ended.
struct Run {
    report: Report,
    seen: Seen,
}

thread_local! {
    /// The first panic of this thread, with its place.
    static PANIC: Cell<String> = const { Cell::new(String::new()) };
}

/// Panics of this thread are kept instead of printed.
fn keep_panics() {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            let before_it = PANIC.take();
            PANIC.set(if before_it.is_empty() { info.to_string().replace('\n', " ") } else { before_it });
            if std::thread::current().name().is_none_or(|name| name != "scenes") {
                before(info);
            }
        }));
    });
}

/// The faults of a scene. Its files are written into `folder`.
pub fn judge(scene: &Scene, folder: &Path) -> Vec<Fault> {
    keep_panics();
    PANIC.take();
    let path = scene.write(folder);
    let scene = Arc::new(scene.clone());
    let mut faults = Vec::new();
    let judged = catch_unwind(AssertUnwindSafe(|| {
        let judge_all = if scene.is_crowd { crowd::judge } else { judge_runs };
        judge_all(&scene, &path, &mut faults);
    }));
    if judged.is_err() {
        faults.push(Fault { verdict: "panic", words: PANIC.take() });
    }
    faults
}

fn judge_runs(scene: &Arc<Scene>, path: &Path, faults: &mut Vec<Fault>) {
    let mut add = |verdict, words: String| faults.push(Fault { verdict, words });
    let coarse = match run(scene, path, |simulation| simulation.tolerance(COARSE)) {
        Ok(coarse) => coarse,
        Err(error) => return add("failed", error),
    };
    for (verdict, words) in alone(scene, &coarse) {
        add(verdict, words);
    }
    if coarse.seen.slow.is_some() {
        return;
    }
    match run(scene, path, |simulation| simulation.tolerance(FINE)) {
        Ok(fine) => {
            if let Some(slow) = fine.seen.slow {
                return add("slow", format!("more than {ATTEMPTS} attempts up to {slow:.3} s at {FINE:e}"));
            }
            let apart = distance(&coarse.report, &fine.report);
            let both = is_reached(&coarse.report) && is_reached(&fine.report);
            if both && apart > APART {
                let told = coarse.report.accuracy.map_or(f64::NAN, |accuracy| accuracy.estimated);
                add("tolerance", format!("{COARSE:e} and {FINE:e} are {apart:.1e} m apart, estimated {told:.1e} m"));
            }
            match run(scene, path, |simulation| simulation.fixed(GIVEN.0, GIVEN.1)) {
                Ok(given) => {
                    let off = distance(&given.report, &fine.report);
                    if let Some(slow) = given.seen.slow {
                        return add(
                            "slow",
                            format!("more than {ATTEMPTS} attempts up to {slow:.3} s with given steps"),
                        );
                    }
                    if both && apart <= APART && given.report.warnings.is_empty() && off > GIVEN_APART {
                        add("steps", format!("steps of {} s are {off:.1e} m off, without a warning", GIVEN.1));
                    }
                    for (verdict, words) in seen_faults(&given.seen, GIVEN_APART) {
                        add(verdict, format!("given steps: {words}"));
                    }
                }
                Err(error) => add("failed", format!("given steps: {error}")),
            }
        }
        Err(error) => add("failed", format!("at {FINE:e}: {error}")),
    }
    if let Some((name, _)) = &scene.twin {
        match run(scene, &path.with_file_name(name), |simulation| simulation.tolerance(COARSE)) {
            Ok(twin) => {
                let apart = distance(&coarse.report, &twin.report);
                if apart > APART {
                    add("twin", format!("{name} ends {apart:.1e} m from it"));
                }
            }
            Err(error) => add("failed", format!("{name}: {error}")),
        }
    }
}

/// Loads and runs a scene with these steps.
fn run(scene: &Arc<Scene>, path: &Path, steps: impl FnOnce(Simulation) -> Simulation) -> Result<Run, String> {
    let model = Model::load(path).map_err(|error| error.to_string())?;
    let simulation = steps(Simulation::new(&model)).rate(RATE);
    let (watch, seen) = Watch::new(scene, &model, simulation.interrupt());
    let mut simulation = simulation.observe(watch);
    let ended = simulation.run();
    let seen = seen.lock().expect("the run has ended").clone();
    match ended {
        Err(Error::Run(_)) if seen.slow.is_some() => {}
        ended => ended.map_err(|error| error.to_string())?,
    }
    let report = simulation.finish().map_err(|error| error.to_string())?;
    Ok(Run { report, seen })
}

/// Whether a run says that it is as accurate as was asked for, and warns of no contact that was not solved.
fn is_reached(report: &Report) -> bool {
    let unsolved = |warning: &String| warning.contains("first-order step") || warning.contains("could not be solved");
    report.accuracy.is_some_and(|accuracy| accuracy.reached) && !report.warnings.iter().any(unsolved)
}

/// Faults in the samples of a run. Shapes and joints may be beyond their bounds by `allowed` (m, rad).
fn seen_faults(seen: &Seen, allowed: f64) -> Vec<(&'static str, String)> {
    let beyond = |what: &Option<(f64, String)>| what.clone().filter(|(amount, _)| *amount > allowed);
    let mut faults = Vec::new();
    faults.extend(seen.not_finite.map(|time| ("failed", format!("numbers that are not finite at {time} s"))));
    faults.extend(beyond(&seen.outside_limit).map(|(_, words)| ("limit", words)));
    faults.extend(beyond(&seen.overlap).map(|(_, words)| ("overlap", words)));
    faults.extend(seen.outside_cone.clone().map(|(_, words)| ("cone", words)));
    faults
}

/// Faults of one run with a tolerance.
fn alone(scene: &Scene, run: &Run) -> Vec<(&'static str, String)> {
    let Run { report, seen } = run;
    let mut faults = seen_faults(seen, 0.0);
    if let Some(slow) = seen.slow {
        faults.push(("slow", format!("more than {ATTEMPTS} attempts up to {slow:.3} s")));
        return faults;
    }
    let energy = &report.energy;
    let scale = f64::max(energy.parts.kinetic, energy.initial.abs()).max(1e-9);
    // Hard dampers take nearly all that springs and motors store with next to no motion: a displacement of a tenth of the tolerance changes it so much.
    let displaced = 0.1 * COARSE * scene.pull;
    let hardly_moves = seen.balance.is_some_and(|(least, most)| {
        (energy.initial - least).max(most - energy.initial) <= (BALANCE * seen.kinetic.max(scene.stored)).max(displaced)
    });
    let balances = energy.max_relative_error <= BALANCE || hardly_moves;
    if !balances {
        faults.push(("energy", format!("the balance is off by {:.1e}", energy.max_relative_error)));
    }
    for (what, lost) in [("impacts", energy.impacts), ("friction", energy.friction), ("dampers", energy.dissipated)] {
        if lost < -1e-9 * scale {
            faults.push(("energy", format!("{what} give {:.1e} J of {scale:.1e} J", -lost)));
        }
        if scene.is_lossless && lost.abs() > BALANCE * scale {
            faults.push(("energy", format!("{what} take {lost:.1e} J of {scale:.1e} J, where there are no losses")));
        }
    }
    let chaotic = report.warnings.iter().any(|warning| warning.contains("chaotic"));
    let reached = report.accuracy.is_some_and(|accuracy| accuracy.reached);
    if scene.is_calm && (chaotic || !reached) {
        faults.push(("chaos", format!("called chaotic ({chaotic}), accuracy reached ({reached})")));
    }
    faults.extend(scene.answers.iter().filter_map(|answer| wrong(answer, run)).map(|words| ("closed form", words)));
    faults
}

/// The deviation from a closed form, in words.
fn wrong(answer: &Answer, Run { report, seen }: &Run) -> Option<String> {
    let off = |what: &str, got: Option<f64>, right: f64, bound: f64| {
        let got = got.unwrap_or(f64::NAN);
        let off = (got - right).abs();
        (off.is_nan() || off > bound).then(|| format!("{what} is {got}, right {right}"))
    };
    match answer {
        Answer::Place { link, axis, right, bound } => {
            let found = report.links.iter().find(|(name, _)| name == link).map(|(_, link)| link.position[*axis]);
            off(&format!("{link}, coordinate {axis},"), found, *right, *bound)
        }
        Answer::Joint { joint, right, bound } => off(joint, position(report, joint), *right, *bound),
        Answer::Start { joint, right } => {
            // Robots of these scenes have one coordinate a joint, in the order of the file.
            let index = report.joints.iter().position(|(name, _)| name == joint);
            off(&format!("at the start {joint}"), index.and_then(|index| seen.start.get(index).copied()), *right, 1e-9)
        }
        Answer::Impacts { right } => {
            (seen.impacts != *right).then(|| format!("{} contact impacts, right {right}", seen.impacts))
        }
        Answer::FewEvents { most } => {
            (seen.events > *most).then(|| format!("{} events, at most {most} are right", seen.events))
        }
    }
}

fn position(report: &Report, joint: &str) -> Option<f64> {
    match &report.joints.iter().find(|(name, _)| name == joint)?.1.position {
        Numbers::One(position) => Some(*position),
        Numbers::Many(_) => None,
    }
}

/// The largest distance of a link's origin, and of points 0.1 m from it, at the ends of two runs (m).
fn distance(one: &Report, other: &Report) -> f64 {
    let links = one.links.iter().zip(&other.links);
    let apart = links.map(|((_, one), (_, other))| {
        let norm =
            |a: &[f64], b: &[f64], sign: f64| a.iter().zip(b).map(|(a, b)| (a - sign * b).powi(2)).sum::<f64>().sqrt();
        let place = norm(&one.position, &other.position, 1.0);
        let turn =
            f64::min(norm(&one.orientation, &other.orientation, 1.0), norm(&one.orientation, &other.orientation, -1.0));
        place.max(0.2 * turn)
    });
    apart.fold(0.0, f64::max)
}
