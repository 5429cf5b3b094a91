//! What acts on a mechanism, as its kernel knows it: a kernel is made for one gravity and one set of forces.

use crate::watching::unseen::Pushes;
use catena_mechanism::description::forces::Forces;
use catena_mechanism::description::mechanism::Mechanism;
use nalgebra::Vector3;
use std::sync::Arc;

/// What acts on a mechanism, as a kernel was made for it.
#[derive(Clone)]
pub(crate) struct Outside {
    gravity: Vector3<f64>,
    forces: Forces,
    /// What they push with.
    pub(crate) pushes: Pushes,
    /// The mechanism with forces that are driven, once efforts have been handed to a step.
    pub(crate) driven: Option<Arc<Mechanism>>,
}

impl Outside {
    /// What acts on it now.
    pub(crate) fn new(mechanism: &Mechanism) -> Self {
        Outside {
            gravity: mechanism.gravity,
            forces: mechanism.forces.clone(),
            pushes: Pushes::of(mechanism),
            driven: None,
        }
    }

    /// Whether that is what acts on this mechanism.
    #[inline]
    pub(crate) fn is_that_of(&self, mechanism: &Mechanism) -> bool {
        let same = self.forces.driven == mechanism.forces.driven && self.forces.are_those_of(&mechanism.forces);
        same && self.gravity == mechanism.gravity
    }
}
