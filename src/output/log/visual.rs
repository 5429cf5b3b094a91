//! The visual geometry of a robot as a `foxglove.SceneUpdate`: one entity a link, fixed to the link's frame.
//!
//! Boxes, spheres, cylinders and capsules become primitives with the colour of their material; mesh files are embedded,
//! up to a limit, so that the log shows the robot on any machine; what is beyond is given by its address. Bodies without
//! looks have a stand-in ([`crate::output::log::standin`]).

use crate::mechanism::description::joint::Pose;
use crate::output::log::standin::{STANDIN_COLOR, Standin};
use crate::scene::{Geometry, Link, Shape};
use foxglove::messages::{
    Color, CubePrimitive, CylinderPrimitive, ModelPrimitive, Pose as PoseMessage, Quaternion, SceneEntity, SceneUpdate,
    SpherePrimitive, Vector3 as VectorMessage,
};
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use std::path::{Path, PathBuf};

/// What has no material is drawn in this grey.
const PLAIN: [f64; 4] = [0.7, 0.7, 0.72, 1.0];

/// All meshes in a log together have at most so many bytes.
const MESH_BYTES: u64 = 1 << 26;

/// What is drawn of all robots.
#[derive(Default)]
pub(crate) struct Looks {
    /// One entity a link.
    pub scene: SceneUpdate,
    missing: Vec<String>,
    /// Meshes that name files which are not in the log.
    plain: Vec<PathBuf>,
    mesh_bytes: u64,
}

impl Looks {
    /// What viewers will not see.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let plain = self.plain.first().map(|first| {
            let count = self.plain.len();
            let meshes = if count == 1 { "1 mesh".to_string() } else { format!("{count} meshes") };
            format!(
                "images, materials or parts that {meshes} take from other files are not in the log, so that some viewers \
                 leave them out: {}",
                first.display()
            )
        });
        self.missing.iter().cloned().chain(plain).collect()
    }

    /// Adds the links of a robot that have looks or a stand-in, with `prefix` before their names.
    pub(crate) fn add(&mut self, links: &[Link], prefix: &str, standins: &[Standin]) {
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
                if names_other_files(media_type, &data) && !self.plain.contains(file) {
                    self.plain.push(file.clone());
                }
                // A viewer takes one or the other.
                model.url.clear();
                model.media_type = media_type.to_string();
                model.data = data.into();
            }
            Err(reason) => self.missing.push(format!("the mesh {} is not in the log: {reason}", file.display())),
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

/// Whether a mesh takes something from other files.
fn names_other_files(media_type: &str, data: &[u8]) -> bool {
    let text = || String::from_utf8_lossy(data);
    match media_type {
        // The name of an image file; without an ending it is that of another element.
        "model/vnd.collada+xml" => text()
            .split("<init_from>")
            .skip(1)
            .any(|rest| rest.split('<').next().is_some_and(|name| name.contains('.'))),
        "model/obj" => text().lines().any(|line| line.starts_with("mtllib ")),
        "model/gltf+json" => text()
            .split("\"uri\"")
            .skip(1)
            .any(|rest| !rest.trim_start_matches(|c: char| c == ':' || c.is_whitespace()).starts_with("\"data:")),
        _ => false,
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

#[cfg(test)]
mod tests {
    use super::names_other_files;

    #[test]
    fn a_mesh_with_images_or_materials_in_other_files_is_told_from_one_without() {
        let collada = "model/vnd.collada+xml";
        let cases = [
            (collada, "<image><init_from>carbon.jpg</init_from></image><surface><init_from>carbon</init_from>", true),
            (collada, "<surface><init_from>carbon</init_from></surface>", false),
            ("model/obj", "# leg\nmtllib leg.mtl\nv 0 0 0\n", true),
            ("model/obj", "# mtllib is not used\nv 0 0 0\n", false),
            ("model/gltf+json", r#"{"buffers": [{"uri" : "leg.bin"}]}"#, true),
            ("model/gltf+json", r#"{"buffers": [{"uri": "data:application/octet-stream;base64,AA=="}]}"#, false),
            ("model/stl", "solid mtllib <init_from>a.png", false),
        ];
        for (media_type, text, expected) in cases {
            assert_eq!(names_other_files(media_type, text.as_bytes()), expected, "{text}");
        }
    }
}
