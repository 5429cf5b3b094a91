//! Ropes: the ends in their bodies, as a ball from inside and a point that it holds.

use crate::mechanism::description::contact::{Collider, Shape};
use crate::model::coupling::builder::{Builder, End};
use crate::model::coupling::forces::frame_at;
use crate::model::description::contact_pairs::RopeRecord;
use crate::model::description::coupling_error::CouplingProblem;
use crate::model::description::model_error::ModelError;
use crate::scene::{Element, Point, SceneRope};

impl Builder<'_> {
    /// A rope of the scene file.
    pub(crate) fn rope(&self, rope: &SceneRope) -> Result<RopeRecord, ModelError> {
        let stand = self.stand(rope.line, Element::Rope(rope.name.clone()));
        let end = |point: &Point| self.end(point.link, &frame_at(&point.position), &stand);
        let [a, b]: [End; 2] = [end(&rope.ends[0])?, end(&rope.ends[1])?];
        if a.attachment.body == b.attachment.body {
            return Err(stand.refuse(CouplingProblem::IdleRope { a: a.link, b: b.link }));
        }
        let collider =
            |name: &str, end: &End, shape| Collider::still(name, end.attachment.body, end.attachment.frame, shape);
        let colliders =
            [collider(&rope.name, &a, Shape::Hollow { radius: rope.length }), collider(&b.link, &b, Shape::Point)];
        let (length, restitution) = (rope.length, rope.restitution);
        Ok(RopeRecord { name: rope.name.clone(), links: [a.link, b.link], colliders, length, restitution })
    }
}
