//! Friction of links as files of other programs say it.
//!
//! | where | who writes it |
//! |---|---|
//! | `<gazebo reference="LINK">` with `<mu1>` and `<mu2>`, or `<mu>` and `<mu2>` of a `<surface>` in it | Gazebo |
//! | `<contact_coefficients mu="...">` of a `<collision>` | Gazebo before SDF, PR2 |
//! | `<contact>` of a `<link>` with `<lateral_friction value="...">` | Bullet |
//!
//! Gazebo's `mu2` is the coefficient across the first direction. Friction here is the same in all directions, so the smaller one is used.

use crate::scene::error::Element;
use crate::scene::numbers::{check_friction, numbers, shown};
use crate::scene::robot::Link;
use crate::scene::taken::{Taken, TakenNumber};
use crate::scene::text::XmlText;
use crate::scene::warning::Warning;
use roxmltree::Node;
use std::collections::BTreeMap;

/// Elements of `<gazebo>` that say friction.
const OF_GAZEBO: [&str; 3] = ["mu", "mu1", "mu2"];

/// Elements within links that say friction.
const OF_LINK: [&str; 2] = ["contact_coefficients", "lateral_friction"];

/// The key that sets it instead.
const INSTEAD: &str = "`friction` of a [[link]] in a scene file, or --set link.NAME.friction=MU, sets it";

/// The parts that are not read of an element that says friction: each part, how it is written, and the name of the element around it. `None` if the
/// element says no friction.
pub(crate) fn beside_friction<'d, 'x>(node: Node<'d, 'x>) -> Option<Vec<(Node<'d, 'x>, String, String)>> {
    let names: &[&str] = match node.tag_name().name() {
        "gazebo" if node.attribute("reference").is_some() => &OF_GAZEBO,
        "contact" | "contact_coefficients" => &OF_LINK,
        _ => return None,
    };
    let says = |node: Node| within(node, names).into_iter().any(has_coefficient);
    if !says(node) {
        return None;
    }
    let (mut beside, mut open) = (Vec::new(), vec![node]);
    while let Some(one) = open.pop() {
        let of = || shown(one.tag_name().name());
        if names.contains(&one.tag_name().name()) {
            let unread = one.attributes().filter(|given| !["mu", "value"].contains(&given.name()));
            beside.extend(unread.map(|given| (one, format!("{}=\"...\"", shown(given.name())), of())));
        }
        let (inner, unread): (Vec<Node>, Vec<Node>) =
            one.children().filter(Node::is_element).partition(|one| says(*one));
        beside.extend(unread.into_iter().map(|part| (part, format!("<{}>", shown(part.tag_name().name())), of())));
        open.extend(inner);
    }
    Some(beside)
}

/// Puts the friction that the document says into the links. Returns the numbers that were taken, and warnings of the others.
pub(crate) fn take_friction(xml: &XmlText, root: Node, links: &mut [Link]) -> (Vec<Taken>, Vec<Warning>) {
    let (mut taken, mut warnings): (Vec<Taken>, Vec<Warning>) = (Vec::new(), Vec::new());
    let odd = |node: Node, link: &str, message: String| {
        Warning::odd(&xml.file, Some(xml.line(node)), Some(Element::Link(link.to_string())), message)
    };
    // A link may be said twice: by itself, and by a reference to it.
    let mut said: BTreeMap<usize, Vec<Node>> = BTreeMap::new();
    for node in root.children().filter(Node::is_element) {
        let (link, all) = match node.tag_name().name() {
            "gazebo" => (node.attribute("reference"), within(node, &OF_GAZEBO)),
            "link" => (node.attribute("name"), within(node, &OF_LINK)),
            _ => continue,
        };
        if let Some(index) = links.iter().position(|own| Some(own.name.as_str()) == link) {
            said.entry(index).or_default().extend(all);
        } else if let Some(name) = link.filter(|name| !all.is_empty() && !is_joint(root, name)) {
            let message =
                format!("friction of <gazebo reference={name:?}> has no effect: there is no link of this name");
            warnings.push(Warning::odd(&xml.file, Some(xml.line(node)), None, message));
        }
    }
    for (index, all) in said {
        let link = &mut links[index];
        let mut read: Vec<f64> = Vec::with_capacity(all.len());
        for one in &all {
            match coefficient(*one) {
                Ok(friction) => read.extend(friction),
                Err(reason) => {
                    let name = shown(one.tag_name().name());
                    let message = format!("its friction in <{name}> is not read: {reason}; {INSTEAD}");
                    warnings.push(odd(*one, &link.name, message));
                }
            }
        }
        let Some(least) = read.iter().copied().reduce(f64::min) else { continue };
        if read.iter().any(|friction| *friction != least) {
            let message =
                "its friction differs by direction, shape or place in the file; the smallest is used".to_string();
            warnings.push(odd(all[0], &link.name, message));
        }
        link.surface.friction = Some(least);
        let of = Element::Link(link.name.clone());
        taken.push(Taken { number: TakenNumber::Friction, of, value: least, line: xml.line(all[0]) });
    }
    (taken, warnings)
}

/// Whether the document has a joint of this name, of which a reference says something else.
fn is_joint(root: Node, name: &str) -> bool {
    root.children().any(|one| one.tag_name().name() == "joint" && one.attribute("name") == Some(name))
}

/// All elements of these names within one.
fn within<'d, 'x>(node: Node<'d, 'x>, names: &[&str]) -> Vec<Node<'d, 'x>> {
    node.descendants().filter(|one| one.is_element() && names.contains(&one.tag_name().name())).collect()
}

/// The coefficient that an element says: its attribute `mu` or `value`, or its text. Of `<contact_coefficients>` without `mu` there is none.
fn coefficient(node: Node) -> Result<Option<f64>, String> {
    if !has_coefficient(node) {
        return Ok(None);
    }
    let attribute = node.attribute("mu").or_else(|| node.attribute("value"));
    let text = attribute.or_else(|| node.text()).unwrap_or_default();
    let (read, _) = numbers(text, 1, false)?;
    let number = read.first().and_then(|number| number.parse().ok()).unwrap_or(f64::NAN);
    check_friction(number).map(|()| Some(number))
}

/// Whether an element that may say friction does.
fn has_coefficient(node: Node) -> bool {
    node.tag_name().name() != "contact_coefficients" || node.has_attribute("mu") || node.has_attribute("value")
}
