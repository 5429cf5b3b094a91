//! One step of the scheme, as those see it who string steps together ([`step`]), and what makes it: the [`kernel`] over a [`workspace`] in
//! space ([`spatial`]) or in a plane ([`planar`]), and steps to 32 digits ([`precise`]).

pub(crate) mod kernel;
mod kernel_step;
pub mod make;
mod planar;
pub mod precise;
pub mod precise_start;
pub(crate) mod spatial;
pub mod step;
mod workspace;
