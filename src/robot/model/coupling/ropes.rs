//! Ropes: the ends in their bodies, as a ball from inside and a point that it holds; and the course of a rope through more than two points.
//!
//! A part of a rope between two bodies that became a point would have no direction. So two balls about its ends, with half the diameter `stop`, touch
//! before that: a weight that is drawn up to its eyelet stops there. Neighbours that start nearer than twice the stop have none.

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
        let stops = if points.len() > 2 { self.stops(rope, &points, &links) } else { Vec::new() };
        // What people see begins at the winch.
        if rope.winch.is_some() {
            links.remove(0);
        }
        Ok(RopeRecord { name: rope.name.clone(), links, points, colliders, stops, length, restitution })
    }
    /// The stops between neighbours on different bodies, each once; a winch has none.
    fn stops(&self, rope: &SceneRope, points: &[Attachment], links: &[String]) -> Vec<[Collider; 2]> {
        let mut ends: Vec<([Attachment; 2], &str)> = Vec::new();
        if rope.stop > 0.0 {
            let first = usize::from(rope.winch.is_some());
            for (pair, link) in points.windows(2).zip(&links[1..]).skip(first) {
                let [a, b] = [pair[0], pair[1]];
                let far = (a.place(self.bodies).0 - b.place(self.bodies).0).norm() >= 2.0 * rope.stop;
                let known = ends.iter().any(|(known, _)| *known == [a, b] || *known == [b, a]);
                if a.body != b.body && far && !known {
                    ends.push(([a, b], link));
                }
            }
        }
        let shape = || Shape::Sphere { radius: 0.5 * rope.stop };
        let ball = |name: &str, end: Attachment| Collider::still(name, end.body, end.frame, shape());
        let stop = |([a, b], link): ([Attachment; 2], &str)| [ball(&format!("{}_stop", rope.name), a), ball(link, b)];
        ends.into_iter().map(stop).collect()
    }
}
