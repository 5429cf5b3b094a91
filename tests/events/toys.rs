//! Toys without exact answers, against their own refinement: nine stages with two steps, or with steps of their own choice.

use crate::mechanisms::{fixed, of_kind};
use catena::mechanism::motion::event::EventKind;
use catena::model::Model;
use catena::scene::{PackagePath, read_scene};
use catena::simulation::{Finished, Simulation, SimulationOptions, StepChoice};
use nalgebra::Vector3;
use std::path::Path;

/// What is changed of a scene.
type Change = fn(&mut Model, &mut Vec<f64>);

/// Runs a scene of `robots/` once for each choice of steps; `change` may change the model, and the velocities at the start.
fn runs(name: &str, duration: f64, change: Change, choices: &[StepChoice]) -> Vec<Finished> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(format!("{name}.toml"));
    let scene = read_scene(&file, &PackagePath::default()).expect("a scene");
    let (mut model, start) = Model::from_scene(&scene).expect("a model");
    let mut start = model.initial_state(&start.positions, &start.velocities, None).expect("a start");
    change(&mut model, &mut start.velocity);
    let run = |&steps: &StepChoice| {
        let options = SimulationOptions::new(duration, steps);
        let mut simulation = Simulation::new(&model.mechanism, start.clone(), options).expect("a run");
        simulation.run().expect("to the end");
        let finished = simulation.finish();
        assert!(finished.summary.contact.penetration <= 1e-12, "{name}, {steps:?}: {:?}", finished.summary.contact);
        assert!(finished.summary.contact.cone_violation <= 1e-10, "{name}, {steps:?}: {:?}", finished.summary.contact);
        finished
    };
    choices.iter().map(run).collect()
}

const AS_IT_IS: Change = |_, _| ();

/// The largest difference of the positions (m or rad) and of the velocities (m/s or rad/s).
fn differences(one: &Finished, other: &Finished) -> [f64; 2] {
    let most = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let found = [most(&one.state.position, &other.state.position), most(&one.state.velocity, &other.state.velocity)];
    println!("{} and {} steps: {found:?}", one.summary.steps, other.summary.steps);
    found
}

#[test]
fn a_woodpecker_converges_and_pecks_with_one_period() {
    let found = runs("woodpecker", 2.0, AS_IT_IS, &[fixed(9, 1e-3), fixed(9, 4e-3), StepChoice::Tolerance(1e-9)]);
    let beak = |finished: &Finished| -> Vec<f64> {
        let impacts = of_kind(finished, EventKind::ContactImpact);
        let strongest = impacts.iter().filter(|impact| impact.impulse.is_some_and(|impulse| impulse > 1e-3));
        strongest.map(|impact| impact.time).collect()
    };
    let pecks = beak(&found[0]);
    assert_eq!(pecks.len(), 15, "{pecks:?}");
    // The spring turns by 1e3 rad/s²: an event 1e-12 s off is a rate 1e-9 rad/s off. Steps of a tolerance keep to it.
    for (other, [place, rate, time]) in found[1..].iter().zip([[1e-10, 1e-8, 1e-11], [1e-9, 1e-6, 1e-9]]) {
        let [positions, velocities] = differences(&found[0], other);
        assert!(positions <= place && velocities <= rate, "{positions:e}, {velocities:e}");
        for (one, other) in pecks.iter().zip(beak(other)) {
            assert!((one - other).abs() <= time, "{one}, {other}");
        }
    }
    // A disturbance shrinks to a tenth or less with every peck: from the tenth on there is nothing left but rounding.
    let periods: Vec<f64> = pecks.windows(2).map(|pair| pair[1] - pair[0]).collect();
    println!("{periods:?}");
    for period in &periods[9..] {
        assert!((period - periods[9]).abs() <= 1e-11, "{periods:?}");
    }
}

