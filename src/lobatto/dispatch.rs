//! Which vectors a step runs in: the narrowest type that holds its stages, of the widest the processor has.

#[cfg(target_arch = "x86_64")]
use super::lanes::{Avx128, Avx256, Avx512, Pair};
use super::lanes::{Isa, Portable};
use super::step::{Kernel, Step};
use super::tableau::Tableau;
use crate::model::Mechanism;

/// A step of the scheme for this mechanism on this processor.
///
/// `isa` must not be more than [`Isa::detect`] found: it is checked, and lowered if need be.
pub fn step_for(mechanism: &Mechanism, tableau: &Tableau, isa: Isa) -> Box<dyn Step> {
    let lanes = tableau.stages - 1;
    #[cfg(target_arch = "x86_64")]
    match (isa, Isa::detect()) {
        (Isa::Avx512, Isa::Avx512) if lanes > 4 => {
            return if lanes <= 8 {
                Box::new(Kernel::<Avx512>::new(mechanism, tableau))
            } else {
                Box::new(Kernel::<Pair<Avx512, 16>>::new(mechanism, tableau))
            };
        }
        (Isa::Avx512 | Isa::Avx2, Isa::Avx512 | Isa::Avx2) => {
            return match lanes {
                ..=2 => Box::new(Kernel::<Avx128>::new(mechanism, tableau)),
                3..=4 => Box::new(Kernel::<Avx256>::new(mechanism, tableau)),
                5..=8 => Box::new(Kernel::<Pair<Avx256, 8>>::new(mechanism, tableau)),
                _ => Box::new(Kernel::<Pair<Pair<Avx256, 8>, 16>>::new(mechanism, tableau)),
            };
        }
        _ => {}
    }
    let _ = isa;
    match lanes {
        ..=2 => Box::new(Kernel::<Portable<2>>::new(mechanism, tableau)),
        3..=4 => Box::new(Kernel::<Portable<4>>::new(mechanism, tableau)),
        5..=8 => Box::new(Kernel::<Portable<8>>::new(mechanism, tableau)),
        _ => Box::new(Kernel::<Portable<16>>::new(mechanism, tableau)),
    }
}
