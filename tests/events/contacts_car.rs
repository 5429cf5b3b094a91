//! A car on four wheels that slides: three of the wheels would carry it, and friction asks how much each of the four does.
//!
//! The pressures lie on a plane over the places of the wheels, as those of the corners of a box ([`crate::contacts_turning`]). With the wheels at
//! (X_i, Y_i) beside the centre of mass, which is at the height h, their radius R, J about their axles, J_z of all about the vertical, P = −∫ x z dm,
//! and all in the axes of the car:
//!
//! ```text
//!     N_i = α + β X_i + γ Y_i,    f_i = −μ N_i u_i/|u_i|,    u_i = v + ω z × r_i − R s_i x
//!     Σ N_i = m g,    Σ (Y_i N_i + h f_iy) = P dω/dt − ω J Σ s_i,    Σ (−X_i N_i − h f_ix) = J Σ ds_i/dt + P ω²
//!     m (dv/dt + ω z × v) = Σ f_i,    J_z dω/dt = Σ (X_i f_iy − Y_i f_ix),    J ds_i/dt = −R f_ix
//! ```
//!
//! which is here integrated on its own: α, β, γ from the first three equations, then the method of Runge and Kutta for (x, y, θ, v, ω, s).

use crate::mechanisms::{GRAVITY, fixed, run};
use crate::runge_kutta::after;
use catena::mechanism::description::contact::{Collider, ContactPair, Shape};
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::motion::state::State;
use nalgebra::{Matrix3, Rotation3, Translation3, Vector3};

const CHASSIS: f64 = 10.0;
const WHEEL: f64 = 0.5;
const MASS: f64 = CHASSIS + 4.0 * WHEEL;
/// Of a wheel about its axle and across it (kg m²).
const ABOUT: f64 = 0.0018;
const ACROSS: f64 = 0.001;
const RADIUS: f64 = 0.08;
/// Of the centre of the chassis over the axles (m).
const OVER: f64 = 0.05;
const FRICTION: f64 = 0.5;
/// Front left, front right, rear left, rear right (m).
const PLACES: [[f64; 2]; 4] = [[0.25, 0.2], [0.25, -0.2], [-0.15, 0.2], [-0.15, -0.2]];
/// The chassis about its centre (kg m²).
const INERTIA: [f64; 3] = [0.2, 0.4, 0.5];

/// How it starts: forwards, to the left and turning, its wheels still [m/s, rad/s].
const FORWARDS: f64 = 1.0;
const SIDEWAYS: f64 = 0.4;
const TURNING: f64 = 3.0;

fn car() -> (Mechanism, State) {
    let free = Joint::new("free", JointKind::Floating, Pose::identity(), Pose::identity());
    let inertia = Vector3::from(INERTIA);
    let mut bodies = vec![Body { name: "chassis".into(), parent: None, mass: CHASSIS, inertia, joint: free }];
    for (number, [x, y]) in PLACES.into_iter().enumerate() {
        // The axle of a wheel is its z, to the left.
        let turned = Rotation3::from_axis_angle(&Vector3::x_axis(), -std::f64::consts::FRAC_PI_2);
        let axle = Pose::from_parts(Translation3::new(x, y, -OVER), turned);
        let joint = Joint::new(&format!("axle{number}"), JointKind::Revolute, axle, Pose::identity());
        let inertia = Vector3::new(ACROSS, ACROSS, ABOUT);
        bodies.push(Body { name: format!("wheel{number}"), parent: Some(0), mass: WHEEL, inertia, joint });
    }
    let mut mechanism = Mechanism::new("car", Vector3::new(0.0, 0.0, -GRAVITY), bodies).expect("a car");
    let nonsmooth = &mut mechanism.nonsmooth;
    let collider = |name: &str, body, shape| Collider::still(name, body, Pose::identity(), shape);
    nonsmooth.colliders.push(collider("floor", None, Shape::HalfSpace));
    for number in 0..4 {
        nonsmooth.colliders.push(collider("tyre", Some(number + 1), Shape::Sphere { radius: RADIUS }));
        nonsmooth.pairs.push(ContactPair::without_moments(number, [0, number + 1], FRICTION, 0.0));
    }
    let mut start = State::zero(&mechanism);
    start.position[2] = OVER + RADIUS;
    start.velocity[..2].copy_from_slice(&[FORWARDS, SIDEWAYS]);
    start.velocity[5] = TURNING;
    (mechanism, start)
}

