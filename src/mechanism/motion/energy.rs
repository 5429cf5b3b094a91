//! Energy, momentum and constraint error of a maximal-coordinate state: the checks of every run.
//!
//! ```text
//!     T = Σ ½ m |v|² + ½ ωᵀ R J Rᵀ ω  [J]         V = −Σ m gᵀ x  [J]
//!     p = Σ m v  [kg m/s]                          L = Σ x × m v + R J Rᵀ ω  [kg m²/s], about the world origin
//! ```
//!
//! Springs and loads with a potential add theirs ([`crate::description::forces`]).

use crate::description::body_state::{BodyState, WORLD};
use crate::description::joint::FreeRotation;
use crate::description::mechanism::Mechanism;
use crate::forces::total::stored;
use crate::ground::matrices::{column, product, times, transpose_times};
use crate::motion::gaps::{loop_gaps, mimic_gap, touch_gaps, worse};
use crate::motion::state::State;
use nalgebra::Vector3;

/// Kinetic energy, and the potential energies by what holds them (J).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Kinetic energy.
    pub kinetic: f64,
    /// Potential energy of gravity, zero for all centres of mass at the world origin.
    pub potential: f64,
    /// Energy stored in springs.
    pub spring: f64,
    /// Potential energy of constant forces and efforts.
    pub load: f64,
}

impl Energy {
    /// The sum of all.
    #[inline]
    pub fn total(&self) -> f64 {
        self.kinetic + self.potential + self.spring + self.load
    }
}

/// Largest violation of any joint, loop or mimic relation, at position and at velocity level.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Violation {
    /// Largest component of g(q): m for gaps, sines of angles for misalignments, m or rad for mimic relations.
    pub position: f64,
    /// Largest component of Dg(q) q̇, in m/s and rad/s.
    pub velocity: f64,
}

/// Angular momentum of one body about its centre of mass, in the world.
fn spin(inertia: &Vector3<f64>, body: &BodyState) -> Vector3<f64> {
    times(&body.rotation, &inertia.component_mul(&transpose_times(&body.rotation, &body.angular_velocity)))
}

/// The energy that the bodies have by themselves, under gravity: without springs and loads.
#[inline]
pub fn energy(mechanism: &Mechanism, bodies: &[BodyState]) -> Energy {
    let mut energy = Energy::default();
    for (body, state) in mechanism.bodies.iter().zip(bodies) {
        energy.kinetic += 0.5 * body.mass * state.velocity.norm_squared()
            + 0.5 * state.angular_velocity.dot(&spin(&body.inertia, state));
        energy.potential -= body.mass * mechanism.gravity.dot(&state.position);
    }
    energy
}

/// The energy of bodies, springs and loads at joint positions, which place the bodies.
#[inline]
pub fn energy_with_forces(mechanism: &Mechanism, position: &[f64], bodies: &[BodyState]) -> Energy {
    let stored = stored(mechanism, position, bodies);
    Energy { spring: stored.spring, load: stored.load, ..energy(mechanism, bodies) }
}

/// Linear momentum, and angular momentum about the world origin.
pub fn momentum(mechanism: &Mechanism, bodies: &[BodyState]) -> (Vector3<f64>, Vector3<f64>) {
    let mut linear = Vector3::zeros();
    let mut angular = Vector3::zeros();
    for (body, state) in mechanism.bodies.iter().zip(bodies) {
        linear += body.mass * state.velocity;
        angular += body.mass * state.position.cross(&state.velocity) + spin(&body.inertia, state);
    }
    (linear, angular)
}

/// How far a state is from satisfying its joints, loops, mimic relations and `RᵀR = 1`. All but mimic relations, which only the
/// joint coordinates know, are measured on the maximal coordinates alone.
#[inline]
pub fn violation(mechanism: &Mechanism, state: &State, bodies: &[BodyState]) -> Violation {
    let mut worst = Violation::default();
    let mut see = |position: f64, velocity: f64| {
        worst.position = worse(worst.position, position.abs());
        worst.velocity = worse(worst.velocity, velocity.abs());
    };
    for (body, here) in mechanism.bodies.iter().zip(bodies) {
        let parent = body.parent.map_or(WORLD, |parent| bodies[parent]);
        let joint = &body.joint;
        let frame_p = product(&parent.rotation, joint.on_parent.rotation.matrix());
        let frame_c = product(&here.rotation, joint.on_child.rotation.matrix());
        let arm_p = times(&parent.rotation, &joint.on_parent.translation.vector);
        let arm_c = times(&here.rotation, &joint.on_child.translation.vector);
        let gap = here.position + arm_c - parent.position - arm_p;
        let gap_rate = here.velocity + here.angular_velocity.cross(&arm_c)
            - parent.velocity
            - parent.angular_velocity.cross(&(arm_p + gap));
        let relative_spin = here.angular_velocity - parent.angular_velocity;
        for axis in (0..3).filter(|axis| !joint.kind.translation_axes().contains(axis)) {
            let direction = column(&frame_p, axis);
            see(direction.dot(&gap), direction.dot(&gap_rate));
        }
        // Each pair (i, j) asks e_i(parent) · e_j(child) = 0; the rate is −(e_i × e_j) · (ω − ω_p).
        let perpendicular: &[(usize, usize)] = match joint.kind.rotation() {
            FreeRotation::None => &[(0, 1), (1, 2), (2, 0)],
            FreeRotation::AboutZ => &[(0, 2), (1, 2)],
            FreeRotation::Ball => &[],
        };
        for &(on_parent, on_child) in perpendicular {
            let (first, second) = (column(&frame_p, on_parent), column(&frame_c, on_child));
            see(first.dot(&second), relative_spin.dot(&second.cross(&first)));
        }
        let across = here.rotation.transpose();
        let defect = product(&across, &here.rotation) - nalgebra::Matrix3::identity();
        see(defect.amax(), 0.0);
    }
    for joint in &mechanism.loops {
        let (gap, rate) = loop_gaps(joint, bodies).largest();
        see(gap, rate);
    }
    for joint in &mechanism.touches {
        let (gap, rate) = touch_gaps(joint, bodies).largest();
        see(gap, rate);
    }
    for mimic in &mechanism.mimics {
        let (gap, rate) = mimic_gap(mimic, state);
        see(gap, rate);
    }
    worst
}
