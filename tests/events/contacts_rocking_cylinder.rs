//! A cylinder that rocks in a plane from one point of its rim to the opposite one, as a block does from edge to edge (Housner).

use crate::exact::near;
use crate::loose::{DOWN, cuboid, loose, meet, obstacle, on_floor, put, solid};
use crate::mechanisms::{GRAVITY, of_kind, run};
use crate::scene_files::{report, scene_of};
use catena::mechanism::description::contact::Shape;
use catena::mechanism::motion::event::EventKind;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::simulation::StepChoice;
use nalgebra::{Rotation3, Vector3};

/// m, m, kg.
const RADIUS: f64 = 0.05;
const HALF: f64 = 0.15;
const MASS: f64 = 1.3;

/// The moment of inertia about a point of the rim, square to the plane of the motion (kg m²), with the part of ω that an impact leaves: the angular
/// momentum about the new point before it is `(J − 2 m r²) ω`, because the centre of mass moves down by r ω at the distance r from that point.
fn moment_and_ratio() -> (f64, f64) {
    let about = solid(MASS, &Shape::Cylinder { radius: RADIUS, half: HALF }).x;
    let moment = about + MASS * (RADIUS * RADIUS + HALF * HALF);
    (moment, 1.0 - 2.0 * MASS * RADIUS * RADIUS / moment)
}

/// The time from the tilt θ₀ at rest until it is flat (s), and ω then: `J ω²/2 = m g (h(θ₀) − h(θ))` with `h = r sin θ + H cos θ`. With
/// `θ = θ₀ (1 − s²)` the integrand `dθ/ω` is smooth; Simpson's rule.
fn fall(tilt: f64) -> (f64, f64) {
    let (moment, _) = moment_and_ratio();
    // h(θ₀) − h(θ) without cancellation.
    let below = |angle: f64| {
        let (middle, half) = (0.5 * (tilt + angle), 0.5 * (tilt - angle));
        2.0 * half.sin() * (RADIUS * middle.cos() - HALF * middle.sin())
    };
    let rate = |angle: f64| (2.0 * MASS * GRAVITY * below(angle) / moment).sqrt();
    let slope = |s: f64| {
        let first = RADIUS * tilt.cos() - HALF * tilt.sin();
        let start = 2.0 * tilt / (2.0 * MASS * GRAVITY * tilt * first / moment).sqrt();
        if s == 0.0 { start } else { 2.0 * tilt * s / rate(tilt * (1.0 - s * s)) }
    };
    let count = 2000;
    let weight = |i: i32| if i == 0 || i == count { 1.0 } else { 2.0 + 2.0 * f64::from(i % 2) };
    let sum: f64 = (0..=count).map(|i| weight(i) * slope(f64::from(i) / f64::from(count))).sum();
    (sum / (3.0 * f64::from(count)), rate(0.0))
}

