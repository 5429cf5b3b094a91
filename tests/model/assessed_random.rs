//! Estimated errors of random motions at three tolerances, compared with reference solutions.
//!
//! The reference is a run iterated to rounding. It counts if a second one with different stages and half the step agrees with it to a tenth of the
//! error. A run is compared at up to [`INSTANTS`] ends of steps, because its estimate is of the largest error over time.

use crate::common::Numbers;
use crate::models;
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::motion::distance::{distance, probes, size};
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::state::State;
use catena::simulation::{Accuracy, Simulation, SimulationOptions, StepChoice};
use catena::stepping::integrator::Lobatto;
use nalgebra::{Rotation3, Translation3, Vector3};

/// Ends of steps at which a run is compared with the reference.
const INSTANTS: usize = 12;
/// Stages of the second reference.
const OTHER_STAGES: usize = 11;
/// Number of motions, each at three tolerances.
const MOTIONS: usize = 700;
/// An estimate that is smaller than the error by more than this factor is too bright, one that is larger by more is too dark.
const HONEST: f64 = 30.0;

/// A random tree, its start and its duration (s).
struct Motion {
    mechanism: Mechanism,
    start: State,
    duration: f64,
    kind: &'static str,
}

const KINDS: [&str; 7] =
    ["whip", "chain in a plane", "chain in space", "branched tree", "free body", "floating tree", "with springs"];

fn motion(number: usize) -> Motion {
    let mut numbers = Numbers::new(40_000 + number as u64);
    let kind = KINDS[number % KINDS.len()];
    let most = if kind == "free body" { 1.0 } else { 16.0_f64.ln() };
    let count = if kind == "free body" { 1 } else { numbers.next(0.0, most).exp().round() as usize };
    let place = |numbers: &mut Numbers, size: f64| Vector3::from_fn(|_, _| numbers.next(-size, size));
    if kind == "whip" {
        let models::Model { mut mechanism, state: start } = models::chain(count.max(2));
        mechanism.gravity *= numbers.next(0.7, 1.5);
        return Motion { mechanism, start, duration: numbers.next(0.3, 0.8), kind };
    }
    let mut bodies: Vec<Body> = Vec::new();
    // The path from the root to the last body, because bodies are in depth-first order.
    let mut branch: Vec<usize> = Vec::new();
    for index in 0..count {
        let is_branched = matches!(kind, "branched tree" | "floating tree" | "with springs");
        let parent = match index {
            0 => None,
            _ if is_branched => {
                branch.truncate((numbers.next(0.4, 0.999) * branch.len() as f64) as usize + 1);
                branch.last().copied()
            }
            _ => Some(index - 1),
        };
        let joint_kind = match kind {
            "free body" => JointKind::Floating,
            "floating tree" if index == 0 => JointKind::Floating,
            "branched tree" | "floating tree" if index % 4 == 3 => JointKind::Spherical,
            "branched tree" if index % 5 == 2 => JointKind::Prismatic,
            _ => JointKind::Revolute,
        };
        let length = numbers.next(0.1, 0.6);
        let axis = match kind {
            "chain in a plane" => Vector3::y(),
            _ => place(&mut numbers, 1.0).normalize(),
        };
        let turned = |at: Vector3<f64>| {
            let turn = Rotation3::rotation_between(&Vector3::z(), &axis).unwrap_or_else(Rotation3::identity);
            Pose::from_parts(Translation3::from(at), turn)
        };
        let along = Vector3::new(0.5 * length, 0.0, 0.0);
        let on_parent = if parent.is_none() { Vector3::zeros() } else { along };
        let mass = numbers.next(0.2, 3.0);
        let inertia = models::box_inertia(mass, Vector3::new(length, numbers.next(0.1, 0.5) * length, 0.2 * length));
        branch.push(index);
        let joint = Joint::new(&format!("joint{index}"), joint_kind, turned(on_parent), turned(-along));
        bodies.push(models::body(&format!("body{index}"), parent, mass, inertia, joint));
    }
    let mut mechanism = Mechanism::new(&format!("{kind} {number}"), models::gravity(), bodies).expect("parents first");
    let mut start = State::zero(&mechanism);
    let speed = if numbers.next(0.0, 1.0) < 0.3 { 0.0 } else { numbers.next(0.0, 8.0) };
    for index in 0..count {
        let joint = &mechanism.bodies[index].joint;
        let (position, velocity) = (joint.position_index, joint.velocity_index);
        if matches!(joint.kind, JointKind::Revolute) {
            start.position[position] = numbers.next(-2.0, 2.0);
        }
        let scale = if matches!(joint.kind, JointKind::Prismatic) { 0.2 } else { 1.0 };
        for freedom in velocity..velocity + joint.kind.velocity_count() {
            start.velocity[freedom] = scale * numbers.next(-speed, speed);
        }
    }
    if kind == "with springs" {
        mechanism.forces = models::joint_springs(&mechanism);
        let stiffness = numbers.next(0.5, 20.0);
        mechanism.forces.joint_springs.iter_mut().for_each(|spring| spring.stiffness = stiffness);
        if number % 12 < 6 {
            mechanism.forces.joint_dampers = models::joint_dampers(&mechanism).joint_dampers;
        }
    }
    let duration = numbers.next(0.2_f64.ln(), 12.0_f64.ln()).exp();
    Motion { mechanism, start, duration, kind }
}

