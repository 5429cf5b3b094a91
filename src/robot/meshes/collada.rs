//! Collada files (DAE): the scene, with the transforms of its nodes.
//!
//! ```text
//!     COLLADA  asset        unit meter="u"                        lengths of the file are u metres
//!              scene        instance_visual_scene                 which scene is shown
//!              visual_scene node … node                           a tree; a node is placed in its parent by the product of its
//!                                                                 matrix, translate, rotate and scale elements in their order
//!              node         instance_geometry, instance_controller, instance_node, node
//! ```
//!
//! The axis that points up is not heeded ([`crate::meshes`] says why). Source: Khronos, COLLADA 1.4.1 specification, chapters 5 and 8.

use crate::meshes::collada_elements::{Elements, child, children, is_named, numbers, wrong};
use crate::meshes::collada_geometry::add_geometry;
use crate::meshes::collada_materials::Colors;
use crate::meshes::error::MeshError;
use crate::meshes::surface::{Placement, Surface};
use nalgebra::{Affine3, Matrix4, Rotation3, Translation3, Unit, Vector3};
use roxmltree::{Document, Node, ParsingOptions};

/// Nodes deeper than this are taken for a circle of instances.
const DEEPEST: usize = 64;

/// More nodes than any scene shows; where they name each other twice at every level they double with it.
const MOST_NODES: usize = 100_000;

/// Reads a Collada file.
pub(super) fn read(data: &[u8]) -> Result<Surface, MeshError> {
    let text = String::from_utf8_lossy(data);
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text.trim_start_matches('\u{feff}'), options).map_err(|error| {
        let reason: String = error.to_string().chars().map(|c| if c.is_control() { '?' } else { c }).collect();
        MeshError::Damaged(format!("it is not well-formed XML: {reason}"))
    })?;
    let elements = Elements::new(&document);
    let unit = child(elements.root(), "asset").and_then(|asset| child(asset, "unit"));
    let unit = unit.and_then(|unit| unit.attribute("meter")?.parse().ok()).filter(|unit| *unit > 0.0).unwrap_or(1.0);
    let metres = Affine3::from_matrix_unchecked(Matrix4::new_scaling(unit));
    let mut surface = Surface::default();
    let shown = child(elements.root(), "scene").and_then(|scene| child(scene, "instance_visual_scene"));
    let shown = shown.and_then(|instance| elements.target(instance, "url"));
    let scenes: Vec<Node> = match shown {
        Some(scene) => vec![scene],
        None => elements.root().descendants().filter(|node| is_named(*node, "visual_scene")).collect(),
    };
    let mut scene = Scene { elements: &elements, surface: &mut surface, nodes: 0 };
    for node in scenes.iter().flat_map(|scene| children(*scene, "node")) {
        scene.add_node(node, metres, 0)?;
    }
    if scenes.is_empty() {
        for geometry in elements.root().descendants().filter(|node| is_named(*node, "geometry")) {
            scene.add_geometry(geometry, geometry, metres)?;
        }
    }
    Ok(surface)
}

/// A scene as far as it was read.
struct Scene<'e, 'd> {
    elements: &'e Elements<'d>,
    surface: &'e mut Surface,
    /// How many nodes were shown.
    nodes: usize,
}

