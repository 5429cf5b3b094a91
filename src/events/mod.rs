//! Motions that are smooth in pieces: limits of joints, dry friction, motors with bounds, contacts, and the events between the pieces.
//!
//! Between events a *mode* says which joints are held (by friction, or on a limit), which way the others slide, which motors are at
//! their bounds, and which contacts are closed and how they grip. Within a mode the scheme is that of every other run, for what is left to
//! move. A step that meets an event is made again with another length, so that it ends there:
//!
//! ```text
//!     mode ──▶ what moves (held) ──▶ step of the scheme ──▶ watched functions φ on its dense output      detection, approach
//!       ▲                                                    │ φ changes its sign
//!       │                                                    ▼
//!     decision ◀── impact ◀── φ(q̄, v̄, t₀ + h) = 0, the step made again with h unknown                    location
//! ```
//!
//! The dense output only brackets: it is of lower order than the ends of steps. Impacts, and what sticks or lets go, are decided at the end of the
//! step with all closures, joints and contacts together, by one problem ([`crate::instant::cone`]).
//!
//! | what | where |
//! |---|---|
//! | limits, friction, motors, pairs of shapes, and the states they can be in | [`crate::instant::elements`], [`crate::instant::touching`], `mode` |
//! | what is left to move while joints are held and contacts closed | `held` |
//! | motors within steps; contacts that slide within steps | `drives`, `sliding` |
//! | efforts from outside that follow the state of the whole, narrowed to what moves | `narrowed` |
//! | functions whose sign is watched; where one changes; the step that ends there | `watched`, `detection`, `approach`, `location` |
//! | accelerations and velocities under efforts and impulses, and the laws | [`crate::instant::response`], [`crate::instant::blocks`], [`crate::instant::cone`] |
//! | what an event does, what it remembers, what it notes | `transition`, `contacts`, `impact`, `resting`, `decision`, `memory`, `noted` |
//! | efforts that hold joints, forces of closed contacts | `holding`, `closed_forces` |
//! | the integrator: its modes, what moves in each, its steps, and what makes them | `integrator`, `present`, `piece`, `steps`, `piece_steps` |
//! | rest, what is done where events crowd or no step can be solved, and what is reported of contacts | `quiet`, `crowding`, `stepwise`, `contact_points`, `reporting` |

mod approach;
mod closed_forces;
mod contact_points;
mod contacts;
mod crowding;
mod decision;
mod detection;
mod drives;
mod held;
mod holding;
mod impact;
mod integrator;
mod location;
mod memory;
mod mode;
mod narrowed;
mod noted;
mod piece;
mod piece_steps;
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
