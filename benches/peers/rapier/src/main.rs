//! Runs a scene in Rapier and prints its cost and where the bodies are at the end, as one line of JSON.
//!
//! `rapier-runner SCENE.json multibody|impulse STEPS REPEATS`, called by `peer_rapier.py`, which writes the scene. The clock runs over the stepping
//! loop alone and the fastest of the repeats counts. Damping, which Rapier gives to the joints of a multibody by itself, is switched off. The scene
//! has no colliders, and bodies never sleep.

use anyhow::{Result, bail};
use rapier_runner::jointed::{Jointed, Joints, Scene};
use rapier3d_f64::prelude::*;

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, kind, steps, repeats] = arguments.as_slice() else {
        bail!("usage: rapier-runner SCENE.json multibody|impulse STEPS REPEATS")
    };
    let scene: Scene = serde_json::from_str(&std::fs::read_to_string(file)?)?;
    let joints = match kind.as_str() {
        "multibody" => Joints::Multibody,
        "impulse" => Joints::Impulse,
        other => bail!("{other} is neither multibody nor impulse"),
    };
    let (steps, repeats): (usize, usize) = (steps.parse()?, repeats.parse()?);
    let parameters = IntegrationParameters { dt: scene.duration / steps as f64, ..Default::default() };
    let mut fastest = f64::INFINITY;
    let mut ends = Vec::new();
    for _ in 0..repeats.max(1) {
        let mut made = Jointed::new(&scene, joints)?;
        fastest = fastest.min(made.world.step(scene.gravity, &parameters, steps));
        ends = made
            .handles
            .iter()
            .map(|&handle| {
                let end = *made.world.bodies[handle].position();
                let q = end.rotation;
                serde_json::json!({ "origin": end.translation.to_array(), "quaternion": [q.w, q.x, q.y, q.z] })
            })
            .collect();
    }
    println!("{}", serde_json::json!({ "cpu_seconds": fastest, "bodies": ends }));
    Ok(())
}
