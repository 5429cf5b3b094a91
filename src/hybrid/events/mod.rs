//! Motions that are smooth in pieces: limits of joints, dry friction, motors with bounds, contacts, and the events between the pieces.
//!
//! Between events a *mode* says which joints are held (by friction or on a limit), which way the others slide, which motors are at their bounds,
//! and which contacts are closed and whether they stick. Within a mode the scheme of every other run integrates the remaining degrees of freedom. A
//! step that meets an event is repeated with a shorter length, so that it ends at the event:
//!
//! ```text
//!     mode ──▶ what moves (held) ──▶ step of the scheme ──▶ watched functions φ on its dense output      detection, approach
//!       ▲                                                    │ φ changes its sign
//!       │                                                    ▼
//!     decision ◀── impact ◀── φ(q̄, v̄, t₀ + h) = 0, the step made again with h unknown                    location
//! ```
//!
//! The dense output is of lower order than the ends of steps, so it only brackets the event. One problem for all closures, joints and contacts
//! ([`crate::instant::cone`]) decides at the end of the step on impacts, sticking and release.
//!
//! | room | contents |
//! |---|---|
//! | `modes` | the states of joints, motors and contacts; the reduced mechanism of each mode, with its steps |
//! | `forces` | efforts that hold joints, forces of closed contacts, and their report |
//! | `finding` | functions whose sign is watched, their first sign change within a step, distances that close |
//! | `effects` | the effects of an event: impulses, which contacts stay closed and stick, the next mode, the list of events |
//! | `crowd` | steps of first order over many events |
//! | `parts` | the parts that the integrator owns: model, workspaces, the step at hand, progress, tally, the last step |
//! | here | the integrator: its steps, steps that end at events, rest, and crowds of events |
//!
//! A room imports those above it in this table. Limits, friction, motors and pairs of shapes are in [`crate::instant::holding::elements`] and
//! [`crate::instant::holding::touching`], accelerations and velocities under efforts and impulses in [`crate::instant::dynamics::response`],
//! [`crate::instant::holding::blocks`] and [`crate::instant::cone`].

mod as_integrator;
mod balance;
mod ballistic;
mod careful;
mod changed_efforts;
mod closing;
mod closing_pairs;
mod commanded;
mod contact_points;
mod covered;
mod crowd;
#[cfg(test)]
mod crowd_tests;
pub mod crowded;
mod early;
mod effects;
mod entering;
mod finding;
pub mod first_contacts;
mod forces;
mod foresight;
mod integrator;
mod jumps;
mod last_step;
mod location;
mod modes;
mod moving;
mod nearing;
mod next_step;
mod parting;
mod parts;
pub mod price;
mod quiet;
mod ringing;
mod singular;
mod sliding;
mod slow_passes;
mod steps;
mod stepwise;
pub mod trace;
mod turning;

pub use finding::cover::check_certificates;
pub use integrator::Eventful;
pub use moving::{Driving, Moving, MovingError, Stuck};
