//! Runs jointed bodies that touch in Rapier and prints its cost and where they are at some instants, as one line of JSON.
//!
//! `standing SCENE.json STEPS ITERATIONS`, called by `standing_peers.py`, which writes the scene. Feet touch a floor, and without a floor all shapes
//! touch each other. Joints are multibody joints. The clock runs over the stepping loop of the last run alone; bodies never sleep; ITERATIONS are the
//! iterations of the solver.

use anyhow::{Result, bail};
use rapier_runner::jointed::{Jointed, Joints, Scene, pose};
use rapier3d_f64::prelude::*;
use serde::Deserialize;

#[derive(Deserialize)]
struct Touching {
    #[serde(flatten)]
    scene: Scene,
    friction: f64,
    floor: bool,
    /// When places are wanted (s), in order, the last at the end.
    instants: Vec<f64>,
}

/// The bodies with their shapes, and a floor.
fn touching(scene: &Scene, friction: f64, floor: bool) -> Result<Jointed> {
    let mut made = Jointed::new(scene, Joints::Multibody)?;
    let shaped = |collider: ColliderBuilder, group: u32, with: u32| {
        let groups = InteractionGroups::new(
            Group::from_bits_truncate(group),
            Group::from_bits_truncate(with),
            InteractionTestMode::And,
        );
        collider.friction(friction).density(0.0).collision_groups(groups).build()
    };
    if floor {
        let ground = made.world.bodies.insert(RigidBodyBuilder::fixed().translation(Vector::new(0.0, 0.0, -1.0)));
        let shape = shaped(ColliderBuilder::cuboid(100.0, 100.0, 1.0), 2, 1);
        made.world.colliders.insert_with_parent(shape, ground, &mut made.world.bodies);
    }
    for (body, &handle) in scene.bodies.iter().zip(&made.handles) {
        let Some(shape) = &body.shape else { continue };
        let collider = match shape.half {
            Some([x, y, z]) => ColliderBuilder::cuboid(x, y, z),
            None => ColliderBuilder::ball(shape.radius),
        };
        let collider = collider.position(pose(shape.at, shape.quaternion));
        let collider = shaped(collider, 1, if floor { 2 } else { 1 });
        made.world.colliders.insert_with_parent(collider, handle, &mut made.world.bodies);
    }
    Ok(made)
}

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, steps, iterations] = arguments.as_slice() else { bail!("usage: standing SCENE.json STEPS ITERATIONS") };
    let Touching { scene, friction, floor, instants } = serde_json::from_str(&std::fs::read_to_string(file)?)?;
    let (steps, iterations): (usize, usize) = (steps.parse()?, iterations.parse()?);
    let dt = scene.duration / steps as f64;
    let parameters = IntegrationParameters { dt, num_solver_iterations: iterations, ..Default::default() };
    let (mut spent, mut places) = (0.0, Vec::new());
    // Each from the start, because a pipeline that is made anew does not know which bodies move.
    for instant in instants {
        let mut made = touching(&scene, friction, floor)?;
        spent = made.world.step(scene.gravity, &parameters, (instant / dt).round() as usize);
        let of = |handle: &RigidBodyHandle| {
            let at = *made.world.bodies[*handle].position();
            let q = at.rotation;
            serde_json::json!({ "origin": at.translation.to_array(), "quaternion": [q.w, q.x, q.y, q.z] })
        };
        places.push(made.handles.iter().map(of).collect::<Vec<_>>());
    }
    println!("{}", serde_json::json!({ "cpu_seconds": spent, "places": places }));
    Ok(())
}
