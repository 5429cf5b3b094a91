//! The visual geometry of a robot as a `foxglove.SceneUpdate`: one entity a link, fixed to the link's frame.
//!
//! Boxes, spheres, cylinders and capsules become primitives with the colour of their material; mesh files are embedded,
//! up to a limit, so that the log shows the robot on any machine; what is beyond is given by its address. Bodies without
//! looks have a stand-in ([`super::standin`]).

use super::standin::{STANDIN_COLOR, Standin};
use crate::model::Pose;
use crate::scene::{Geometry, Link, Shape};
use foxglove::messages::{
    Color, CubePrimitive, CylinderPrimitive, ModelPrimitive, Pose as PoseMessage, Quaternion, SceneEntity, SceneUpdate,
    SpherePrimitive, Vector3 as VectorMessage,
};
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use std::path::Path;

/// What has no material is drawn in this grey.
const PLAIN: [f64; 4] = [0.7, 0.7, 0.72, 1.0];

/// All meshes in a log together have at most so many bytes.
const MESH_BYTES: u64 = 1 << 26;

/// What is drawn of all robots.
#[derive(Default)]
pub(super) struct Looks {
    /// One entity a link.
    pub scene: SceneUpdate,
    /// What viewers will not see.
    pub warnings: Vec<String>,
    mesh_bytes: u64,
}

impl Looks {
    /// Adds the links of a robot that have looks or a stand-in, with `prefix` before their names.
    pub(super) fn add(&mut self, links: &[Link], prefix: &str, standins: &[Standin]) {
        for (index, link) in links.iter().enumerate() {
            let name = format!("{prefix}{}", link.name);
            let mut entity =
                SceneEntity { frame_id: name.clone(), id: name, frame_locked: true, ..SceneEntity::default() };
            link.visuals.iter().for_each(|visual| self.add_shape(&mut entity, visual));
            for standin in standins.iter().filter(|standin| standin.link == index) {
                let [r, g, b, a] = STANDIN_COLOR;
                entity.cubes.push(CubePrimitive {
                    pose: Some(place(&standin.pose)),
                    size: Some(vector(&standin.size)),
                    color: Some(Color { r, g, b, a }),
                });
            }
            let shapes = entity.cubes.len() + entity.spheres.len() + entity.cylinders.len() + entity.models.len();
            if shapes > 0 {
                self.scene.entities.push(entity);
            }
        }
    }

    fn add_shape(&mut self, entity: &mut SceneEntity, visual: &Shape) {
        add(entity, visual);
        let (Geometry::Mesh(mesh), Some(model)) = (&visual.geometry, entity.models.last_mut()) else { return };
        // What was not found is a warning of the robot's already.
        let Some(file) = &mesh.resolved else { return };
        match self.mesh(file) {
            Ok((media_type, data)) => {
                // A viewer takes one or the other.
                model.url.clear();
                model.media_type = media_type.to_string();
                model.data = data.into();
            }
            Err(reason) => self.warnings.push(format!("the mesh {} is not in the log: {reason}", file.display())),
        }
    }

    /// The kind and the bytes of a mesh file, if they may be in the log.
    fn mesh(&mut self, file: &Path) -> Result<(&'static str, Vec<u8>), String> {
        let ending = file.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
        let media_type = match ending.as_str() {
            "stl" => "model/stl",
            "dae" => "model/vnd.collada+xml",
            "obj" => "model/obj",
            "glb" => "model/gltf-binary",
            "gltf" => "model/gltf+json",
            _ => return Err(format!("viewers do not know files that end in {ending:?}")),
        };
        let size = std::fs::metadata(file).map_err(|error| error.to_string())?.len();
        if self.mesh_bytes + size > MESH_BYTES {
            return Err(format!("all meshes together are larger than {} MiB", MESH_BYTES >> 20));
        }
        let data = std::fs::read(file).map_err(|error| error.to_string())?;
        self.mesh_bytes += size;
        Ok((media_type, data))
    }
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
