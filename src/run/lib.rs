//! Runs: from a mechanism and its start to a log and a report.
//!
//! | floor | what is in it |
//! |---|---|
//! | [`simulation`] | a run, its islands, its accuracy, its observers |
//! | [`derivatives`] | derivatives of motions by the numbers of a scene |
//! | [`output`] | log and report; reading logs |
//! | [`session`] | a run as people ask for it |

#![deny(unsafe_code)]

pub mod derivatives;
pub mod output;
pub mod session;
pub mod simulation;

use catena_drawing as drawing;
use catena_geometry as geometry;
use catena_hybrid::{events, instant};
use catena_lobatto as lobatto;
use catena_mechanism as mechanism;
use catena_reduced as reduced;
use catena_robot::{meshes, model, scene};
use catena_stepping as stepping;
