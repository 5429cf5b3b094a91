//! Friction of links as files of other programs say it.
//!
//! | where | who writes it |
//! |---|---|
//! | `<gazebo reference="LINK">` with `<mu1>` and `<mu2>`, or `<mu>` and `<mu2>` of a `<surface>` in it | Gazebo |
//! | `<contact_coefficients mu="...">` of a `<collision>` | Gazebo before SDF, PR2 |
//! | `<contact>` of a `<link>` with `<lateral_friction value="...">` | Bullet |
//!
//! Gazebo's `mu2` is the coefficient across the first direction. Friction here is the same in all directions, so the smaller one is used.

use crate::mechanism::ground::words::counted;
use crate::scene::error::Element;
use crate::scene::numbers::{check_friction, numbers, shown};
use crate::scene::robot::Link;
use crate::scene::text::XmlText;
use crate::scene::warning::{Warning, WarningGroup};
use roxmltree::Node;
use std::collections::BTreeMap;

/// Elements of `<gazebo>` that say friction.
const OF_GAZEBO: [&str; 3] = ["mu", "mu1", "mu2"];

/// What sets it instead.
const INSTEAD: &str = "`friction` of a [[link]] in a scene file, or --set link.NAME.friction=MU, sets it";

/// Most links that a message names.
const NAMED: usize = 6;

/// Whether an element says friction and no more, so that it is not ignored.
pub(crate) fn says_friction_alone(node: Node) -> bool {
    let own = node.tag_name().name() == "gazebo" && node.attribute("reference").is_some();
    let mut parts = node.children().filter(Node::is_element).peekable();
    own && parts.peek().is_some() && parts.all(|part| OF_GAZEBO.contains(&part.tag_name().name()))
}

/// Puts the friction that the document says into the links. The warnings say which coefficients were taken and which were not.
pub(crate) fn take_friction(xml: &XmlText, root: Node, links: &mut [Link]) -> Vec<Warning> {
    let (mut taken, mut warnings): (Vec<(String, f64, usize)>, Vec<Warning>) = (Vec::new(), Vec::new());
    let odd = |node: Node, link: &str, message: String| {
        Warning::odd(&xml.file, Some(xml.line(node)), Some(Element::Link(link.to_string())), message)
    };
    // A link may be said twice: by itself, and by a reference to it.
    let mut said: BTreeMap<usize, Vec<Node>> = BTreeMap::new();
    for node in root.children().filter(Node::is_element) {
        let (link, all) = match node.tag_name().name() {
            "gazebo" => (node.attribute("reference"), within(node, &OF_GAZEBO)),
            "link" => (node.attribute("name"), within(node, &["contact_coefficients", "lateral_friction"])),
            _ => continue,
        };
        // A reference to a joint says something else.
        if let Some(index) = links.iter().position(|own| Some(own.name.as_str()) == link) {
            said.entry(index).or_default().extend(all);
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
        taken.push((link.name.clone(), least, xml.line(all[0])));
    }
    if let Some((_, _, line)) = taken.first() {
        let mut named: Vec<String> =
            taken.iter().take(NAMED).map(|(link, friction, _)| format!("{friction} for {link:?}")).collect();
        if taken.len() > NAMED {
            named.push(format!("and so on for {} more", taken.len() - NAMED));
        }
        let links = counted(taken.len(), "link", "links");
        let message = format!("friction of {links} is taken from the file: {}", named.join(", "));
        warnings.push(Warning::odd(&xml.file, Some(*line), None, message).in_group(WarningGroup::Taken));
    }
    warnings
}

/// All elements of these names within one.
fn within<'d, 'x>(node: Node<'d, 'x>, names: &[&str]) -> Vec<Node<'d, 'x>> {
    node.descendants().filter(|one| one.is_element() && names.contains(&one.tag_name().name())).collect()
}

/// The coefficient that an element says: its attribute `mu` or `value`, or its text. Of `<contact_coefficients>` without `mu` there is none.
fn coefficient(node: Node) -> Result<Option<f64>, String> {
    let attribute = node.attribute("mu").or_else(|| node.attribute("value"));
    if attribute.is_none() && node.tag_name().name() == "contact_coefficients" {
        return Ok(None);
    }
    let text = attribute.or_else(|| node.text()).unwrap_or_default();
    let (read, _) = numbers(text, 1, false)?;
    let number = read.first().and_then(|number| number.parse().ok()).unwrap_or(f64::NAN);
    check_friction(number).map(|()| Some(number))
}
