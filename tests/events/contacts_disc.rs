//! Cylinders that stand: the disc carries what its rim can, in every direction.

use crate::continuous::run_under;
use crate::loose::{DOWN, loose, meet, obstacle, on_floor, resting};
use crate::mechanisms::{GRAVITY, fixed, run};
use catena::mechanism::description::contact::Shape;
use catena::mechanism::description::joint::Pose;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::state::State;
use catena::simulation::{ContinuousController, StepChoice};
use nalgebra::{DMatrix, Vector3};

/// Radius, half height, height of the centre of mass (m) and mass (kg) of the cylinder.
const RADIUS: f64 = 0.07;
const HALF: f64 = 0.1;
const CENTRE: f64 = 0.15;
const MASS: f64 = 1.3;

/// A cylinder that stands on a floor at z = 0.
fn standing(gravity: Vector3<f64>, friction: f64, restitution: f64) -> (Mechanism, State) {
    let mut mechanism = loose(gravity, &[(MASS, Shape::Cylinder { radius: RADIUS, half: HALF })]);
    mechanism.nonsmooth.colliders[0].pose = Pose::translation(0.0, 0.0, HALF - CENTRE);
    on_floor(&mut mechanism, friction, restitution);
    let start = resting(&mechanism, &[Vector3::new(0.0, 0.0, CENTRE)]);
    (mechanism, start)
}

/// How far the centre of mass has gone (m) a time after a cylinder has begun to tip over a point of its rim, under the forces `along(t)` and `-weight` on
/// it (N): `J q̈ = along z + weight (R − x)` about that point, by Runge and Kutta's method.
fn tipped(time: f64, along: impl Fn(f64) -> f64, weight: f64) -> [f64; 2] {
    let about = MASS * (0.25 * RADIUS * RADIUS + HALF * HALF / 3.0 + CENTRE * CENTRE + RADIUS * RADIUS);
    let place = |q: f64| [CENTRE * q.sin() - RADIUS * q.cos(), RADIUS * q.sin() + CENTRE * q.cos()];
    let slope = |t: f64, [q, w]: [f64; 2]| {
        let [x, z] = place(q);
        [w, (along(t) * z + weight * x) / about]
    };
    let steps = 2000;
    let h = time / f64::from(steps);
    let mut y = [0.0; 2];
    for step in 0..steps {
        let t = f64::from(step) * h;
        let ahead = |part: f64, k: [f64; 2]| [y[0] + part * h * k[0], y[1] + part * h * k[1]];
        let first = slope(t, y);
        let second = slope(t + 0.5 * h, ahead(0.5, first));
        let third = slope(t + 0.5 * h, ahead(0.5, second));
        let fourth = slope(t + h, ahead(1.0, third));
        y = [0, 1].map(|i| y[i] + h / 6.0 * (first[i] + 2.0 * second[i] + 2.0 * third[i] + fourth[i]));
    }
    let [x, z] = place(y[0]);
    [RADIUS + x, z - CENTRE]
}

/// A force on the centre of mass of the first body that depends on time (N).
struct Push<F: Fn(f64) -> Vector3<f64>>(F);

impl<F: Fn(f64) -> Vector3<f64>> ContinuousController for Push<F> {
    fn freedoms(&self, _: &Mechanism) -> Vec<usize> {
        (0..3).collect()
    }

    fn efforts(&self, _: &Mechanism, state: &State, efforts: &mut [f64]) {
        efforts.copy_from_slice((self.0)(state.time).as_slice());
    }

    fn derivatives(&self, _: &Mechanism, _: &State, _: &mut DMatrix<f64>, _: &mut DMatrix<f64>) {}
}

