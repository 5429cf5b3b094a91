//! Runs free bodies on a level floor in Rapier and prints its cost and where they are at the end, as one line of JSON.
//!
//! `contacts SCENE.json STEPS REPEATS ITERATIONS`, called by `contact_peers.py`, which writes the scene. The clock runs over the stepping loop alone
//! and the fastest of the repeats counts. Bodies may sleep, as they do by default; ITERATIONS are the iterations of the solver (4 by default).

use anyhow::{Result, bail};
use rapier_runner::World;
use rapier3d_f64::prelude::*;
use serde::Deserialize;

#[derive(Deserialize)]
struct Scene {
    duration: f64,
    gravity: [f64; 3],
    friction: f64,
    restitution: f64,
    bodies: Vec<Body>,
}

#[derive(Deserialize)]
struct Body {
    mass: f64,
    /// Principal moments of inertia, along the axes of the body [kg m²].
    inertia: [f64; 3],
    /// Half sizes of a box (m); a ball has `radius` instead.
    half: Option<[f64; 3]>,
    radius: Option<f64>,
    position: [f64; 3],
    velocity: [f64; 3],
    spin: [f64; 3],
}

fn run(scene: &Scene, steps: usize, iterations: usize) -> Result<(f64, Vec<[f64; 3]>)> {
    let (mut bodies, mut colliders) = (RigidBodySet::new(), ColliderSet::new());
    let touching = |collider: ColliderBuilder| {
        collider.friction(scene.friction).restitution(scene.restitution).density(0.0).build()
    };
    // The top of a floor that is far larger than the motion.
    let floor = bodies.insert(RigidBodyBuilder::fixed().translation(Vector::new(0.0, 0.0, -1.0)));
    colliders.insert_with_parent(touching(ColliderBuilder::cuboid(100.0, 100.0, 1.0)), floor, &mut bodies);
    let mut handles = Vec::new();
    for body in &scene.bodies {
        let mass = MassProperties::with_principal_inertia_frame(
            Vector::ZERO,
            body.mass,
            Vector::from_array(body.inertia),
            Rotation::IDENTITY,
        );
        let rigid = RigidBodyBuilder::dynamic()
            .translation(Vector::from_array(body.position))
            .linvel(Vector::from_array(body.velocity))
            .angvel(Vector::from_array(body.spin))
            .additional_mass_properties(mass);
        let handle = bodies.insert(rigid);
        let shape = match (body.half, body.radius) {
            (Some([x, y, z]), None) => ColliderBuilder::cuboid(x, y, z),
            (None, Some(radius)) => ColliderBuilder::ball(radius),
            _ => bail!("a body is a box or a ball"),
        };
        colliders.insert_with_parent(touching(shape), handle, &mut bodies);
        handles.push(handle);
    }
    let parameters = IntegrationParameters {
        dt: scene.duration / steps as f64,
        num_solver_iterations: iterations,
        ..Default::default()
    };
    let mut world = World { bodies, colliders, ..World::default() };
    let spent = world.step(scene.gravity, &parameters, steps);
    Ok((spent, handles.iter().map(|&handle| world.bodies[handle].translation().to_array()).collect()))
}

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, steps, repeats, iterations] = arguments.as_slice() else {
        bail!("usage: contacts SCENE.json STEPS REPEATS ITERATIONS")
    };
    let scene: Scene = serde_json::from_str(&std::fs::read_to_string(file)?)?;
    let (steps, repeats, iterations) = (steps.parse()?, repeats.parse::<usize>()?, iterations.parse()?);
    let (mut fastest, mut places) = run(&scene, steps, iterations)?;
    for _ in 1..repeats {
        let again = run(&scene, steps, iterations)?;
        fastest = fastest.min(again.0);
        places = again.1;
    }
    println!("{}", serde_json::json!({ "cpu_seconds": fastest, "places": places }));
    Ok(())
}