#[test]
fn a_coin_that_rolls_on_its_rim_converges_and_keeps_its_energy() {
    let found = runs("spinning_coin", 2.0, AS_IT_IS, &[fixed(9, 1e-3), fixed(9, 4e-3), StepChoice::Tolerance(1e-9)]);
    for (other, bound) in found[1..].iter().zip([1e-12, 1e-10]) {
        assert!(other.events.is_empty(), "{:?}", other.events);
        // The place of the centre; the turn about its axis drifts with the rounding of 28 rad/s.
        let place = |of: &Finished| Vector3::from_column_slice(&of.state.position[..3]);
        let apart = (place(&found[0]) - place(other)).norm();
        println!("{} steps: {apart:e} m, {:?}", other.summary.steps, differences(&found[0], other));
        assert!(apart <= bound, "{apart:e} m");
        assert!(other.summary.max_relative_energy_error <= 1e-10, "{:?}", other.summary);
    }
}

/// Not rolling at the start, on a floor that is less rough.
const SLIDING: Change = |model, velocity| {
    model.mechanism.nonsmooth.pairs.retain_mut(|pair| {
        pair.friction = 0.3;
        true
    });
    velocity[..3].copy_from_slice(&[0.0, 0.1, 0.0]);
};

#[test]
fn a_coin_that_slides_until_it_rolls_converges() {
    let found =
        runs("spinning_coin", 0.05, SLIDING, &[fixed(9, 1.25e-4), fixed(9, 2.5e-4), StepChoice::Tolerance(1e-9)]);
    println!("{:?}", found[0].events);
    assert!(!of_kind(&found[0], EventKind::Stick).is_empty(), "{:?}", found[0].events);
    for other in &found[1..] {
        let [positions, _] = differences(&found[0], other);
        // A slip that stops while it turns round has a fractional power of time in it, which costs fixed steps their order.
        assert!(positions <= 1e-8, "{positions:e}");
    }
}

#[test]
fn a_tippe_top_turns_over_and_converges_through_a_hundred_impacts() {
    // With 1e-6 m its slip begins in a step of a millisecond, and the 1e-7 m that this one is off grow to millimetres: its report says that it holds until
    // 0.014 s.
    let found = runs("tippe_top", 3.0, AS_IT_IS, &[fixed(9, 2.5e-4), StepChoice::Tolerance(1e-8)]);
    let impacts = of_kind(&found[1], EventKind::ContactImpact).len();
    assert!(impacts > 100, "{impacts}");
    let [positions, _] = differences(&found[0], &found[1]);
    // It amplifies 1e-13 by what the report warns of.
    assert!(positions <= 1e-6, "{positions:e}");
    for finished in &found {
        // The centre of mass is 16 mm up at the start; standing on its stem it is 42 mm up.
        let centre = finished.state.position[2];
        assert!(centre > 0.036, "{centre}");
    }
}

#[test]
fn a_rover_whose_wheels_break_away_together_converges_without_first_order_steps() {
    // Four wheels share a weight that three would carry, and begin to slide where the motors overcome friction: at once all of them do, in directions that
    // friction and motors say together, with an acceleration that begins at zero.
    let choices = [StepChoice::Tolerance(1e-6), StepChoice::Tolerance(1e-8), fixed(9, 0.01), fixed(5, 0.01)];
    let found = runs("rover_turns", 4.0, AS_IT_IS, &choices);
    for finished in &found {
        assert_eq!(of_kind(finished, EventKind::Slip).len(), 4, "{:?}", finished.events);
        assert_eq!(finished.method.unsolved_contacts, 0);
        // With steps that the stop of no slip cuts short: where directions were repeated instead of solved for there were thousands.
        assert!(finished.summary.steps < 500, "{}", finished.summary.steps);
    }
    let chassis = |finished: &Finished| Vector3::from_column_slice(&finished.state.position[..3]);
    // A few tolerances, because slips amplify errors; and far less between given steps of two orders.
    for (other, most) in [(&found[0], 2e-6), (&found[1], 5e-8), (&found[3], 1e-9)] {
        let off = (chassis(&found[2]) - chassis(other)).norm();
        println!("{} and {} steps: {off:e} m", found[2].summary.steps, other.summary.steps);
        assert!(off < most, "{off:e} m");
    }
}
