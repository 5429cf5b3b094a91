//! Estimated errors of motions that dampers, stiff springs and motors hold, compared with their exact answers.
//!
//! A hinge with a spring and a damper has its answer in closed form, with `I q̈ = −k q − c q̇`. All others are compared with a run of the plain scheme
//! to rounding, of the mechanism with the springs and dampers that its motors are; a second one of other stages and shorter steps says how far that is
//! known. A run is compared at ends of its steps, because its estimate is of the largest error over time.

use crate::assessed::{options, told};
use crate::assessed_random::places_at;
use crate::common::Numbers;
use crate::models;
use catena::mechanism::description::forces::{JointDamper, JointSpring};
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::description::nonsmooth::{Motor, MotorLaw};
use catena::mechanism::description::target::Target;
use catena::mechanism::forces::total::scalar_coordinate;
use catena::mechanism::motion::distance::{distance, probes, size};
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::state::State;
use catena::simulation::method::run_integrator::RunIntegrator;
use catena::simulation::{Accuracy, Simulation};
use catena::stepping::integrator::Lobatto;
use catena::stepping::recipe::Steps;
use nalgebra::{Rotation3, Translation3, Vector3};

/// Ends of steps at which a run is compared.
const INSTANTS: usize = 40;
/// Stages of the second reference.
const OTHER_STAGES: usize = 7;
/// Its steps over those of the first.
const SHORTER: f64 = 0.3;
/// Estimates are within this factor of the error.
const HONEST: f64 = 10.0;

const KINDS: [&str; 5] = ["hinge", "springs", "dampers", "springs and dampers", "motors"];

/// What holds the hinge: `k` (N m/rad) and `c` (N m s/rad).
#[derive(Clone, Copy)]
struct Hold {
    stiffness: f64,
    damping: f64,
}

/// A mechanism that is held, its start and its duration (s).
struct Motion {
    kind: &'static str,
    /// As it is run.
    mechanism: Mechanism,
    /// With springs and dampers in place of motors.
    smooth: Mechanism,
    start: State,
    duration: f64,
    /// Of the hinge.
    exact: Option<(Hold, f64)>,
}

/// The moment of inertia of the hinge (kg m²).
const INERTIA: f64 = 0.2;

fn motion(number: usize) -> Motion {
    let mut numbers = Numbers::new(70_000 + number as u64);
    let kind = KINDS[number % KINDS.len()];
    let is_hinge = kind == "hinge";
    let count = if is_hinge { 1 } else { 1 + (number / KINDS.len()) % 7 };
    let mut bodies: Vec<Body> = Vec::new();
    let mut reach = Vec::new();
    for index in 0..count {
        let length = numbers.next(0.1, 0.6);
        let axis = Vector3::from_fn(|_, _| numbers.next(-1.0, 1.0)).normalize();
        let turn = Rotation3::rotation_between(&Vector3::z(), &axis).unwrap_or_else(Rotation3::identity);
        let turned = |x: f64| Pose::from_parts(Translation3::new(x, 0.0, 0.0), turn);
        let mass = if is_hinge { 1.0 } else { numbers.next(0.2, 3.0) };
        let inertia = if is_hinge {
            Vector3::repeat(INERTIA)
        } else {
            models::box_inertia(mass, Vector3::new(length, 0.3 * length, 0.2 * length))
        };
        let [on_parent, own] =
            if is_hinge { [0.0, 0.0] } else { [if index == 0 { 0.0 } else { 0.5 * length }, -0.5 * length] };
        let joint = Joint::new(&format!("joint{index}"), JointKind::Revolute, turned(on_parent), turned(own));
        bodies.push(models::body(&format!("body{index}"), index.checked_sub(1), mass, inertia, joint));
        reach.push((mass, length));
    }
    let gravity = if is_hinge { Vector3::zeros() } else { models::gravity() };
    let mut smooth = Mechanism::new(&format!("{kind} {number}"), gravity, bodies).expect("parents first");
    let mut start = State::zero(&smooth);
    let mut mechanism = smooth.clone();
    let mut exact = None;
    for index in 0..count {
        // About the joint: of all that it carries, laid out straight.
        let mut arm = 0.0;
        let carried: f64 = reach[index..]
            .iter()
            .map(|&(mass, length)| {
                arm += length;
                mass * arm * arm / 3.0
            })
            .sum();
        let carried = if is_hinge { INERTIA } else { carried };
        let stiffness = 10_f64.powf(numbers.next(0.5, if is_hinge { 4.0 } else { 3.5 }));
        let ratio = 10_f64.powf(numbers.next(-1.0, 1.3));
        let damping = 2.0 * ratio * (stiffness * carried).sqrt();
        let rest = if is_hinge { 0.0 } else { numbers.next(-1.0, 1.0) };
        let hold = Hold { stiffness, damping };
        let coordinate = scalar_coordinate(&smooth, index).expect("a hinge");
        if kind != "dampers" {
            smooth.forces.joint_springs.push(JointSpring { coordinate, stiffness, rest });
        }
        if kind != "springs" {
            smooth.forces.joint_dampers.push(JointDamper { freedom: index, coefficient: damping });
        }
        if kind == "motors" {
            mechanism.nonsmooth.motors.push(Motor {
                coordinate,
                law: MotorLaw::Position { kp: stiffness, kd: damping },
                target: Target::constant(rest),
                max_effort: f64::INFINITY,
                period: 0.0,
                held: None,
            });
        }
        start.position[index] = numbers.next(-1.0, 1.0);
        if !is_hinge {
            start.velocity[index] = numbers.next(-2.0, 2.0);
        } else {
            exact = Some((hold, start.position[0]));
        }
    }
    if kind != "motors" {
        mechanism = smooth.clone();
    }
    let duration = numbers.next(0.5_f64.ln(), 12.0_f64.ln()).exp();
    Motion { kind, mechanism, smooth, start, duration, exact }
}

