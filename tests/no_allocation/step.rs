//! A step allocates nothing on the heap.

use crate::{closed, linkage, models};
use allocation_counter::measure;
use catena::events::Eventful;
use catena::mechanism::description::closure::{Coordinate, JointLimit};
use catena::mechanism::description::joint::JointKind;
use catena::mechanism::description::nonsmooth::{DryFriction, Motor, MotorLaw};
use catena::mechanism::description::target::{Interpolation, Target};
use catena::mechanism::motion::inputs::Inputs;
use catena::mechanism::motion::integrator::Integrator;
use catena::stepping::integrator::Lobatto;
use catena::stepping::recipe::{Recipe, Steps};
use catena::stepping::trees::other_tree::OnOtherTree;

#[test]
fn a_step_allocates_nothing_with_fixed_or_chosen_steps_any_joint_any_force_and_loops() {
    let mut all =
        vec![models::double_pendulum(), models::floating_tree(), models::slow_heavy_top(), models::free_body()];
    // In a plane, with a kernel of their own.
    all.push(models::planar_chain(4));
    all.extend([JointKind::Planar, JointKind::Prismatic].map(models::one_joint));
    all.extend([models::floating_tree(), models::one_joint(JointKind::Planar), models::planar_chain(4)].map(|model| {
        let every_force = models::every_force(&model.mechanism).pop().unwrap().1;
        models::with_forces(model, every_force)
    }));
    all.extend(
        [closed::four_bars(2, 5), closed::bricard()].map(|(mechanism, state)| models::Model { mechanism, state }),
    );
    for model in all {
        let mechanism = &model.mechanism;
        let integrators = [2, 5, 9]
            .map(|stages| Lobatto::fixed(mechanism, stages, 0.01).unwrap())
            .into_iter()
            .chain([Lobatto::adaptive(mechanism, 1e-6)])
            .chain(Lobatto::precise(mechanism, 5, 0.01));
        for mut lobatto in integrators {
            let mut state = model.state.clone();
            // The first step sets up the controller.
            lobatto.advance(mechanism, &mut state, f64::INFINITY).unwrap();
            // Counts on this thread alone.
            let change = measure(|| {
                for _ in 0..50 {
                    lobatto.advance(mechanism, &mut state, f64::INFINITY).unwrap();
                }
            });
            // The second is what was allocated less what was freed.
            let counts = (change.count_total, change.count_current);
            assert_eq!(counts, (0, 0), "{}, {:?}: {change:?}", mechanism.name, lobatto.description());
        }
    }
}

#[test]
fn a_step_on_another_spanning_tree_than_the_files_allocates_nothing() {
    // Fast enough that joints turn further in a step than is followed at once.
    let (mechanism, start) = linkage::path(8, 15.0);
    let recipe = Recipe::new(Steps::Fixed { stages: 5, step: 0.01 }, Vec::new());
    let mut steps = OnOtherTree::new(&mechanism, &[], &recipe).unwrap().expect("another tree");
    let mut state = start.clone();
    steps.advance(&mechanism, &mut state, f64::INFINITY).unwrap();
    let (mut position, mut velocity) = (state.position.clone(), state.velocity.clone());
    let change = measure(|| {
        for _ in 0..50 {
            steps.advance(&mechanism, &mut state, f64::INFINITY).unwrap();
            steps.dense(&mechanism, state.time - 0.003, &mut position, &mut velocity);
        }
    });
    assert_eq!((change.count_total, change.count_current), (0, 0), "{change:?}");
}

