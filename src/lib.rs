//! catena: rigid multibody dynamics by the constrained Lobatto IIIA–IIIB scheme in maximal coordinates.
//!
//! Data goes one way, and nothing imports anything to its right:
//!
//! ```text
//!     URDF, scene file → scene → model → mechanism → lobatto → stepping → simulation → output → study
//!                                            └→ reduced (joint coordinates: the comparator and a test oracle)
//! ```
//!
//! | floor | what it is |
//! |---|---|
//! | [`mechanism`] | what is simulated: bodies, joints, closures, forces; state, kinematics, energy |
//! | [`lobatto`] | one step of the method |
//! | [`scene`] | what the user wrote, validated |
//! | [`model`] | from what was written to what is simulated |
//! | [`reduced`] | joint coordinates: the comparator |
//! | [`instant`] | the problem at one instant: assembly, reactions, rest |
//! | [`stepping`] | steps strung together |
//! | [`simulation`] | a run: islands, accuracy, observers |
//! | [`output`] | logs, reports, looks at logs |
//! | [`study`] | many runs, compared |
//! | [`drawing`] | figures, for both |

#![deny(unsafe_code)]

pub mod drawing;
pub mod instant;
pub mod model;
pub mod output;
pub mod reduced;
pub mod scene;
pub mod simulation;
pub mod stepping;
pub mod study;

pub use catena_kernels as kernels;
pub use catena_lobatto as lobatto;
pub use catena_mechanism as mechanism;
