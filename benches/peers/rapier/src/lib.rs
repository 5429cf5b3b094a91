//! The stepping loop of Rapier and its cost, which both programs time.

pub mod jointed;

use cpu_time::ThreadTime;
use rapier3d_f64::prelude::*;

/// The bodies and joints that Rapier moves.
#[derive(Default)]
pub struct World {
    pub bodies: RigidBodySet,
    pub colliders: ColliderSet,
    pub impulse_joints: ImpulseJointSet,
    pub multibody_joints: MultibodyJointSet,
}

impl World {
    /// Makes `steps` steps; CPU time of the loop [s].
    pub fn step(&mut self, gravity: [f64; 3], parameters: &IntegrationParameters, steps: usize) -> f64 {
        let gravity = Vector::from_array(gravity);
        let (mut pipeline, mut islands) = (PhysicsPipeline::new(), IslandManager::new());
        let (mut broad_phase, mut narrow_phase) = (BroadPhaseBvh::new(), NarrowPhase::new());
        let (mut soft_bodies, mut ccd_solver) = (SoftBodySet::default(), CCDSolver::new());
        let clock = ThreadTime::now();
        for _ in 0..steps {
            pipeline.step(
                gravity,
                parameters,
                &mut islands,
                &mut broad_phase,
                &mut narrow_phase,
                &mut self.bodies,
                &mut self.colliders,
                &mut self.impulse_joints,
                &mut self.multibody_joints,
                &mut soft_bodies,
                &mut ccd_solver,
                &(),
                &(),
            );
        }
        clock.elapsed().as_secs_f64()
    }
}
