//! The scale of the proximal term of equations that are eliminated at their bodies.
//!
//! ε is a part of the mobility of an equation. A contact with the world is eliminated before any freedom ([`crate::plan::elimination`]), so its
//! mobility is not known yet. The mobility of its body alone takes its place, for a push (f, t) with the torque τ about the centre of mass:
//!
//! ```text
//!     (1 + m |τ|²/J) / M  [1/kg],        J = tr(J)/3,        M = min(100 m, whole), but no less than 1e-4 whole
//! ```
//!
//! m is the mass of the body, `whole` the mass of its part ([`crate::equations::origins`]); the value for a body alone is its mobility. A foot under
//! a robot moves less easily than alone, so the mobility of the foot alone would make its ε too large. But in the matrix the contact is as heavy as
//! M/ε, beside which the inertia of a light body is rounded; and the ε of a feather would be a large part of the force with which the robot presses
//! it.

use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::structure::islands::first_of_tied;

/// The largest M, in masses of the body.
const MOST: f64 = 100.0;
/// The least M, in masses of the part.
const LEAST: f64 = 1e-4;

/// 1/M of every body [1/kg].
pub(crate) fn weights(mechanism: &Mechanism) -> Vec<f64> {
    let firsts = first_of_tied(mechanism);
    let mut wholes = vec![0.0; firsts.len()];
    mechanism.bodies.iter().zip(&firsts).for_each(|(body, &first)| wholes[first] += body.mass);
    let of = |mass: f64, whole: f64| (MOST * mass).min(whole).max(LEAST * whole);
    let masses = mechanism.bodies.iter().zip(&firsts).map(|(body, &first)| of(body.mass, wholes[first]));
    masses.map(|mass| if mass > 0.0 { 1.0 / mass } else { 1.0 }).collect()
}