/// Positions of the probes at some times (s) of a motion from a state on, as these steps make them; `None` if a step fails.
pub fn places_at(
    mechanism: &Mechanism,
    start: &State,
    times: &[f64],
    mut lobatto: Lobatto,
) -> Option<Vec<Vec<Vector3<f64>>>> {
    let mut state = start.clone();
    let mut places = Vec::new();
    for &time in times {
        while state.time < time {
            lobatto.advance(mechanism, &mut state, time).ok()?;
        }
        places.push(probes(mechanism, &state));
    }
    Some(places)
}

/// The accuracy that a run told, its largest error (m), and the uncertainty of that error (m).
struct Compared {
    told: Accuracy,
    error: f64,
    doubt: f64,
}

fn compared(motion: &Motion, tolerance: f64) -> Option<Compared> {
    let Motion { mechanism, start, duration, .. } = motion;
    let steps = StepChoice::Tolerance(tolerance);
    let options = SimulationOptions::new(*duration, steps);
    let mut simulation = Simulation::new(mechanism, start.clone(), options).expect("a simulation");
    simulation.run().ok()?;
    let told = simulation.finish().accuracy[0].clone().ok()?;
    if told.holds_until < *duration {
        return None;
    }
    // Repeats the run to get the ends of its steps.
    let mut lobatto = Lobatto::adaptive_with_stages(mechanism, tolerance, told.stop, told.stages);
    let mut state = start.clone();
    let mut ends = Vec::new();
    while state.time < *duration {
        lobatto.advance(mechanism, &mut state, *duration).ok()?;
        ends.push((state.time, probes(mechanism, &state)));
    }
    let stride = ends.len().div_ceil(INSTANTS);
    let ends: Vec<_> = ends.into_iter().rev().step_by(stride).collect::<Vec<_>>().into_iter().rev().collect();
    let times: Vec<f64> = ends.iter().map(|(time, _)| *time).collect();
    let truth = places_at(mechanism, &motion.start, &times, Lobatto::adaptive_with_stop(mechanism, 1e-12, 1e-16))?;
    let half = lobatto.description().step / 2.0;
    let other = places_at(mechanism, &motion.start, &times, Lobatto::fixed(mechanism, OTHER_STAGES, half).ok()?)?;
    let largest = |one: &mut dyn Iterator<Item = f64>| one.fold(0.0, f64::max);
    let error = largest(&mut ends.iter().zip(&truth).map(|((_, end), truth)| distance(end, truth)));
    let doubt = largest(&mut other.iter().zip(&truth).map(|(other, truth)| distance(other, truth)));
    Some(Compared { told, error, doubt })
}

#[test]
#[ignore = "half a minute: cargo test --release --test model assessed_random -- --ignored --nocapture"]
fn of_hundreds_of_random_motions_next_to_none_is_less_accurate_than_it_says_and_few_estimates_are_thirty_times_off() {
    let (mut reached, mut wrong, mut judged, mut bright, mut dark) = (0, 0, 0, 0, 0);
    for number in 0..MOTIONS {
        let motion = motion(number);
        let size = size(&motion.mechanism, &motion.start);
        for tolerance in [1e-3, 1e-6, 1e-9] {
            let Some(Compared { told, error, doubt }) = compared(&motion, tolerance) else { continue };
            reached += 1;
            if doubt < 0.1 * tolerance {
                wrong += usize::from(error > tolerance);
                if error > tolerance {
                    println!(
                        "WRONG {number} {} {} freedoms {tolerance:e}: {error:.2e} told {:.2e} doubt {doubt:.1e} stop {:.0e}",
                        motion.kind, motion.mechanism.velocity_count, told.estimate, told.stop
                    );
                }
            }
            // Errors below rounding cannot be estimated.
            let floor = 1e-14 * size.max(1.0);
            if doubt > 0.1 * error.max(floor) {
                continue;
            }
            judged += 1;
            let (is_bright, is_dark) =
                (error > HONEST * told.estimate.max(floor), told.estimate > HONEST * error.max(floor));
            bright += usize::from(is_bright);
            dark += usize::from(is_dark);
            println!(
                "{number} {} {} bodies {} freedoms {:.2} s {tolerance:e}: error {error:.2e} told {:.2e} ratio {:.1e} stop {:.0e} begun {}{}{}",
                motion.kind,
                motion.mechanism.bodies.len(),
                motion.mechanism.velocity_count,
                motion.duration,
                told.estimate,
                told.estimate / error.max(floor),
                told.stop,
                told.begun,
                if is_bright { " BRIGHT" } else { "" },
                if is_dark { " DARK" } else { "" }
            );
        }
    }
    println!(
        "{reached} runs say reached, {wrong} wrongly; of {judged} that can be judged {bright} too bright, {dark} too dark"
    );
    // Before the truncation error depended on the number of freedoms, 7 of 1861 runs said "reached" wrongly, 2 of 1484 estimates were too bright and
    // 90 too dark. The first two bounds are what it was then; the third is the goal, one in a hundred. Since truncation parts the motions
    // only, 4 of 1855 are wrong, and of 1524 two are too bright and seven too dark.
    assert!(
        wrong * 250 <= reached && bright * 500 <= judged && dark * 100 <= judged,
        "wrong {wrong}, bright {bright}, dark {dark}"
    );
}