#[test]
fn a_cylinder_that_is_pushed_ever_harder_tips_when_the_moment_is_that_of_its_weight_about_the_rim() {
    let (mechanism, start) = standing(DOWN, 1.5, 0.0);
    let weight = MASS * GRAVITY;
    // F h = m g r at 1 s.
    let rise = weight * RADIUS / CENTRE;
    for angle in [0.0, 0.785, 2.6] {
        let towards = Vector3::new(f64::cos(angle), f64::sin(angle), 0.0);
        let push = Push(|time| towards * (rise * time));
        for steps in [fixed(5, 0.05), StepChoice::Tolerance(1e-8)] {
            let held = run_under(&mechanism, &start, 1.0 - 1e-10, steps, &push).unwrap();
            assert_eq!(held.state.position, start.position, "{angle}");
            let done = run_under(&mechanism, &start, 1.02, steps, &push).unwrap();
            let gone = Vector3::from_column_slice(&done.state.position[..3]) - Vector3::z() * CENTRE;
            let [along, up] = tipped(0.02, |time| rise * (1.0 + time), weight);
            // At 6e-4 m/s an instant that is 1e-10 s off is 6e-14 m off.
            let off = (gone - towards * along - Vector3::z() * up).norm();
            println!("{angle} {steps:?}: {off:e} m of {along:e}");
            assert!(off < 2e-14, "{angle} {steps:?}: {off:e} m");
        }
    }
}

#[test]
fn a_cylinder_on_a_slope_stays_for_ever_below_the_angle_of_its_rim_and_tips_above() {
    for angle in [0.1, 0.785, 2.0, 5.0] {
        let towards = Vector3::new(f64::cos(angle), f64::sin(angle), 0.0);
        let slope = |part: f64| (towards * (RADIUS / CENTRE * part) - Vector3::z()) * GRAVITY;
        for (part, stays) in [(1.0 - 1e-8, true), (1.0 + 1e-8, false)] {
            let (mechanism, start) = standing(slope(part), 1.5, 0.0);
            let done = run(&mechanism, &start, 0.5, fixed(5, 0.01));
            if stays {
                assert_eq!(done.state.position, start.position, "{angle}");
                continue;
            }
            let along = MASS * GRAVITY * RADIUS / CENTRE * part;
            let [wanted, _] = tipped(0.5, |_| along, MASS * GRAVITY);
            let gone = towards.dot(&Vector3::from_column_slice(&done.state.position[..3]));
            println!("{angle}: {gone:e} of {wanted:e}");
            // What tips is 1e-8 of the forces, which are known to 1e-14.
            assert!((gone / wanted - 1.0).abs() < 1e-5, "{angle}: {gone:e} of {wanted:e}");
        }
    }
}

#[test]
fn a_cylinder_that_stands_on_the_edge_of_another_stays_until_its_centre_is_beyond_the_rim() {
    let half = 0.05;
    for (part, angle) in [(0.5, 0.0), (0.5, 0.7), (0.999, 0.785), (0.999, 2.0), (1.001, 0.785), (1.001, 4.0)] {
        let mut mechanism = loose(DOWN, &[(MASS, Shape::Cylinder { radius: RADIUS, half })]);
        let below =
            obstacle(&mut mechanism, Shape::Cylinder { radius: 1.3 * RADIUS, half }, Vector3::new(0.0, 0.0, -half));
        meet(&mut mechanism, below, 0, 0.8, 0.0);
        let towards = Vector3::new(f64::cos(angle), f64::sin(angle), 0.0);
        let at = towards * (1.3 * RADIUS * part) + Vector3::z() * half;
        let start = resting(&mechanism, &[at]);
        let done = run(&mechanism, &start, 0.3, fixed(5, 0.01));
        println!("{part} {angle}: {:?} {:?}", done.state.position, done.events);
        if part < 1.0 {
            assert_eq!(done.state.position, start.position, "{part}, {angle}");
        } else {
            // About the point of the lower rim, which slides on the upper cap not at all at first: m g (d − r) / J.
            let arm = 1.3 * RADIUS * (part - 1.0);
            let about = MASS * (0.25 * RADIUS * RADIUS + half * half / 3.0 + half * half + arm * arm);
            let rate = (MASS * GRAVITY * half / about).sqrt();
            // θ̈ ≈ m g (arm + h θ)/J while θ is small.
            let angle = arm / half * ((rate * 0.3).cosh() - 1.0);
            let found = towards.dot(&(Vector3::from_column_slice(&done.state.position[..3]) - at));
            println!("leans {angle}: moved {found} for {}", half * angle);
            assert!(found > 0.5 * half * angle.min(0.2), "{part}, {angle}: {found}");
        }
    }
}