/// The tilt that a cylinder reaches which is flat with this ω: by bisection.
fn rises(rate: f64) -> f64 {
    let (mut low, mut high) = (0.0, (RADIUS / HALF).atan());
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if fall(middle).1 < rate { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[test]
fn a_cylinder_that_rocks_in_a_plane_lands_on_the_opposite_point_of_its_rim_when_and_as_fast_as_housner_says() {
    let (tilt, shape) = (0.15, Shape::Cylinder { radius: RADIUS, half: HALF });
    let (_, ratio) = moment_and_ratio();
    // In the direction of a point that stands for a flat rim, and between them.
    for (azimuth, on_box) in [(0.0_f64, false), (0.3, false), (2.0, false), (0.0, true), (0.3, true)] {
        let mut mechanism = loose(DOWN, &[(MASS, shape.clone())]);
        if on_box {
            let below = obstacle(&mut mechanism, cuboid(0.4, 0.4, 0.1), Vector3::new(0.0, 0.0, -0.1));
            meet(&mut mechanism, below, 0, 0.8, 0.0);
        } else {
            on_floor(&mut mechanism, 0.8, 0.0);
        }
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), azimuth)
            * Rotation3::from_axis_angle(&Vector3::y_axis(), tilt)
            * Rotation3::from_axis_angle(&Vector3::z_axis(), -azimuth);
        let mut start = State::zero(&mechanism);
        let height = Vector3::z() * (RADIUS * tilt.sin() + HALF * tilt.cos());
        put(&mechanism, &mut start, 0, [height, turn.scaled_axis(), Vector3::zeros(), Vector3::zeros()]);
        let found = run(&mechanism, &start, 4.0, StepChoice::Tolerance(1e-9));
        let impacts = of_kind(&found, EventKind::ContactImpact);
        println!("{azimuth}: {:?} {:?}", found.events, found.summary);
        let (until, mut rate) = fall(tilt);
        let mut time = until;
        for impact in &impacts[..6] {
            // Each impact closes gaps of 1e-13 of its size, which is as much in its energy.
            near(impact.time, time, 1e-10);
            // The centre of mass falls with r ω⁻, and rises with r ω⁺.
            near(impact.impulse.expect("an impulse") / (MASS * RADIUS * rate * (1.0 + ratio)), 1.0, 1e-9);
            rate *= ratio;
            time += 2.0 * fall(rises(rate)).0;
        }
        let end = &body_states(&mechanism, &found.state)[0];
        // It stands.
        assert!(end.angular_velocity.norm() == 0.0 && end.velocity.norm() == 0.0, "{end:?}");
        near(end.position.z, HALF, 1e-10);
        // Closing gaps gains nothing: where it did, small bounces lived on it, 1.5e-10 and more.
        assert!(found.summary.max_relative_energy_error <= 5e-11, "{:?}", found.summary);
        assert!(found.summary.contact.penetration <= 1e-11, "{:?}", found.summary.contact);
    }
}

/// A plate on a hinge about y, its upper face at the height of the hinge.
const PLATE: &str = "<link name='base'/><link name='plate'><inertial><mass value='3'/>\
    <inertia ixx='0.05' iyy='0.2' izz='0.25' ixy='0' ixz='0' iyz='0'/></inertial>\
    <collision><origin xyz='0 0 -0.02'/><geometry><box size='1 0.6 0.04'/></geometry></collision></link>\
    <joint name='tilts' type='continuous'><parent link='base'/><child link='plate'/><axis xyz='0 1 0'/></joint>";

/// Its flights became as low as the gap at which shapes count as closed, and no lower: each impact came late by that gap, and gave back what it took.
#[test]
fn a_can_a_rounding_above_a_plate_that_begins_to_tilt_stops_rocking_and_turns_with_it() {
    let (aside, height, duration) = (-0.01, 0.3, 0.02);
    let text = format!(
        "[[robot]]\nurdf = \"robot.urdf\"\n[[motion]]\njoint = \"tilts\"\nposition = {{ formula = \"a*(1-cos(w*t))\", a = 0.05, w = 3 }}\n\
         [[body]]\nname = \"can\"\nshape = {{ type = \"cylinder\", radius = 0.06, length = 0.6 }}\nmass = 2\n\
         pose = {{ position = [{aside}, 0, 0.300000002] }}\n[contact]\npairs = \"all\"\nfriction = 0.8\n"
    );
    let end = report(&scene_of("can_on_plate", PLATE, &text), &[], &[], Some(duration), 1e-9);
    // Each impact leaves 0.95 of the rate before; the first one is of 2e-5 m/s, and flights of 1e-6 m/s are too low to be seen.
    assert!(end.events.counts.total() < 100, "{:?}", end.events.counts);
    assert!(end.accuracy.as_ref().is_some_and(|accuracy| accuracy.reached), "{:?}", end.accuracy);
    let (sine, cosine) = (0.05 * (1.0 - (3.0 * duration).cos())).sin_cos();
    let can = end.links.iter().find(|(name, _)| name == "can").expect("the can").1.position;
    near(can[0], aside * cosine + height * sine, 1e-9);
    near(can[2], height * cosine - aside * sine, 1e-9);
}
