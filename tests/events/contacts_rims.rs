//! Rims of cylinders against what is round: balls, capsules, sides and rims of other cylinders.

use crate::exact::near;
use crate::loose::{DOWN, cuboid, loose, meet, obstacle, put, resting};
use crate::mechanisms::{GRAVITY, fixed, of_kind, run};
use catena::geometry::PairGeometry;
use catena::mechanism::description::contact::Shape;
use catena::mechanism::description::joint::Pose;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::event::EventKind;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::simulation::{Finished, StepChoice};
use nalgebra::{Rotation3, Translation3, UnitQuaternion, Vector3};
use std::f64::consts::FRAC_PI_2;

/// Radius and half the height of the cylinders that stand with their upper cap at z = 0 (m).
const RIM: f64 = 0.5;
const HALF: f64 = 0.1;

/// A body over a fixed shape.
fn over(mass: f64, body: &Shape, under: Shape, at: Vector3<f64>, friction: f64) -> Mechanism {
    let mut mechanism = loose(DOWN, &[(mass, body.clone())]);
    let under = obstacle(&mut mechanism, under, at);
    meet(&mut mechanism, under, 0, friction, 0.0);
    mechanism
}

fn cylinder() -> Shape {
    Shape::Cylinder { radius: RIM, half: HALF }
}

fn block() -> Shape {
    cuboid(RIM, RIM, HALF)
}

const BELOW: Vector3<f64> = Vector3::new(0.0, 0.0, -HALF);

/// How deep the only pair of a mechanism overlaps in a state, or how far it is apart (m), by the certificate, which knows nothing of contacts that are closed.
pub(crate) fn distance(mechanism: &Mechanism, state: &State) -> f64 {
    let bodies = body_states(mechanism, state);
    let colliders = &mechanism.nonsmooth.colliders;
    let pair = mechanism.nonsmooth.pairs.at(0);
    let [a, b] = [pair.a, pair.b].map(|number| &colliders[number]);
    let pose = |body: Option<usize>| match body.map(|body| &bodies[body]) {
        Some(body) => {
            Pose::from_parts(Translation3::from(body.position), Rotation3::from_matrix_unchecked(body.rotation))
        }
        None => Pose::identity(),
    };
    PairGeometry::new(a, b).expect("a pair").distance(&pose(a.body), &pose(b.body)).distance
}

fn centre(finished: &Finished) -> Vector3<f64> {
    Vector3::from_column_slice(&finished.state.position[..3])
}

#[test]
fn a_ball_rolls_over_the_rim_of_a_cylinder_as_over_the_edge_of_a_box() {
    let radius = 0.1;
    let ball = Shape::Sphere { radius };
    for (friction, angle) in [(0.0, 0.0), (0.8, 0.0), (0.8, 0.7), (0.3, 4.0)] {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), angle);
        let from = |mechanism: &Mechanism, turn: Rotation3<f64>| {
            let mut start = State::zero(mechanism);
            let (at, along) = (Vector3::new(RIM - 0.02, 0.0, radius), Vector3::x() * 0.1);
            let spin = if friction > 0.0 { Vector3::y() * (0.1 / radius) } else { Vector3::zeros() };
            put(mechanism, &mut start, 0, [turn * at, Vector3::zeros(), turn * along, turn * spin]);
            start
        };
        let on_box = over(1.0, &ball, block(), BELOW, friction);
        let on_rim = over(1.0, &ball, cylinder(), BELOW, friction);
        let [wanted, found] = [(&on_box, Rotation3::identity()), (&on_rim, turn)]
            .map(|(mechanism, turn)| run(mechanism, &from(mechanism, turn), 0.6, fixed(9, 0.01)));
        println!("{friction}, {angle}:\n{:?}\n{:?}", wanted.events, found.events);
        let off = (turn * centre(&wanted) - centre(&found)).norm();
        println!("{friction}, {angle}: {off:e} m; {:?}", found.summary.contact);
        let leaves = [&wanted, &found].map(|run| of_kind(run, EventKind::Release)[0].time);
        near(leaves[1], leaves[0], 1e-11);
        assert!(off < 1e-11, "{friction}, {angle}: {off:e} m");
    }
}

