//! What people look at after a run.
//!
//! | floor | what is in it |
//! |---|---|
//! | [`page`] | a run or a model as one HTML file |
//! | [`film`] | a log as GIF, MP4 or PNG |

#![deny(unsafe_code)]
// Figures are for films alone.
#![cfg_attr(not(feature = "film"), allow(unused_imports))]

#[cfg(feature = "film")]
pub mod film;
pub mod page;

use catena_drawing as drawing;
use catena_geometry as geometry;
use catena_mechanism as mechanism;
use catena_robot::{meshes, model, scene};
use catena_run::output;
