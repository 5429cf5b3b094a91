//! One step of the scheme, as those see it who string steps together ([`step`]), and the kernels that make it: in space, in a plane, to 32 digits.

pub mod kernel;
pub mod kernel_step;
pub mod make;
pub mod planar_kernel;
pub mod precise;
pub mod precise_start;
pub mod step;
