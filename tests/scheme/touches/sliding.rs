//! Sliding with and without friction.

use super::*;
use crate::runge_kutta::after;

/// Block of C2 and C3 of the exact answers: 0.4 × 0.4 × 0.1 m, 1 kg, on four corners on a slope of tangent 5/12.
fn block(grip: Grip) -> (Mechanism, State) {
    let size = Vector3::new(0.4, 0.4, 0.1);
    let square = size.component_mul(&size);
    let inertia = Vector3::new(square.y + square.z, square.z + square.x, square.x + square.y) / 12.0;
    let mut mechanism = free(Vector3::new(5.0 / 13.0, 0.0, -12.0 / 13.0) * 9.81, &[(1.0, inertia)]);
    for (x, y) in [(0.2, 0.2), (-0.2, 0.2), (-0.2, -0.2), (0.2, -0.2)] {
        mechanism.touches.push(on_floor(0, Vector3::new(x, y, -0.05), 0.0, grip));
    }
    let mut state = State::zero(&mechanism);
    set(&mut state, 0, [0.0, 0.0, 0.05], Vector3::zeros(), [0.0; 3], [0.0; 3]);
    (mechanism, state)
}

#[test]
fn a_block_on_four_corners_slides_up_a_slope_and_back() {
    let g = 9.81;
    let (mechanism, start) = block(slides(0.25));
    // Places and speeds of 1 m and 1 m/s round to 1e-15; of four equations three are independent.
    for stages in [3, 5, 9] {
        // Uphill for 0.3 s; constant acceleration, which every number of stages meets.
        let mut state = start.clone();
        state.velocity[0] = -2.0;
        let ran = run(&mechanism, &mut state, stages, 3, 0.3);
        let acceleration = g * (5.0 / 13.0 + 0.25 * 12.0 / 13.0);
        let error = (state.position[0] - (-2.0 * 0.3 + 0.5 * acceleration * 0.09)).abs();
        assert!(error < 1e-14 && ran.gap < 1e-15 && ran.rate < 1e-14 && ran.lost.abs() < 1e-13);
    }
    // From rest it slides down, in the direction that is given.
    let (mechanism, mut state) = block(Grip::Slides { friction: 0.25, direction: Vector3::x() });
    let ran = run(&mechanism, &mut state, 5, 4, 1.0);
    let distance = 0.5 * g * (5.0 / 13.0 - 0.25 * 12.0 / 13.0);
    assert!((state.position[0] - distance).abs() < 1e-14 && ran.lost.abs() < 1e-13, "{state:?}");
}

#[test]
fn a_block_thrown_across_a_slope_slides_on_its_curve_to_the_full_order() {
    let (mechanism, start) = block(slides(0.5));
    let g = 9.81;
    let until = 0.8;
    let exact = after(
        |&[_, _, u, v]: &[f64; 4]| {
            let brake = 0.5 * g * 12.0 / 13.0 / u.hypot(v);
            [u, v, g * 5.0 / 13.0 - brake * u, -brake * v]
        },
        [0.0, 0.0, 0.0, 1.5],
        until,
        40_000,
    );
    let mut start = start;
    start.velocity[1] = 1.5;
    let error = |state: &State| {
        (0..2).map(|i| (state.position[i] - exact[i]).abs() + (state.velocity[i] - exact[i + 2]).abs()).sum::<f64>()
    };
    // Runge–Kutta with 2e-5 s leaves 1e-14.
    assert_order((&mechanism, &start), until, 0.0, [(2, [16, 32, 64]), (3, [8, 16, 32]), (5, [4, 8, 16])], error);
    assert_order((&mechanism, &start), until, 1e-12, [(9, [6, 12, 24]); 3], error);
}

#[test]
fn a_ball_that_slips_follows_its_parabola() {
    for (velocity, spin, until) in
        [([1.8, 0.0, 0.0], [0.0, -15.0, 0.0], 0.349), ([2.0, 0.0, 0.0], [12.0, -10.0, 25.0], 0.3)]
    {
        let inertia = Vector3::repeat(0.4 * 0.12 * 0.12);
        let mut mechanism = free(Vector3::new(0.0, 0.0, -9.81), &[(1.0, inertia)]);
        mechanism.touches.push(on_floor(0, Vector3::zeros(), 0.12, slides(0.3)));
        let start = {
            let mut state = State::zero(&mechanism);
            set(&mut state, 0, [0.0, 0.0, 0.12], Vector3::zeros(), velocity, spin);
            state
        };
        // u = v + ω × (−r z).
        let slip = Vector3::from(velocity) + Vector3::from(spin).cross(&Vector3::new(0.0, 0.0, -0.12));
        let brake = -slip / slip.norm() * 0.3 * 9.81;
        let exact = Vector3::new(0.0, 0.0, 0.12) + Vector3::from(velocity) * until + brake * (0.5 * until * until);
        let error = |state: &State| (Vector3::from_column_slice(&state.position[..3]) - exact).norm();
        // The first slips along a line, which is exact in every step.
        let counts = [(3, [40, 80, 160]), (5, [10, 20, 40]), (9, [4, 8, 16])];
        assert_order((&mechanism, &start), until, 1e-13, counts, error);
    }
}

/// Rod of C6: θ and the place of its centre from the equations of a plane, with friction against a slip of this sign.
fn rod(friction: f64, sign: f64) -> impl Fn(&[f64; 4]) -> [f64; 4] {
    move |&[_, angle, rate, turn]: &[f64; 4]| {
        let (l, r, inertia) = (0.5, 0.01, 0.25 / 3.0);
        let (sine, cosine) = angle.sin_cos();
        // θ̈ = N a, with N = g + z̈ and z̈ = −l (sin θ θ̈ + cos θ θ̇²).
        let a = (l * sine + (l * cosine + r) * friction * sign) / inertia;
        let normal = (9.81 - l * cosine * turn * turn) / (1.0 + l * sine * a);
        [rate, turn, -friction * sign * normal, normal * a]
    }
}

#[test]
fn a_falling_rod_slides_to_the_full_order() {
    // Sliding with −1 m/s from 0.5 rad, and from rest at 0.3 rad, where it begins to slide against x.
    for (friction, angle, velocity, direction, until) in [(0.3, 0.5, -1.0, 0.0, 0.4), (0.2, 0.3, 0.0, -1.0, 0.4)] {
        let exact = after(rod(friction, -1.0), [0.0, angle, velocity, 0.0], until, 20_000);
        let mut mechanism = free(Vector3::new(0.0, 0.0, -9.81), &[(1.0, Vector3::new(0.25 / 3.0, 0.25 / 3.0, 1e-3))]);
        let grip = Grip::Slides { friction, direction: Vector3::new(direction, 0.0, 0.0) };
        mechanism.touches.push(on_floor(0, Vector3::new(0.0, 0.0, -0.5), 0.01, grip));
        let mut start = State::zero(&mechanism);
        let turn = Vector3::new(0.0, angle, 0.0);
        set(&mut start, 0, [0.0, 0.0, 0.5 * angle.cos() + 0.01], turn, [velocity, 0.0, 0.0], [0.0; 3]);
        let error = |state: &State| (state.position[0] - exact[0]).abs() + (state.velocity[4] - exact[3]).abs();
        // Runge–Kutta with 2e-5 s leaves 1e-13.
        let counts = [(3, [8, 16, 32]), (5, [4, 8, 16]), (9, [4, 8, 16])];
        assert_order((&mechanism, &start), until, 2e-13, counts, error);
    }
}
