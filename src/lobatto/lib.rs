//! One step of the method: the constrained Lobatto IIIA–IIIB scheme (2.5.11) in maximal coordinates.
//!
//! Equation numbers such as (2.5.11) are from section 2.5 of T. M. Tyranowski, "Geometric integration applied to moving mesh methods and degenerate
//! Lagrangians", PhD thesis, California Institute of Technology, 2014. `doc/method.md` lists these equations and derives the form that is solved.
//!
//! The modules are in the order in which a step is computed:
//!
//! | module | what is in it |
//! |---|---|
//! | [`numbers`], [`vectors`] | one number for each stage; the vectors of the processors |
//! | [`tableau`] | coefficients, stability, dense output |
//! | [`plan`] | plans made before the first step |
//! | [`stages`] | start, poses and rows of all stages, first guess |
//! | [`equations`] | the residuals of (2.5.11) |
//! | [`solve`] | the simplified Newton iteration over the tree |
//! | [`ending`] | momenta and velocities at the end (2.5.11h) |
//! | [`coupled`] | the exact Newton step, for closed loops |
//! | [`planar`] | the equations in a plane |
//! | [`step`] | the step as a whole |
//! | [`instants`] | samples of a motion |

// Allowed in one file: `vectors/x86.rs`.
#![deny(unsafe_code)]

#[doc(hidden)]
pub mod coupled;
#[doc(hidden)]
pub mod ending;
#[doc(hidden)]
pub mod equations;
#[doc(hidden)]
pub mod instants;
#[doc(hidden)]
pub mod numbers;
#[doc(hidden)]
pub mod plan;
#[doc(hidden)]
pub mod planar;
#[doc(hidden)]
pub mod solve;
#[doc(hidden)]
pub mod stages;
#[doc(hidden)]
pub mod step;
#[doc(hidden)]
pub mod tableau;
#[doc(hidden)]
pub mod vectors;
