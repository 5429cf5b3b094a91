//! How far two states of a mechanism are apart: one length that sees translation and rotation.
//!
//! Every body is probed at four points: its centre of mass `x`, and the tips of its axes at the distance at which the
//! mass sits on average,
//!
//! ```text
//!     x,   x + ρ R e₁,   x + ρ R e₂,   x + ρ R e₃          ρ = √( tr(J) / (2 m) ) = √( ∫ r² dm / m )       [m]
//! ```
//!
//! and the distance is the largest over all probes of all bodies (m). The centre of mass alone would not see a body
//! that only spins; a rotation error of δ rad counts as about ρ δ metres.

use crate::description::body_state::BodyState;
use crate::description::mechanism::Mechanism;
use crate::motion::kinematics::body_states;
use crate::motion::state::State;
use nalgebra::Vector3;

/// Probes of one body.
pub const PROBES: usize = 4;

/// The probes of all bodies, in the world (m), [`PROBES`] to a body.
pub fn probes(mechanism: &Mechanism, state: &State) -> Vec<Vector3<f64>> {
    probes_of_bodies(mechanism, &body_states(mechanism, state))
}

/// The probes of bodies wherever they are, whether their joints hold or not (m).
pub fn probes_of_bodies(mechanism: &Mechanism, bodies: &[BodyState]) -> Vec<Vector3<f64>> {
    let mut probes = Vec::with_capacity(PROBES * mechanism.bodies.len());
    for (body, pose) in mechanism.bodies.iter().zip(bodies) {
        // A body without mass has no size that would matter.
        let radius = if body.mass > 0.0 { (0.5 * body.inertia.sum() / body.mass).sqrt() } else { 0.0 };
        probes.push(pose.position);
        probes.extend(pose.rotation.column_iter().map(|axis| pose.position + radius * axis));
    }
    probes
}

/// The largest distance between corresponding probes (m); NaN if any of them is not finite.
pub fn distance(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    let distances = a.iter().zip(b).map(|(a, b)| (a - b).norm());
    distances.fold(0.0, |worst: f64, distance| if distance.is_nan() { f64::NAN } else { worst.max(distance) })
}

/// The mean of several answers, probe by probe; empty without answers.
pub fn mean(answers: &[Vec<Vector3<f64>>]) -> Vec<Vector3<f64>> {
    let Some((first, others)) = answers.split_first() else { return Vec::new() };
    // Summed as deviations from the first, so that the mean does not lose the digits in which they agree.
    let share = 1.0 / answers.len() as f64;
    let deviation = |probe: usize| others.iter().map(|other| other[probe] - first[probe]).sum::<Vector3<f64>>();
    first.iter().enumerate().map(|(probe, point)| point + share * deviation(probe)).collect()
}

/// The largest distance between any body's probe and the mean of all probes, at least 1 mm (m).
pub fn size(mechanism: &Mechanism, state: &State) -> f64 {
    let probes = probes(mechanism, state);
    let mean: Vector3<f64> = probes.iter().sum::<Vector3<f64>>() / probes.len().max(1) as f64;
    probes.iter().map(|probe| (probe - mean).norm()).fold(1e-3, f64::max)
}
