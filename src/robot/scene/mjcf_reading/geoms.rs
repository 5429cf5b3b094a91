//! Geoms of MJCF: shapes with their frames, looks and masses.

use crate::meshes::collision_surface;
use crate::scene::body::{SceneBody, Weight};
use crate::scene::bounded::read_bounded;
use crate::scene::error::SceneError;
use crate::scene::mjcf_reading::grips::Grip;
use crate::scene::mjcf_reading::mass::{Inside, MassOf, Solid, of_triangles};
use crate::scene::mjcf_reading::parts::{Form, Geom};
use crate::scene::mjcf_reading::reader::Reader;
use crate::scene::mjcf_reading::tree::Element;
use crate::scene::numbers::{normalised, turn_of_z};
use crate::scene::robot::{Geometry, MeshFile, Pose, Surface};
use nalgebra::{Matrix3, Rotation3, Translation3, Vector3};
use std::path::Path;

/// Density of a geom by default [kg/m³].
const DENSITY: f64 = 1000.0;

/// Groups above this one are not shown.
const LAST_SHOWN: f64 = 2.0;

impl Reader<'_> {
    /// A geom of a body whose class is `inherited`, and its mass.
    pub fn geom(&mut self, given: &Element, inherited: Option<&str>) -> Result<(Geom, Option<MassOf>), SceneError> {
        let geom = self.defaults.applied(given, inherited);
        let default_kind = if geom.text("mesh").is_some() { "mesh" } else { "sphere" };
        let kind = geom.text("type").unwrap_or(default_kind).to_string();
        let fitted = self.fitted(&geom, &kind)?;
        let given = geom.list("size", 1, 3)?.unwrap_or_default();
        let size = fitted.as_ref().map_or(given, |(_, sizes)| sizes.clone());
        let sizes = |count: usize| match size.get(..count) {
            Some(numbers) if numbers.iter().all(|number| *number > 0.0) => Ok(numbers.to_vec()),
            _ => Err(geom.error("size", format!("its shape needs {count} numbers greater than zero"))),
        };
        let mut pose = self.angles.pose(&geom)?;
        if let Some((frame, _)) = &fitted {
            pose *= frame;
        }
        // Capsules and the like from one point to another: their z is along the line.
        let mut half = None;
        if let Some(ends) = geom.list("fromto", 6, 6)? {
            let (from, to) = (Vector3::from_column_slice(&ends[..3]), Vector3::from_column_slice(&ends[3..]));
            let along = to - from;
            let z = normalised(&along).ok_or_else(|| geom.error("fromto", "both ends are one point".to_string()))?;
            // MuJoCo's z is from the second point to the first.
            pose = Pose::from_parts(Translation3::from((from + to) * 0.5), turn_of_z(&-z));
            half = Some(0.5 * along.norm());
        }
        let long = |sizes: &dyn Fn(usize) -> Result<Vec<f64>, SceneError>| -> Result<(f64, f64), SceneError> {
            Ok(match half {
                Some(half) => (sizes(1)?[0], 2.0 * half),
                None => {
                    let both = sizes(2)?;
                    (both[0], 2.0 * both[1])
                }
            })
        };
        let across = |sizes: &dyn Fn(usize) -> Result<Vec<f64>, SceneError>| -> Result<Vector3<f64>, SceneError> {
            Ok(match half {
                Some(half) => Vector3::new(sizes(1)?[0], sizes(1)?[0], half),
                None => Vector3::from_column_slice(&sizes(3)?),
            })
        };
        let mut ellipsoid = None;
        let form = match kind.as_str() {
            "plane" => Form::Plane,
            "sphere" => Form::Solid(Geometry::Sphere { radius: sizes(1)?[0] }),
            "capsule" => {
                let (radius, length) = long(&sizes)?;
                Form::Solid(Geometry::Capsule { radius, length })
            }
            "cylinder" => {
                let (radius, length) = long(&sizes)?;
                Form::Solid(Geometry::Cylinder { radius, length })
            }
            "box" => Form::Solid(Geometry::Box { size: 2.0 * across(&sizes)? }),
            "mesh" => match geom.text("mesh").and_then(|name| self.meshes.get(name)) {
                Some((mesh, _)) => Form::Solid(Geometry::Mesh(mesh.clone())),
                // It was told of where it stands.
                None if geom.text("mesh").is_some_and(|name| self.left_out.contains(name)) => Form::Other,
                None => return Err(geom.error("mesh", "there is no such mesh among the assets".to_string())),
            },
            "hfield" => match geom.text("hfield").and_then(|name| self.fields.get(name)) {
                Some(file) => Form::Field(file.clone()),
                // A picture was told of where it stands.
                None => Form::Other,
            },
            "ellipsoid" => {
                let radii = across(&sizes)?;
                ellipsoid = Some(radii);
                Form::Solid(Geometry::Ellipsoid { radii })
            }
            other => {
                self.not_simulated(&geom, format!("a geom of the type {other:?} touches nothing and has no mass"));
                Form::Other
            }
        };
        let integer = |name: &str, otherwise: f64| Ok::<f64, SceneError>(geom.number(name)?.unwrap_or(otherwise));
        let (own, others) = (integer("contype", 1.0)?, integer("conaffinity", 1.0)?);
        let material = geom.text("material").and_then(|name| self.colors.get(name).copied());
        let color = match geom.list("rgba", 4, 4)? {
            Some(rgba) => Some([rgba[0], rgba[1], rgba[2], rgba[3]]),
            None => material,
        };
        let group = integer("group", 0.0)?;
        let mass = if self.compiler.weighs(group) { self.mass_of(&geom, &form, ellipsoid, &pose)? } else { None };
        if mass.is_some() && geom.flag("shellinertia") == Some(true) {
            self.odd(&geom, "shellinertia is not read: the shape is solid".to_string());
        }
        for soft in ["solref", "solimp", "margin", "gap"] {
            if geom.text(soft).is_some() {
                self.ignored_attribute(&geom, soft);
            }
        }
        let read = Geom {
            name: geom.text("name").map(str::to_string),
            form,
            pose,
            touches: own != 0.0 || others != 0.0 || geom.text("name").is_some_and(|name| self.paired.contains(name)),
            masks: [own as u32, others as u32],
            is_shown: group <= LAST_SHOWN,
            color,
            grip: Grip::of(&geom)?,
        };
        Ok((read, mass))
    }

    /// The mass of a geom: its own, or that of its density.
    fn mass_of(
        &mut self,
        geom: &Element,
        form: &Form,
        ellipsoid: Option<Vector3<f64>>,
        pose: &Pose,
    ) -> Result<Option<MassOf>, SceneError> {
        let density = geom.number("density")?.unwrap_or(DENSITY);
        let given = geom.number("mass")?;
        if given == Some(0.0) || (given.is_none() && density == 0.0) {
            return Ok(None);
        }
        let weight = given.map_or(Weight::Density(density), Weight::Mass);
        let scaled = |volume: f64| given.unwrap_or(density * volume);
        if let Some(half) = ellipsoid {
            let mass = scaled(4.0 / 3.0 * std::f64::consts::PI * half.x * half.y * half.z);
            let [x, y, z] = [half.x * half.x, half.y * half.y, half.z * half.z];
            let moments = mass / 5.0 * Vector3::new(y + z, z + x, x + y);
            return Ok(Some(MassOf { mass, frame: *pose, inertia: Matrix3::from_diagonal(&moments) }));
        }
        match form {
            Form::Solid(Geometry::Mesh(mesh)) => {
                let Some(Solid { volume, center, inertia }) = self.solid(geom, mesh)? else { return Ok(None) };
                let mass = scaled(volume);
                let at = Pose::from_parts(Translation3::from(center), Rotation3::identity());
                Ok(Some(MassOf { mass, frame: pose * at, inertia: mass / volume * inertia }))
            }
            Form::Solid(shape) => {
                let body = SceneBody { shape: shape.clone(), weight, color: None, surface: Surface::default() };
                let inertia = Matrix3::from_diagonal(&body.moments());
                Ok(Some(MassOf { mass: body.mass(), frame: *pose, inertia }))
            }
            Form::Plane | Form::Field(_) | Form::Other => Ok(None),
        }
    }

    /// Volume, centre and inertia of unit density of a mesh; `None` with a warning for a mesh that is not found or not closed.
    pub fn solid(&mut self, geom: &Element, mesh: &MeshFile) -> Result<Option<Solid>, SceneError> {
        let bytes = match self.made.get(&mesh.path) {
            Some(bytes) => Ok(bytes.to_vec()),
            None => read_bounded(&self.folder.join(&mesh.path)).map_err(|error| error.to_string()),
        };
        let surface = bytes.and_then(|bytes| {
            collision_surface(Path::new(&mesh.path), &bytes, &mesh.scale).map_err(|error| error.to_string())
        });
        let surface = match surface {
            Ok(surface) => surface,
            Err(reason) => {
                self.odd(geom, format!("the mesh {:?} has no mass: {reason}", mesh.path));
                return Ok(None);
            }
        };
        let corner = |index: u32| surface.vertices[index as usize];
        let inside =
            geom.text("mesh").and_then(|name| self.meshes.get(name)).map_or(Inside::Legacy, |(_, inside)| *inside);
        let triangles: Vec<_> = surface.triangles.iter().map(|triangle| triangle.map(corner)).collect();
        let solid = of_triangles(&triangles, inside);
        if solid.is_none() {
            self.odd(geom, format!("the mesh {:?} encloses nothing and has no mass", mesh.path));
        }
        Ok(solid)
    }
}
