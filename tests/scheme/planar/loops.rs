//! Closed loops in a plane: fixed and chosen steps, what is interpolated, and singular positions are those in space.

use super::{KINDS, apart, random_loops};
use crate::in_plane::random_tree;
use crate::models::Model;
use crate::{closed, models};
use catena::instant::start::assembly::assemble;
use catena::lobatto::numbers::lanes::Isa;
use catena::lobatto::stages::attempt::StopRule;
use catena::mechanism::description::closure::{Coordinate, Mimic};
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::rules::Rule;
use catena::mechanism::motion::gaps::{loop_gaps, mimic_gap};
use catena::mechanism::motion::integrator::{Integrator, StepOutcome};
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::mechanism::structure::plane::Plane;
use catena::stepping::integrator::Lobatto;
use nalgebra::Vector3;

/// A tree in a plane in which a hinge follows another, and a slide a hinge.
fn geared() -> Model {
    let mut model = random_tree(7, 9, Vector3::new(0.1, 0.2, 0.9));
    let coordinate = |body: usize| {
        let joint = &model.mechanism.bodies[body].joint;
        Coordinate { body, position: joint.position_index, freedom: joint.velocity_index }
    };
    let mimic = |name: &str, follower, leader, multiplier| Mimic {
        name: name.into(),
        follower: coordinate(follower),
        leader: coordinate(leader),
        multiplier,
        offset: 0.2,
        more: Vec::new(),
        over_time: None,
    };
    model.mechanism.mimics = vec![mimic("hinge", 6, 1, -1.7), mimic("slide", 3, 0, 0.4)];
    assemble(&model.mechanism, &mut model.state).expect("mimics can always be followed");
    model
}

/// With every kind of force.
fn forced(mut model: Model) -> Model {
    let all = models::every_force(&model.mechanism).pop().expect("all forces").1;
    model.mechanism.forces = all;
    model
}

fn everything() -> Vec<(String, Model)> {
    let bars = |count, rows| {
        let (mechanism, state) = closed::four_bars(count, rows);
        Model { mechanism, state }
    };
    let mut all = vec![
        ("four-bar".to_string(), bars(1, 5)),
        ("two four-bars with balls".to_string(), bars(2, 3)),
        ("mimics".to_string(), geared()),
        ("four-bar with forces".to_string(), forced(bars(1, 5))),
        ("mimics with forces".to_string(), forced(geared())),
    ];
    for (seed, (kind, lies, _)) in KINDS.into_iter().enumerate() {
        let model = random_loops(seed as u64, kind, lies);
        all.push((format!("{kind:?} {lies:?}"), if seed % 3 == 1 { forced(model) } else { model }));
    }
    all
}

/// Largest gap of any closure.
fn gap(mechanism: &Mechanism, state: &State) -> f64 {
    let bodies = body_states(mechanism, state);
    let loops = mechanism.loops.iter().map(|joint| loop_gaps(joint, &bodies).largest().0);
    let mimics = mechanism.mimics.iter().map(|mimic| mimic_gap(mimic, state).0.abs());
    loops.chain(mimics).fold(0.0, f64::max)
}

/// The run in the plane, and that of the full model: the states at the end, and what the steps did.
fn both(model: &Model, make: impl Fn() -> Lobatto, until: f64) -> [(State, Vec<StepOutcome>); 2] {
    assert!(Plane::of(&model.mechanism).is_some(), "no plane");
    [&[][..], &[Rule::Planar]].map(|kept| {
        let mut lobatto = make().keeping(&model.mechanism, kept);
        let (mut state, mut outcomes) = (model.state.clone(), Vec::new());
        while state.time < until {
            outcomes.push(lobatto.advance(&model.mechanism, &mut state, until).expect("a step"));
        }
        (state, outcomes)
    })
}

#[test]
fn fixed_steps_of_closed_loops_in_the_plane_are_those_in_space() {
    for (name, model) in everything() {
        let (mut count, mut expected, mut steps) = (0, 0, 0);
        for stages in 2..=9 {
            let step = if stages < 4 { 0.002 } else { 0.01 };
            let make = || Lobatto::fixed(&model.mechanism, stages, step).expect("stages");
            let [(flat, ours), (full, theirs)] = both(&model, make, 10.0 * step);
            let difference = apart(&flat, &full);
            let of_positions = apart(&State { velocity: full.velocity.clone(), ..flat.clone() }, &full);
            // Places round by 2.4e-13 at most and velocities by that over a step, 9.3e-12, which Portable, Avx2 and Avx512 were measured to do. A
            // start that is moved by four roundings ends 7e-12 away in either run, so that no computation of the same steps can promise less.
            assert!(of_positions < 1e-12, "{name}, {stages} stages: {of_positions:e}");
            assert!(difference < 1e-11, "{name}, {stages} stages: {difference:e}");
            let iterations = |outcomes: &[StepOutcome]| outcomes.iter().map(|one| one.cost.iterations).sum::<usize>();
            // A step ends where an increment is at rounding (2e-16), or where one below 1e-11 is more than half of the one before. Guesses of
            // seven stages are that good: then steps have two iterations or five, as roundings will (in all 47 in the plane and 36 in space).
            let (own, full) = (iterations(&ours), iterations(&theirs));
            assert!(own <= full + 2 * ours.len(), "{name}, {stages} stages: {own} iterations, not {full}");
            count += own;
            expected += full;
            steps += ours.len();
            // Some metres, rounded.
            assert!(gap(&model.mechanism, &flat) < 3e-14, "{name}: {:e}", gap(&model.mechanism, &flat));
            let sums = |outcomes: &[StepOutcome]| {
                outcomes
                    .iter()
                    .fold((0.0, 0.0), |sum, one| (sum.0 + one.exchange.dissipated, sum.1 + one.exchange.work))
            };
            let ((lost, put_in), (expected, work)) = (sums(&ours), sums(&theirs));
            assert!(
                (lost - expected).abs() <= 1e-11 && (put_in - work).abs() <= 1e-11,
                "{name}: {lost} J, {expected} J"
            );
            assert_eq!(expected != 0.0, !model.mechanism.forces.is_empty(), "{name}");
        }
        // The same matrix, but for rows that say nothing: as many iterations, and one more or less a step, over all numbers of stages.
        assert!(count <= expected + steps, "{name}: {count} iterations, not {expected}");
    }
}

