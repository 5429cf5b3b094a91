//! Newton's cradle: five equal balls in a row, without gravity and friction.

use crate::exact::near;
use crate::loose::{loose, meet, put};
use crate::mechanisms::{fixed, run};
use catena::mechanism::description::contact::Shape;
use catena::mechanism::motion::state::State;
use nalgebra::Vector3;

/// The speeds of the balls at the end, of which the first few arrive with speed 1.
fn speeds(restitution: f64, arriving: usize, apart: f64, duration: f64) -> Vec<f64> {
    let ball = Shape::Sphere { radius: 0.1 };
    let mut cradle = loose(Vector3::zeros(), &vec![(1.0, ball); 5]);
    (0..4).for_each(|first| meet(&mut cradle, first, first + 1, 0.0, restitution));
    let mut start = State::zero(&cradle);
    for number in 0..5 {
        let comes = number < arriving;
        let x = 0.2 * number as f64 - if comes { apart } else { 0.0 };
        let at = Vector3::new(x, 0.0, 0.0);
        let velocity = if comes { Vector3::x() } else { Vector3::zeros() };
        put(&cradle, &mut start, number, [at, Vector3::zeros(), velocity, Vector3::zeros()]);
    }
    let finished = run(&cradle, &start, duration, fixed(5, 0.1));
    println!("{:?}", finished.events);
    (0..5).map(|number| finished.state.velocity[6 * number]).collect()
}

fn all_near(found: &[f64], wanted: [f64; 5]) {
    for (&found, wanted) in found.iter().zip(wanted) {
        near(found, wanted, 1e-12);
    }
}

#[test]
fn as_many_balls_leave_an_elastic_cradle_as_arrive() {
    for apart in [0.0, 0.05] {
        all_near(&speeds(1.0, 1, apart, 0.3), [0.0, 0.0, 0.0, 0.0, 1.0]);
        all_near(&speeds(1.0, 2, apart, 0.3), [0.0, 0.0, 0.0, 1.0, 1.0]);
    }
}

#[test]
fn the_balls_of_a_plastic_cradle_go_on_together() {
    for apart in [0.0, 0.05] {
        all_near(&speeds(0.0, 1, apart, 0.3), [0.2; 5]);
        all_near(&speeds(0.0, 2, apart, 0.3), [0.4; 5]);
    }
}

#[test]
fn a_cradle_of_half_restitution_keeps_the_momentum_and_loses_energy_and_its_balls_do_not_run_into_each_other() {
    for apart in [0.0, 0.05] {
        let speeds = speeds(0.5, 1, apart, 0.3);
        println!("{speeds:?}");
        near(speeds.iter().sum(), 1.0, 1e-12);
        let energy: f64 = speeds.iter().map(|speed| 0.5 * speed * speed).sum();
        assert!(energy > 0.1 && energy < 0.5, "{energy} J");
        assert!(speeds.windows(2).all(|pair| pair[0] <= pair[1] + 1e-12), "{speeds:?}");
    }
}
