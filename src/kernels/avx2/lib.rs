//! The kernels compiled for AVX2: a separate crate, because two cores then compile kernels in parallel, each crate as one unit.

#![cfg(target_arch = "x86_64")]
#![deny(unsafe_code)]

use catena_lobatto::instants::snapshot::Instants;
use catena_lobatto::step::interface::Step;
use catena_lobatto::step::make::{MakeInstants, MakePrecise, MakeStep};
use catena_lobatto::vectors::{eight_in_avx2, in_avx2};

/// A step in these vectors. `None` if the processor lacks them.
pub fn step(make: MakeStep) -> Option<Box<dyn Step>> {
    in_avx2(make.lanes(), make)
}

/// A step with 32 digits in these vectors. `None` if the processor lacks them.
pub fn precise_step(make: MakePrecise) -> Option<Box<dyn Step>> {
    eight_in_avx2(make)
}

/// Computes eight instants at once in these vectors. `None` if the processor lacks them.
pub fn instants(make: MakeInstants) -> Option<Box<dyn Instants>> {
    eight_in_avx2(make)
}
