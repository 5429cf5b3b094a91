//! catena: rigid multibody dynamics by the constrained Lobatto IIIA–IIIB scheme in maximal coordinates.
//!
//! Links become rigid bodies with a pose each, joints become holonomic constraints `g(q) = 0`, and the whole is integrated by a symplectic
//! scheme of order `2s − 2`. A run takes four lines:
//!
//! ```
//! use catena::prelude::*;
//!
//! let robot = read_urdf("robots/double_pendulum.urdf".as_ref(), &PackagePath::default())?;
//! let model = Model::new(robot, &ModelOptions::default())?;
//! let start = State::zero(&model.mechanism);
//! let options = SimulationOptions { duration: 1.0, steps: StepChoice::Tolerance(1e-6), switched_off: &[], interrupt: None };
//! let mut simulation = Simulation::new(&model.mechanism, start, options)?;
//! simulation.run()?;
//! assert!(simulation.finish().summary.max_relative_energy_error < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Data goes one way through the floors, and nothing imports anything to its right:
//!
//! ```text
//!     URDF, scene file → scene → model → mechanism → lobatto → stepping → instant → events → simulation → output → study
//!                                            └→ reduced (joint coordinates: the comparator and a test oracle)
//! ```
//!
//! | floor | what it is |
//! |---|---|
//! | [`mechanism`] | what is simulated: bodies, joints, closures, forces (constant); state, kinematics, energy (changing) |
//! | [`scene`] | what the user wrote, validated |
//! | [`model`] | from what was written to what is simulated |
//! | [`reduced`] | the same mechanism in joint coordinates: the comparator |
//! | [`stepping`] | steps strung together: [`Lobatto`](stepping::Lobatto) |
//! | [`instant`] | the problem at one instant: assembly of loops, reactions, what holds joints, rest |
//! | [`events`] | steps that end at events: limits, dry friction, motors |
//! | [`simulation`] | a run: [`Simulation`](simulation::Simulation), its observers |
//! | [`output`] | logs, reports and pages |
//!
//! The step itself (`lobatto`, and `kernels`, which are its code for each instruction set), charts and stability maps (`study`) and their
//! drawing kit are public to the programs of this repository alone: they change without notice. `doc/architecture.md` is the map for people who
//! work on the source.

#![deny(unsafe_code)]

// The command line names the library as other programs do.
extern crate self as catena;

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
