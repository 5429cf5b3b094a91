//! Which kernel makes the steps, and in which vectors: the narrowest type that holds the stages, of the widest the
//! processor has.

use super::instants::{Instants, LaneInstants, LinkPlace};
use super::kernel::Kernel;
#[cfg(target_arch = "x86_64")]
use super::lanes::{Avx128, Avx256, Avx512, Pair, Sse2};
use super::lanes::{Isa, Lanes, Portable};
use super::planar::PlanarKernel;
use super::precise::Precise;
use super::step::Step;
use super::tableau::Tableau;
use crate::model::{Mechanism, Plane, Rule};

/// A step of the scheme for this mechanism on this processor: in the plane, if the mechanism has one; `kept` are the rules that
/// leave nothing out.
///
/// `isa` must not be more than [`Isa::detect`] found: it is checked, and lowered if need be.
pub fn step_for(mechanism: &Mechanism, tableau: &'static Tableau, isa: Isa, kept: &[Rule]) -> Box<dyn Step> {
    match Plane::of(mechanism).filter(|_| !kept.contains(&Rule::Planar)) {
        Some(plane) => in_vectors(&Planar { mechanism, tableau, plane }, tableau, isa),
        None => in_vectors(&Spatial { mechanism, tableau, kept }, tableau, isa),
    }
}

/// Most stages of steps with 32 digits: they have eight lanes, whatever the processor.
pub const MOST_PRECISE_STAGES: usize = 9;

/// The vectors of a step with 32 digits on every other processor. On x86-64 they are those of many stages, so that there is no kernel for
/// eight lanes, which would take its share of the build.
#[cfg(target_arch = "x86_64")]
type ForAny = Portable<16>;
#[cfg(not(target_arch = "x86_64"))]
type ForAny = Portable<8>;

/// A step with 32 digits for a tree under gravity alone, of at most [`MOST_PRECISE_STAGES`] stages.
pub fn precise_step_for(mechanism: &Mechanism, tableau: &'static Tableau, kept: &[Rule]) -> Box<dyn Step> {
    match Isa::detect() {
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512 => Box::new(Precise::<Avx512>::new(mechanism, tableau, kept)),
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 => Box::new(Precise::<Pair<Avx256, 8>>::new(mechanism, tableau, kept)),
        _ => Box::new(Precise::<ForAny>::new(mechanism, tableau, kept)),
    }
}

/// What looks at eight instants of a tree without forces on bodies at once.
pub fn instants_for(mechanism: &Mechanism, links: &[LinkPlace]) -> Box<dyn Instants> {
    match Isa::detect() {
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512 => Box::new(LaneInstants::<Avx512>::new(mechanism, links)),
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 => Box::new(LaneInstants::<Pair<Avx256, 8>>::new(mechanism, links)),
        _ => Box::new(LaneInstants::<Portable<8>>::new(mechanism, links)),
    }
}

/// Makes a kernel with the lanes it is told.
trait Make {
    fn make<V: Lanes>(&self) -> Box<dyn Step>;
}

struct Spatial<'m> {
    mechanism: &'m Mechanism,
    tableau: &'static Tableau,
    kept: &'m [Rule],
}

struct Planar<'m> {
    mechanism: &'m Mechanism,
    tableau: &'static Tableau,
    plane: Plane,
}

impl Make for Spatial<'_> {
    fn make<V: Lanes>(&self) -> Box<dyn Step> {
        Box::new(Kernel::<V>::new(self.mechanism, self.tableau, self.kept))
    }
}

impl Make for Planar<'_> {
    fn make<V: Lanes>(&self) -> Box<dyn Step> {
        Box::new(PlanarKernel::<V>::new(self.mechanism, &self.plane, self.tableau))
    }
}

fn in_vectors(kernel: &impl Make, tableau: &Tableau, isa: Isa) -> Box<dyn Step> {
    let lanes = tableau.stages - 1;
    #[cfg(target_arch = "x86_64")]
    match (isa, Isa::detect()) {
        (Isa::Avx512, Isa::Avx512) if lanes > 4 => {
            return match lanes {
                ..=8 => kernel.make::<Avx512>(),
                _ => kernel.make::<Pair<Avx512, 16>>(),
            };
        }
        (Isa::Avx512 | Isa::Avx2, Isa::Avx512 | Isa::Avx2) => {
            return match lanes {
                ..=2 => kernel.make::<Avx128>(),
                3..=4 => kernel.make::<Avx256>(),
                5..=8 => kernel.make::<Pair<Avx256, 8>>(),
                _ => kernel.make::<Pair<Pair<Avx256, 8>, 16>>(),
            };
        }
        // Few processors of this kind lack AVX2, and every type takes a share of the build: two do for all stages.
        _ if lanes <= 4 => return kernel.make::<Pair<Sse2, 4>>(),
        _ => {}
    }
    let _ = isa;
    match lanes {
        #[cfg(not(target_arch = "x86_64"))]
        ..=2 => kernel.make::<Portable<2>>(),
        #[cfg(not(target_arch = "x86_64"))]
        ..=4 => kernel.make::<Portable<4>>(),
        #[cfg(not(target_arch = "x86_64"))]
        ..=8 => kernel.make::<Portable<8>>(),
        _ => kernel.make::<Portable<16>>(),
    }
}
