//! Bodies thrown at random onto a floor with a block on it: no step gains energy, no force leaves its cone, nothing overlaps.

use crate::common::Numbers;
use crate::loose::{DOWN, cuboid, loose, meet, obstacle, put};
use crate::mechanisms::fixed;
use catena::mechanism::description::contact::Shape;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::state::State;
use catena::simulation::{
    Finished, Observer, ObserverError, Sample, Simulation, SimulationOptions, StepChoice, StepEnd,
};
use nalgebra::Vector3;
use std::f64::consts::PI;

/// A box, a cylinder, a ball or a capsule of any size, friction and restitution, thrown from a metre above the floor. A fourth of the throws have two
/// bodies.
fn thrown(seed: u64) -> (Mechanism, State) {
    let mut random = Numbers::new(1000 + seed);
    let bodies = if seed.is_multiple_of(4) { 2 } else { 1 };
    let shapes: Vec<(f64, Shape)> = (0..bodies)
        .map(|body| {
            let mut size = || random.next(0.05, 0.3);
            let shape = match (seed + body) % 4 {
                0 => cuboid(size(), size(), size()),
                1 => Shape::Cylinder { radius: size(), half: size() },
                2 => Shape::Sphere { radius: size() },
                _ => Shape::Capsule { radius: size(), half: size() },
            };
            (random.next(0.5, 5.0), shape)
        })
        .collect();
    let mut mechanism = loose(DOWN, &shapes);
    let (friction, restitution) = (random.next(0.0, 1.0), random.next(0.0, 1.0));
    let floor = obstacle(&mut mechanism, Shape::HalfSpace, Vector3::zeros());
    let block = obstacle(&mut mechanism, cuboid(0.4, 0.4, 0.1), Vector3::new(0.5, 0.0, 0.1));
    for body in 0..shapes.len() {
        meet(&mut mechanism, floor, body, friction, restitution);
        meet(&mut mechanism, block, body, friction, restitution);
        (body + 1..shapes.len()).for_each(|other| meet(&mut mechanism, body, other, friction, restitution));
    }
    let mut start = State::zero(&mechanism);
    for body in 0..shapes.len() {
        let mut any = |most: f64| Vector3::from_fn(|_, _| random.next(-most, most));
        let (turned, velocity, spin) = (any(PI), any(2.0), any(6.0));
        let at = Vector3::new(0.0, 0.0, 1.0 + 1.5 * body as f64);
        put(&mechanism, &mut start, body, [at, turned, velocity, spin]);
    }
    (mechanism, start)
}

/// The largest rise of the energy in a step, over what roundings of positions may be in a step of its length.
#[derive(Default)]
struct Rises {
    before: Option<f64>,
    /// Over the bound, with the time (s), the length of the step (s), and the rise over the largest energy.
    largest: (f64, f64, f64, f64),
    scale: f64,
}

/// A gap, or a length of a metre, is known to 1e-16 m. In a step of length h that is a velocity of 1e-16 m / h; of bodies with some metres a second
/// and ten times the rounding it is this part of their energy.
const OF_POSITIONS: f64 = 1e-15;
/// The energy itself is the sum of terms that are rounded, some of them a hundred times.
const OF_ENERGY: f64 = 1e-14;

impl Observer for Rises {
    fn sample(&mut self, _: &Sample) -> Result<(), ObserverError> {
        Ok(())
    }

    fn step(&mut self, end: &StepEnd) {
        let (energy, step) = (end.energy.total(), end.outcome.step);
        self.scale = self.scale.max(energy);
        if let Some(before) = self.before {
            let rise = (energy - before) / self.scale;
            // At an event without a step the velocities alone change.
            let bound = OF_ENERGY + if step > 0.0 { OF_POSITIONS / step } else { 0.0 };
            if rise / bound > self.largest.0 {
                self.largest = (rise / bound, end.time, step, rise);
            }
        }
        self.before = Some(energy);
    }
}

fn throw(seed: u64, steps: StepChoice) -> (Finished, Rises) {
    let (mechanism, start) = thrown(seed);
    let mut rises = Rises::default();
    let options = SimulationOptions::new(1.5, steps);
    let mut simulation = Simulation::new(&mechanism, start, options).expect("a run");
    simulation.observe(&mut rises);
    simulation.run().unwrap_or_else(|error| panic!("throw {seed}: {error}"));
    (simulation.finish(), rises)
}

/// Throws these, and asserts what holds of all.
fn throws(seeds: impl Iterator<Item = u64>) {
    catena::events::check_certificates();
    for seed in seeds {
        let (finished, rises) = throw(seed, fixed(9, 0.01));
        let figures = &finished.summary.contact;
        let (over, time, step, rise) = rises.largest;
        println!("{seed}: {over:.1} of the bound at {time} s, step {step:.1e}, rise {rise:.1e}; {figures:?}");
        assert!(
            over <= 1.0,
            "throw {seed}: the energy rises by {rise:e} of itself at {time} s in a step of {step:e} s"
        );
        assert!(figures.penetration <= 1e-12, "throw {seed}: {figures:?}");
        // Of forces of some ten newtons, and a hundred in throws that wedge.
        assert!(figures.cone_violation <= 1e-10, "throw {seed}: {figures:?}");
    }
}

#[test]
fn no_body_that_is_thrown_gains_energy_or_leaves_its_cone_or_overlaps() {
    // In the 68th the edge of a box comes down flat on the cap of a cylinder and slides over its rim; in the 16th corners of a box that slides stop one
    // after the other.
    throws((0..40).filter(|seed| seed % 4 != 0).chain([16, 68]));
}

#[test]
#[ignore = "a minute: cargo test --release --test events thrown -- --ignored --nocapture"]
fn neither_do_more_that_are_thrown_and_pairs_of_them() {
    throws(0..100);
}