#[test]
fn a_capsule_that_points_away_slides_over_the_rim_as_over_the_edge_of_a_box() {
    let (radius, half) = (0.05, 0.3);
    let capsule = Shape::Capsule { radius, half };
    for (friction, angle) in [(0.0, 0.0), (0.0, 2.0), (0.4, 0.9)] {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), angle);
        let from = |mechanism: &Mechanism, turn: Rotation3<f64>| {
            // Its axis leans down by 0.3 rad outwards, a tenth of a metre of it beyond the rim.
            let lean = Rotation3::new(Vector3::y() * (FRAC_PI_2 + 0.3));
            let axis = lean * Vector3::z();
            let normal = Vector3::y().cross(&axis) * -1.0;
            let at = Vector3::x() * RIM + normal * (radius * normal.z.signum()) + axis * 0.1;
            let mut start = State::zero(mechanism);
            put(mechanism, &mut start, 0, [turn * at, (turn * lean).scaled_axis(), Vector3::zeros(), Vector3::zeros()]);
            start
        };
        let on_box = over(1.0, &capsule, block(), BELOW, friction);
        let on_rim = over(1.0, &capsule, cylinder(), BELOW, friction);
        let [wanted, found] = [(&on_box, Rotation3::identity()), (&on_rim, turn)]
            .map(|(mechanism, turn)| run(mechanism, &from(mechanism, turn), 0.3, fixed(9, 0.01)));
        println!("{friction}, {angle}:\n{:?}\n{:?}", wanted.events, found.events);
        let off = (turn * centre(&wanted) - centre(&found)).norm();
        println!("{friction}, {angle}: {off:e} m; {:?}", found.summary.contact);
        assert!(off < 1e-11, "{friction}, {angle}: {off:e} m");
        assert!(distance(&on_rim, &found.state) >= -1e-12);
    }
}

#[test]
fn a_capsule_along_the_rim_slides_down_it_as_a_ball_does() {
    let radius = 0.1;
    // At an eighth of a turn over the rim; without friction it does not turn, and moves as a ball.
    let lean = 0.6_f64;
    let at = Vector3::new(RIM + radius * lean.sin(), 0.0, radius * lean.cos());
    let ball = over(1.0, &Shape::Sphere { radius }, cylinder(), BELOW, 0.0);
    let capsule = over(1.0, &Shape::Capsule { radius, half: 0.2 }, cylinder(), BELOW, 0.0);
    let mut start = State::zero(&capsule);
    put(&capsule, &mut start, 0, [at, Vector3::x() * FRAC_PI_2, Vector3::zeros(), Vector3::zeros()]);
    let wanted = run(&ball, &resting(&ball, &[at]), 0.2, fixed(9, 0.01));
    let found = run(&capsule, &start, 0.2, fixed(9, 0.01));
    println!("{:?}\n{:?}", wanted.events, found.events);
    let off = (centre(&wanted) - centre(&found)).norm();
    println!("{off:e} m; {:?}", found.summary.contact);
    assert!(off < 1e-11, "{off:e} m");
}

#[test]
fn a_cylinder_rolls_and_slides_over_a_parallel_one() {
    // L θ̈ = factor g sin θ.
    let (radius, under, half, from, until) = (0.1, 0.3, 0.2, 0.3_f64, 0.3);
    let reach: f64 = radius + under;
    for (friction, factor) in [(0.0, 1.0), (2.0, 2.0 / 3.0)] {
        let (steps, mut angle, mut rate) = (20_000, from, 0.0);
        let h = until / f64::from(steps);
        let slope = |angle: f64| factor * GRAVITY / reach * angle.sin();
        for _ in 0..steps {
            let [a1, r1] = [rate, slope(angle)];
            let [a2, r2] = [rate + 0.5 * h * r1, slope(angle + 0.5 * h * a1)];
            let [a3, r3] = [rate + 0.5 * h * r2, slope(angle + 0.5 * h * a2)];
            let [a4, r4] = [rate + h * r3, slope(angle + h * a3)];
            angle += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
            rate += h / 6.0 * (r1 + 2.0 * r2 + 2.0 * r3 + r4);
        }
        let mut log = loose(DOWN, &[(1.0, Shape::Cylinder { radius, half })]);
        let below = obstacle(&mut log, Shape::Cylinder { radius: under, half: 0.5 }, Vector3::zeros());
        log.nonsmooth.colliders[below].pose =
            Pose::from_parts(Translation3::identity(), Rotation3::new(Vector3::x() * FRAC_PI_2));
        meet(&mut log, below, 0, friction, 0.0);
        let mut start = State::zero(&log);
        let none = Vector3::zeros();
        let at = Vector3::new(reach * from.sin(), 0.0, reach * from.cos());
        put(&log, &mut start, 0, [at, Vector3::x() * FRAC_PI_2, none, none]);
        let found = run(&log, &start, until, fixed(9, 0.01));
        println!("{friction}: {:?} {:?}", found.events, found.summary.contact);
        let wanted = Vector3::new(reach * angle.sin(), 0.0, reach * angle.cos());
        let off = (centre(&found) - wanted).norm();
        println!("{friction}: {off:e} m after {:e} m", (wanted - at).norm());
        assert!(off < 1e-11, "{friction}: {off:e} m");
    }
}

