//! Stiffness and damping of MJCF that follow from inertia at the start.
//!
//! The inertia of a joint at the start, with all joints at their references and the others free to move, is
//!
//! ```text
//!     M_j = 1/(M⁻¹)_jj,   M = Σ (m Jᵥᵀ Jᵥ + J_ωᵀ I J_ω) + diag(armature)         [kg m²] of a hinge, [kg] of a slide
//!     springdamper = (t, ζ):   k = M_j/(t² ζ²),   d = 2 M_j/t                    in the joint
//!     dampratio = ζ:           kv = 2 ζ √(kp Σ M_j/G_j²)                         of an actuator on joints j with the gears G_j
//! ```
//!
//! with each link's mass m (kg), its inertia I about its centre of mass (kg m²) and the Jacobians of that centre's velocity and of its spin. The axes of a
//! free base and of a ball joint are x, y and z; a ball joint has the harmonic mean of its three.
//!
//! Source: MuJoCo documentation, XML reference, `joint/springdamper` and `actuator/position/dampratio`, and what MuJoCo 4.0 computes.

use crate::scene::mjcf_reading::parts::{Joint, Tree};
use crate::scene::mjcf_reading::reader::Reader;
use crate::scene::mjcf_reading::tree::Element;
use crate::scene::robot::{Pose, UrdfJointKind};
use nalgebra::{DMatrix, Matrix3xX, Vector3};
use std::collections::HashMap;

/// A way to move: about an axis through a point (m), or along it.
#[derive(Clone, Copy)]
struct Freedom {
    axis: Vector3<f64>,
    through: Option<Vector3<f64>>,
    armature: f64,
}

impl Tree {
    /// The inertia of a joint at the start [kg m² or kg]; `None` if something moves without a mass. All masses are known by then.
    fn inertia_at_start(&self, joint: &str) -> Option<f64> {
        self.inertias.get_or_init(|| self.inertias_at_start()).get(joint).copied()
    }

    fn inertias_at_start(&self) -> HashMap<String, f64> {
        let mut freedoms: Vec<Freedom> = Vec::new();
        // Its pose in the tree, and the freedoms that move it.
        let mut placed: HashMap<&str, (Pose, Vec<usize>)> = HashMap::new();
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        if self.floats {
            let base = |through| axes.map(|axis| Freedom { axis, through, armature: 0.0 });
            freedoms.extend(base(None).into_iter().chain(base(Some(Vector3::zeros()))));
        }
        let base = self.links.iter().find(|link| !self.joints.iter().any(|(between, _)| between.child == link.name));
        if let Some(base) = base {
            placed.insert(&base.name, (Pose::identity(), (0..freedoms.len()).collect()));
        }
        let mut own_freedoms: Vec<(&str, std::ops::Range<usize>)> = Vec::new();
        // Parents come before their children.
        for (between, joint) in &self.joints {
            let (parent, mut moving) = placed.get(between.parent.as_str()).cloned().unwrap_or_default();
            let pose = parent * between.origin;
            let first = freedoms.len();
            if let Some(joint) = joint {
                let through = Some(pose.translation.vector);
                let along = |axis: Vector3<f64>, through| Freedom {
                    axis: pose.rotation * axis,
                    through,
                    armature: joint.armature,
                };
                match joint.kind {
                    UrdfJointKind::Prismatic => freedoms.push(along(joint.axis, None)),
                    UrdfJointKind::Spherical => freedoms.extend(axes.map(|axis| along(axis, through))),
                    _ => freedoms.push(along(joint.axis, through)),
                }
                own_freedoms.push((&joint.name, first..freedoms.len()));
            }
            moving.extend(first..freedoms.len());
            placed.insert(&between.child, (pose, moving));
        }
        let mut masses = DMatrix::zeros(freedoms.len(), freedoms.len());
        freedoms.iter().enumerate().for_each(|(index, freedom)| masses[(index, index)] = freedom.armature);
        for link in &self.links {
            let (Some((pose, moving)), Some(of)) = (placed.get(link.name.as_str()), &link.mass) else { continue };
            let frame = pose * of.frame;
            let inertia = frame.rotation * of.inertia * frame.rotation.inverse();
            let center = frame.translation.vector;
            let spin = |&index: &usize| freedoms[index].through.map_or(Vector3::zeros(), |_| freedoms[index].axis);
            let velocity = |&index: &usize| {
                let Freedom { axis, through, .. } = freedoms[index];
                through.map_or(axis, |point| axis.cross(&(center - point)))
            };
            let spins = Matrix3xX::from_columns(&moving.iter().map(spin).collect::<Vec<_>>());
            let velocities = Matrix3xX::from_columns(&moving.iter().map(velocity).collect::<Vec<_>>());
            let own = of.mass * velocities.transpose() * &velocities + spins.transpose() * inertia * &spins;
            for (row, &at) in moving.iter().enumerate() {
                for (column, &other) in moving.iter().enumerate() {
                    masses[(at, other)] += own[(row, column)];
                }
            }
        }
        let Some(inverse) = masses.cholesky().map(|factor| factor.inverse()) else { return HashMap::new() };
        let inertia = |range: std::ops::Range<usize>| {
            range.len() as f64 / range.map(|index| inverse[(index, index)]).sum::<f64>()
        };
        own_freedoms.into_iter().map(|(name, range)| (name.to_string(), inertia(range))).collect()
    }
}

impl Reader<'_> {
    /// Gives joints with a time constant and a damping ratio their stiffness and damping.
    pub fn tune_joints(&mut self) {
        for tree in &mut self.trees {
            for at in 0..tree.joints.len() {
                let tuned = |joint: &Joint| Some((joint.spring_damper?, tree.inertia_at_start(&joint.name)?));
                let tuned = tree.joints[at].1.as_ref().and_then(tuned);
                if let (Some(joint), Some(([time, ratio, rest], inertia))) = (&mut tree.joints[at].1, tuned) {
                    joint.spring = Some((inertia / (time * ratio).powi(2), rest));
                    joint.damping = 2.0 * inertia / time;
                }
            }
        }
    }

    /// The damping kv of an actuator of the stiffness kp with a damping ratio, on joints with gears; zero with a warning if a joint moves no mass.
    pub fn damping_of_ratio(&mut self, actuator: &Element, kp: f64, ratio: f64, joints: &[(&str, f64)]) -> f64 {
        let inertia = |&(joint, gear): &(&str, f64)| {
            let (tree, _) = self.references.get(joint)?;
            Some(self.trees[*tree].inertia_at_start(joint)? / (gear * gear))
        };
        let geared = joints.iter().filter(|(_, gear)| *gear != 0.0);
        match geared.map(inertia).sum::<Option<f64>>() {
            Some(sum) => 2.0 * ratio * (kp * sum).sqrt(),
            None => {
                self.not_simulated(
                    actuator,
                    "a damping ratio of a joint that moves no mass is not simulated".to_string(),
                );
                0.0
            }
        }
    }
}
