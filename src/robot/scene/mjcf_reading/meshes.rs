//! Meshes of MJCF: files, and vertices that the file has itself.
//!
//! A mesh with `vertex` and `face` is the triangles between its vertices, one without `face` the convex hull of its vertices. It becomes an OBJ file in
//! memory, as height fields do ([`super::fields`]).

use crate::geometry::hull_surface;
use crate::scene::error::SceneError;
use crate::scene::mjcf_reading::fields::Field;
use crate::scene::mjcf_reading::mass::Inside;
use crate::scene::mjcf_reading::reader::Reader;
use crate::scene::mjcf_reading::tree::Element;
use crate::scene::robot::MeshFile;
use nalgebra::Vector3;
use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

/// Most numbers of a mesh in the file itself.
const MOST: usize = 3_000_000;

impl Reader<'_> {
    /// A mesh among the assets.
    pub fn mesh(&mut self, asset: &Element) -> Result<(), SceneError> {
        if asset.flag("shellinertia") == Some(true) {
            self.odd(asset, "shellinertia is not read: the mesh is solid".to_string());
        }
        if asset.text("refpos").is_some() || asset.text("refquat").is_some() {
            self.odd(asset, "refpos and refquat of a mesh are not read".to_string());
        }
        let file = asset.text("file");
        let stem = || file.and_then(|file| Path::new(file).file_stem()).map(|stem| stem.to_string_lossy().into_owned());
        let name = asset.text("name").map(str::to_string).or_else(stem).unwrap_or_default();
        let path = match (file, asset.list("vertex", 0, MOST)?) {
            (Some(file), _) => self.compiler.asset_file(file).to_string_lossy().into_owned(),
            (None, Some(vertices)) => {
                let path = format!("{}.mesh.obj", name.replace(['/', '\\'], "_"));
                let obj = obj_of(asset, &vertices)?;
                self.made.insert(path.clone(), Arc::new(obj.into_bytes()));
                path
            }
            (None, None) => {
                self.not_simulated(asset, "a mesh without a file or vertices is left out".to_string());
                self.left_out.insert(name);
                return Ok(());
            }
        };
        let scale = asset.vector("scale")?.unwrap_or(Vector3::repeat(1.0));
        let inside = match asset.text("inertia").unwrap_or("legacy") {
            "legacy" if !self.compiler.exact_meshes => Inside::Legacy,
            "legacy" | "exact" => Inside::Exact,
            other => {
                self.odd(asset, format!("inertia {other:?} of a mesh is read as \"exact\""));
                Inside::Exact
            }
        };
        self.meshes.insert(name, (MeshFile { path, resolved: None, scale, carried: None }, inside));
        Ok(())
    }

    /// A height field among the assets.
    pub fn height_field(&mut self, asset: &Element) -> Result<(), SceneError> {
        let path = asset.text("file").map(|file| self.folder.join(self.compiler.asset_file(file)));
        match Field::read(asset, path.as_deref())? {
            Some((name, field)) => {
                self.made.insert(field.file.clone(), Arc::new(field.obj().into_bytes()));
                self.fields.insert(name, field.file);
            }
            None => {
                let message = "a height field from a picture is not read: write its numbers as elevation";
                self.not_simulated(asset, message.to_string());
            }
        }
        Ok(())
    }
}

/// The triangles of a mesh or of the hull of its vertices as an OBJ file.
fn obj_of(asset: &Element, numbers: &[f64]) -> Result<String, SceneError> {
    let refuse = |name: &str, reason: &str| asset.error(name, reason.to_string());
    if !numbers.len().is_multiple_of(3) || numbers.len() < 12 {
        return Err(refuse("vertex", "four points of three numbers are wanted at least"));
    }
    let mut vertices: Vec<Vector3<f64>> = numbers.chunks_exact(3).map(Vector3::from_column_slice).collect();
    let triangles: Vec<[usize; 3]> = match asset.list("face", 0, MOST)? {
        None => {
            let hull = hull_surface(&vertices).map_err(|error| refuse("vertex", &error.to_string()))?;
            vertices = hull.vertices;
            hull.triangles.iter().map(|corners| corners.map(|corner| corner as usize)).collect()
        }
        Some(corners) => {
            let is_known = |corner: &f64| corner.fract() == 0.0 && (0.0..vertices.len() as f64).contains(corner);
            if !corners.len().is_multiple_of(3) || !corners.iter().all(is_known) {
                return Err(refuse("face", "it is no list of triangles, of three numbers of vertices from 0 each"));
            }
            corners.chunks_exact(3).map(|corners| [0, 1, 2].map(|at: usize| corners[at] as usize)).collect()
        }
    };
    let mut text = String::new();
    // Writing into a String cannot fail. Corners count from one.
    for [x, y, z] in vertices.iter().map(|vertex| [vertex.x, vertex.y, vertex.z]) {
        let _ = writeln!(text, "v {x:?} {y:?} {z:?}");
    }
    for [a, b, c] in triangles {
        let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    Ok(text)
}
