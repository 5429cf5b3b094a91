//! The kernels compiled for AVX-512: a separate crate, because two cores then compile kernels in parallel, each crate as one unit.
//! `build.rs` says whether they are compiled.

#![cfg(target_arch = "x86_64")]
#![deny(unsafe_code)]

use catena_lobatto::instants::snapshot::Instants;
use catena_lobatto::step::interface::Step;
use catena_lobatto::step::make::{MakeInstants, MakePrecise, MakeStep};
#[cfg(compiled)]
use catena_lobatto::vectors::{eight_in_avx512, in_avx512};
#[cfg(not(compiled))]
use catena_lobatto::vectors::{no_vectors as eight_in_avx512, no_vectors_of as in_avx512};

/// Whether there are any.
pub const COMPILED: bool = cfg!(compiled);

/// A step in these vectors. `None` if they are not compiled or the processor lacks them, or if narrower vectors hold it.
pub fn step(make: MakeStep) -> Option<Box<dyn Step>> {
    in_avx512(make.lanes(), make)
}

/// A step with 32 digits in these vectors. `None` if they are not compiled or the processor lacks them.
pub fn precise_step(make: MakePrecise) -> Option<Box<dyn Step>> {
    eight_in_avx512(make)
}

/// Computes eight instants at once in these vectors. `None` if they are not compiled or the processor lacks them.
pub fn instants(make: MakeInstants) -> Option<Box<dyn Instants>> {
    eight_in_avx512(make)
}
