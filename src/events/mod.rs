//! Motions that are smooth in pieces: limits of joints, dry friction, motors with bounds, and the events between the pieces.
//!
//! Between events a *mode* says which joints are held (by friction, or on a limit), which way the others slide, and which motors are at
//! their bounds. Within a mode the scheme is that of every other run, for what is left to move. A step that meets an event is made again
//! with another length, so that it ends there:
//!
//! ```text
//!     mode ──▶ what moves (held) ──▶ step of the scheme ──▶ watched functions φ on its dense output      detection
//!       ▲                                                    │ φ changes its sign
//!       │                                                    ▼
//!     decision ◀── impact ◀── φ(q̄, v̄, t₀ + h) = 0, the step made again with h unknown                    location
//! ```
//!
//! The dense output only brackets: it is of lower order than the ends of steps. Impacts, and what sticks or lets go, are decided at the end of the
//! step with all closures, several joints together, by one problem in a box.
//!
//! | what | where |
//! |---|---|
//! | limits, friction, motors, and the states they can be in | [`crate::instant::elements`], `mode` |
//! | what is left to move while joints are held | `held` |
//! | motors within steps | `drives` |
//! | functions whose sign is watched; where one changes; the step that ends there | `watched`, `detection`, `location` |
//! | accelerations and velocities under efforts and impulses | [`crate::instant::response`], [`crate::instant::bounded`] |
//! | what an event does | `impact`, `decision`, `transition` |
//! | efforts that hold joints | `holding` |
//! | the integrator: its modes, what moves in each, its steps | `integrator`, `piece`, `steps` |

mod decision;
mod detection;
mod drives;
mod held;
mod holding;
mod impact;
mod integrator;
mod location;
mod mode;
mod piece;
mod steps;
mod transition;
mod watched;

pub use integrator::Eventful;
