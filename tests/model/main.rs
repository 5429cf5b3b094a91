//! From files to mechanisms: what is read, what is left out, and that nothing is lost by it.

// `models` names its mechanisms by this path, so that tests of single crates have it, too.
use catena::mechanism;

#[path = "../shared/closed/mod.rs"]
mod closed;
#[path = "../shared/common/mod.rs"]
mod common;
#[path = "../shared/models/mod.rs"]
mod models;

mod assessed;
mod assessed_random;
mod assessed_stiff;
mod assessed_while_it_goes_on;
mod islands;
mod lean;
mod mesh_formats;
mod mjcf;
mod model_reduction;
mod parameters;
mod parameters_walked;
mod robots;
mod scene_file;
mod scenes;
mod simulation;
mod start_within_limits;
mod starts_as_given;
mod urdf_corpus_reading;
mod urdf_reading;
