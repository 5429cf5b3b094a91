//! The effects of an event: impulses, the contacts that stay closed, and the next mode.

pub(crate) mod blocked;
pub(crate) mod contacts;
mod deciding;
pub(crate) mod decision;
pub(crate) mod first_slips;
pub(crate) mod flat_ends;
pub(crate) mod gathering;
pub(crate) mod immobile;
pub(crate) mod impact;
pub(crate) mod low_rebounds;
pub(crate) mod memory;
mod next_modes;
pub(crate) mod noted;
pub(crate) mod omitted_flights;
mod passed_borders;
pub(crate) mod planar_rims;
mod rest_problem;
pub(crate) mod resting;
mod rim_points;
pub(crate) mod seams;
mod seizing;
mod shared_loads;
pub(crate) mod shared_pressures;
mod stopped;
pub(crate) mod transition;
mod turnings;
pub(crate) mod unpressed;
