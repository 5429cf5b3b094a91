//! Many runs: charts of speed against accuracy, maps of stability, sweeps over the numbers of a scene.

#![deny(unsafe_code)]
// The crates are named for all studies, and features leave some out.
#![cfg_attr(not(all(feature = "plot", feature = "scene")), allow(unused_imports))]

#[cfg(feature = "plot")]
pub mod chart;
#[cfg(feature = "plot")]
pub mod stress;
#[cfg(feature = "scene")]
pub mod sweep;

use catena_drawing as drawing;
use catena_hybrid::{events, instant};
use catena_mechanism as mechanism;
use catena_reduced as reduced;
use catena_robot::{model, scene};
use catena_run::{output, session, simulation};
use catena_stepping as stepping;
