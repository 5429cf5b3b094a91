//! Makes the kernels for a given type of vectors ([`InVectors`]).

use crate::instants::snapshot::{Instants, LinkPlace};
use crate::instants::tree::LaneInstants;
use crate::numbers::lanes::Lanes;
use crate::step::interface::Step;
use crate::step::kernel::Kernel;
use crate::step::planar::PlanarWorkspace;
use crate::step::precise::Precise;
use crate::step::spatial::SpatialWorkspace;
use crate::tableau::butcher::Tableau;
use crate::vectors::InVectors;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::description::rules::Rule;
use catena_mechanism::structure::plane::Plane;

/// Most stages of steps with 32 digits: they have eight lanes, whatever the processor.
pub const MOST_PRECISE_STAGES: usize = 9;

/// Makes the step of a mechanism: in its plane if it has one, in space otherwise.
#[derive(Clone, Copy)]
pub struct MakeStep<'m> {
    /// The mechanism.
    pub mechanism: &'m Mechanism,
    /// The scheme.
    pub tableau: &'static Tableau,
    /// The plane that it moves in.
    pub plane: Option<Plane>,
    /// Disabled simplification rules.
    pub kept: &'m [Rule],
}

impl<'m> MakeStep<'m> {
    /// Finds the plane of the mechanism, unless that rule is `kept` from leaving something out.
    pub fn new(mechanism: &'m Mechanism, tableau: &'static Tableau, kept: &'m [Rule]) -> Self {
        let plane = if kept.contains(&Rule::Planar) { None } else { Plane::of(mechanism) };
        MakeStep { mechanism, tableau, plane, kept }
    }

    /// Number of lanes in use.
    pub fn lanes(&self) -> usize {
        self.tableau.stages - 1
    }
}

impl InVectors for MakeStep<'_> {
    type Output = Box<dyn Step>;
    fn with<V: Lanes>(self) -> Box<dyn Step> {
        let MakeStep { mechanism, tableau, plane, kept } = self;
        match &plane {
            Some(plane) => {
                Box::new(Kernel::new(mechanism, tableau, PlanarWorkspace::<V>::new(mechanism, plane, tableau)))
            }
            None => Box::new(Kernel::new(mechanism, tableau, SpatialWorkspace::<V>::new(mechanism, tableau, kept))),
        }
    }
}

/// Makes a step with 32 digits, for a tree under gravity alone and at most [`MOST_PRECISE_STAGES`] stages.
#[derive(Clone, Copy)]
pub struct MakePrecise<'m> {
    /// The mechanism.
    pub mechanism: &'m Mechanism,
    /// The scheme.
    pub tableau: &'static Tableau,
    /// Disabled simplification rules.
    pub kept: &'m [Rule],
}

impl InVectors for MakePrecise<'_> {
    type Output = Box<dyn Step>;
    fn with<V: Lanes>(self) -> Box<dyn Step> {
        Box::new(Precise::<V>::new(self.mechanism, self.tableau, self.kept))
    }
}

/// Makes the evaluation of eight instants at once, for a tree without forces on bodies.
#[derive(Clone, Copy)]
pub struct MakeInstants<'m> {
    /// The mechanism.
    pub mechanism: &'m Mechanism,
    /// Its links.
    pub links: &'m [LinkPlace],
}

impl InVectors for MakeInstants<'_> {
    type Output = Box<dyn Instants>;
    fn with<V: Lanes>(self) -> Box<dyn Instants> {
        Box::new(LaneInstants::<V>::new(self.mechanism, self.links))
    }
}
