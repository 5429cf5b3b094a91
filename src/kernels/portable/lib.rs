//! The kernels compiled for every processor: a separate crate, because two cores then compile kernels in parallel, each crate as one unit.
//! `build.rs` says which of them.

#![deny(unsafe_code)]

use catena_lobatto::instants::snapshot::Instants;
use catena_lobatto::step::interface::Step;
use catena_lobatto::step::make::{MakeInstants, MakePrecise, MakeStep};
#[cfg(narrow)]
use catena_lobatto::vectors::in_portable;
use catena_lobatto::vectors::{eight_in_portable, wide_in_portable};

/// Whether narrow vectors are among them.
pub const NARROW: bool = cfg!(narrow);

/// A step in these vectors.
pub fn step(make: MakeStep) -> Box<dyn Step> {
    #[cfg(narrow)]
    return in_portable(make.lanes(), make);
    #[cfg(not(narrow))]
    wide_in_portable(make)
}

/// A step with 32 digits in these vectors.
pub fn precise_step(make: MakePrecise) -> Box<dyn Step> {
    wide_in_portable(make)
}

/// Computes eight instants at once in these vectors.
pub fn instants(make: MakeInstants) -> Box<dyn Instants> {
    eight_in_portable(make)
}
