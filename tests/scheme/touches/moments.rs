//! Rolling and spinning friction: moments that brake, and equations that hold.

use super::*;
use crate::runge_kutta::after;
use catena::mechanism::description::contact::Moment;

/// Radius (m), moment of inertia of 1 kg, and acceleration of gravity [m/s²] of a ball on a floor.
const RADIUS: f64 = 0.12;
const INERTIA: f64 = 0.4 * RADIUS * RADIUS;
const GRAVITY: f64 = 9.81;

/// A moment that brakes with this length (m).
fn brakes(length: f64) -> Moment {
    Moment::Brakes { length, direction: Vector3::zeros() }
}

/// A ball of 1 kg on a floor.
fn ball(grip: Grip, moments: Moments, velocity: [f64; 3], spin: [f64; 3]) -> (Mechanism, State) {
    let mut mechanism = free(Vector3::new(0.0, 0.0, -GRAVITY), &[(1.0, Vector3::repeat(INERTIA))]);
    let joint = on_floor(0, Vector3::zeros(), RADIUS, grip);
    mechanism.touches.push(TouchJoint { moments, ..joint });
    let mut state = State::zero(&mechanism);
    set(&mut state, 0, [0.0, 0.0, RADIUS], Vector3::zeros(), velocity, spin);
    (mechanism, state)
}

#[test]
fn a_ball_that_rolls_and_spins_is_braked_by_its_moments_along_a_line() {
    let (rolling, spinning, until) = (0.004, 0.002, 1.5);
    let moments = Moments { rolling: brakes(rolling), spinning: brakes(spinning) };
    let (mechanism, start) = ball(Grip::Rolls, moments, [0.6, 0.8, 0.0], [-0.8 / RADIUS, 0.6 / RADIUS, 7.0]);
    // (I/r² + m) v̇ = −ρ m g/r.
    let brake = rolling * GRAVITY / (1.4 * RADIUS);
    let (way, spin) = (until - 0.5 * brake * until * until, 7.0 - spinning * GRAVITY / INERTIA * until);
    let error = |state: &State| {
        let place = Vector3::new(0.6 * way, 0.8 * way, RADIUS);
        let turns = body_states(&mechanism, state)[0].angular_velocity.z - spin;
        (Vector3::from_column_slice(&state.position[..3]) - place).norm() + turns.abs()
    };
    // The motion is a parabola, but the turn of the ball is not.
    assert_order((&mechanism, &start), until, 1e-12, [(3, [64, 128, 256]), (5, [16, 32, 64]), (9, [8, 16, 32])], error);
}

#[test]
fn a_ball_that_slips_rolls_and_spins_in_different_directions_follows_its_equations() {
    let (friction, rolling, spinning, until) = (0.3, 0.02, 0.003, 0.3);
    let moments = Moments { rolling: brakes(rolling), spinning: brakes(spinning) };
    let (velocity, spin) = ([2.0, 0.0, 0.0], [12.0, -10.0, 25.0]);
    let (mechanism, start) = ball(slides(friction), moments, velocity, spin);
    let rates = |y: &[f64; 7]| {
        let slip = [y[2] - RADIUS * y[5], y[3] + RADIUS * y[4]];
        let (slips, rolls) = (slip[0].hypot(slip[1]), y[4].hypot(y[5]));
        let force = slip.map(|slip| -friction * GRAVITY * slip / slips);
        // The force at −r z has the moment (r f_y, −r f_x).
        let moment = [RADIUS * force[1], -RADIUS * force[0]];
        let turn = |axis: usize| (moment[axis] - rolling * GRAVITY * y[4 + axis] / rolls) / INERTIA;
        [y[2], y[3], force[0], force[1], turn(0), turn(1), -spinning * GRAVITY * y[6].signum() / INERTIA]
    };
    let begins = [0.0, 0.0, velocity[0], velocity[1], spin[0], spin[1], spin[2]];
    // Runge–Kutta with 1.5e-5 s leaves 1e-13.
    let exact = after(rates, begins, until, 20_000);
    let error = |state: &State| {
        let place = (state.position[0] - exact[0]).hypot(state.position[1] - exact[1]);
        place + (state.velocity[0] - exact[2]).hypot(state.velocity[1] - exact[3])
    };
    assert_order((&mechanism, &start), until, 1e-12, [(3, [40, 80, 160]), (5, [10, 20, 40]), (9, [8, 16, 32])], error);
}

#[test]
fn a_ball_whose_rolling_is_held_slides_without_turning_under_the_moment_of_its_friction() {
    let moments = Moments { rolling: Moment::Holds, spinning: Moment::Holds };
    let (friction, until) = (0.5, 0.18);
    let (mechanism, start) = ball(slides(friction), moments, [1.0, 0.0, 0.0], [0.0; 3]);
    let place = until - 0.5 * friction * GRAVITY * until * until;
    for (stages, steps) in [(3, 8), (5, 4), (9, 1)] {
        let mut state = start.clone();
        let Ran { iterations, lost, rate, .. } = run(&mechanism, &mut state, stages, steps, until);
        let (off, turns) =
            ((state.position[0] - place).abs(), Vector3::from_column_slice(&state.velocity[3..6]).norm());
        println!(
            "s = {stages}: {off:.1e} m, {turns:.1e} rad/s, {iterations:.1} iterations, {rate:.1e}, lost {lost:.1e}"
        );
        assert!(off < 1e-15 && turns < 1e-13 && lost.abs() < 1e-14, "s = {stages}: {off:e}, {turns:e}, {lost:e}");
    }
}
