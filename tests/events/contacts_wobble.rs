//! Cylinders that wobble and roll on a rim: against equations of motion of their angles.

use crate::exact::near;
use crate::loose::{DOWN, loose, on_floor, put, solid};
use crate::mechanisms::{GRAVITY, fixed, run};
use crate::runge_kutta::after;
use catena::mechanism::description::contact::Shape;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use nalgebra::{Matrix3, Rotation3, Vector3};

/// m, kg.
const RADIUS: f64 = 0.1;
const MASS: f64 = 0.8;

/// A solid cylinder of this half height on a floor.
fn on_its_rim(half: f64, friction: f64, restitution: f64) -> Mechanism {
    let mut mechanism = loose(DOWN, &[(MASS, Shape::Cylinder { radius: RADIUS, half })]);
    on_floor(&mut mechanism, friction, restitution);
    mechanism
}

/// The moments of inertia across and along its axis (kg m²).
fn moments(half: f64) -> [f64; 2] {
    let all = solid(MASS, &Shape::Cylinder { radius: RADIUS, half });
    [all.x, all.z]
}

/// Puts it on its lower rim, tilted towards an azimuth (rad), with an angular velocity in the world and its centre of mass above the origin.
fn tilted(
    mechanism: &Mechanism,
    half: f64,
    [tilt, azimuth]: [f64; 2],
    spin: Vector3<f64>,
    velocity: Vector3<f64>,
) -> State {
    let turn =
        Rotation3::from_axis_angle(&Vector3::z_axis(), azimuth) * Rotation3::from_axis_angle(&Vector3::y_axis(), tilt);
    let height = RADIUS * tilt.sin() + half * tilt.cos();
    let mut start = State::zero(mechanism);
    put(mechanism, &mut start, 0, [Vector3::z() * height, turn.scaled_axis(), velocity, turn.inverse() * spin]);
    start
}

/// The axis of the body in the world, and its angular velocity.
fn axis_and_spin(mechanism: &Mechanism, state: &State) -> (Vector3<f64>, Vector3<f64>) {
    let body = &body_states(mechanism, state)[0];
    (body.rotation.column(2).into_owned(), body.angular_velocity)
}

/// The tilt θ, its rate and the azimuth φ of a cylinder that slides on its rim without friction. ω about its axis and the angular momentum L about the vertical
/// are kept, and with the height of the centre of mass h = ρ sin θ + H cos θ
///
/// ```text
///     φ̇ = (L − C ω cos θ)/(A sin² θ)        (A + m h'²) θ̈ = −m h' (h'' θ̇² + g) − d/dθ (L − C ω cos θ)²/(2 A sin² θ)
/// ```
fn wobble(half: f64, spin: f64, momentum: f64) -> impl Fn(&[f64; 3]) -> [f64; 3] {
    let [a, c] = moments(half);
    move |&[tilt, rate, _]: &[f64; 3]| {
        let (sine, cosine) = tilt.sin_cos();
        let (slope, bend) = (RADIUS * cosine - half * sine, -RADIUS * sine - half * cosine);
        let rest = momentum - c * spin * cosine;
        let turning = rest / (a * sine * sine);
        let barrier = rest * (c * spin * sine * sine - rest * cosine) / (a * sine.powi(3));
        let tilting = -(MASS * slope * (bend * rate * rate + GRAVITY) + barrier) / (a + MASS * slope * slope);
        [rate, tilting, turning]
    }
}

/// The angular velocity of a tilted cylinder towards azimuth zero that does not tilt, with φ̇ and ω as of [`wobble`].
fn spinning(half: f64, tilt: f64, spin: f64, momentum: f64) -> Vector3<f64> {
    let turning = wobble(half, spin, momentum)(&[tilt, 0.0, 0.0])[2];
    let axis = Vector3::new(tilt.sin(), 0.0, tilt.cos());
    Vector3::z() * turning + axis * (spin - turning * tilt.cos())
}

#[test]
fn a_wobbling_cylinder_without_friction_tilts_and_turns_as_its_three_constants_say() {
    let (half, tilt, until) = (0.03, 0.5, 0.6);
    for (spin, momentum) in [(10.0, 0.03), (-6.0, -0.015)] {
        let mechanism = on_its_rim(half, 0.0, 0.0);
        let start = tilted(&mechanism, half, [tilt, 0.0], spinning(half, tilt, spin, momentum), Vector3::zeros());
        let found = run(&mechanism, &start, until, fixed(9, 0.01));
        let [wanted, _, azimuth] = after(wobble(half, spin, momentum), [tilt, 0.0, 0.0], until, 40_000);
        let (axis, turning) = axis_and_spin(&mechanism, &found.state);
        println!("tilt {wanted} turned {azimuth}: {:?} {:?}", found.events, found.summary);
        assert!(found.events.is_empty(), "{:?}", found.events);
        let expected = Vector3::new(wanted.sin() * azimuth.cos(), wanted.sin() * azimuth.sin(), wanted.cos());
        println!("{:e}, {:e}", (axis - expected).norm(), turning.dot(&axis) - spin);
        // Some tens of turns' roundings.
        assert!((axis - expected).norm() <= 1e-10, "{axis} for {expected}");
        near(turning.dot(&axis), spin, 1e-11);
        // Nothing pushes it aside.
        assert!(found.state.position[0].hypot(found.state.position[1]) <= 1e-13);
        assert!(found.summary.max_relative_energy_error <= 1e-12, "{:?}", found.summary);
    }
}

