//! Geometry as one `visualization_msgs/msg/MarkerArray` that never changes: every marker is fixed to the frame of a link, or to the world.
//!
//! | geometry       | marker                                                                  |
//! |----------------|-------------------------------------------------------------------------|
//! | box            | `CUBE`, scale = edges (m)                                               |
//! | sphere         | `SPHERE`, scale = diameters                                             |
//! | cylinder       | `CYLINDER` along z, scale = two diameters and the length                |
//! | capsule        | a cylinder and two spheres                                              |
//! | mesh in the log | `TRIANGLE_LIST`, three points a triangle, one marker for each colour   |
//! | other mesh     | `MESH_RESOURCE`, with the address of its file                           |
//!
//! The namespace of a marker is its link or obstacle, its number is 65536 v + k for the k-th marker of the v-th visual or collision shape of it, both
//! from 0. So readers of the log know which triangles belong together.
//!
//! Source: the package `visualization_msgs` of ROS 2.

use crate::mechanism::description::joint::Pose;
use crate::output::log::encoding::cdr::CdrWriter;
use crate::scene::Geometry;
use nalgebra::{Translation3, UnitQuaternion};
use std::rc::Rc;

/// The topic.
pub(crate) const TOPIC: &str = "/visual_markers";

/// Numbers of markers that a visual or collision shape has for itself.
pub(crate) const SHAPES: u32 = 1 << 16;

/// The shape of a marker.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum MarkerShape {
    Cube,
    Sphere,
    Cylinder,
    /// Corners of triangles (m), three each.
    Triangles(Rc<[[f32; 3]]>),
    /// The address of a mesh file, and whether its own colours are shown.
    Mesh(String, bool),
}

impl MarkerShape {
    /// The number of the kind.
    fn kind(&self) -> u32 {
        match self {
            MarkerShape::Cube => 1,
            MarkerShape::Sphere => 2,
            MarkerShape::Cylinder => 3,
            MarkerShape::Mesh(..) => 10,
            MarkerShape::Triangles(_) => 11,
        }
    }
}

/// The markers of a primitive whose frame is `place`: the place, the scale and the shape of each; empty for a mesh.
pub(crate) fn primitives(geometry: &Geometry, place: &Pose) -> Vec<(Pose, [f64; 3], MarkerShape)> {
    let round = |radius: f64, length: f64| [2.0 * radius, 2.0 * radius, length];
    match geometry {
        Geometry::Box { size } => vec![(*place, (*size).into(), MarkerShape::Cube)],
        Geometry::Sphere { radius } => vec![(*place, [2.0 * radius; 3], MarkerShape::Sphere)],
        Geometry::Ellipsoid { radii } => vec![(*place, (2.0 * radii).into(), MarkerShape::Sphere)],
        Geometry::Cylinder { radius, length } => vec![(*place, round(*radius, *length), MarkerShape::Cylinder)],
        Geometry::Capsule { radius, length } => {
            let at = |end: f64| place * Translation3::new(0.0, 0.0, end);
            let ball = |end: f64| (at(end), [2.0 * radius; 3], MarkerShape::Sphere);
            let side = (*place, round(*radius, *length), MarkerShape::Cylinder);
            vec![ball(-0.5 * length), ball(0.5 * length), side]
        }
        Geometry::Mesh(_) => Vec::new(),
    }
}

/// A shape that moves with its frame.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Marker {
    /// The frame of the link, or the world.
    pub frame: String,
    /// The link or obstacle, by which viewers switch it on and off.
    pub namespace: String,
    /// Which of its visuals or collision shapes it shows, from 0; stand-ins come after visuals.
    pub visual: u32,
    /// The place of the shape in it.
    pub pose: Pose,
    /// Edges (m) of a primitive, factors of a mesh.
    pub scale: [f64; 3],
    /// Red, green, blue, opacity.
    pub color: [f64; 4],
    pub shape: MarkerShape,
}

/// Encodes the message; its markers have the time `nanoseconds`.
pub(crate) fn encode_markers(markers: &[Marker], nanoseconds: u64, out: &mut Vec<u8>) {
    let mut writer = CdrWriter::begin(out);
    writer.unsigned(markers.len() as u32);
    let mut before: Option<&Marker> = None;
    let mut shape = 0;
    for marker in markers {
        let goes_on = before.is_some_and(|last| last.namespace == marker.namespace && last.visual == marker.visual);
        shape = if goes_on { shape + 1 } else { 0 };
        before = Some(marker);
        let number = marker.visual * SHAPES + shape;
        let head = Head { frame: &marker.frame, namespace: &marker.namespace, number, nanoseconds };
        write_marker(&head, marker, &mut writer);
    }
}

