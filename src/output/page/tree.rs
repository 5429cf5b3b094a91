//! The tree of a model as a page needs it: links in bodies, bodies on joints, and the ends of loops.
//!
//! The page places bodies as [`crate::mechanism::motion::kinematics`] does:
//!
//! ```text
//!     T_body = T_parent · F_p · D(q) · F_c⁻¹        T_link = T_body · L
//! ```
//!
//! with the joint frame F on the parent and on the child, the displacement D of the joint's positions q, and the link frame L in its
//! body. Poses are x, y, z (m), then the quaternion w, x, y, z.

use crate::mechanism::description::closure::{Attachment, Coordinate, LoopKind};
use crate::mechanism::description::joint::{Pose, wxyz_from_rotation};
use crate::mechanism::motion::state::State;
use crate::model::{Model, RopeRecord};
use serde::Serialize;

/// A pose as x, y, z (m), w, x, y, z.
pub(super) fn pose_numbers(pose: &Pose) -> [f64; 7] {
    let [x, y, z] = pose.translation.vector.into();
    let [qw, qx, qy, qz] = wxyz_from_rotation(pose.rotation.matrix());
    [x, y, z, qw, qx, qy, qz]
}

/// A frame fixed in a body, or in the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Frame {
    /// The body; `null` is the world.
    pub body: Option<usize>,
    /// The frame in the body, or in the world.
    pub pose: [f64; 7],
}

impl From<&Attachment> for Frame {
    fn from(end: &Attachment) -> Self {
        Frame { body: end.body, pose: pose_numbers(&end.frame) }
    }
}

/// A link.
#[derive(Serialize)]
struct LinkInBody<'m> {
    name: &'m str,
    #[serde(flatten)]
    frame: Frame,
}

/// A body and the joint above it.
#[derive(Serialize)]
struct BodyOnJoint<'m> {
    name: &'m str,
    parent: Option<usize>,
    joint: &'m str,
    /// `revolute`, `prismatic`, `planar`, `spherical`, `floating`.
    kind: &'static str,
    on_parent: [f64; 7],
    on_child: [f64; 7],
    /// Its positions at the start.
    start: Vec<f64>,
    /// Limits of joints of one number: from, to (m, rad).
    #[serde(skip_serializing_if = "Option::is_none")]
    limit: Option<[Option<f64>; 2]>,
    /// For a joint that follows another: the body of that joint, the factor, the offset.
    #[serde(skip_serializing_if = "Option::is_none")]
    follows: Option<(usize, f64, f64)>,
}

/// A joint that closes a loop.
#[derive(Serialize)]
struct LoopEnds<'m> {
    name: &'m str,
    kind: &'static str,
    /// The axes along which the ends coincide, and the pairs of axes (of a, of b) that are square: the equations of
    /// [`crate::mechanism::description::closure`].
    slides: &'static [usize],
    squares: &'static [(usize, usize)],
    /// The length of a distance (m).
    length: Option<f64>,
    a: Frame,
    b: Frame,
}

/// The tree of a model.
#[derive(Serialize)]
pub(super) struct Tree<'m> {
    links: Vec<LinkInBody<'m>>,
    bodies: Vec<BodyOnJoint<'m>>,
    loops: Vec<LoopEnds<'m>>,
}

/// A rope, which is drawn as a line.
#[derive(Serialize)]
pub(super) struct DrawnRope<'m> {
    name: &'m str,
    points: Vec<Frame>,
}

/// The ropes of a model; a winch is drawn as the first point of its rope.
pub(super) fn ropes(model: &Model) -> Vec<DrawnRope<'_>> {
    let ropes = model.contact.ropes.iter().filter(|_| !model.contact.owners.is_empty());
    let points = |rope: &RopeRecord| rope.seen_points().iter().map(Frame::from).collect();
    ropes.map(|rope| DrawnRope { name: &rope.name, points: points(rope) }).collect()
}

/// The tree of a model with its joints at `start`.
pub(super) fn tree<'m>(model: &'m Model, start: &State) -> Tree<'m> {
    let mechanism = &model.mechanism;
    let links = model.links.iter().map(|link| {
        let frame = Frame { body: link.body, pose: pose_numbers(&link.in_body) };
        LinkInBody { name: &link.name, frame }
    });
    let finite = |value: f64| value.is_finite().then_some(value);
    let bodies = mechanism.bodies.iter().enumerate().map(|(index, body)| {
        let is_here = |coordinate: &Coordinate| coordinate.body == index;
        let limit = mechanism.limits.iter().find(|limit| is_here(&limit.coordinate));
        let mimic = mechanism.mimics.iter().find(|mimic| mimic.more.is_empty() && is_here(&mimic.follower));
        BodyOnJoint {
            name: &body.name,
            parent: body.parent,
            joint: &body.joint.name,
            kind: body.joint.kind.name(),
            on_parent: pose_numbers(&body.joint.on_parent),
            on_child: pose_numbers(&body.joint.on_child),
            start: start.position[body.joint.position_range()].to_vec(),
            limit: limit.map(|limit| [finite(limit.lower), finite(limit.upper)]),
            follows: mimic.map(|mimic| (mimic.leader.body, mimic.multiplier, mimic.offset)),
        }
    });
    let loops = mechanism.loops.iter().map(|closing| LoopEnds {
        name: &closing.name,
        kind: closing.kind.name(),
        slides: closing.kind.slides(),
        squares: closing.kind.squares(),
        length: if let LoopKind::Distance(length) = closing.kind { Some(length) } else { None },
        a: (&closing.a).into(),
        b: (&closing.b).into(),
    });
    Tree { links: links.collect(), bodies: bodies.collect(), loops: loops.collect() }
}
