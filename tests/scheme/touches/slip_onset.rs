//! A slip that begins while the force that begins it turns: at first it grows as t², and friction takes its direction at once.

use super::*;
use catena::mechanism::description::forces::PointSpring;
use nalgebra::Vector2;

/// Friction, acceleration of gravity [m/s²], stiffness [N/m] and length of the spring at the start (m), masses of the block and of what pulls it (kg).
const FRICTION: f64 = 0.3;
const GRAVITY: f64 = 9.81;
const STIFFNESS: f64 = 20.0;
const LENGTH: f64 = 0.5;
const MASSES: [f64; 2] = [1.0, 4.0];
/// How fast the spring grows at the start [m/s].
const GROWS: f64 = 1.0;

/// Length of the spring without force (m): at the start it pulls as much as friction can hold.
fn rest() -> f64 {
    LENGTH - FRICTION * MASSES[0] * GRAVITY / STIFFNESS
}

/// A block at rest that touches the floor below its centre of mass, and what pulls it by a spring as it passes by, `across` [m/s].
fn pulled(across: f64) -> (Mechanism, State) {
    let mut mechanism = free(Vector3::new(0.0, 0.0, -GRAVITY), &MASSES.map(|mass| (mass, Vector3::repeat(0.01))));
    let grip = Grip::Slides { friction: FRICTION, direction: Vector3::x() };
    mechanism.touches.push(on_floor(0, Vector3::zeros(), 0.0, grip));
    mechanism.touches.push(on_floor(1, Vector3::zeros(), 0.0, slides(0.0)));
    let [a, b] = [0, 1].map(|body| feature(Some(body), Vector3::zeros(), Vector3::zeros()));
    let (name, stiffness, damping, rest_length) = ("spring".to_string(), STIFFNESS, 0.0, rest());
    mechanism.forces.point_springs.push(PointSpring { name, a, b, stiffness, damping, rest_length });
    let mut state = State::zero(&mechanism);
    set(&mut state, 1, [LENGTH, 0.0, 0.0], Vector3::zeros(), [GROWS, across, 0.0], [0.0; 3]);
    (mechanism, state)
}

/// Places of both, then their velocities.
type Planar = [Vector2<f64>; 4];

/// Newton's law for both, with friction against the slip.
fn slope([a, b, u, v]: &Planar) -> Planar {
    let apart = b - a;
    let pull = apart * (STIFFNESS * (1.0 - rest() / apart.norm()));
    [*u, *v, pull / MASSES[0] - u * (FRICTION * GRAVITY / u.norm()), -pull / MASSES[1]]
}

/// The motion by Runge and Kutta's method, from the first terms of its series after 1e-5 s. Friction turns the slip to the direction that it
/// must have at the rate `μ g/|u|`, from whatever it is at first, and steps are no longer than a third of the time that takes.
fn exact(across: f64, until: f64) -> Planar {
    let from = 1e-5;
    let pull = FRICTION * GRAVITY * MASSES[0];
    let grows = Vector2::new(STIFFNESS * GROWS, pull / LENGTH * across);
    let given = Vector2::x() * (pull * from) + grows * (0.5 * from * from);
    let nearer = Vector2::x() * (0.5 * pull / MASSES[1] * from * from);
    let begins = Vector2::x() * (0.5 * STIFFNESS / MASSES[0] * GROWS * from * from);
    let velocity = Vector2::new(GROWS, across);
    let ahead = Vector2::x() * LENGTH + velocity * from - nearer;
    let mut y = [Vector2::zeros(), ahead, begins, velocity - given / MASSES[1]];
    let mut time = from;
    while time < until {
        let h = (0.3 * y[2].norm() / (FRICTION * GRAVITY)).min(2e-5).min(until - time);
        let moved = |k: &Planar, h: f64| std::array::from_fn(|i| y[i] + k[i] * h);
        let k1 = slope(&y);
        let k2 = slope(&moved(&k1, 0.5 * h));
        let k3 = slope(&moved(&k2, 0.5 * h));
        let k4 = slope(&moved(&k3, h));
        y = std::array::from_fn(|i| y[i] + (k1[i] + (k2[i] + k3[i]) * 2.0 + k4[i]) * (h / 6.0));
        time += h;
    }
    y
}

/// Largest difference of place (m) and velocity [m/s] of the block from the exact ones.
fn error(state: &State, wanted: &Planar) -> f64 {
    let [place, speed] = [&state.position, &state.velocity].map(|of| Vector2::new(of[0], of[1]));
    (place - wanted[0]).norm() + (speed - wanted[2]).norm()
}

#[test]
fn a_slip_that_begins_while_its_force_turns_is_solved_in_few_iterations_and_converges() {
    let until = 0.2;
    for across in [0.5, 2.0, 5.0] {
        let (mechanism, start) = pulled(across);
        let wanted = exact(across, until);
        // The first step begins where the equations are singular. Its slip looks alike whatever its length, and so does the error of its direction: 0.2 rad
        // with three stages where the force turns by 10 rad/s. The order is lost there: measured 1.7 to 2.6, 4.8 to 5.7, 7 to 8.
        for (stages, order, counts) in [(3, 1.6, [16, 32, 64]), (5, 4.6, [8, 16, 32]), (9, 6.5, [2, 4, 8])] {
            let errors = counts.map(|steps| {
                let mut state = start.clone();
                let ran = run(&mechanism, &mut state, stages, steps, until);
                let error = error(&state, &wanted);
                println!("across {across}, s = {stages}, {steps} steps: {error:.2e}, {:.1} iterations", ran.iterations);
                // Two more than other slips, in the first step; without t of its own it was 20 to 90.
                assert!(ran.iterations < 12.0, "s = {stages}, {steps} steps: {} iterations", ran.iterations);
                error
            });
            for pair in errors.windows(2) {
                let seen = (pair[0] / pair[1]).log2();
                // Runge and Kutta's method leaves 1e-13, and what increments of 1e-12 m leave of velocities is below 1e-12 m/s.
                assert!(seen > order || pair[1] < 2e-12, "across {across}, s = {stages}: order {seen} from {errors:?}");
            }
            assert!(stages < 9 || errors[2] < 2e-12, "across {across}: {errors:?}");
        }
    }
}

#[test]
fn short_steps_follow_a_slow_slip_as_long_ones_do() {
    // The slip grows to 1e-3 m/s in 0.01 s, and is 1e-9 m/s after the first of the shortest steps: it moves by 1e-14 m in it, far below the increments
    // with which the iteration of faster ones may end.
    let until = 0.01;
    for across in [0.5, 2.0, 5.0] {
        let (mechanism, start) = pulled(across);
        let wanted = exact(across, until);
        for steps in [10, 100, 1000] {
            let mut state = start.clone();
            let ran = run(&mechanism, &mut state, 9, steps, until);
            let error = error(&state, &wanted);
            println!("across {across}, {steps} steps: {error:.2e}, {:.1} iterations", ran.iterations);
            // A thousandth of a slide in an increment leaves its square; roundings of places, 1e-16 m in 1e-5 s, are 1e-11 m/s.
            assert!(error < 1e-9, "across {across}, {steps} steps: {error:e}");
        }
    }
}
