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
//! | `cli` | the command line (`catena`), with clap, indicatif, signal-hook; enables the next three features | yes |
//! | `log` | logs in MCAP and pages, with mcap, zstd | yes |
//! | `plot` | figures as SVG and PNG, charts and stability maps, with plotters | yes |
//! | `scene` | scene files and sweeps, with toml | yes |
//! | `parquet` | rows of sweeps as Apache Parquet | no |
//!
//! Without these features (`default-features = false`) the library reads URDF files, runs them, gives reports, and calls an
//! [`Observer`](simulation::Observer) during runs.
//!
//! The library has layers. A layer imports only layers to its left:
//!
//! ```text
//!     URDF, scene file → scene → model → mechanism → lobatto → stepping → instant → events → simulation → output → session → study
//!                                            └→ reduced (joint coordinates: the comparator and a test oracle)
//! ```
//!
//! | layer | what it is |
//! |---|---|
//! | [`mechanism`] | bodies, joints, closures, forces (constant); state, kinematics, energy (functions of time) |
//! | [`scene`] | the user's files, validated |
//! | [`model`] | builds a mechanism from a scene |
//! | [`reduced`] | the same mechanism in joint coordinates, for comparison |
//! | [`stepping`] | the integrator: a sequence of steps ([`Lobatto`](stepping::Lobatto)) |
//! | [`instant`] | problems at one instant: assembly of loops, reactions, forces that hold joints, equilibrium |
//! | [`events`] | steps that end at events: limits, dry friction, motors, contacts |
//! | [`simulation`] | a run: [`Simulation`](simulation::Simulation), its observers |
//! | [`output`] | logs, reports and pages |
//! | [`session`] | runs with all their options: the base of the command line, of Rust programs and of Python |
//!
//! The step itself (`lobatto`, and `kernels`, its code for each instruction set), charts and stability maps (`study`) and the drawing functions are
//! public only for the programs of this repository: they change without notice. `doc/architecture.md` describes the source.

#![deny(unsafe_code)]

// The binary refers to this library by its name, as other programs do.
extern crate self as catena;

#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
#[doc(hidden)]
pub mod drawing;
pub mod events;
pub mod instant;
#[doc(hidden)]
pub mod meshes;
pub mod model;
pub mod output;
pub mod prelude;
pub mod scene;
pub mod session;
pub mod simulation;
#[doc(hidden)]
pub mod study;

#[doc(hidden)]
pub use catena_geometry as geometry;
#[doc(hidden)]
pub use catena_kernels as kernels;
#[doc(hidden)]
pub use catena_lobatto as lobatto;
pub use catena_mechanism as mechanism;
pub use catena_reduced as reduced;
pub use catena_stepping as stepping;
/// Vectors and matrices of what this library takes and gives.
pub use nalgebra;