/// The beginning of every marker.
pub(crate) struct Head<'h> {
    /// The frame in which its pose is.
    pub frame: &'h str,
    /// Together with its number its identity.
    pub namespace: &'h str,
    pub number: u32,
    /// Its time.
    pub nanoseconds: u64,
}

/// The body of a marker: the number of its kind and of its action, whether it follows its frame, place, size and colour.
struct Body {
    kind: u32,
    action: u32,
    follows: bool,
    /// x, y, z (m), then the quaternion x, y, z, w.
    pose: [f64; 7],
    scale: [f64; 3],
    color: [f64; 4],
}

/// The place of a marker whose points are in its frame.
const AT_FRAME: [f64; 7] = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// Adds a marker that deletes all others of its topic.
pub(crate) fn write_deletion(head: &Head, writer: &mut CdrWriter) {
    let delete_all = Body { kind: 0, action: 3, follows: false, pose: AT_FRAME, scale: [1.0; 3], color: [0.0; 4] };
    write_body(head, &delete_all, writer);
    writer.unsigned(0);
    write_rest(head, ("", false), writer);
}

/// Adds an arrow between two points (m), as thick as one of this length should be, in red, green, blue, opacity.
pub(crate) fn write_arrow(head: &Head, ends: [[f64; 3]; 2], length: f64, color: [f64; 4], writer: &mut CdrWriter) {
    // Diameter of the shaft, diameter and length of the head.
    let scale = [0.03 * length, 0.08 * length, 0.2 * length];
    write_body(head, &Body { kind: 0, action: 0, follows: false, pose: AT_FRAME, scale, color }, writer);
    writer.unsigned(ends.len() as u32);
    ends.iter().flatten().for_each(|coordinate| writer.double(*coordinate));
    write_rest(head, ("", false), writer);
}

/// Adds a line of this width through so many points (m), in red, green, blue, opacity.
pub(crate) fn write_line(
    head: &Head,
    (points, count): (impl Iterator<Item = [f64; 3]>, usize),
    width: f64,
    color: [f64; 4],
    writer: &mut CdrWriter,
) {
    let scale = [width, 0.0, 0.0];
    write_body(head, &Body { kind: 4, action: 0, follows: false, pose: AT_FRAME, scale, color }, writer);
    writer.unsigned(count as u32);
    points.flatten().for_each(|coordinate| writer.double(coordinate));
    write_rest(head, ("", false), writer);
}

fn write_marker(head: &Head, marker: &Marker, writer: &mut CdrWriter) {
    let at = marker.pose.translation.vector;
    let turn = UnitQuaternion::from_rotation_matrix(&marker.pose.rotation);
    let pose = [at.x, at.y, at.z, turn.i, turn.j, turn.k, turn.w];
    let kind = marker.shape.kind();
    write_body(head, &Body { kind, action: 0, follows: true, pose, scale: marker.scale, color: marker.color }, writer);
    match &marker.shape {
        MarkerShape::Triangles(corners) => writer.triples(corners),
        _ => writer.unsigned(0),
    }
    let mesh = match &marker.shape {
        MarkerShape::Mesh(address, own_colors) => (address.as_str(), *own_colors),
        _ => ("", false),
    };
    write_rest(head, mesh, writer);
}

/// The fields before the points.
fn write_body(head: &Head, body: &Body, writer: &mut CdrWriter) {
    writer.time(head.nanoseconds);
    writer.string(head.frame);
    writer.string(head.namespace);
    [head.number, body.kind, body.action].into_iter().for_each(|number| writer.unsigned(number));
    body.pose.into_iter().chain(body.scale).for_each(|value| writer.double(value));
    body.color.iter().for_each(|part| writer.single(*part as f32));
    // Shown for ever.
    writer.unsigned(0);
    writer.unsigned(0);
    writer.byte(u8::from(body.follows));
}

/// The fields after the points; a mesh is the address of its file, and whether its own colours are shown.
fn write_rest(head: &Head, (address, own_colors): (&str, bool), writer: &mut CdrWriter) {
    // No colours of points, no texture (address, header, format, bytes), no coordinates in it.
    writer.unsigned(0);
    writer.string("");
    writer.time(head.nanoseconds);
    writer.string("");
    writer.string("");
    writer.unsigned(0);
    writer.unsigned(0);
    // No text.
    writer.string("");
    writer.string(address);
    // No file (name, bytes).
    writer.string("");
    writer.unsigned(0);
    writer.byte(u8::from(own_colors));
}
