//! The polygons of a Collada geometry.
//!
//! ```text
//!     mesh       source …                          rows of numbers: those of its array, `stride` apart
//!                vertices  input POSITION, NORMAL  the rows of a vertex
//!                triangles, tristrips, trifans, polylist, polygons
//!                          input VERTEX, NORMAL offset="k"
//!                          p                       numbers of rows; a corner is so many of them, the k-th for the input of offset k
//! ```
//!
//! Source: Khronos, COLLADA 1.4.1 specification, chapter 5.

use crate::meshes::collada_elements::{Elements, child, children, numbers, wrong};
use crate::meshes::collada_materials::Colors;
use crate::meshes::error::MeshError;
use crate::meshes::surface::{Corner, Placement, Surface};
use nalgebra::{Point3, Vector3};
use roxmltree::Node;

/// Adds the polygons of a geometry.
pub(super) fn add_geometry(
    elements: &Elements,
    geometry: Node,
    placement: &Placement,
    colors: &Colors,
    surface: &mut Surface,
) -> Result<(), MeshError> {
    let Some(mesh) = child(geometry, "mesh") else { return Ok(()) };
    for primitive in mesh.children().filter(Node::is_element) {
        let kind = primitive.tag_name().name();
        if !["triangles", "tristrips", "trifans", "polylist", "polygons"].contains(&kind) {
            continue;
        }
        let inputs = Inputs::new(elements, primitive)?;
        let (color, is_image) = colors.of(primitive.attribute("material").unwrap_or_default());
        surface.has_images |= is_image;
        let part = surface.part(color);
        let mut add = |corners: &mut [Corner]| {
            placement.place(corners);
            part.add_polygon(corners);
        };
        for indices in indices(primitive)? {
            let mut corners = inputs.corners(primitive, &indices)?;
            match kind {
                "triangles" => corners.chunks_exact_mut(3).for_each(&mut add),
                "polylist" => {
                    let counts: Vec<usize> = child(primitive, "vcount").map_or(Ok(Vec::new()), numbers)?;
                    let mut rest = &mut corners[..];
                    for count in counts {
                        let split = rest.split_at_mut_checked(count);
                        let (polygon, after) =
                            split.ok_or_else(|| wrong(primitive, "it has fewer corners than it says"))?;
                        add(polygon);
                        rest = after;
                    }
                }
                "tristrips" => {
                    for (number, strip) in corners.windows(3).enumerate() {
                        // Every other triangle of a strip is the other way round.
                        let mut triangle = [strip[0], strip[1], strip[2]];
                        if number % 2 == 1 {
                            triangle.swap(0, 1);
                        }
                        add(&mut triangle);
                    }
                }
                _ => add(&mut corners),
            }
        }
    }
    Ok(())
}

/// The numbers of each list of corners; of a polygon with holes, of its outside.
fn indices(primitive: Node) -> Result<Vec<Vec<usize>>, MeshError> {
    let holed = children(primitive, "ph").filter_map(|polygon| child(polygon, "p"));
    children(primitive, "p").chain(holed).map(numbers).collect()
}

/// The parts of a corner.
struct Inputs {
    positions: Rows,
    normals: Option<Rows>,
    /// How many numbers a corner has.
    stride: usize,
}

impl Inputs {
    fn new(elements: &Elements, primitive: Node) -> Result<Self, MeshError> {
        let (mut positions, mut normals, mut stride) = (None, None, 1);
        for input in children(primitive, "input") {
            let offset = input.attribute("offset").and_then(|offset| offset.parse().ok()).unwrap_or(0);
            stride = stride.max(usize::saturating_add(offset, 1));
            let source = elements.target(input, "source").ok_or_else(|| wrong(input, "its source does not exist"))?;
            match input.attribute("semantic") {
                Some("VERTEX") => {
                    for of_vertex in children(source, "input") {
                        let rows = || {
                            let source = elements.target(of_vertex, "source");
                            Rows::new(source.ok_or_else(|| wrong(of_vertex, "its source does not exist"))?, offset)
                        };
                        match of_vertex.attribute("semantic") {
                            Some("POSITION") => positions = Some(rows()?),
                            Some("NORMAL") => normals = Some(rows()?),
                            _ => {}
                        }
                    }
                }
                Some("NORMAL") => normals = Some(Rows::new(source, offset)?),
                _ => {}
            }
        }
        let positions = positions.ok_or_else(|| wrong(primitive, "it has no positions"))?;
        Ok(Inputs { positions, normals, stride })
    }

    fn corners(&self, primitive: Node, indices: &[usize]) -> Result<Vec<Corner>, MeshError> {
        let corner = |numbers: &[usize]| {
            let position = Point3::from(self.positions.row(numbers)?);
            let normal = self.normals.as_ref().and_then(|normals| normals.row(numbers)).map(Vector3::from);
            Some(Corner { position, normal })
        };
        let corners: Option<Vec<Corner>> = indices.chunks_exact(self.stride).map(corner).collect();
        corners.ok_or_else(|| wrong(primitive, "a corner does not exist"))
    }
}

/// Rows of three numbers.
struct Rows {
    values: Vec<f64>,
    stride: usize,
    start: usize,
    /// Which of the numbers of a corner tells the row.
    offset: usize,
}

impl Rows {
    fn new(source: Node, offset: usize) -> Result<Self, MeshError> {
        let array = child(source, "float_array").ok_or_else(|| wrong(source, "it has no numbers"))?;
        let accessor = child(source, "technique_common").and_then(|common| child(common, "accessor"));
        let number = |name: &str| accessor.and_then(|accessor| accessor.attribute(name)?.parse().ok());
        let (stride, start) = (number("stride").unwrap_or(3), number("offset").unwrap_or(0));
        Ok(Rows { values: numbers(array)?, stride, start, offset })
    }

    /// The row of a corner.
    fn row(&self, corner: &[usize]) -> Option<[f64; 3]> {
        let first = corner.get(self.offset)?.checked_mul(self.stride)?.checked_add(self.start)?;
        self.values.get(first..)?.first_chunk().copied()
    }
}