/// What (x, y, θ, v_x, v_y, ω, s) change by in time, while all wheels slide; x and y are of the centre of mass, v_x and v_y its velocity in the axes of the car.
fn rates(state: &[f64; 10]) -> [f64; 10] {
    let [_, _, angle, vx, vy, turning, spins @ ..] = *state;
    let middle = PLACES.iter().map(|[x, _]| x * WHEEL).sum::<f64>() / MASS;
    let height = RADIUS + CHASSIS * OVER / MASS;
    let about_wheels = |[x, y]: &[f64; 2]| ACROSS + WHEEL * ((x - middle).powi(2) + y * y);
    let yaw = INERTIA[2] + CHASSIS * middle * middle + PLACES.iter().map(about_wheels).sum::<f64>();
    let places = PLACES.map(|[x, y]| [x - middle, y]);
    let below = |[x, _]: &[f64; 2]| WHEEL * x * (height - RADIUS);
    let product = CHASSIS * middle * (OVER + RADIUS - height) + places.iter().map(below).sum::<f64>();
    // The friction of a unit of pressure at each wheel.
    let drags: Vec<[f64; 2]> = (places.iter().zip(spins))
        .map(|([x, y], spin)| {
            let (ux, uy) = (vx - turning * y - RADIUS * spin, vy + turning * x);
            [ux, uy].map(|part| -FRICTION * part / ux.hypot(uy))
        })
        .collect();
    let mut matrix = Matrix3::zeros();
    for ([x, y], [dx, dy]) in places.iter().zip(&drags) {
        let of_a_unit =
            Vector3::new(1.0, y + height * dy - product * (x * dy - y * dx) / yaw, (RADIUS - height) * dx - x);
        matrix += of_a_unit * Vector3::new(1.0, *x, *y).transpose();
    }
    let right = Vector3::new(MASS * GRAVITY, -turning * ABOUT * spins.iter().sum::<f64>(), product * turning * turning);
    let plane = matrix.lu().solve(&right).expect("it stands on four wheels");
    let (sine, cosine) = angle.sin_cos();
    let mut all = [
        cosine * vx - sine * vy,
        sine * vx + cosine * vy,
        turning,
        turning * vy,
        -turning * vx,
        0.0,
        0.0,
        0.0,
        0.0,
        0.0,
    ];
    for (number, ([x, y], [dx, dy])) in places.iter().zip(&drags).enumerate() {
        let pressure = plane.dot(&Vector3::new(1.0, *x, *y));
        assert!(pressure > 0.0);
        all[3] += pressure * dx / MASS;
        all[4] += pressure * dy / MASS;
        all[5] += pressure * (x * dy - y * dx) / yaw;
        all[6 + number] = -RADIUS * pressure * dx / ABOUT;
    }
    all
}

/// How far a run is from the reference after a time (s): the largest differences of places (m) and of rates (m/s, rad/s).
fn errors(stages: usize, step: f64, until: f64) -> [f64; 2] {
    let (mechanism, start) = car();
    let State { position, velocity, .. } = run(&mechanism, &start, until, fixed(stages, step)).state;
    let middle = PLACES.iter().map(|[x, _]| x * WHEEL).sum::<f64>() / MASS;
    // With steps four times as long it is 2e-12 off.
    let exact = after(
        rates,
        [middle, 0.0, 0.0, FORWARDS, SIDEWAYS + TURNING * middle, TURNING, 0.0, 0.0, 0.0, 0.0],
        until,
        8000,
    );
    let (sine, cosine) = exact[2].sin_cos();
    let origin = [exact[0] - middle * cosine, exact[1] - middle * sine];
    let place = (0..2).map(|axis| (position[axis] - origin[axis]).abs()).fold(0.0, f64::max);
    let spins = (0..4).map(|wheel| (velocity[6 + wheel] - exact[6 + wheel]).abs());
    [place, spins.fold((velocity[5] - exact[5]).abs(), f64::max)]
}

#[test]
fn the_pressures_of_a_car_that_slides_on_four_wheels_lie_on_a_plane() {
    // A step of 5 ms moves wheels by millimetres, which the elimination rounds at 1e-19 m; over ε that is a force of 1e-6 N, for as long as the step. With gaps
    // that are not made those of motions it is a hundred times as much, and the more the shorter the steps; with other compliances rates are 1e-2 off.
    for (stages, step, most) in [(9, 5e-3, 2e-6), (9, 1e-3, 2e-7), (5, 5e-4, 5e-8), (3, 5e-5, 1e-9), (3, 1e-5, 1e-9)] {
        // Four hundred steps show what the shortest do.
        let [place, rate] = errors(stages, step, f64::min(0.02, 400.0 * step));
        println!("{stages} stages, {step} s: {place:e} m, {rate:e} rad/s");
        assert!(place < 1e-10, "{stages} stages, {step} s: {place:e} m");
        assert!(rate < most, "{stages} stages, {step} s: {rate:e} rad/s");
    }
}
