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
//! | what | where |
//! |---|---|
//! | limits, friction, motors, pairs of shapes, and the states they can be in | [`crate::instant::elements`], [`crate::instant::touching`], `mode` |
//! | the remaining degrees of freedom while joints are held and contacts closed | `held` |
//! | motors within steps; contacts that slide within steps | `drives`, `sliding` |
//! | efforts of a controller that reads the whole state, restricted to the remaining degrees of freedom | `narrowed` |
//! | functions whose sign is watched; where one changes; the step that ends there | `watched`, `detection`, `approach`, `location` |
//! | accelerations and velocities under efforts and impulses, and the laws | [`crate::instant::response`], [`crate::instant::blocks`], [`crate::instant::cone`] |
//! | the effects, the memory and the list of events | `transition`, `contacts`, `flat_ends`, `planar_rims`, `impact`, `resting`, `decision`, `first_slips`, `memory`, `noted` |
//! | efforts that hold joints, forces of closed contacts | `holding`, `closed_forces` |
//! | the integrator: its modes, the moving mechanism of each mode, steps, schemes | `integrator`, `present`, `piece`, `instants`, `steps`, `piece_steps` |
//! | rest, first-order steps in crowds of events, and the report of contacts | `quiet`, `cycle`, `crowding`, `stepwise`, `contact_points`, `reporting` |

mod approach;
mod closed_forces;
mod contact_points;
mod contacts;
mod crowding;
mod cycle;
mod decision;
mod detection;
mod drives;
mod first_slips;
mod flat_ends;
mod held;
mod holding;
mod impact;
mod instants;
mod integrator;
mod last_step;
mod location;
mod memory;
mod mode;
mod narrowed;
mod noted;
mod piece;
mod piece_steps;
mod planar_rims;
mod present;
mod quiet;
mod reporting;
mod resting;
mod sliding;
mod steps;
mod stepwise;
mod transition;
mod watched;

pub use integrator::Eventful;
