//! The meshes of a page: each read once, made of fewer triangles if there are too many, and packed.
//!
//! A corner is three whole numbers k (16 bits each) on a grid over the mesh, so that STL corners that are the same become one:
//!
//! ```text
//!     p = origin + step · k       [m], step = longest edge of the bounding box / 65535
//! ```
//!
//! Triangles are written as distances of their corners from the newest one: corners are numbered in the order in which triangles
//! name them first, and `0` is a new corner, `d` the one `d` before the next new one.

use crate::mechanism::ground::words::counted;
use crate::meshes::read_beside;
use crate::output::log::reading::meshes::LoggedPart;
use crate::output::log::sha256;
use crate::page::packing::{Packed, Place};
use crate::page::simplify::simplify;
use serde::Serialize;
use std::collections::HashMap;
use std::path::PathBuf;

/// The largest number of the grid.
const GRID: f64 = 65535.0;

/// Fewest triangles of a part, however many triangles there are.
const FEWEST: usize = 60;

/// A mesh.
pub(crate) struct MeshData {
    /// The key that tells it from others.
    pub key: String,
    /// Its triangles, or their source.
    pub content: MeshContent,
}

/// The source of the triangles of a mesh.
pub(crate) enum MeshContent {
    /// A mesh file, and its bytes.
    File(PathBuf, Vec<u8>),
    /// A log; the scale of the URDF is in the triangles.
    Log(Vec<LooseTriangles>),
}

/// Triangles of a mesh.
#[cfg(feature = "film")]
pub(crate) struct IndexedPart {
    /// Their colour, if the mesh has one.
    pub color: Option<[f32; 4]>,
    /// Corners (m).
    pub corners: Vec<[f64; 3]>,
    /// Three numbers of corners a triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// A colour, if there is one, and corners (m), three a triangle.
pub(crate) type LooseTriangles = (Option<[f32; 4]>, Vec<[f64; 3]>);

impl MeshData {
    /// The triangles of a log; those that are the same are told by their numbers.
    pub(super) fn of_log(parts: &[LoggedPart]) -> Self {
        let numbers = parts.iter().flat_map(|part| {
            let corners = part.corners.iter().flatten().copied();
            std::iter::once(part.corners.len() as f32).chain(part.color).chain(corners)
        });
        let loose = parts
            .iter()
            .map(|part| (Some(part.color), part.corners.iter().map(|corner| corner.map(f64::from)).collect()));
        let key = sha256(&numbers.flat_map(f32::to_le_bytes).collect::<Vec<u8>>());
        MeshData { key, content: MeshContent::Log(loose.collect()) }
    }
}

/// The meshes of a page.
#[derive(Default)]
pub(crate) struct SharedMeshes {
    known: HashMap<String, Result<usize, String>>,
    meshes: Vec<GridMesh>,
    with_textures: usize,
}

/// A mesh with its corners on the grid.
struct GridMesh {
    origin: [f64; 3],
    step: f64,
    parts: Vec<GridPart>,
}

/// Triangles of one colour.
struct GridPart {
    color: Option<[f32; 4]>,
    corners: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

/// A mesh in the page.
#[derive(Serialize)]
pub(super) struct PackedMesh {
    /// Corner of the bounding box (m).
    origin: [f64; 3],
    /// Width of the grid (m).
    step: f64,
    parts: Vec<PackedPart>,
}

/// Triangles of one colour.
#[derive(Serialize)]
struct PackedPart {
    color: Option<[f32; 4]>,
    /// Three columns of numbers on the grid.
    corners: Place,
    /// Three numbers a triangle.
    triangles: Place,
}

impl SharedMeshes {
    /// Reads a mesh, or finds it among those that were read; its number.
    ///
    /// # Errors
    /// Why it cannot be drawn.
    pub(super) fn add(&mut self, data: MeshData) -> Result<usize, String> {
        if let Some(known) = self.known.get(&data.key) {
            return known.clone();
        }
        let parts: Result<Vec<LooseTriangles>, String> = match data.content {
            MeshContent::File(file, bytes) => {
                read_beside(&file, &bytes).map_err(|error| error.to_string()).map(|surface| {
                    self.with_textures += usize::from(surface.has_images);
                    surface.parts.into_iter().map(|part| (part.color, part.corners)).collect()
                })
            }
            MeshContent::Log(parts) => Ok(parts),
        };
        let number = parts.map(|parts| {
            self.meshes.push(on_grid(&parts));
            self.meshes.len() - 1
        });
        self.known.insert(data.key, number.clone());
        number
    }

    /// Packs all meshes, with at most about `limit` triangles; returns notes about the meshes that were changed for this limit.
    pub(super) fn pack(mut self, limit: usize, packed: &mut Packed) -> (Vec<PackedMesh>, Vec<String>) {
        let notes = self.simplify(limit);
        (self.meshes.iter().map(|mesh| pack_mesh(mesh, packed)).collect(), notes)
    }

    /// The parts of all meshes, with at most about `limit` triangles; and notes, as [`Self::pack`] gives them.
    #[cfg(feature = "film")]
    pub(crate) fn indexed(mut self, limit: usize) -> (Vec<Vec<IndexedPart>>, Vec<String>) {
        let notes = self.simplify(limit);
        let meshes = self.meshes.into_iter().map(|GridMesh { origin, step, parts }| {
            let place = |corner: [f64; 3]| [0, 1, 2].map(|axis| origin[axis] + step * corner[axis]);
            let part = |GridPart { color, corners, triangles }| {
                let corners = corners.into_iter().map(place).collect();
                IndexedPart { color, corners, triangles }
            };
            parts.into_iter().map(part).collect()
        });
        (meshes.collect(), notes)
    }

