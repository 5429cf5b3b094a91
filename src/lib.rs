//! catena: rigid multibody dynamics by the constrained Lobatto IIIA–IIIB scheme in maximal coordinates.
//!
//! Each link becomes a rigid body with its own pose, and each joint becomes holonomic constraints `g(q) = 0`. A symplectic scheme of order `2s − 2`
//! integrates the equations of motion. A run takes four lines:
//!
//! ```
//! use catena::prelude::*;
//!
//! let model = Model::load("robots/double_pendulum.urdf")?; // or a scene file
//! let mut simulation = Simulation::new(&model).tolerance(1e-6).duration(2.0).start([("shoulder", 0.5)])?;
//! simulation.run()?;
//! println!("the tip is at {}", simulation.pose("lower_arm")?.translation);
//! # assert!(simulation.energy()?.total().is_finite());
//! let report = simulation.finish()?;
//! assert!(report.energy.max_relative_error < 1e-6);
//! # Ok::<(), catena::session::Error>(())
//! ```
//!
//! A controller may set efforts during the run, and a log in MCAP shows the run in viewers:
//!
//! ```
//! # use catena::prelude::*;
//! # let folder = std::env::temp_dir().join(format!("catena-front-page-{}", std::process::id()));
//! # std::fs::create_dir_all(&folder)?;
//! # let path = folder.join("held.mcap");
//! let model = Model::load("robots/arm7.urdf")?;
//! let holding = model.clone();
//! let mut simulation = Simulation::new(&model).duration(0.5).log(&path);
//! simulation.set_controller(0.001, move |now, efforts| {
//!     if let Ok(weight) = holding.gravity_efforts(&now.q) {
//!         efforts.copy_from_slice(weight.as_slice());
//!     }
//! })?;
//! simulation.step_to(0.25)?;
//! simulation.run()?;
//! assert!(simulation.velocity("joint2")?[0].abs() < 1e-3, "it holds itself");
//! simulation.finish()?;
//! # std::fs::remove_dir_all(&folder)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`prelude`] has the names that most programs need. [`session::Model`] also computes the mass matrix, Jacobians and inverse dynamics, and makes
//! many runs at once ([`session::Model::rollout`]).
//!
//! | feature | what it adds | by default |
//! |---|---|---|
//! | `cli` | the command line (`catena`), with clap, indicatif, signal-hook; enables the next four features | yes |
//! | `film` | films of logs as GIF, MP4 and PNG, with gif, png; enables `log` | yes |
//! | `log` | logs in MCAP and pages, with mcap, zstd | yes |
//! | `plot` | figures as SVG and PNG, charts and stability maps, with plotters | yes |
//! | `scene` | scene files and sweeps, with toml | yes |
//! | `parquet` | rows of sweeps as Apache Parquet | no |
//! | `urdf-rs` | models of robots of `urdf-rs` | no |
//!
//! Without these features (`default-features = false`) the library reads URDF files, runs them, gives reports, and calls an
//! [`Observer`](observing::Observer) during runs.
//!
//! | module | what is in it |
//! |---|---|
//! | [`prelude`] | the names that most programs need |
//! | [`session`] | models, runs, and many runs at once |
//! | [`report`] | the report of a run: the JSON of `catena simulate --json` as structures |
//! | [`observing`] | samples, steps, events and contacts during a run |
//! | [`errors`] | the causes that an [`Error`](session::Error) may hold |
//!
//! All other modules are hidden in this documentation. They are public for the binary, the Python package and the tests of this repository, and
//! change without notice. `doc/architecture.md` describes the source.

#![deny(unsafe_code)]

// The binary refers to this library by its name, as other programs do.
extern crate self as catena;

pub mod errors;
pub mod observing;
#[cfg(feature = "urdf-rs")]
mod of_urdf_rs;
pub mod prelude;
pub mod report;

#[doc(inline)]
pub use catena_run::session;

/// Vectors and matrices in the arguments and results of this library.
pub use nalgebra;

// These modules are public for the binary, the Python package and the tests of this repository only.
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
/// What runs leave.
#[doc(hidden)]
pub mod output {
    #[cfg(feature = "film")]
    pub use catena_page::film;
    #[cfg(feature = "log")]
    pub use catena_page::page;
    pub use catena_run::output::*;
}

#[doc(hidden)]
pub use catena_crowd as crowd;
#[doc(hidden)]
pub use catena_drawing as drawing;
#[doc(hidden)]
pub use catena_geometry as geometry;
#[doc(hidden)]
pub use catena_hybrid::{events, instant};
#[doc(hidden)]
pub use catena_kernels as kernels;
#[doc(hidden)]
pub use catena_lobatto as lobatto;
#[doc(hidden)]
pub use catena_mechanism as mechanism;
#[doc(hidden)]
pub use catena_reduced as reduced;
#[doc(hidden)]
pub use catena_robot::{meshes, model, scene};
#[doc(hidden)]
pub use catena_run::{derivatives, simulation};
#[doc(hidden)]
pub use catena_stepping as stepping;
#[doc(hidden)]
pub use catena_study as study;
