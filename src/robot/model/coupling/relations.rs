//! Linear relations of joints of a scene file, `Σ c_i q_i = offset`, as mimic relations: the first joint follows the others,
//! `q₁ = Σ (−c_i / c₁) q_i + offset / c₁`.

use crate::mechanism::description::closure::{Coordinate, Mimic};
use crate::model::coupling::builder::Builder;
use crate::model::description::model_error::ModelError;
use crate::scene::Element;

impl Builder<'_> {
    /// The relations of the scene file.
    ///
    /// # Errors
    /// [`ModelError::Coupling`] with the line, for a joint without the one coordinate that it is about.
    pub(crate) fn relations(&self) -> Result<Vec<Mimic>, ModelError> {
        let mut relations = Vec::new();
        for coupling in self.scene.iter().flat_map(|scene| &scene.couplings) {
            let stand = self.stand(coupling.line, Element::Coupling(coupling.name.clone()));
            let mut terms: Vec<(Coordinate, f64)> = Vec::with_capacity(coupling.terms.len());
            for (joint, coefficient) in &coupling.terms {
                terms.push((self.coordinate(joint.robot, &joint.joint, &stand)?, *coefficient));
            }
            // The reader has asked for two joints or more.
            let [(follower, first), (leader, second), more @ ..] = &terms[..] else { continue };
            relations.push(Mimic {
                name: coupling.name.clone(),
                follower: *follower,
                leader: *leader,
                multiplier: -second / first,
                offset: coupling.offset / first,
                more: more.iter().map(|&(own, coefficient)| (own, -coefficient / first)).collect(),
                over_time: None,
            });
        }
        Ok(relations)
    }
}
