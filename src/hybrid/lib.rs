//! Motions that are smooth in pieces.
//!
//! | floor | what is in it |
//! |---|---|
//! | [`instant`] | the problem at one instant: what holds, presses and slips; starts; reactions |
//! | [`events`] | the integrator: modes, steps that end at events, and steps over many of them |

#![deny(unsafe_code)]

pub mod events;
pub mod instant;

use catena_crowd as crowd;
use catena_geometry as geometry;
use catena_kernels as kernels;
use catena_lobatto as lobatto;
use catena_mechanism as mechanism;
use catena_reduced as reduced;
use catena_stepping as stepping;