/// A cylinder whose rim crosses that of a fixed one, as it turns and slides without friction.
fn crossing(steps: StepChoice, until: f64, friction: f64) -> (Mechanism, Finished) {
    let (radius, half) = (0.2, 0.15);
    let mechanism = over(1.0, &Shape::Cylinder { radius, half }, cylinder(), BELOW, friction);
    let mut start = State::zero(&mechanism);
    // Its lower rim, with the axis leaning across the tangent of the other rim.
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.9, 0.2, 0.3));
    let axis = turn * Vector3::z();
    let down = -Vector3::z() - Vector3::x() * 0.8;
    let out = (down - axis * axis.dot(&down)).normalize();
    let at = Vector3::x() * RIM - (out * radius - axis * half);
    let spin = Vector3::new(0.5, 0.3, 1.0);
    // What its point of contact has is along its own tangent, so that nothing is hit.
    let along = axis.cross(&out) * 0.2;
    let velocity = along - spin.cross(&(Vector3::x() * RIM - at));
    put(&mechanism, &mut start, 0, [at, turn.scaled_axis(), velocity, turn.inverse() * spin]);
    println!("distance at the start {:e} m", distance(&mechanism, &start));
    let finished = run(&mechanism, &start, until, steps);
    (mechanism, finished)
}

#[test]
fn rims_that_cross_stay_in_touch_keep_their_energy_and_converge() {
    // The distance is that of the shapes by their own certificate: it knows nothing of the contact that is closed.
    for friction in [0.0, 0.3] {
        let runs = [fixed(9, 0.002), fixed(9, 0.01), StepChoice::Tolerance(1e-10)];
        let runs = runs.map(|steps| crossing(steps, 0.08, friction));
        for (mechanism, finished) in &runs {
            let apart = distance(mechanism, &finished.state);
            println!("{friction}: {apart:e} m, {:?} {:?}", finished.summary, finished.events);
            assert!(apart.abs() <= 1e-12, "{apart:e} m");
            if friction == 0.0 {
                assert!(finished.summary.max_relative_energy_error <= 1e-12, "{:?}", finished.summary);
            }
        }
        let [first, others @ ..] = &runs;
        for (other, bound) in others.iter().zip([1e-11, 1e-9]) {
            let off = (centre(&first.1) - centre(&other.1)).norm();
            println!("{friction}: {off:e} m");
            assert!(off <= bound, "{off:e} m");
        }
    }
}

/// A cylinder that lies flat on a fixed one but for a tilt (rad) about one of the two places where their rims cross, seen from above. It slides along both
/// rims, so that nothing is hit, and its tilt grows first.
fn nearly_flat(steps: StepChoice, tilt: f64, friction: f64) -> (Mechanism, Finished) {
    let (radius, half, beside) = (0.45, 0.15, 0.2);
    let mechanism = over(1.0, &Shape::Cylinder { radius, half }, cylinder(), BELOW, friction);
    let mut start = State::zero(&mechanism);
    let along = (beside * beside + RIM * RIM - radius * radius) / (2.0 * beside);
    let corner = Vector3::new(along, (RIM * RIM - along * along).sqrt(), 0.0);
    let from_other = corner - Vector3::x() * beside;
    // Down towards the middle of what is outside of both.
    let down = (corner / RIM + from_other / radius).normalize();
    let about = Vector3::new(-down.y, down.x, 0.0);
    let turn = UnitQuaternion::from_scaled_axis(about * tilt);
    let at = corner + turn * (Vector3::z() * half - from_other);
    let velocity = (Vector3::z().cross(&corner) + turn * Vector3::z().cross(&from_other)).normalize() * 0.8;
    let spin = about * 0.1;
    put(
        &mechanism,
        &mut start,
        0,
        [at, turn.scaled_axis(), velocity + spin.cross(&(at - corner)), turn.inverse() * spin],
    );
    println!("distance at the start {:e} m", distance(&mechanism, &start));
    let finished = run(&mechanism, &start, 0.012, steps);
    (mechanism, finished)
}

#[test]
fn discs_that_are_nearly_flat_on_each_other_stay_in_touch_where_their_rims_cross() {
    // As above. Flatter than a milliradian neither rim has a certain place in the plane of the other.
    for (tilt, friction) in [(5e-4, 0.0), (5e-4, 0.3), (5e-5, 0.0)] {
        let runs = [fixed(9, 5e-5), fixed(9, 2e-4), StepChoice::Tolerance(1e-10)];
        let runs = runs.map(|steps| nearly_flat(steps, tilt, friction));
        // The last keeps to its tolerance.
        for ((mechanism, finished), most) in runs.iter().zip([1e-12, 1e-12, 1e-10]) {
            let apart = distance(mechanism, &finished.state);
            println!("{tilt}, {friction}: {apart:e} m, {:?} {:?}", finished.summary, finished.events);
            assert!(apart.abs() <= 1e-12, "{apart:e} m");
            if friction == 0.0 {
                assert!(finished.summary.max_relative_energy_error <= most, "{:?}", finished.summary);
            }
            let [place] = &finished.contacts[..] else { panic!("{:?}", finished.contacts) };
            assert!(place.gap.abs() <= 1e-15, "{place:?}");
        }
        let [first, others @ ..] = &runs;
        for other in others {
            let off = (centre(&first.1) - centre(&other.1)).norm();
            println!("{off:e} m");
            assert!(off <= 1e-10, "{off:e} m");
        }
    }
}
