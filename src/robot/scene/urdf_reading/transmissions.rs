//! Rotors of a URDF: the inertia that a motor adds to its joint through its gear.
//!
//! A rotor with the inertia J [kg m²] that turns n times as fast as its joint adds `n² J` to it, the armature of the joint. Files say J and n in a
//! `<transmission>` with one `<joint>`, as elements with a text or a `value`:
//!
//! | number | names | who writes it |
//! |---|---|---|
//! | n | `<mechanicalReduction>`, `<drake:gear_ratio>` | ROS, Drake |
//! | J | `<rotorInertia>`, `<motorInertia>`, `<rotor_inertia>`, `<drake:rotor_inertia>` | Gazebo, Drake |
//!
//! Standard URDF has no rotors. A `<dynamics armature="...">` says `n² J` itself.

use crate::mechanism::ground::words::counted;
use crate::scene::error::Element;
use crate::scene::numbers::numbers;
use crate::scene::robot::UrdfJoint;
use crate::scene::taken::{Taken, TakenNumber};
use crate::scene::text::XmlText;
use crate::scene::warning::Warning;
use roxmltree::Node;

const INERTIAS: [&str; 3] = ["rotorInertia", "motorInertia", "rotor_inertia"];
const RATIOS: [&str; 2] = ["mechanicalReduction", "gear_ratio"];

/// The key that sets it instead.
const INSTEAD: &str = "`armature` of a [[joint]] in a scene file, or --set joint.NAME.armature=A, sets it";

/// Whether an element says the inertia of a rotor, so that it is not ignored.
pub(crate) fn says_rotor(node: Node) -> bool {
    node.tag_name().name() == "transmission" && inside(node, &INERTIAS).next().is_some()
}

/// Adds the armatures that transmissions say to the joints. Returns the numbers that were taken, and warnings of the others.
pub(crate) fn take_rotors(xml: &XmlText, root: Node, joints: &mut [UrdfJoint]) -> (Vec<Taken>, Vec<Warning>) {
    let (mut taken, mut warnings): (Vec<Taken>, Vec<Warning>) = (Vec::new(), Vec::new());
    for node in root.children().filter(|node| node.is_element() && says_rotor(*node)) {
        let called = node.attribute("name").unwrap_or("without a name");
        let read = driven(node, joints).and_then(|joint| Ok((joint, armature(node)?)));
        match read {
            Ok((joint, armature)) => {
                *joint.armature.get_or_insert(0.0) += armature;
                let of = Element::Joint(joint.name.clone());
                taken.push(Taken { number: TakenNumber::Armature, of, value: armature, line: xml.line(node) });
            }
            Err(reason) => {
                let message = format!("the rotor of <transmission> {called:?} is not simulated: {reason}; {INSTEAD}");
                warnings.push(Warning::odd(&xml.file, Some(xml.line(node)), None, message));
            }
        }
    }
    (taken, warnings)
}

/// The joint that a transmission drives.
fn driven<'j>(node: Node, joints: &'j mut [UrdfJoint]) -> Result<&'j mut UrdfJoint, String> {
    let names: Vec<&str> = node
        .children()
        .filter(|part| part.is_element() && part.tag_name().name() == "joint")
        .filter_map(|part| part.attribute("name"))
        .collect();
    let [name] = names[..] else { return Err(format!("it drives {}", counted(names.len(), "joint", "joints"))) };
    joints.iter_mut().find(|joint| joint.name == name).ok_or_else(|| format!("there is no joint {name:?}"))
}

/// `n² J` [kg m²].
fn armature(node: Node) -> Result<f64, String> {
    let (inertia, ratio) = (only(node, &INERTIAS)?.unwrap_or(0.0), only(node, &RATIOS)?.unwrap_or(1.0));
    let armature = ratio * ratio * inertia;
    if inertia < 0.0 || !armature.is_finite() {
        return Err(format!("an inertia of {inertia} kg m² geared by {ratio} cannot be"));
    }
    Ok(armature)
}

/// The number that elements of these names say, if there is one.
fn only(node: Node, names: &[&str]) -> Result<Option<f64>, String> {
    let mut said: Option<f64> = None;
    for one in inside(node, names) {
        let text = one.attribute("value").or_else(|| one.text()).unwrap_or_default();
        let (read, _) = numbers(text, 1, false)?;
        let number = read.first().and_then(|number| number.parse().ok()).unwrap_or(f64::NAN);
        if said.is_some_and(|before| before != number) {
            return Err(format!("it has more than one <{}>", one.tag_name().name()));
        }
        said = Some(number);
    }
    Ok(said)
}

/// All elements of these names within one.
fn inside<'d, 'x>(node: Node<'d, 'x>, names: &[&str]) -> impl Iterator<Item = Node<'d, 'x>> {
    node.descendants().filter(|one| one.is_element() && names.contains(&one.tag_name().name()))
}
