//! Scenes whose motion is known from programs of others, run to more digits than are compared.

use crate::common::{accuracy_of, by_tolerance, rotation_angle, run_until, shared};
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::distance::{distance, probes};
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::model::{Model, ModelOptions};
use catena::reduced::Dop853;
use catena::scene::{PackagePath, read_urdf};
use catena::simulation::{Simulation, SimulationOptions, StepChoice};
use catena::stepping::integrator::Lobatto;
use nalgebra::{Matrix3, Vector3};
use serde_json::Value;
use std::path::Path;

/// A scene with its answer.
struct Scene {
    model: Model,
    start: State,
    answer: Value,
}

impl Scene {
    fn read(folder: &Path, name: &str) -> Self {
        let text = std::fs::read_to_string(folder.join(format!("answers/{name}.json"))).unwrap();
        let answer: Value = serde_json::from_str(&text).unwrap();
        let robot = read_urdf(&folder.join(format!("scenes/{name}.urdf")), &PackagePath::default()).unwrap();
        let options = ModelOptions { gravity: vector(&answer["gravity"]), ..Default::default() };
        let model = Model::new(robot, &options).unwrap();
        let (mut positions, mut velocities) = (Vec::new(), Vec::new());
        for (joint, value) in answer["initial"].as_object().unwrap() {
            if let Some(base) = value["base"].as_array() {
                // The only floating scene starts at the origin, unturned.
                assert_eq!((numbers(&base[0]), numbers(&base[1])), (vec![0.0; 3], vec![1.0, 0.0, 0.0, 0.0]));
                velocities.push((joint.clone(), [numbers(&base[2]), numbers(&base[3])].concat()));
            } else {
                positions.push((joint.clone(), vec![value["position"].as_f64().unwrap()]));
                velocities.push((joint.clone(), vec![value["velocity"].as_f64().unwrap()]));
            }
        }
        let start = model.initial_state(&positions, &velocities, None).unwrap();
        Scene { model, start, answer }
    }