impl<'d> Scene<'_, 'd> {
    /// Adds what a node and those below it show; the node's parent is placed by `parent`.
    fn add_node(&mut self, node: Node<'d, 'd>, parent: Affine3<f64>, depth: usize) -> Result<(), MeshError> {
        self.nodes += 1;
        if depth > DEEPEST || self.nodes > MOST_NODES {
            return Err(wrong(node, "its nodes contain each other"));
        }
        let mut place = parent;
        for element in node.children().filter(Node::is_element) {
            if let Some(step) = transform(element)? {
                place *= step;
            }
        }
        for element in node.children().filter(Node::is_element) {
            let target = self.elements.target(element, "url");
            match element.tag_name().name() {
                "node" => self.add_node(element, place, depth + 1)?,
                "instance_node" => {
                    let target = target.ok_or_else(|| wrong(element, "its node does not exist"))?;
                    self.add_node(target, place, depth + 1)?;
                }
                "instance_geometry" | "instance_controller" => {
                    // The skin of a controller refers to a geometry.
                    let geometry = match target.and_then(|target| child(target, "skin")) {
                        Some(skin) => self.elements.target(skin, "source"),
                        None => target,
                    };
                    let geometry = geometry.ok_or_else(|| wrong(element, "its geometry does not exist"))?;
                    self.add_geometry(geometry, element, place)?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Adds a geometry, which `instance` shows.
    fn add_geometry(
        &mut self,
        geometry: Node<'d, 'd>,
        instance: Node<'d, 'd>,
        place: Affine3<f64>,
    ) -> Result<(), MeshError> {
        let colors = Colors { elements: self.elements, instance };
        add_geometry(self.elements, geometry, &Placement::new(place), &colors, self.surface)?;
        // Instances of instances can be more than any memory holds.
        self.surface.check_size()
    }
}

/// The transform that an element stands for, if it is one.
fn transform(element: Node) -> Result<Option<Affine3<f64>>, MeshError> {
    let name = element.tag_name().name();
    if !["matrix", "translate", "rotate", "scale"].contains(&name) {
        return Ok(None);
    }
    let values: Vec<f64> = numbers(element)?;
    let matrix = match (name, &values[..]) {
        ("translate", &[x, y, z]) => Translation3::new(x, y, z).to_homogeneous(),
        ("scale", &[x, y, z]) => Matrix4::new_nonuniform_scaling(&Vector3::new(x, y, z)),
        ("rotate", &[x, y, z, degrees]) => match Unit::try_new(Vector3::new(x, y, z), 0.0) {
            Some(axis) => Rotation3::from_axis_angle(&axis, degrees.to_radians()).to_homogeneous(),
            None => Matrix4::identity(),
        },
        ("matrix", values) if values.len() == 16 => {
            let mut matrix = Matrix4::from_row_slice(values);
            // Placements have this row always; some writers leave it empty.
            matrix.set_row(3, &nalgebra::RowVector4::new(0.0, 0.0, 0.0, 1.0));
            matrix
        }
        _ => return Err(wrong(element, &format!("it has {} numbers", values.len()))),
    };
    Ok(Some(Affine3::from_matrix_unchecked(matrix)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle in the plane of x and y, mirrored and placed twice; lengths in decimetres; y points up, which is not heeded.
    const SCENE: &str = r##"<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit meter="0.1"/><up_axis>Y_UP</up_axis></asset>
  <library_effects><effect id="red-effect"><profile_COMMON><technique sid="t"><phong>
    <diffuse><color>1 0 0 1</color></diffuse></phong></technique></profile_COMMON></effect></library_effects>
  <library_materials><material id="red"><instance_effect url="#red-effect"/></material></library_materials>
  <library_geometries><geometry id="g"><mesh>
    <source id="p"><float_array id="pa" count="12">0 0 0  10 0 0  10 10 0  0 10 0</float_array>
      <technique_common><accessor source="#pa" count="4" stride="3"/></technique_common></source>
    <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
    <polylist count="1" material="paint"><input semantic="VERTEX" source="#v" offset="0"/><vcount>4</vcount><p>0 1 2 3</p></polylist>
    <tristrips count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 3 2</p></tristrips>
  </mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="s">
    <node><translate>0 0 5</translate><rotate>0 0 1 90</rotate><node><scale>-1 1 1</scale>
      <instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="paint" target="#red"/>
      </technique_common></bind_material></instance_geometry></node></node>
  </visual_scene></library_visual_scenes>
  <scene><instance_visual_scene url="#s"/></scene></COLLADA>"##;

    #[test]
    fn nodes_place_polygons_in_metres_and_mirrored_ones_still_look_outwards() {
        let surface = read(SCENE.as_bytes()).expect("a surface");
        assert_eq!(surface.triangle_count(), 4);
        let red = &surface.parts[0];
        assert_eq!(red.color, Some([1.0, 0.0, 0.0, 1.0]));
        assert_eq!(surface.parts[1].color, None);
        for part in &surface.parts {
            for (triangle, normals) in part.corners.chunks(3).zip(part.normals.chunks(3)) {
                let [a, b, c] = [0, 1, 2].map(|corner| Vector3::from(triangle[corner]));
                let outward = (b - a).cross(&(c - a)).normalize();
                // A mirror in x turns the order of corners, and their normal stays along z.
                assert!((outward - Vector3::z()).norm() < 1e-6, "{triangle:?}");
                assert!(normals.iter().all(|normal| (Vector3::from(normal.map(f64::from)) - outward).norm() < 1e-6));
            }
        }
        // (10, 10, 0) is mirrored to (−10, 10, 0), turned to (−10, −10, 0), moved to z = 5, and a tenth of it in metres.
        assert!(
            red.corners.iter().any(|corner| (Vector3::from(*corner) - Vector3::new(-1.0, -1.0, 0.5)).norm() < 1e-6)
        );
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        let missing = SCENE.replace("url=\"#g\"", "url=\"#h\"");
        let error = read(missing.as_bytes()).expect_err("no geometry").to_string();
        assert_eq!(error, "line 15: <instance_geometry>: its geometry does not exist");
        let circle = SCENE.replace("<node><scale>", "<node id=\"n\"><instance_node url=\"#n\"/><scale>");
        assert!(read(circle.as_bytes()).expect_err("a circle").to_string().contains("contain each other"));
        let outside = SCENE.replace("<p>0 1 2 3</p>", "<p>0 1 2 4</p>");
        assert!(read(outside.as_bytes()).expect_err("no vertex").to_string().contains("does not exist"));
    }
}
