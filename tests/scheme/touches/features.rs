//! Every pair of features, against motions of one or two angles.

use super::*;
use crate::runge_kutta::after;

/// `L θ̈ = factor g sin θ` down from an angle at rest: what slides or rolls over a ball or a cylinder.
fn over(factor: f64, reach: f64, angle: f64, until: f64) -> f64 {
    after(|&[angle, rate]: &[f64; 2]| [rate, factor * 9.81 / reach * angle.sin()], [angle, 0.0], until, 20_000)[0]
}

#[test]
fn a_ball_slides_and_rolls_over_a_ball_and_over_a_cylinder() {
    let (radius, reach, from, until) = (0.1, 0.4, 0.3, 0.4);
    let under = [Feature::Point { radius: 0.3 }, Feature::Line { radius: 0.3 }];
    for (first, grip, factor) in [
        (under[0], slides(0.0), 1.0),
        (under[1], slides(0.0), 1.0),
        (under[0], Grip::Rolls, 5.0 / 7.0),
        (under[1], Grip::Rolls, 5.0 / 7.0),
    ] {
        let exact = over(factor, reach, from, until);
        let inertia = Vector3::repeat(0.4 * 2.0 * radius * radius);
        let mut mechanism = free(Vector3::new(0.0, 0.0, -9.81), &[(2.0, inertia)]);
        // The axis of the cylinder is y, that of the world's feature.
        let a = feature(None, Vector3::new(0.2, 0.1, -0.3), Vector3::new(-std::f64::consts::FRAC_PI_2, 0.0, 0.0));
        let b = feature(Some(0), Vector3::zeros(), Vector3::zeros());
        mechanism.touches.push(touch([first, Feature::Point { radius }], grip, a, b));
        let mut start = State::zero(&mechanism);
        let place = [0.2 + reach * from.sin(), 0.1, -0.3 + reach * from.cos()];
        set(&mut start, 0, place, Vector3::zeros(), [0.0; 3], [0.0; 3]);
        let error = |state: &State| ((state.position[0] - 0.2).atan2(state.position[2] + 0.3) - exact).abs();
        let counts = [(3, [8, 16, 32]), (5, [4, 8, 16]), (9, [8, 16, 32])];
        assert_order((&mechanism, &start), until, 2e-13, counts, error);
    }
}

#[test]
fn a_rod_slides_across_a_fixed_rod() {
    // s: how far the middle of the rod is along its own axis d = (cos θ, 0, sin θ); n = (−sin θ, 0, cos θ); N acts at the contact along n.
    let (length, reach, mass, inertia) = (0.8, 0.05, 1.5, 1.5 * 0.64 / 12.0);
    let (until, from) = (0.5, [0.1, 0.05, 0.3, 0.2]);
    let exact = after(
        |&[s, angle, slide, turn]: &[f64; 4]| {
            let (sine, cosine) = angle.sin_cos();
            let normal = 2.0 * slide * turn - reach * turn * turn + 9.81 * cosine;
            let turning = -s * mass * normal / (inertia + mass * s * s);
            [slide, turn, reach * turning + s * turn * turn - 9.81 * sine, turning]
        },
        from,
        until,
        20_000,
    );
    let gravity = Vector3::new(0.0, 0.0, -9.81);
    let mut mechanism = free(gravity, &[(mass, Vector3::new(inertia, inertia, 1e-3))]);
    let a = feature(None, Vector3::zeros(), Vector3::new(-std::f64::consts::FRAC_PI_2, 0.0, 0.0));
    let b = feature(Some(0), Vector3::new(0.0, 0.0, 0.1 * length), Vector3::zeros());
    let mut joint = touch([Feature::Line { radius: 0.03 }, Feature::Line { radius: 0.02 }], slides(0.0), a, b);
    joint.touch.side = -1.0;
    mechanism.touches.push(joint);
    let place = |&[s, angle, ..]: &[f64; 4]| {
        let (sine, cosine) = angle.sin_cos();
        [s * cosine - reach * sine, 0.0, s * sine + reach * cosine]
    };
    let [s, angle, slide, turn] = from;
    let (sine, cosine) = f64::sin_cos(angle);
    let (along, up) = (slide - reach * turn, s * turn);
    let mut start = State::zero(&mechanism);
    // The body's z is d: turned about y by π/2 − θ; θ turns about −y.
    let turned = Vector3::new(0.0, std::f64::consts::FRAC_PI_2 - angle, 0.0);
    let velocity = [along * cosine - up * sine, 0.0, along * sine + up * cosine];
    set(&mut start, 0, place(&from), turned, velocity, [0.0, -turn, 0.0]);
    let exact = Vector3::from(place(&exact));
    let error = |state: &State| (Vector3::from_column_slice(&state.position[..3]) - exact).norm();
    let counts = [(3, [8, 16, 32]), (5, [4, 8, 16]), (9, [8, 16, 32])];
    assert_order((&mechanism, &start), until, 1e-13, counts, error);
}