/// The angle of a hinge that starts at rest (rad).
fn closed_form(Hold { stiffness, damping, .. }: Hold, from: f64, time: f64) -> f64 {
    let omega = (stiffness / INERTIA).sqrt();
    let ratio = damping / (2.0 * (stiffness * INERTIA).sqrt());
    if ratio < 1.0 {
        let turned = omega * (1.0 - ratio * ratio).sqrt();
        let (sine, cosine) = (turned * time).sin_cos();
        return from * (-ratio * omega * time).exp() * (cosine + ratio * omega / turned * sine);
    }
    let root = (ratio * ratio - 1.0).sqrt();
    // (ratio − root) without cancellation.
    let (slow, fast) = (-omega / (ratio + root), -omega * (ratio + root));
    from * (fast * (slow * time).exp() - slow * (fast * time).exp()) / (fast - slow)
}

impl Motion {
    /// The places at some times (s), and how far they are known (m).
    fn truth(&self, times: &[f64]) -> Option<(Vec<Vec<Vector3<f64>>>, f64)> {
        if let Some((hold, from)) = self.exact {
            let place = |&time: &f64| {
                let mut state = self.start.clone();
                state.position[0] = closed_form(hold, from, time);
                probes(&self.smooth, &state)
            };
            return Some((times.iter().map(place).collect(), 0.0));
        }
        let fine = Lobatto::adaptive_with_stop(&self.smooth, 1e-12, 1e-16);
        let truth = places_at(&self.smooth, &self.start, times, fine)?;
        let mut lobatto = Lobatto::adaptive_with_stop(&self.smooth, 1e-12, 1e-16);
        let mut state = self.start.clone();
        while state.time < self.duration {
            lobatto.advance(&self.smooth, &mut state, self.duration).ok()?;
        }
        let step = SHORTER * lobatto.description().step;
        let other =
            places_at(&self.smooth, &self.start, times, Lobatto::fixed(&self.smooth, OTHER_STAGES, step).ok()?)?;
        let doubt = other.iter().zip(&truth).map(|(other, truth)| distance(other, truth)).fold(0.0, f64::max);
        Some((truth, doubt))
    }
}

/// What a run said of itself, its largest error (m), and the uncertainty of that error (m).
struct Compared {
    told: Accuracy,
    steps: usize,
    error: f64,
    doubt: f64,
}

fn compared(motion: &Motion, tolerance: f64) -> Option<Compared> {
    let Motion { mechanism, start, duration, .. } = motion;
    let mut simulation =
        Simulation::new(mechanism, start.clone(), options(*duration, tolerance)).expect("a simulation");
    simulation.run().expect("a run");
    let told = told(&simulation.finish());
    // Repeats the run to get the ends of its steps.
    let steps = Steps::Chosen { tolerance, stop: told.stop, stages: told.stages };
    let mut run = RunIntegrator::new(mechanism, steps, &[]).expect("steps");
    let mut state = start.clone();
    let mut ends = Vec::new();
    while state.time < *duration {
        run.advance(mechanism, &mut state, *duration).expect("a step");
        ends.push((state.time, probes(mechanism, &state)));
    }
    let steps = ends.len();
    let stride = steps.div_ceil(INSTANTS);
    let ends: Vec<_> = ends.into_iter().rev().step_by(stride).collect::<Vec<_>>().into_iter().rev().collect();
    let times: Vec<f64> = ends.iter().map(|(time, _)| *time).collect();
    let (truth, doubt) = motion.truth(&times)?;
    let error = ends.iter().zip(&truth).map(|((_, end), truth)| distance(end, truth)).fold(0.0, f64::max);
    Some(Compared { told, steps, error, doubt })
}

