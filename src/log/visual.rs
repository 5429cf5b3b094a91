//! The visual geometry of a robot as a `foxglove.SceneUpdate`: one entity a link, fixed to the link's frame.
//!
//! Boxes, spheres, cylinders and capsules become primitives with the colour of their material; meshes are given by
//! their address, because the log is not the place to keep them.

use crate::model::Pose;
use crate::scene::{Geometry, Link, Shape};
use foxglove::messages::{
    Color, CubePrimitive, CylinderPrimitive, ModelPrimitive, Pose as PoseMessage, Quaternion, SceneEntity,
    SpherePrimitive, Vector3 as VectorMessage,
};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

/// What has no material is drawn in this grey.
const PLAIN: [f64; 4] = [0.7, 0.7, 0.72, 1.0];

/// The links of a robot that have looks, with `prefix` before their names.
pub(super) fn entities(links: &[Link], prefix: &str) -> impl Iterator<Item = SceneEntity> {
    let drawn = links.iter().filter(|link| !link.visuals.is_empty());
    drawn.map(move |link| entity(link, format!("{prefix}{}", link.name)))
}

fn entity(link: &Link, name: String) -> SceneEntity {
    let mut entity = SceneEntity { frame_id: name.clone(), id: name, frame_locked: true, ..SceneEntity::default() };
    link.visuals.iter().for_each(|visual| add(&mut entity, visual));
    entity
}

fn add(entity: &mut SceneEntity, visual: &Shape) {
    let [r, g, b, a] = visual.color.unwrap_or(PLAIN);
    let color = Some(Color { r, g, b, a });
    let mut ball = |pose: &Pose, radius: f64| {
        let size = Some(vector(&Vector3::repeat(2.0 * radius)));
        entity.spheres.push(SpherePrimitive { pose: Some(place(pose)), size, color });
    };
    let pose = Some(place(&visual.origin));
    match &visual.geometry {
        Geometry::Box { size } => entity.cubes.push(CubePrimitive { pose, size: Some(vector(size)), color }),
        Geometry::Sphere { radius } => ball(&visual.origin, *radius),
        Geometry::Cylinder { radius, length } => entity.cylinders.push(cylinder(pose, *radius, *length, color)),
        Geometry::Capsule { radius, length } => {
            for end in [-0.5 * length, 0.5 * length] {
                ball(&(visual.origin * Translation3::new(0.0, 0.0, end)), *radius);
            }
            entity.cylinders.push(cylinder(pose, *radius, *length, color));
        }
        Geometry::Mesh(mesh) => entity.models.push(ModelPrimitive {
            pose,
            scale: Some(vector(&mesh.scale)),
            color,
            override_color: visual.color.is_some(),
            url: match &mesh.resolved {
                Some(file) => format!("file://{}", file.display()),
                None => mesh.path.clone(),
            },
            ..ModelPrimitive::default()
        }),
    }
}

fn cylinder(pose: Option<PoseMessage>, radius: f64, length: f64, color: Option<Color>) -> CylinderPrimitive {
    let size = Some(vector(&Vector3::new(2.0 * radius, 2.0 * radius, length)));
    CylinderPrimitive { pose, size, bottom_scale: 1.0, top_scale: 1.0, color }
}

fn place(pose: &Pose) -> PoseMessage {
    let turn = UnitQuaternion::from_rotation_matrix(&pose.rotation);
    PoseMessage {
        position: Some(vector(&pose.translation.vector)),
        orientation: Some(Quaternion { x: turn.i, y: turn.j, z: turn.k, w: turn.w }),
    }
}

fn vector(vector: &Vector3<f64>) -> VectorMessage {
    VectorMessage { x: vector.x, y: vector.y, z: vector.z }
}
