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
    for node in root.children().filter(Node::is_element) {
        let (link, said) = match node.tag_name().name() {
            "gazebo" => match node.attribute("reference") {
                Some(link) => (link, within(node, &OF_GAZEBO)),
                None => continue,
            },
            "link" => {
                let mut said: Vec<Node> = within(node, &["contact_coefficients"]);
                said.extend(within(node, &["lateral_friction"]));
                (node.attribute("name").unwrap_or_default(), said)
            }
            _ => continue,
        };
        if said.is_empty() {
            continue;
        }
        let Some(index) = links.iter().position(|own| own.name == link) else {
            // A reference to a joint says something else.
            continue;
        };
        let mut least: Option<f64> = None;
        for one in &said {
            match coefficient(*one) {
                Ok(Some(friction)) => {
                    if least.is_some_and(|other| other != friction) {
                        let message = "its friction differs by direction or shape; the smallest is used".to_string();
                        warnings.push(odd(*one, link, message));
                    }
                    least = Some(least.map_or(friction, |other| other.min(friction)));
                }
                Ok(None) => {}
                Err(reason) => {
                    let name = shown(one.tag_name().name());
                    warnings.push(odd(
                        *one,
                        link,
                        format!("its friction in <{name}> is not read: {reason}; {INSTEAD}"),
                    ));
                }
            }
        }
        if let Some(friction) = least {
            links[index].surface.friction = Some(friction);
            taken.push((link.to_string(), friction, xml.line(node)));
        }
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
