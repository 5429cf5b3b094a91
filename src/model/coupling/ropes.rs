//! Ropes: the ends in their bodies, as a ball from inside and a point that it holds; and the course of a rope through more than two points.

use crate::mechanism::description::closure::Attachment;
use crate::mechanism::description::contact::{Collider, Shape, apart};
use crate::model::coupling::builder::Builder;
use crate::model::coupling::forces::frame_at;
use crate::model::description::contact_pairs::RopeRecord;
use crate::model::description::coupling_error::CouplingProblem;
use crate::model::description::model_error::ModelError;
use crate::scene::{Element, SceneRope};

impl Builder<'_> {
    /// A rope of the scene file.
    pub(crate) fn rope(&self, rope: &SceneRope) -> Result<RopeRecord, ModelError> {
        let stand = self.stand(rope.line, Element::Rope(rope.name.clone()));
        let (mut points, mut links) = (Vec::new(), Vec::new());
        for point in &rope.points {
            let end = self.end(point.link, &frame_at(&point.position), &stand)?;
            points.push(end.attachment);
            links.push(end.link);
        }
        let last = links.last().cloned().unwrap_or_default();
        // The first two that two bodies have, or of a rope between two points its ends.
        let ends = if let [a, b] = points[..] { Some([a, b]).filter(|_| a.body != b.body) } else { apart(&points) };
        let Some([a, b]) = ends else {
            let first = links.first().cloned().unwrap_or_default();
            return Err(stand.refuse(CouplingProblem::IdleRope { a: first, b: last }));
        };
        let collider = |name: &str, end: Attachment, shape| Collider::still(name, end.body, end.frame, shape);
        let colliders =
            [collider(&rope.name, a, Shape::Hollow { radius: rope.length }), collider(&last, b, Shape::Point)];
        let (length, restitution) = (rope.length, rope.restitution);
        // What people see begins at the winch.
        if rope.winch.is_some() {
            links.remove(0);
        }
        Ok(RopeRecord { name: rope.name.clone(), links, points, colliders, length, restitution })
    }
}
