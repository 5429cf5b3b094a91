//! The choice of kernel and vectors for a step: the widest instruction set of the processor, and its narrowest type that holds the stages.

#![deny(unsafe_code)]

use catena_lobatto::instants::snapshot::{Instants, LinkPlace};
use catena_lobatto::numbers::lanes::Isa;
use catena_lobatto::step::interface::Step;
use catena_lobatto::step::make::{MakeInstants, MakePrecise, MakeStep};
use catena_lobatto::tableau::butcher::Tableau;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::description::rules::Rule;

/// Whether all vectors that a processor of this kind takes are compiled. Without the feature `every-processor` they are for processors like the one
/// that built the program; on others, steps are right and take slower vectors.
pub fn are_complete_for(isa: Isa) -> bool {
    #[cfg(target_arch = "x86_64")]
    match isa {
        Isa::Avx512 => return catena_kernels_avx512::COMPILED,
        Isa::Avx2 => return catena_kernels_avx2::WIDE,
        Isa::Portable => {}
    }
    let _ = isa;
    catena_kernels_portable::NARROW
}

/// The vector instructions of this processor that steps take, on which their last bits depend.
pub fn instructions() -> String {
    let isa = Isa::detect();
    if are_complete_for(isa) { isa.name().to_string() } else { format!("{}, built for another processor", isa.name()) }
}

/// A step of the scheme for this mechanism on this processor: the planar kernel if the mechanism has a plane. `kept` lists the rules that are
/// disabled.
///
/// The vectors are not wider than `isa`, and the processor has them.
pub fn step_for(mechanism: &Mechanism, tableau: &'static Tableau, isa: Isa, kept: &[Rule]) -> Box<dyn Step> {
    let make = MakeStep::new(mechanism, tableau, kept);
    #[cfg(target_arch = "x86_64")]
    {
        let avx512 = || (isa == Isa::Avx512).then(|| catena_kernels_avx512::step(make)).flatten();
        let avx2 = || (isa != Isa::Portable).then(|| catena_kernels_avx2::step(make)).flatten();
        if let Some(step) = avx512().or_else(avx2) {
            return step;
        }
    }
    let _ = isa;
    catena_kernels_portable::step(make)
}

/// A step with 32 digits for a tree under gravity alone, of at most
/// [`MOST_PRECISE_STAGES`](catena_lobatto::step::make::MOST_PRECISE_STAGES) stages.
pub fn precise_step_for(mechanism: &Mechanism, tableau: &'static Tableau, kept: &[Rule]) -> Box<dyn Step> {
    let make = MakePrecise { mechanism, tableau, kept };
    #[cfg(target_arch = "x86_64")]
    if let Some(step) = catena_kernels_avx512::precise_step(make).or_else(|| catena_kernels_avx2::precise_step(make)) {
        return step;
    }
    catena_kernels_portable::precise_step(make)
}

/// Computes eight instants of a tree without forces on bodies at once.
pub fn instants_for(mechanism: &Mechanism, links: &[LinkPlace]) -> Box<dyn Instants> {
    let make = MakeInstants { mechanism, links };
    #[cfg(target_arch = "x86_64")]
    if let Some(instants) = catena_kernels_avx512::instants(make).or_else(|| catena_kernels_avx2::instants(make)) {
        return instants;
    }
    catena_kernels_portable::instants(make)
}