#[test]
fn a_driven_step_on_another_spanning_tree_allocates_nothing() {
    let (mechanism, start) = linkage::path(8, 2.0);
    let recipe = Recipe::new(Steps::Fixed { stages: 5, step: 0.01 }, Vec::new());
    let mut steps = OnOtherTree::new(&mechanism, &[0], &recipe).unwrap().expect("another tree");
    let (mut state, mut efforts) = (start.clone(), vec![0.0; mechanism.velocity_count]);
    efforts[0] = 1.0;
    // The first step makes the kernel that knows efforts.
    steps.step(&mechanism, Inputs::constant(&efforts), &mut state, f64::INFINITY).unwrap();
    steps.step(&mechanism, Inputs::constant(&efforts), &mut state, f64::INFINITY).unwrap();
    let change = measure(|| {
        for _ in 0..50 {
            efforts[0] += 0.1;
            steps.step(&mechanism, Inputs::constant(&efforts), &mut state, f64::INFINITY).unwrap();
        }
    });
    assert_eq!((change.count_total, change.count_current), (0, 0), "{change:?}");
}

#[test]
fn a_step_that_is_driven_from_outside_allocates_nothing() {
    for model in [models::floating_tree(), models::planar_chain(4)] {
        let mechanism = &model.mechanism;
        for mut lobatto in [Lobatto::fixed(mechanism, 5, 0.01).unwrap(), Lobatto::adaptive(mechanism, 1e-6)] {
            let mut state = model.state.clone();
            let mut efforts = vec![0.1; mechanism.velocity_count];
            // The first step makes the kernel that knows efforts.
            lobatto.step(mechanism, Inputs::constant(&efforts), &mut state, f64::INFINITY).unwrap();
            lobatto.step(mechanism, Inputs::constant(&efforts), &mut state, f64::INFINITY).unwrap();
            let change = measure(|| {
                for _ in 0..50 {
                    efforts[0] += 0.01;
                    lobatto.step(mechanism, Inputs::constant(&efforts), &mut state, f64::INFINITY).unwrap();
                }
            });
            assert_eq!((change.count_total, change.count_current), (0, 0), "{}: {change:?}", mechanism.name);
        }
    }
}

#[test]
fn a_step_between_events_allocates_nothing_though_limits_friction_motors_and_a_held_joint_are_watched() {
    let model = models::planar_chain(4);
    let mut mechanism = model.mechanism.clone();
    let at = |body: usize| {
        let joint = &model.mechanism.bodies[body].joint;
        Coordinate { body, position: joint.position_index, freedom: joint.velocity_index }
    };
    let start = model.state.position.clone();
    let [near, held, driven] = [at(0), at(3), at(1)];
    let nonsmooth = &mut mechanism.nonsmooth;
    let limit = |coordinate: Coordinate, room: f64| JointLimit {
        coordinate,
        lower: start[coordinate.position] - room,
        upper: start[coordinate.position] + room,
        restitution: 0.5,
    };
    nonsmooth.limits.push(limit(near, 0.6));
    nonsmooth
        .friction
        .extend([(held, 1e6), (driven, 1e-3)].map(|(coordinate, effort)| DryFriction { coordinate, effort }));
    let target = Target::table(&[(0.0, start[driven.position]), (10.0, 1.0)], Interpolation::Linear).unwrap();
    let law = MotorLaw::Position { kp: 5.0, kd: 1.0 };
    nonsmooth.motors.push(Motor { coordinate: driven, law, target, max_effort: 1e3, period: 0.0, held: None });
    let mut state = model.state.clone();
    state.velocity.fill(0.0);
    state.velocity[driven.freedom] = 0.3;
    let recipe = Recipe::new(Steps::Fixed { stages: 5, step: 1e-3 }, Vec::new());
    let mut eventful = Eventful::new(&mechanism, recipe).unwrap();
    for _ in 0..3 {
        eventful.advance(&mechanism, &mut state, f64::INFINITY).unwrap();
    }
    let mut events = Vec::new();
    eventful.take_events(&mut events);
    events.clear();
    let change = measure(|| {
        for _ in 0..20 {
            eventful.advance(&mechanism, &mut state, f64::INFINITY).unwrap();
        }
    });
    eventful.take_events(&mut events);
    assert!(events.is_empty(), "{events:?}");
    assert_eq!((change.count_total, change.count_current), (0, 0), "{change:?}");
}
