//! The forces on a mechanism, as its kernel knows them: a kernel is made for one gravity and one set of forces.

use crate::watching::unseen::Pushes;
use catena_mechanism::description::forces::Forces;
use catena_mechanism::description::mechanism::Mechanism;
use nalgebra::Vector3;
use std::sync::Arc;

/// Gravity and forces on a mechanism, for which a kernel was made.
#[derive(Clone)]
pub(crate) struct Outside {
    gravity: Vector3<f64>,
    forces: Forces,
    /// The sizes of these forces.
    pub(crate) pushes: Pushes,
    /// The mechanism with forces that are driven, once efforts have been handed to a step.
    pub(crate) driven: Option<Arc<Mechanism>>,
}

impl Outside {
    /// The present gravity and forces.
    pub(crate) fn new(mechanism: &Mechanism) -> Self {
        Outside {
            gravity: mechanism.gravity,
            forces: mechanism.forces.clone(),
            pushes: Pushes::of(mechanism),
            driven: None,
        }
    }

    /// Whether this mechanism has the same gravity and forces.
    #[inline]
    pub(crate) fn is_that_of(&self, mechanism: &Mechanism) -> bool {
        let same = self.forces.driven == mechanism.forces.driven && self.forces.are_those_of(&mechanism.forces);
        same && self.gravity == mechanism.gravity
    }
}