/// A thin disc that rolls on its rim, with v = ω × ρ m: rotation matrix, angular velocity and place by Newton's and Euler's equations.
fn rolling_disc(mass: f64, rim: f64) -> impl Fn(&[f64; 15]) -> [f64; 15] {
    move |y: &[f64; 15]| {
        let rotation = nalgebra::Matrix3::from_column_slice(&y[..9]);
        let spin = Vector3::from_column_slice(&y[9..12]);
        let moments = nalgebra::Matrix3::from_diagonal(&(Vector3::new(0.25, 0.25, 0.5) * (mass * rim * rim)));
        let inertia = rotation * moments * rotation.transpose();
        let (up, axis) = (Vector3::z(), rotation.column(2).into_owned());
        let turning = spin.cross(&axis);
        let across = up - axis * axis.dot(&up);
        let towards = across.normalize();
        let change = -axis * turning.dot(&up) - turning * axis.dot(&up);
        let change = (change - towards * towards.dot(&change)) / across.norm();
        let matrix = inertia + (nalgebra::Matrix3::identity() - towards * towards.transpose()) * (mass * rim * rim);
        let right = -spin.cross(&(inertia * spin))
            - towards.cross(&spin.cross(&change)) * (mass * rim * rim)
            - towards.cross(&up) * (mass * rim * 9.81);
        let acceleration = matrix.lu().solve(&right).unwrap();
        let rates = nalgebra::Matrix3::from_columns(&[0, 1, 2].map(|i| spin.cross(&rotation.column(i).into_owned())));
        let velocity = spin.cross(&towards) * rim;
        let all = rates.iter().chain(acceleration.iter()).chain(velocity.iter());
        let all: Vec<f64> = all.copied().collect();
        std::array::from_fn(|i| all[i])
    }
}

#[test]
fn a_disc_rolls_on_its_rim() {
    let (mass, rim, until) = (0.7, 0.2, 0.6);
    let turn = Rotation3::new(Vector3::new(1.1, 0.0, 0.0));
    let spin = turn * Vector3::new(0.4, 0.6, 6.0);
    let axis = turn * Vector3::z();
    let towards = (Vector3::z() - axis * axis.z).normalize();
    let place = towards * rim;
    let start_of: Vec<f64> = turn.matrix().iter().chain(spin.iter()).chain(place.iter()).copied().collect();
    let exact = after(rolling_disc(mass, rim), std::array::from_fn(|i| start_of[i]), until, 20_000);
    let mut mechanism =
        free(Vector3::new(0.0, 0.0, -9.81), &[(mass, Vector3::new(0.25, 0.25, 0.5) * (mass * rim * rim))]);
    let floor = feature(None, Vector3::zeros(), Vector3::zeros());
    let b = feature(Some(0), Vector3::zeros(), Vector3::zeros());
    mechanism.touches.push(touch([Feature::Plane, Feature::Rim { radius: rim }], Grip::Rolls, floor, b));
    let mut start = State::zero(&mechanism);
    // The gap asks for the height of the centre alone.
    let velocity = spin.cross(&towards) * rim;
    set(&mut start, 0, place.into(), turn.scaled_axis(), velocity.into(), [0.4, 0.6, 6.0]);
    let end = Vector3::from_column_slice(&exact[12..]);
    let error = |state: &State| (Vector3::from_column_slice(&state.position[..3]) - end).norm();
    let counts = [(3, [16, 32, 64]), (5, [8, 16, 32]), (9, [8, 16, 32])];
    assert_order((&mechanism, &start), until, 1e-12, counts, error);
}
