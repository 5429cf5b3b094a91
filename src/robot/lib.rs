//! From files to mechanisms.
//!
//! | floor | what is in it |
//! |---|---|
//! | [`meshes`] | the surfaces of mesh files |
//! | [`scene`] | what the user wrote, validated |
//! | [`model`] | from what was written to what is simulated |

#![deny(unsafe_code)]

pub mod meshes;
pub mod model;
pub mod scene;

use catena_geometry as geometry;
use catena_mechanism as mechanism;
