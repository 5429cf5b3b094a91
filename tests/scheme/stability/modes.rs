//! The fastest mode of mechanisms with springs, dampers and loops.

use super::{rod_on_a_hinge, start_of, taut_chain};
use crate::models::Model;
use crate::{closed, models};
use catena::mechanism::description::closure::Coordinate;
use catena::mechanism::description::forces::{JointSpring, PointSpring};
use catena::stepping::watching::dynamics::Dynamics;
use catena::stepping::watching::fastest_mode::Fastest;
use catena::stepping::watching::linearised::Linearised;

fn mode(model: &Model, iterations: usize) -> catena::stepping::watching::watch::Mode {
    Linearised::new(&model.mechanism).estimate(&model.mechanism, &model.state, iterations)
}

#[test]
fn the_mode_of_a_spring_with_a_damper_is_that_of_the_textbook() {
    for (stiffness, damping) in [(1e3, 0.0), (1e3, 2.0), (1e12, 3e4), (1e-3, 1.0)] {
        let found = mode(&rod_on_a_hinge(stiffness, damping), 2);
        let inertia = 1.0_f64 / 3.0;
        let frequency = (stiffness / inertia).sqrt();
        // Differences of relative step 1e-6 of a linear function.
        assert!((found.frequency / frequency - 1.0).abs() < 1e-8, "{found:?}, {frequency}");
        let ratio = 0.5 * damping / (inertia * frequency);
        assert!((found.damping - ratio).abs() <= 1e-8 * ratio, "{found:?}, {ratio}");
    }
}

#[test]
fn without_forces_the_mode_is_that_of_the_geometric_stiffness_alone() {
    // In equilibrium, hanging and upright: elsewhere the one holds the accelerations of the bodies and the other the rates of
    // the joints.
    for angle in [0.0, std::f64::consts::PI] {
        let mut model = taut_chain();
        model.state.velocity.fill(0.0);
        model.state.position.copy_from_slice(&[angle, 0.0, 0.0]);
        let (plan, start) = start_of(&model.mechanism, &model.state);
        let mut dynamics = Dynamics::new(&plan, model.mechanism.velocity_count);
        let mut fastest = Fastest::new(model.mechanism.velocity_count);
        let expected = fastest.estimate(&mut dynamics, &plan, &start, &model.mechanism.gravity.into(), 100);
        let found = mode(&model, 100).frequency;
        // Nine digits of differences, some of them lost to the light links.
        assert!((found / expected - 1.0).abs() < 1e-6, "{found}, {expected}");
    }
}

#[test]
fn the_mode_of_a_closed_mechanism_is_that_of_its_free_motion() {
    // A parallelogram of three rods hanging straight down and up again: the cranks swing together, the coupler does not turn.
    let (mut mechanism, mut state) = closed::four_bars(1, 5);
    state.velocity.fill(0.0);
    // Upright it falls with (l/2 + l + l/2) m g on 2 m l²/3 + m l², the rods' 1 kg, 1 m.
    let gravity: f64 = 2.0 * 9.81 / (5.0 / 3.0);
    let found = mode(&Model { mechanism: mechanism.clone(), state: state.clone() }, 4);
    assert!((found.frequency / gravity.sqrt() - 1.0).abs() < 1e-6 && found.damping == 0.0, "{found:?}");
    let coordinate = Coordinate { body: 0, position: 0, freedom: 0 };
    mechanism.forces.joint_springs.push(JointSpring { coordinate, stiffness: 5e4, rest: 0.0 });
    let found = mode(&Model { mechanism, state }, 4);
    let frequency = (5e4 / (5.0 / 3.0) - gravity).sqrt();
    assert!((found.frequency / frequency - 1.0).abs() < 1e-6, "{found:?} {frequency}");
}

#[test]
fn a_hard_damper_is_not_taken_for_a_spring() {
    // Its force turns with its line, by 1e10 N s/m times the velocity across it: no spring, since it pulls nothing back.
    let mut model = rod_on_a_hinge(0.0, 0.0);
    model.mechanism.gravity = models::gravity();
    model.mechanism.forces.point_springs.push(PointSpring {
        name: "damper".to_string(),
        a: models::point_of(None, [0.8, 0.0, 1.0]),
        b: models::point_of(Some(0), [0.5, 0.0, 0.0]),
        stiffness: 0.0,
        damping: 1e10,
        rest_length: 1.0,
    });
    model.state.velocity[0] = 2.0;
    let found = mode(&model, 4);
    assert!(found.frequency < 10.0, "{found:?}");
}