/// Figures of many runs.
#[derive(Debug, Default)]
struct Figures {
    runs: usize,
    alarms: usize,
    wrong: usize,
    judged: usize,
    bright: usize,
    dark: usize,
    again: usize,
}

fn figures(numbers: std::ops::Range<usize>) -> Figures {
    let mut figures = Figures::default();
    for number in numbers {
        let motion = motion(number);
        let size = size(&motion.mechanism, &motion.start);
        for tolerance in [1e-4, 1e-6, 1e-8] {
            let Some(Compared { told, steps, error, doubt }) = compared(&motion, tolerance) else {
                println!("NONE {number}");
                continue;
            };
            figures.runs += 1;
            figures.again += usize::from(told.begun > 1);
            let is_reached = told.holds_until >= motion.duration;
            // A motion is not chaotic where two references and the run itself are within a tenth of the tolerance.
            let is_alarm = !is_reached && doubt.max(error) < 0.1 * tolerance;
            let is_wrong = is_reached && doubt < 0.1 * tolerance && error > tolerance;
            // Errors below rounding cannot be estimated, and a thousandth of the tolerance is told well enough: iterations to rounding beside hard dampers
            // leave many errors of less.
            let floor = (1e-14 * size.max(1.0)).max(1e-3 * tolerance);
            let is_judged = is_reached && doubt <= 0.1 * error.max(floor);
            let is_bright = is_judged && error > HONEST * told.estimate.max(floor);
            let is_dark = is_judged && told.estimate > HONEST * error.max(floor);
            figures.alarms += usize::from(is_alarm);
            figures.wrong += usize::from(is_wrong);
            figures.judged += usize::from(is_judged);
            figures.bright += usize::from(is_bright);
            figures.dark += usize::from(is_dark);
            println!(
                "{number} {} {} freedoms {:.2} s {tolerance:e}: error {error:.2e} told {:.2e} ratio {:.1e} doubt {doubt:.0e} stop {:.0e} begun {} steps {steps}{}{}{}{}{}",
                motion.kind,
                motion.mechanism.velocity_count,
                motion.duration,
                told.estimate,
                told.estimate / error.max(floor),
                told.stop,
                told.begun,
                if is_alarm { " ALARM" } else { "" },
                if is_wrong { " WRONG" } else { "" },
                if is_bright { " BRIGHT" } else { "" },
                if is_dark { " DARK" } else { "" },
                if is_judged { "" } else { " unjudged" },
            );
        }
    }
    println!("{figures:?}");
    figures
}

#[test]
fn motions_that_dampers_springs_and_motors_hold_are_not_called_chaotic_and_say_their_error_to_a_factor_of_ten() {
    let Figures { runs, alarms, wrong, judged, bright, dark, again } = figures(0..15);
    // 5 of these runs were called chaotic while iterations of the companion ended at a part of a guess, and 8 errors were told wrong by more than a factor
    // of ten; none is now. 38 of the errors can be judged.
    assert_eq!((runs, alarms, wrong), (45, 0, 0));
    assert!(bright + dark <= 1 && 4 * judged >= 3 * runs, "{bright} too bright, {dark} too dark of {judged}");
    // 11 began again; the 8 that still do have undamped springs, or errors that grow before dampers stop the motion.
    assert!(again <= 9, "{again} begin again");
}

#[test]
#[ignore = "a minute: cargo test --release --test model assessed_stiff -- --ignored --nocapture"]
fn of_nine_hundred_runs_that_dampers_springs_and_motors_hold_none_is_called_chaotic_and_next_to_all_say_their_error_to_a_factor_of_ten()
 {
    let Figures { runs, alarms, wrong, judged, bright, dark, .. } = figures(0..300);
    assert_eq!((runs, alarms), (900, 0));
    // 194 were called chaotic, 2 were wrong, and of 487 69 too bright and 56 too dark, before the companion was solved to a part of what parts it from the run
    // and truncation was told with dampers. Since then 1 is wrong, and of 502 2 are too bright and 2 too dark: the goals are one in 250, one in 50 and one in 30.
    assert!(
        wrong * 250 <= runs && bright * 50 <= judged && dark * 30 <= judged,
        "wrong {wrong}, bright {bright}, dark {dark}"
    );
}
