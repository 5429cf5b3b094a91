//! The surfaces of mesh files: triangles with colours, read from STL, OBJ and Collada. Logs, pages and collision shapes use them.
//!
//! A surface is a list of triangles in the axes of the file, in metres before the `scale` of a URDF. The unit of a Collada file is applied. Its up
//! axis is not: URDFs are written for viewers of ROS, which ignore it (RViz, "mesh_loader").
//!
//! | file | what is read                                                                                         |
//! |------|------------------------------------------------------------------------------------------------------|
//! | STL  | binary and text                                                                                      |
//! | OBJ  | polygons, normals, and the diffuse colours of the materials in the files it names                    |
//! | DAE  | triangles, strips, fans, polygons; nodes with their transforms; normals, diffuse colours and opacity  |
//!
//! Textures are left out. Corners that are not finite are an error.

mod collada;
mod collada_elements;
mod collada_geometry;
mod collada_materials;
mod collision;
mod error;
mod glb;
mod obj;
mod stl;
mod surface;

pub use collision::{collision_surface, connected_parts};
pub use error::MeshError;
pub use glb::glb;
pub use surface::{Part, Surface};

use std::path::Path;

/// Gives the bytes of another file in the folder of a mesh, by its name, if there is one.
pub type Neighbour<'n> = dyn Fn(&str) -> Option<Vec<u8>> + 'n;

/// Reads a mesh; `ending` is the ending of its name in any case, `neighbour` gives the files of materials that it names.
///
/// # Errors
/// [`MeshError`] if it is of no known kind, damaged, or has no triangles.
pub fn read_surface(ending: &str, data: &[u8], neighbour: &Neighbour) -> Result<Surface, MeshError> {
    if data.starts_with(b"version https://git-lfs.") {
        return Err(MeshError::LfsPointer);
    }
    let surface = match ending.to_ascii_lowercase().as_str() {
        "stl" => stl::read(data)?,
        "obj" => obj::read(data, neighbour)?,
        "dae" => collada::read(data)?,
        ending => return Err(MeshError::UnknownKind { ending: ending.to_string() }),
    };
    surface.checked()
}

/// Reads the bytes of a mesh file, with the files of materials beside it.
///
/// # Errors
/// As of [`read_surface`].
pub fn read_beside(file: &Path, data: &[u8]) -> Result<Surface, MeshError> {
    let neighbour = |name: &str| {
        // A name alone: no file may send readers into other folders.
        std::fs::read(file.with_file_name(Path::new(name).file_name()?)).ok()
    };
    read_surface(&ending_of(file), data, &neighbour)
}

/// Reads a mesh file, with the files of materials beside it.
///
/// # Errors
/// As of [`read_surface`], and [`MeshError::Io`] if it cannot be read.
pub fn read_file(file: &Path) -> Result<Surface, MeshError> {
    read_beside(file, &std::fs::read(file)?)
}

/// The ending of the name of a file, without the dot.
fn ending_of(file: &Path) -> String {
    file.extension().unwrap_or_default().to_string_lossy().into_owned()
}
