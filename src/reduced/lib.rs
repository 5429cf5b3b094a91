//! The comparator: the mechanism as an unconstrained ordinary differential equation in joint coordinates.
//!
//! Its dynamics share no code with the Lobatto scheme. Only the forces of springs, dampers and loads in a given state are the same code
//! ([`catena_mechanism::description::forces`]). So tests use it as a reference, and benches use it, tuned, as a comparator. In reading order:
//!
//! - [`articulated_body`] and `articulated_inertia`: joint accelerations, O(n);
//! - [`inverse_dynamics`]: the wrenches in the joints;
//! - [`ode`]: the first-order system y = (position, velocity);
//! - [`regularised`]: limits, dry friction and motors as ordinary forces;
//! - [`euler`], [`rk4`], [`dop853`]: three integrators.

#![deny(unsafe_code)]

pub mod articulated_body;
mod articulated_inertia;
pub mod dop853;
mod dop853_step;
mod dop853_table;
pub mod euler;
pub mod inverse_dynamics;
mod link;
pub mod ode;
pub mod regularised;
mod response;
pub mod rk4;
mod weighted_sums;

pub use articulated_body::ArticulatedBody;
pub use dop853::Dop853;
pub use euler::Euler;
pub use inverse_dynamics::{Reaction, joint_reactions, reactions_under};
pub use ode::ReducedOde;
pub use regularised::{Regularised, SoftFriction, SoftLimit};
pub use rk4::Rk4;