    /// Largest distance of a centre of mass [m] and largest angle [rad] of a link from the answer, over both its times.
    fn error(&self, integrator: &mut dyn Integrator) -> (f64, f64) {
        let mut state = self.start.clone();
        let (mut distance, mut angle) = (0.0_f64, 0.0_f64);
        let links = self.answer["links"].as_array().unwrap();
        for (row, time) in numbers(&self.answer["times"]).into_iter().enumerate() {
            run_until(&self.model.mechanism, &mut state, integrator, time);
            let bodies = body_states(&self.model.mechanism, &state);
            for (column, link) in links.iter().enumerate() {
                let link = self.model.link(link.as_str().unwrap()).unwrap();
                let found = self.model.link_state(&bodies, link);
                let centre = vector(&self.answer["com"][row][column]);
                let rows = numbers_of(self.answer["rotation"][row][column].as_array().unwrap());
                distance = distance.max((found.center_of_mass - centre).norm());
                angle = angle.max(rotation_angle(&found.rotation, &Matrix3::from_row_slice(&rows)));
            }
        }
        (distance, angle)
    }
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

fn numbers_of(rows: &[Value]) -> Vec<f64> {
    rows.iter().flat_map(numbers).collect()
}

fn vector(value: &Value) -> Vector3<f64> {
    Vector3::from_row_slice(&numbers(value))
}

/// A scene, the step of nine stages at which truncation is below rounding, and the largest error [m] and [rad]. The
/// angles are worse than the places where the motion turns thin links about their own axes: their inertia about them is
/// a hundredth and less of the one across, so that rounding turns them so much further.
const FIXED: [(&str, f64, f64, f64); 5] = [
    ("pendulum3d_double_T3", 0.1, 1e-11, 1e-11),
    ("arm7_T1", 0.005, 1e-8, 1e-8),
    ("chain_10_T05", 0.005, 1e-9, 1e-7),
    ("heavy_tip_T05", 0.00125, 1e-8, 1e-6),
    // 500 rad in 100 s, past the unstable axis again and again, with the centre of mass at rest.
    ("dzhanibekov", 0.05, 1e-14, 1e-7),
];

/// The same with 32 digits and half the step. The answers are from numbers of nineteen digits, a thousandth of the rounding of doubles, and
/// so is what is left where the motion amplifies it; of the free body it is the state's quaternion, rounded in every step.
const PRECISE: [(&str, f64, f64, f64); 5] = [
    ("pendulum3d_double_T3", 0.05, 1e-15, 1e-15),
    ("arm7_T1", 0.0025, 1e-11, 1e-10),
    ("chain_10_T05", 0.0025, 1e-12, 1e-10),
    ("heavy_tip_T05", 0.000625, 1e-12, 1e-10),
    ("dzhanibekov", 0.025, 1e-14, 1e-12),
];

/// Holds the ends of integrators against the answers of a table's scenes.
fn assert_answers<I: Integrator>(table: &[(&str, f64, f64, f64)], make: impl Fn(&Mechanism, f64) -> I) {
    let Some(folder) = shared("reference") else { return };
    for &(name, step, metres, radians) in table {
        let scene = Scene::read(&folder, name);
        let (distance, angle) = scene.error(&mut make(&scene.model.mechanism, step));
        println!("{name}: {distance:.1e} m, {angle:.1e} rad");
        assert!(distance <= metres, "{name}: {distance:.1e} m");
        assert!(angle <= radians, "{name}: {angle:.1e} rad");
    }
}

#[test]
fn fixed_steps_of_nine_stages_give_the_reference_answers() {
    assert_answers(&FIXED, |mechanism, step| Lobatto::fixed(mechanism, 9, step).unwrap());
}

#[test]
fn steps_with_32_digits_differ_from_the_answers_by_what_these_are_good_to() {
    assert_answers(&PRECISE, |mechanism, step| Lobatto::precise(mechanism, 9, step).unwrap());
}

#[test]
fn chosen_steps_give_the_reference_answers_as_well_as_fixed_ones() {
    assert_answers(&FIXED, |mechanism, _| Lobatto::adaptive(mechanism, 1e-12));
}

#[test]
fn the_comparator_with_its_tightest_tolerance_gives_the_reference_answers_as_well_as_fixed_steps() {
    assert_answers(&FIXED, |mechanism, _| Dop853::new(mechanism, 1e-13));
}

#[test]
fn whoever_names_an_accuracy_gets_it_within_a_factor_of_ten() {
    let Some(folder) = shared("reference") else { return };
    let mut misses = Vec::new();
    for (name, ..) in FIXED {
        let scene = Scene::read(&folder, name);
        let duration = scene.answer["duration"].as_f64().unwrap();
        for tolerance in [1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-9] {
            let mut lobatto = by_tolerance(&scene.model.mechanism, &scene.start, duration, tolerance);
            let (distance, angle) = scene.error(&mut lobatto);
            println!("{name} at {tolerance:.0e}: {distance:.1e} m, {angle:.1e} rad");
            // The factor is the claim: a run estimates its error by another motion, with other errors.
            if distance > 10.0 * tolerance {
                misses.push(format!("{name} at {tolerance:.0e}: {distance:.1e} m"));
            }
        }
    }
    assert!(misses.is_empty(), "{misses:#?}");
}

/// Where a run ends.
fn end(mechanism: &Mechanism, start: &State, duration: f64, mut integrator: Lobatto) -> Vec<Vector3<f64>> {
    let mut state = start.clone();
    run_until(mechanism, &mut state, &mut integrator, duration);
    probes(mechanism, &state)
}

#[test]
fn hardly_a_run_is_far_from_the_accuracy_that_it_tells_where_a_motion_amplifies_errors() {
    let Some(folder) = shared("reference") else { return };
    let Scene { model, start, answer } = Scene::read(&folder, "chain_10_T05");
    let mut mechanism = model.mechanism;
    let (duration, gravity) = (answer["duration"].as_f64().unwrap(), mechanism.gravity);
    let (mut misses, mut wrong) = (Vec::new(), 0);
    for number in 0..48 {
        mechanism.gravity = (1.0 + 0.0101 * f64::from(number)) * gravity;
        let truth = end(&mechanism, &start, duration, Lobatto::fixed(&mechanism, 9, 1e-3).unwrap());
        for tolerance in [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9] {
            let options = SimulationOptions::new(duration, StepChoice::Tolerance(tolerance));
            let mut simulation = Simulation::new(&mechanism, start.clone(), options).unwrap();
            simulation.run().unwrap();
            let finished = simulation.finish();
            let told = finished.accuracy[0].clone().unwrap();
            let error = distance(&probes(&mechanism, &finished.state), &truth);
            wrong += usize::from(told.holds_until >= duration && error > tolerance);
            if error > 10.0 * tolerance {
                println!("gravity {number}, {tolerance:e} m: {:.1} tolerances, {told:?}", error / tolerance);
                misses.push(error / tolerance);
            }
        }
    }
    println!("{wrong} of 432 runs are off by more than they say, {} by more than ten times", misses.len());
    assert!(misses.len() <= 9, "{} of 432 runs", misses.len());
    assert!(misses.iter().all(|&miss| miss < 60.0), "{misses:?}");
}

#[test]
fn what_rounding_leaves_of_a_fine_accuracy_is_said() {
    let Some(folder) = shared("reference") else { return };
    // A body that has passed its unstable axis for 100 s, and a chain whose tip is ten thousand times as heavy; each a little faster than
    // the reference scene, where rounding happens to leave less.
    for (name, faster, tolerance, step) in
        [("dzhanibekov", 1.0 + 0.0037 * 9.0, 1e-9, 0.1), ("heavy_tip_T05", 1.0 + 0.0037 * 28.0, 1e-10, 0.000625)]
    {
        let Scene { model, mut start, answer } = Scene::read(&folder, name);
        let mut mechanism = model.mechanism;
        mechanism.gravity *= faster;
        start.velocity.iter_mut().for_each(|rate| *rate *= faster);
        let duration = answer["duration"].as_f64().unwrap();
        let end = |integrator| end(&mechanism, &start, duration, integrator);
        let found = accuracy_of(&mechanism, &start, duration, tolerance);
        let truth = end(Lobatto::precise(&mechanism, 9, step).unwrap());
        let error =
            distance(&end(Lobatto::adaptive_with_stages(&mechanism, tolerance, found.stop, found.stages)), &truth);
        println!("{name}: {error:.1e} m, {:.1e} m said, until t = {} s", found.estimate, found.holds_until);
        // Ten to twenty tolerances off, with 512-bit vectors, because no step is more accurate.
        assert!(found.holds_until < duration, "{name}: said to hold to the end");
        // Two runs are compared, and this is a third: the largest ratio seen in 576 runs was 8.
        assert!(error < 10.0 * found.estimate, "{name}: {error:.1e} m, {:.1e} m said", found.estimate);
    }
}