#[test]
fn chosen_steps_of_closed_loops_in_the_plane_are_those_in_space() {
    for (name, model) in everything() {
        for (tolerance, stop) in [(1e-3, 1e-7), (1e-6, 1e-10), (1e-9, 1e-13)] {
            let make = || Lobatto::adaptive_with_stop(&model.mechanism, tolerance, stop);
            let [(flat, ours), (full, theirs)] = both(&model, make, 0.5);
            // The steps of a motion that is amplified differ by shares of their errors: the change of the energy, of which the last digits
            // are rounding, and the iterates, of which six coordinates a body have others, have a say in their lengths.
            assert!(ours.len().abs_diff(theirs.len()) <= 1, "{name}, {tolerance:e}: {} {}", ours.len(), theirs.len());
            let difference = apart(&flat, &full);
            assert!(difference < tolerance, "{name}, {tolerance:e}: {difference:e}");
        }
    }
}

#[test]
fn every_vector_type_makes_the_same_steps_of_closed_loops_in_the_plane() {
    for (name, model) in everything().into_iter().take(6) {
        for stages in [2, 3, 5, 6, 9, 10] {
            let ends = [Isa::Portable, Isa::Avx2, Isa::Avx512].map(|isa| {
                let mut state = model.state.clone();
                let mut lobatto =
                    Lobatto::fixed_with(&model.mechanism, stages, 0.002, StopRule::ROUNDING, isa).expect("stages");
                while state.time < 0.02 {
                    lobatto.advance(&model.mechanism, &mut state, 0.02).expect("a step");
                }
                state
            });
            for other in &ends[1..] {
                assert!(apart(&ends[0], other) < 1e-12, "{name}, {stages} stages: {:e}", apart(&ends[0], other));
            }
        }
    }
}

#[test]
fn what_is_interpolated_in_the_plane_is_on_the_loops_and_what_it_is_in_space() {
    for (name, model) in everything() {
        let [flat, full] = [&[][..], &[Rule::Planar]].map(|kept| {
            let mut lobatto =
                Lobatto::fixed(&model.mechanism, 5, 0.05).expect("stages").keeping(&model.mechanism, kept);
            let (mut state, mut inside) = (model.state.clone(), model.state.clone());
            lobatto.advance(&model.mechanism, &mut state, 0.05).expect("a step");
            [0.013, 0.021, 0.047].map(|time| {
                lobatto.dense(&model.mechanism, time, &mut inside.position, &mut inside.velocity);
                inside.clone()
            })
        });
        for (flat, full) in flat.iter().zip(&full) {
            let difference = apart(flat, full);
            assert!(difference < 1e-11, "{name}: {difference:e}");
            assert!(gap(&model.mechanism, flat) < 3e-14, "{name}: {:e}", gap(&model.mechanism, flat));
        }
    }
}

#[test]
fn singular_positions_are_seen_in_the_plane_as_in_space() {
    let (mechanism, mut beside) = closed::four_bars(1, 5);
    let mut lobatto = Lobatto::fixed(&mechanism, 5, 0.01).expect("stages");
    while beside.time < 0.7 {
        lobatto.advance(&mechanism, &mut beside, 0.7).expect("a step");
    }
    let [flat, full] = [&[][..], &[Rule::Planar]].map(|kept| {
        // All rods lie in one line near 0.708 s, and steps of 1e-4 rad do not miss it.
        let mut lobatto = Lobatto::fixed(&mechanism, 3, 2e-5).expect("stages").keeping(&mechanism, kept);
        let mut state = beside.clone();
        while state.time < 0.72 {
            lobatto.advance(&mechanism, &mut state, 0.72).expect("a step");
        }
        lobatto.description().singular
    });
    assert!(flat.is_some_and(|seen| seen.extra == 1 && (seen.time - 0.708).abs() < 1e-3), "{flat:?}");
    assert_eq!(flat, full);
}
