//! The visual geometry of a URDF as a `foxglove.SceneUpdate`: one entity a link, fixed to the link's frame.
//!
//! Boxes, spheres and cylinders become primitives with the colour of their material. Meshes are given by their
//! address alone. What cannot be understood is left out: this is a picture, and the model has been checked elsewhere.

use foxglove::messages::{
    Color, CubePrimitive, CylinderPrimitive, ModelPrimitive, Pose, Quaternion, SceneEntity, SceneUpdate,
    SpherePrimitive, Vector3,
};
use nalgebra::UnitQuaternion;
use roxmltree::{Document, Node};

/// What has no material is drawn in this grey.
const PLAIN: Color = Color { r: 0.7, g: 0.7, b: 0.72, a: 1.0 };

/// The scene of a URDF, empty if nothing can be drawn.
pub(super) fn scene(urdf: &str) -> SceneUpdate {
    let Ok(document) = Document::parse(urdf) else { return SceneUpdate::default() };
    let robot = document.root_element();
    let entities = children(robot, "link").filter_map(|link| entity(robot, link));
    SceneUpdate { entities: entities.collect(), ..SceneUpdate::default() }
}

fn entity(robot: Node, link: Node) -> Option<SceneEntity> {
    let name = link.attribute("name")?.to_string();
    let mut entity = SceneEntity { frame_id: name.clone(), id: name, frame_locked: true, ..SceneEntity::default() };
    for visual in children(link, "visual") {
        add_visual(&mut entity, robot, visual);
    }
    let drawn = entity.cubes.len() + entity.spheres.len() + entity.cylinders.len() + entity.models.len();
    (drawn > 0).then_some(entity)
}

fn add_visual(entity: &mut SceneEntity, robot: Node, visual: Node) -> Option<()> {
    let pose = Some(pose(child(visual, "origin")));
    let color = Some(color(robot, visual).unwrap_or(PLAIN));
    let shape = child(visual, "geometry")?.children().find(Node::is_element)?;
    let number = |name| shape.attribute(name)?.trim().parse::<f64>().ok();
    match shape.tag_name().name() {
        "box" => {
            let [x, y, z] = numbers(shape.attribute("size")?)?;
            entity.cubes.push(CubePrimitive { pose, size: Some(Vector3 { x, y, z }), color });
        }
        "sphere" => {
            let diameter = 2.0 * number("radius")?;
            let size = Some(Vector3 { x: diameter, y: diameter, z: diameter });
            entity.spheres.push(SpherePrimitive { pose, size, color });
        }
        "cylinder" => {
            let diameter = 2.0 * number("radius")?;
            let size = Some(Vector3 { x: diameter, y: diameter, z: number("length")? });
            entity.cylinders.push(CylinderPrimitive { pose, size, bottom_scale: 1.0, top_scale: 1.0, color });
        }
        "mesh" => {
            let [x, y, z] = shape.attribute("scale").and_then(numbers).unwrap_or([1.0; 3]);
            entity.models.push(ModelPrimitive {
                pose,
                scale: Some(Vector3 { x, y, z }),
                color,
                override_color: child(visual, "material").is_some(),
                url: shape.attribute("filename")?.to_string(),
                ..ModelPrimitive::default()
            });
        }
        _ => {}
    }
    Some(())
}

fn pose(origin: Option<Node>) -> Pose {
    let read = |name| origin.and_then(|node| numbers(node.attribute(name)?)).unwrap_or([0.0; 3]);
    let [x, y, z] = read("xyz");
    let [roll, pitch, yaw] = read("rpy");
    let turn = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    Pose {
        position: Some(Vector3 { x, y, z }),
        orientation: Some(Quaternion { x: turn.i, y: turn.j, z: turn.k, w: turn.w }),
    }
}

/// The colour of a visual: its own, or that of the robot's material of the same name.
fn color(robot: Node, visual: Node) -> Option<Color> {
    let material = child(visual, "material")?;
    let named = || children(robot, "material").find(|other| other.attribute("name") == material.attribute("name"));
    let color = child(material, "color").or_else(|| child(named()?, "color"))?;
    let [r, g, b, a] = numbers(color.attribute("rgba")?)?;
    Some(Color { r, g, b, a })
}

fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let numbers: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
    numbers.ok()?.try_into().ok()
}

fn children<'a, 'd: 'a>(node: Node<'a, 'd>, name: &'static str) -> impl Iterator<Item = Node<'a, 'd>> {
    node.children().filter(move |child| child.has_tag_name(name))
}

fn child<'a, 'd: 'a>(node: Node<'a, 'd>, name: &'static str) -> Option<Node<'a, 'd>> {
    children(node, name).next()
}
