//! The kernels compiled for AVX2: a separate crate, because two cores then compile kernels in parallel, each crate as one unit.
//! `build.rs` says which of them.

#![cfg(target_arch = "x86_64")]
#![deny(unsafe_code)]

use catena_lobatto::instants::snapshot::Instants;
use catena_lobatto::step::interface::Step;
use catena_lobatto::step::make::{MakeInstants, MakePrecise, MakeStep};
#[cfg(wide)]
use catena_lobatto::vectors::{eight_in_avx2, in_avx2};
#[cfg(not(wide))]
use catena_lobatto::vectors::{in_avx2_up_to_four as in_avx2, no_vectors as eight_in_avx2};

/// Whether vectors of more than four lanes are among them.
pub const WIDE: bool = cfg!(wide);

/// A step in these vectors. `None` if the processor lacks them, or if they are too narrow.
pub fn step(make: MakeStep) -> Option<Box<dyn Step>> {
    in_avx2(make.lanes(), make)
}

/// A step with 32 digits in these vectors. `None` if the processor lacks them, or if they are too narrow.
pub fn precise_step(make: MakePrecise) -> Option<Box<dyn Step>> {
    eight_in_avx2(make)
}

/// Computes eight instants at once in these vectors. `None` if the processor lacks them, or if they are too narrow.
pub fn instants(make: MakeInstants) -> Option<Box<dyn Instants>> {
    eight_in_avx2(make)
}
