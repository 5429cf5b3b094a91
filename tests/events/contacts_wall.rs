//! A rod that is thrown at a thin wall: it always hits.

use crate::exact::near;
use crate::loose::{DOWN, cuboid, loose, meet, obstacle, put};
use crate::mechanisms::{fixed, of_kind, run_within};
use catena::mechanism::description::contact::Shape;
use catena::mechanism::motion::event::{Event, EventKind};
use catena::mechanism::motion::state::State;
use catena::simulation::{Simulation, SimulationOptions, StepChoice};
use nalgebra::Vector3;

/// A rod of 0.4 m that flies along x, turns about z, and starts 1 m before a wall 10 mm thick.
fn against_a_wall(speed: f64, spin: f64, steps: f64) -> Result<(f64, f64, Vec<Event>), String> {
    let mut rod = loose(Vector3::zeros(), &[(1.0, Shape::Capsule { radius: 0.01, half: 0.19 })]);
    let wall = obstacle(&mut rod, cuboid(0.005, 5.0, 5.0), Vector3::zeros());
    meet(&mut rod, wall, 0, 0.3, 0.5);
    let mut start = State::zero(&rod);
    // It lies along x and turns about z, which is its own −x.
    let turned = Vector3::y() * std::f64::consts::FRAC_PI_2;
    put(&rod, &mut start, 0, [-Vector3::x(), turned, Vector3::x() * speed, -Vector3::x() * spin]);
    let duration = 1.5 / speed;
    let options = SimulationOptions::new(duration, fixed(5, steps));
    let mut simulation = Simulation::new(&rod, start, options).map_err(|error| error.to_string())?;
    simulation.run().map_err(|error| error.to_string())?;
    let finished = simulation.finish();
    let impacts = of_kind(&finished, EventKind::ContactImpact);
    Ok((finished.state.position[0], finished.summary.contact.penetration, impacts))
}

#[test]
fn a_spinning_rod_never_gets_through_a_thin_wall() {
    let mut failed = Vec::new();
    for speed in [2.0, 20.0] {
        for spin in [0.0, 1.0, 7.0, 30.0, 80.0, 200.0] {
            for step in [0.01, 0.03, 0.1, 0.5] {
                match against_a_wall(speed, spin, step) {
                    Ok((x, depth, impacts)) => {
                        println!(
                            "{speed} m/s, {spin} rad/s, {step} s: {} impacts, x {x}, depth {depth:e}",
                            impacts.len()
                        );
                        if impacts.is_empty() || x > -0.015 + 1e-12 || depth > 1e-12 {
                            failed
                                .push(format!("{speed} m/s, {spin} rad/s, {step} s: {x} m, {depth:e} m, {impacts:?}"));
                        }
                    }
                    Err(error) => failed.push(format!("{speed} m/s, {spin} rad/s, {step} s: {error}")),
                }
            }
        }
    }
    assert!(failed.is_empty(), "{} failed:\n{}", failed.len(), failed.join("\n"));
}

#[test]
fn a_rod_that_flies_end_first_hits_a_thin_wall_when_it_is_there() {
    for (speed, step) in [(2.0, 0.5), (20.0, 0.5), (20.0, 0.003)] {
        let (_, _, impacts) = against_a_wall(speed, 0.0, step).expect("a run");
        near(impacts[0].time, (1.0 - 0.2 - 0.005) / speed, 1e-12);
    }
}

#[test]
fn a_ball_that_has_hit_a_wall_without_rebound_falls_along_it_as_freely_as_alone() {
    // Nothing presses it against the wall, so that friction holds nothing.
    for friction in [0.0, 0.3, 0.8] {
        let mut ball = loose(DOWN, &[(1.6, Shape::Sphere { radius: 0.1 })]);
        let wall = obstacle(&mut ball, cuboid(0.5, 5.0, 5.0), Vector3::new(-0.5, 0.0, 0.0));
        meet(&mut ball, wall, 0, friction, 0.0);
        let mut start = State::zero(&ball);
        let none = Vector3::zeros();
        put(&ball, &mut start, 0, [Vector3::new(0.1, 0.0, 0.0), none, Vector3::new(-0.7, 0.0, 0.0), none]);
        for steps in [fixed(5, 0.01), StepChoice::Tolerance(1e-6)] {
            let finished = run_within(300, &ball, &start, 0.4, steps);
            let fallen = finished.state.position[2] + 0.5 * 9.81 * 0.16;
            println!("{friction}, {steps:?}: {fallen:e} m, {:?}", finished.summary.contact);
            assert!(fallen.abs() <= 1e-13, "{friction}, {steps:?}: {fallen:e} m off");
            assert!(
                finished.state.velocity[3..].iter().all(|spin| spin.abs() <= 1e-12),
                "{:?}",
                finished.state.velocity
            );
            assert!(finished.summary.contact.cone_violation <= 1e-12, "{:?}", finished.summary.contact);
        }
    }
}
