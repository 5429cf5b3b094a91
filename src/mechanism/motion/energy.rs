//! Energy, momentum and constraint error of a maximal-coordinate state: the checks of every run.
//!
//! ```text
//!     T = Σ ½ m |v|² + ½ ωᵀ R J Rᵀ ω  [J]         V = −Σ m gᵀ x  [J]
//!     p = Σ m v  [kg m/s]                          L = Σ x × m v + R J Rᵀ ω  [kg m²/s], about the world origin
//! ```
//!
//! Springs and loads with a potential add theirs ([`crate::description::forces`]).

use crate::description::body_state::{BodyState, WORLD};
use crate::description::joint::{FreeRotation, Joint};
use crate::description::mechanism::Mechanism;
use crate::forces::total::stored;
use crate::ground::matrices::{column, cross, dot, product, times, transpose_times};
use crate::motion::gaps::{loop_gaps, mimic_gap, touch_gaps};
use crate::motion::state::State;
use nalgebra::Vector3;

/// Kinetic energy, and the potential energies by their sources (J).
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

/// The rate of a joint with one degree of freedom [rad/s or m/s], from the motion of its two bodies.
fn axial_rate(joint: &Joint, parent: &BodyState, child: &BodyState) -> f64 {
    let spin = child.angular_velocity - parent.angular_velocity;
    if joint.kind.rotation() != FreeRotation::None {
        return dot(&times(&child.rotation, &column(joint.on_child.rotation.matrix(), 2)), &spin);
    }
    let arm = child.position + times(&child.rotation, &joint.on_child.translation.vector) - parent.position;
    let on_child = child.velocity + cross(&child.angular_velocity, &(parent.position + arm - child.position));
    let slip = on_child - parent.velocity - cross(&parent.angular_velocity, &arm);
    dot(&times(&parent.rotation, &column(joint.on_parent.rotation.matrix(), 2)), &slip)
}

/// The energy that the bodies and the rotors of their joints have by themselves, under gravity: without springs and loads.
#[inline]
pub fn energy(mechanism: &Mechanism, bodies: &[BodyState]) -> Energy {
    let mut energy = Energy::default();
    for (body, state) in mechanism.bodies.iter().zip(bodies) {
        energy.kinetic += 0.5 * body.mass * state.velocity.norm_squared()
            + 0.5 * state.angular_velocity.dot(&spin(&body.inertia, state));
        if body.joint.armature != 0.0 {
            let parent = body.parent.map_or(&WORLD, |parent| &bodies[parent]);
            energy.kinetic += 0.5 * body.joint.armature * axial_rate(&body.joint, parent, state).powi(2);
        }
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
    // The bits of nonnegative numbers are in the order of the numbers, and the bits of NaN are beyond all.
    let [mut position, mut velocity] = [0; 2];
    let mut see = |gap: f64, rate: f64| {
        position = gap.abs().to_bits().max(position);
        velocity = rate.abs().to_bits().max(velocity);
    };
    for (body, here) in mechanism.bodies.iter().zip(bodies) {
        let parent = body.parent.map_or(&WORLD, |parent| &bodies[parent]);
        let joint = &body.joint;
        let frame_p = product(&parent.rotation, joint.on_parent.rotation.matrix());
        let arm_p = times(&parent.rotation, &joint.on_parent.translation.vector);
        let arm_c = times(&here.rotation, &joint.on_child.translation.vector);
        let gap = here.position + arm_c - parent.position - arm_p;
        let gap_rate = here.velocity + cross(&here.angular_velocity, &arm_c)
            - parent.velocity
            - cross(&parent.angular_velocity, &(arm_p + gap));
        let relative_spin = here.angular_velocity - parent.angular_velocity;
        for &axis in joint.kind.fixed_axes() {
            let direction = column(&frame_p, axis);
            see(dot(&direction, &gap), dot(&direction, &gap_rate));
        }
        // Each axis e_j of the child asks e_i(parent) · e_j(child) = 0 of these; the rate is −(e_i × e_j) · (ω − ω_p).
        let mut squares = |on_child: usize, on_parent: &[usize]| {
            let second = times(&here.rotation, &column(joint.on_child.rotation.matrix(), on_child));
            for &axis in on_parent {
                let first = column(&frame_p, axis);
                see(dot(&first, &second), dot(&relative_spin, &cross(&second, &first)));
            }
        };
        match joint.kind.rotation() {
            FreeRotation::None => {
                [(1, 0), (2, 1), (0, 2)].into_iter().for_each(|(child, parent)| squares(child, &[parent]))
            }
            FreeRotation::AboutZ => squares(2, &[0, 1]),
            FreeRotation::Ball => {}
        }
        // RᵀR is symmetric to the last bit.
        let [x, y, z] = [0, 1, 2].map(|axis| column(&here.rotation, axis));
        let lengths = [dot(&x, &x) - 1.0, dot(&y, &y) - 1.0, dot(&z, &z) - 1.0];
        for defect in lengths.into_iter().chain([dot(&x, &y), dot(&y, &z), dot(&z, &x)]) {
            see(defect, 0.0);
        }
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
    Violation { position: f64::from_bits(position), velocity: f64::from_bits(velocity) }
}