    /// Leaves at most about `limit` triangles of all meshes; returns notes about the meshes that were changed for this limit, or are not as in their
    /// files.
    fn simplify(&mut self, limit: usize) -> Vec<String> {
        let counts = self.meshes.iter().flat_map(|mesh| &mesh.parts).map(|part| part.triangles.len());
        let counts: Vec<usize> = counts.collect();
        let before: usize = counts.iter().sum();
        let most = most_of_a_part(counts, limit);
        let mut after = 0;
        for part in self.meshes.iter_mut().flat_map(|mesh| &mut mesh.parts) {
            if part.triangles.len() > most {
                simplify(&mut part.corners, &mut part.triangles, most);
                let rounded: Vec<[f64; 3]> =
                    part.corners.iter().map(|v| v.map(|x| x.round().clamp(0.0, GRID))).collect();
                (part.corners, part.triangles) = welded(&rounded, &part.triangles);
            }
            after += part.triangles.len();
        }
        let mut notes = Vec::new();
        if before > after {
            notes.push(format!(
                "meshes are simplified from {before} to {after} triangles; --mesh-limit {before} draws them in full"
            ));
        }
        if self.with_textures > 0 {
            let meshes = counted(self.with_textures, "mesh is", "meshes are");
            notes.push(format!("{meshes} drawn without the images on their surfaces"));
        }
        notes
    }
}

/// The most triangles that a part may have, so that all together have at most `limit`: small parts stay as they are.
fn most_of_a_part(mut counts: Vec<usize>, limit: usize) -> usize {
    counts.sort_unstable();
    let mut left = limit;
    for (index, &count) in counts.iter().enumerate() {
        let share = left / (counts.len() - index);
        if count > share {
            return share.max(FEWEST);
        }
        left -= count;
    }
    usize::MAX
}

/// Puts the corners of a mesh on its grid; parts without area are left out.
fn on_grid(parts: &[LooseTriangles]) -> GridMesh {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for corner in parts.iter().flat_map(|(_, corners)| corners) {
        for axis in 0..3 {
            low[axis] = low[axis].min(corner[axis]);
            high[axis] = high[axis].max(corner[axis]);
        }
    }
    let longest = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    let step = if longest > 0.0 { longest / GRID } else { 1.0 };
    let rounded = |corner: &[f64; 3]| [0, 1, 2].map(|axis| ((corner[axis] - low[axis]) / step).round());
    let parts = parts.iter().map(|(color, corners)| {
        let corners: Vec<[f64; 3]> = corners.iter().map(rounded).collect();
        let triangles: Vec<[u32; 3]> = (0..corners.len() as u32 / 3).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let (corners, triangles) = welded(&corners, &triangles);
        GridPart { color: *color, corners, triangles }
    });
    GridMesh { origin: low, step, parts: parts.filter(|part| !part.triangles.is_empty()).collect() }
}

fn pack_mesh(mesh: &GridMesh, packed: &mut Packed) -> PackedMesh {
    let parts = mesh.parts.iter().map(|part| pack_part(part.color, &part.corners, &part.triangles, packed));
    PackedMesh { origin: mesh.origin, step: mesh.step, parts: parts.collect() }
}

/// Corners on the grid that are the same made one, numbered as triangles name them first; triangles without area left out.
fn welded(corners: &[[f64; 3]], triangles: &[[u32; 3]]) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let mut places: HashMap<[u64; 3], u32> = HashMap::with_capacity(triangles.len() / 2);
    let (mut new_corners, mut new_triangles) = (Vec::new(), Vec::with_capacity(triangles.len()));
    for triangle in triangles {
        let [a, b, c] = triangle.map(|corner| corners[corner as usize].map(f64::to_bits));
        if a == b || b == c || c == a {
            continue;
        }
        new_triangles.push([a, b, c].map(|corner| {
            *places.entry(corner).or_insert_with(|| {
                new_corners.push(corner.map(f64::from_bits));
                new_corners.len() as u32 - 1
            })
        }));
    }
    (new_corners, new_triangles)
}

fn pack_part(color: Option<[f32; 4]>, corners: &[[f64; 3]], triangles: &[[u32; 3]], packed: &mut Packed) -> PackedPart {
    let columns: Vec<u64> = (0..3).flat_map(|axis| corners.iter().map(move |corner| corner[axis] as u64)).collect();
    let mut newest = 0;
    let distances = triangles.iter().flatten().map(|&corner| {
        let distance = newest - u64::from(corner);
        newest = newest.max(u64::from(corner) + 1);
        distance
    });
    let distances: Vec<u64> = distances.collect();
    let (corners, triangles) = (packed.words(&columns, 2, corners.len()), packed.words(&distances, 4, 0));
    PackedPart { color, corners, triangles }
}

#[cfg(test)]
mod tests {
    use super::{most_of_a_part, welded};

    #[test]
    fn small_parts_stay_and_large_ones_share_what_is_left() {
        assert_eq!(most_of_a_part(vec![100, 200, 300], 600), usize::MAX);
        // 100 and 1000 stay, the other two share 11 100 - 1100.
        assert_eq!(most_of_a_part(vec![9000, 100, 50_000, 1000], 11_100), 5000);
        assert_eq!(most_of_a_part(vec![9000; 1000], 1000), super::FEWEST);
        assert_eq!(most_of_a_part(Vec::new(), 0), usize::MAX);
    }

    #[test]
    fn corners_at_the_same_place_are_one_and_triangles_without_area_are_none() {
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3], [1.0, 0.0, 0.0], [5.0; 3]];
        let (corners, triangles) = welded(&corners, &[[5, 1, 2], [0, 3, 1], [3, 4, 2]]);
        assert_eq!(triangles, [[0, 1, 2], [3, 1, 2]]);
        assert_eq!(corners, [[5.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3]]);
    }
}
