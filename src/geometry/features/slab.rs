//! The features of a core in a slab below a support plane, without a look at all others if there are many.
//!
//! The vertices of a convex polytope above any height are connected along edges, and faces and edges in the slab have a vertex in it. So a walk from the
//! top sees what is in the slab and its border, and no more. Facets that a hull has merged are flat to 1e-10 of the size only: the walk goes as much
//! deeper as [`Neighbours::above`] says, and each feature is tested.
//!
//! [`Neighbours::above`]: crate::shapes::neighbours::Neighbours::above

use crate::features::feature::{FeatureId, features, lies_near};
use crate::shapes::convex::Core;
use crate::shapes::polytope::Polytope;
use nalgebra::Vector3;

/// All features that lie in the slab `n · p ≥ least` (m) as a whole, in the order of [`features`].
pub fn lying(core: &Core, normal: &Vector3<f64>, least: f64) -> Vec<FeatureId> {
    match dense(core) {
        Some(polytope) => Slab::new(polytope, normal, least).features(|inside, of| inside == of),
        None => features(core).filter(|&feature| lies_near(core, feature, normal, least)).collect(),
    }
}

/// All features of a dense polytope that reach into the slab, in the order of [`features`]; `None` for other cores.
pub fn reaching(core: &Core, normal: &Vector3<f64>, least: f64) -> Option<Vec<FeatureId>> {
    dense(core).map(|polytope| Slab::new(polytope, normal, least).features(|inside, _| inside > 0))
}

/// The polytope, if its vertices know their neighbours.
fn dense(core: &Core) -> Option<&Polytope> {
    match core {
        Core::Polytope(polytope) => Some(polytope).filter(|polytope| polytope.neighbours.are_known()),
        Core::Cylinder(_) | Core::Ellipsoid(_) => None,
    }
}

/// The part of a polytope above a height.
struct Slab<'p> {
    polytope: &'p Polytope,
    /// Its vertices, in the order of their numbers.
    vertices: Vec<usize>,
}

impl<'p> Slab<'p> {
    fn new(polytope: &'p Polytope, normal: &Vector3<f64>, least: f64) -> Self {
        Slab { polytope, vertices: polytope.neighbours.above(&polytope.vertices, normal, least) }
    }

    /// The features of which a test tells how many of their vertices are above, of how many.
    fn features(&self, is_in: impl Fn(usize, usize) -> bool) -> Vec<FeatureId> {
        let Slab { polytope, vertices } = self;
        let above = |corners: &[usize]| corners.iter().filter(|corner| vertices.binary_search(corner).is_ok()).count();
        let beside = |of: &dyn Fn(usize) -> &'p [u32]| {
            let mut all: Vec<u32> = vertices.iter().flat_map(|&vertex| of(vertex)).copied().collect();
            all.sort_unstable();
            all.dedup();
            all
        };
        let corners_of = |face: &u32| &polytope.faces[*face as usize].corners[..];
        let ends_of = |edge: &u32| &polytope.edges[*edge as usize].ends[..];
        let mut faces = beside(&|vertex| polytope.beside.faces(vertex));
        faces.retain(|face| is_in(above(corners_of(face)), corners_of(face).len()));
        let mut edges = beside(&|vertex| polytope.beside.edges(vertex));
        edges.retain(|edge| is_in(above(ends_of(edge)), 2));
        let faces = faces.into_iter().map(FeatureId::Face);
        let vertices = vertices.iter().map(|&vertex| FeatureId::Vertex(vertex as u32));
        faces.chain(edges.into_iter().map(FeatureId::Edge)).chain(vertices).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::convex::Convex;
    use crate::tests::scenes::Numbers;
    use catena_mechanism::description::contact::Shape;
    use catena_mechanism::description::joint::Pose;
    use std::sync::Arc;

    #[test]
    fn a_walk_finds_the_features_in_a_slab_that_a_look_at_all_of_them_finds() {
        let mut numbers = Numbers::new(6);
        for flat in [false, true] {
            let mut point = || {
                let point = numbers.vector().normalize() * 0.2;
                if flat { Vector3::new(point.x, point.y, point.z.max(-0.1)) } else { point }
            };
            let shape = Shape::Hull(Arc::new((0..600).map(|_| point()).collect()));
            let core = Convex::new(&shape, &Pose::identity()).expect("possible").expect("convex").core;
            let mut counts = [0, 0];
            for round in 0..200 {
                let any = numbers.vector().normalize();
                let normal = if round % 4 == 0 { -Vector3::z() } else { any };
                let least = core.support(&normal) - [0.0, 1e-9, 1e-3, 0.02, 0.5][round % 5];
                let wanted: Vec<FeatureId> =
                    features(&core).filter(|&feature| lies_near(&core, feature, &normal, least)).collect();
                assert_eq!(lying(&core, &normal, least), wanted, "round {round}");
                let reaching = reaching(&core, &normal, least).expect("many vertices");
                assert!(wanted.iter().all(|feature| reaching.contains(feature)));
                counts = [counts[0] + wanted.len(), counts[1] + reaching.len()];
            }
            assert!(counts[0] > 1000 && counts[1] > counts[0] + 1000, "{counts:?}");
        }
    }
}