/// Rotation matrix, angular velocity and place of a cylinder that rolls on its lower rim. With r from the point of contact to the centre of mass,
/// r = ρ u + H k, u up in the plane of the rim, v = ω × r and
///
/// ```text
///     I ω̇ + m r × (ω̇ × r) = −ω × I ω − m r × (ω × ṙ) + m r × g
/// ```
fn rolling(half: f64, gravity: Vector3<f64>) -> impl Fn(&[f64; 15]) -> [f64; 15] {
    let [a, c] = moments(half);
    move |y: &[f64; 15]| {
        let rotation = Matrix3::from_column_slice(&y[..9]);
        let spin = Vector3::from_column_slice(&y[9..12]);
        let inertia = rotation * Matrix3::from_diagonal(&Vector3::new(a, a, c)) * rotation.transpose();
        let (up, axis) = (Vector3::z(), rotation.column(2).into_owned());
        let across = up - axis * axis.dot(&up);
        let towards = across.normalize();
        let turning = spin.cross(&axis);
        let change = -turning * axis.dot(&up) - axis * turning.dot(&up);
        let change = (change - towards * towards.dot(&change)) / across.norm();
        let (arm, arm_rate) = (towards * RADIUS + axis * half, change * RADIUS + turning * half);
        let matrix = inertia + (Matrix3::identity() * arm.norm_squared() - arm * arm.transpose()) * MASS;
        let right =
            -spin.cross(&(inertia * spin)) - arm.cross(&spin.cross(&arm_rate)) * MASS + arm.cross(&gravity) * MASS;
        let acceleration = matrix.lu().solve(&right).expect("a definite matrix");
        let velocity = spin.cross(&arm);
        let rates = Matrix3::from_columns(&[0, 1, 2].map(|i| spin.cross(&rotation.column(i).into_owned())));
        let all: Vec<f64> = rates.iter().chain(acceleration.iter()).chain(velocity.iter()).copied().collect();
        std::array::from_fn(|i| all[i])
    }
}

#[test]
fn a_cylinder_that_is_rough_rolls_on_its_rim_as_newton_and_euler_say() {
    let (half, tilt, until) = (0.03, 1.1, 0.4);
    // About its axis, and across it.
    for (along, across) in [(8.0, Vector3::new(0.3, 0.2, 0.0)), (-6.0, Vector3::new(0.0, 0.5, 0.3))] {
        let mechanism = on_its_rim(half, 5.0, 0.0);
        let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), tilt);
        let axis = turn * Vector3::z();
        let arm = (Vector3::z() - axis * axis.z).normalize() * RADIUS + axis * half;
        let spin = axis * along + across;
        let start = tilted(&mechanism, half, [tilt, 0.0], spin, spin.cross(&arm));
        let found = run(&mechanism, &start, until, fixed(9, 0.005));
        let from: Vec<f64> = turn.matrix().iter().chain(spin.iter()).chain(&[0.0, 0.0, arm.z]).copied().collect();
        let wanted = after(rolling(half, DOWN), std::array::from_fn(|i| from[i]), until, 40_000);
        let place = Vector3::from_column_slice(&found.state.position[..3]);
        let expected = Vector3::from_column_slice(&wanted[12..]);
        println!("{:?} {:?}: {:e}", found.events, found.summary.contact, (place - expected).norm());
        assert!(found.events.is_empty(), "{:?}", found.events);
        assert!((place - expected).norm() <= 1e-10, "{place} for {expected}");
        let (axis, _) = axis_and_spin(&mechanism, &found.state);
        assert!((axis - Vector3::from_column_slice(&wanted[6..9])).norm() <= 1e-10);
        assert!(found.summary.max_relative_energy_error <= 1e-12, "{:?}", found.summary);
    }
}

#[test]
fn a_cylinder_that_is_pulled_out_of_the_plane_of_its_tilt_rolls_on_its_rim_as_newton_and_euler_say() {
    let (half, until) = (0.03, 0.15);
    // From rest, where nothing tells yet that it will leave the plane.
    for tilt in [0.6, 1.0] {
        let gravity = Vector3::new(0.0, 1.5, -GRAVITY);
        let mut mechanism = loose(gravity, &[(MASS, Shape::Cylinder { radius: RADIUS, half })]);
        on_floor(&mut mechanism, 5.0, 0.0);
        let start = tilted(&mechanism, half, [tilt, 0.0], Vector3::zeros(), Vector3::zeros());
        let found = run(&mechanism, &start, until, fixed(9, 0.0025));
        let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), tilt);
        let height = RADIUS * tilt.sin() + half * tilt.cos();
        let from: Vec<f64> = turn.matrix().iter().chain(&[0.0, 0.0, 0.0, 0.0, 0.0, height]).copied().collect();
        let wanted = after(rolling(half, gravity), std::array::from_fn(|i| from[i]), until, 40_000);
        let expected = Vector3::from_column_slice(&wanted[12..]);
        let place = Vector3::from_column_slice(&found.state.position[..3]);
        println!("{:?} {place}: {:e} {:?}", found.events, (place - expected).norm(), found.summary);
        assert!(found.events.is_empty(), "{:?}", found.events);
        assert!((place - expected).norm() <= 1e-10, "{place} for {expected}");
        assert!(found.summary.max_relative_energy_error <= 1e-12, "{:?}", found.summary);
    }
}
