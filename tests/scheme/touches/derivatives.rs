//! The derivatives of gaps and slips against differences on random motions.

use super::*;
use catena::mechanism::description::body_state::BodyState;
use catena::mechanism::description::contact::LEVEL;
use catena::mechanism::motion::touches::{tangents, touch_accelerations, touch_motion};
use nalgebra::Matrix3;

/// A motion with this place, turn, velocities and accelerations at t = 0: `R = exp(ω̂ t) exp(α̂ t²/2) R₀`.
struct Path {
    place: Vector3<f64>,
    turn: Vector3<f64>,
    velocity: Vector3<f64>,
    spin: Vector3<f64>,
    acceleration: Vector3<f64>,
    angular: Vector3<f64>,
}

impl Path {
    fn at(&self, t: f64) -> BodyState {
        let matrix = |vector: Vector3<f64>| *Rotation3::new(vector).matrix();
        let turning: Matrix3<f64> = matrix(self.spin * t);
        BodyState {
            position: self.place + self.velocity * t + self.acceleration * (0.5 * t * t),
            rotation: turning * matrix(self.angular * (0.5 * t * t)) * matrix(self.turn),
            velocity: self.velocity + self.acceleration * t,
            angular_velocity: self.spin + turning * self.angular * t,
        }
    }
}

/// First and second derivative by differences of order six.
fn differences(h: f64, f: impl Fn(f64) -> f64) -> (f64, f64) {
    let (mut first, mut second) = (0.0, -49.0 / 18.0 * f(0.0));
    for (k, (one, two)) in [(0.75, 1.5), (-0.15, -0.15), (1.0 / 60.0, 1.0 / 90.0)].into_iter().enumerate() {
        let t = h * (k + 1) as f64;
        first += one * (f(t) - f(-t));
        second += two * (f(t) + f(-t));
    }
    (first / h, second / (h * h))
}

#[test]
fn rates_and_second_rates_of_all_pairs_are_those_of_differences() {
    let (point, line) = (Feature::Point { radius: 0.13 }, Feature::Line { radius: 0.07 });
    let pairs = [
        [Feature::Point { radius: 0.21 }, point],
        [Feature::Plane, point],
        [line, point],
        [line, Feature::Line { radius: 0.11 }],
        [Feature::Plane, Feature::Rim { radius: 0.3 }],
        [Feature::Line { radius: 0.0 }, Feature::Rim { radius: 0.3 }],
        [Feature::Rim { radius: 0.3 }, Feature::Line { radius: 0.0 }],
        [Feature::Rim { radius: 0.3 }, Feature::Point { radius: 0.25 }],
        [Feature::Rim { radius: 0.3 }, Feature::Line { radius: 0.25 }],
        [Feature::Rim { radius: 0.3 }, line],
        [Feature::Rim { radius: 0.3 }, Feature::Rim { radius: 0.5 }],
        [Feature::Rim { radius: 0.3 }, Feature::Rim { radius: 0.5 }],
    ];
    // The second feature is about a metre above the first, its axis across that of the first. A line goes through a rim that is next to it, or out of
    // one that is below it; it lies beside it, or across it. The second rim goes down through the plane of the first, next to it, or lies nearly in it.
    let place_and_turn = |pair: usize| match pair {
        5 => (Vector3::new(0.3, 0.0, 0.1), Vector3::new(0.3, 0.2, 0.0)),
        6 => (Vector3::new(0.0, 0.1, 0.1), Vector3::new(1.4, 0.0, 0.3)),
        7 => (Vector3::new(0.5, 0.1, 0.2), Vector3::zeros()),
        8 => (Vector3::new(0.6, 0.2, 0.2), Vector3::new(1.2, 0.3, 0.2)),
        9 => (Vector3::new(0.1, 0.2, 0.15), Vector3::new(1.7, 0.0, 0.2)),
        10 => (Vector3::new(0.6, 0.1, 0.0), Vector3::new(1.3, 0.0, 0.3)),
        11 => (Vector3::new(0.4, 0.1, 0.01), Vector3::new(0.02, 0.0, 0.3)),
        _ => (Vector3::new(0.4, 0.3, 1.0), Vector3::new(0.9, 0.0, 0.3)),
    };
    let mut seed = 1_u64;
    let mut next = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let mut worst = [[0.0_f64; 4]; 12];
    for number in 0..960 {
        let pair = number % pairs.len();
        // A line may pass a rim at a slant, where the seventh derivatives are a hundred times as large.
        let h = if pair >= 5 { 1e-3 } else { 2.5e-3 };
        let mut vector = |size: f64| Vector3::new(next(), next(), next()) * size;
        let mut path = |place: Vector3<f64>, turn: Vector3<f64>| Path {
            place: place + vector(0.05),
            turn: turn + vector(0.05),
            velocity: vector(1.0),
            spin: vector(1.0),
            acceleration: vector(2.0),
            angular: vector(2.0),
        };
        let (place, turn) = place_and_turn(pair);
        let mut paths = [path(Vector3::zeros(), Vector3::zeros()), path(place, turn)];
        let [a, b] = [0, 1].map(|body: usize| feature(Some(body), vector(0.05), vector(0.05)));
        let mut joint = touch(pairs[pair], slides(0.0), a, b);
        // Of a rim and a line the nearest place, or the one where the line goes outwards.
        joint.touch.side = [0.0, LEVEL, 1.0][if pair == 8 {
            0
        } else if pair == 11 {
            1
        } else {
            2
        }];
        // The gap of a line and a rim is a distance where they touch.
        for _ in 0..if pair >= 5 { 8 } else { 0 } {
            let here = touch_motion(&joint, &paths.each_ref().map(|path| path.at(0.0)));
            paths[1].place -= here.normal * here.gap;
        }
        let bodies = |t: f64| paths.each_ref().map(|path| path.at(t));
        let motion = |t: f64| touch_motion(&joint, &bodies(t));
        let (rate, second) = differences(h, |t| motion(t).gap);
        let here = motion(0.0);
        let along = tangents(&here.normal);
        let accelerations = paths.each_ref().map(|path| (path.acceleration, path.angular));
        let values = touch_accelerations(&joint, &bodies(0.0), &accelerations, &along);
        let start = bodies(0.0)[0].rotation.transpose();
        let slip = |tangent: Vector3<f64>| {
            differences(h, |t| {
                let motion = motion(t);
                let tangent = bodies(t)[0].rotation * start * tangent;
                (motion.slip + motion.normal * motion.rate).dot(&tangent)
            })
            .0
        };
        let errors = [here.rate - rate, values[0] - second, values[1] - slip(along[0]), values[2] - slip(along[1])];
        for (worst, error) in worst[pair].iter_mut().zip(errors) {
            *worst = worst.max(error.abs());
        }
        assert!(here.slip.dot(&here.normal).abs() < 1e-14 && along[0].dot(&along[1]).abs() < 1e-15);
    }
    println!("{worst:?}");
    let worst: [f64; 4] = std::array::from_fn(|i| worst.iter().fold(0.0, |most: f64, worst| most.max(worst[i])));
    // The differences leave h⁶ f⁽⁷⁾/140, some 1e-18 · 1e7 where the cores are a third of a metre apart, and round to 1e-16/h and 1e-15/h².
    assert!(worst[0] < 1e-10 && worst[1..].iter().all(|&error| error < 1e-8), "{worst:?}");
}
