//! The proximal term of the equations that go at their bodies: what it is a part of.
//!
//! ε is a part of the mobility of an equation. Where a contact with the world goes before any freedom ([`crate::plan::elimination`]), nothing is
//! eliminated yet that could say its mobility, and that of its body alone takes its place, for a push (f, t) with the torque τ about the centre of mass:
//!
//! ```text
//!     (1 + m |τ|²/J) / M  [1/kg],        J = tr(J)/3,        M = min(100 m, whole), but no less than 1e-4 whole
//! ```
//!
//! m is the mass of the body, and the whole that of the mechanism: for a body alone this is its mobility. A foot under a robot moves less easily than alone,
//! and its ε would be as much larger a part of what it is. But in the matrix the contact is as heavy as M/ε, beside which the inertia of a
//! light body is rounded; and ε of a feather would be no small part of what the robot presses it with.

use catena_mechanism::description::mechanism::Mechanism;

/// The largest M, in masses of the body.
const MOST: f64 = 100.0;
/// The least M, in masses of the mechanism.
const LEAST: f64 = 1e-4;

/// 1/M of every body [1/kg].
pub(crate) fn weights(mechanism: &Mechanism) -> Vec<f64> {
    let whole = mechanism.total_mass();
    let of = |mass: f64| (MOST * mass).min(whole).max(LEAST * whole);
    let masses = mechanism.bodies.iter().map(|body| of(body.mass));
    masses.map(|mass| if mass > 0.0 { 1.0 / mass } else { 1.0 }).collect()
}
