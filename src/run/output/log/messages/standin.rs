//! The looks of bodies without visuals, so that every robot is visible: the box with the same mass and inertia.
//!
//! A box of mass m with edges a, b, c has the principal moments J₁ = m (b² + c²) / 12 and so on, so that
//!
//! ```text
//!     a² = 6 (J₂ + J₃ − J₁) / m         [m²]    in the principal axes of inertia, at the centre of mass
//! ```
//!
//! A moment that is zero, or larger than the sum of the others, would make an edge of no length; edges are at least a
//! tenth of the longest, and at least a millimetre. A point mass is a box of 2 cm.

use crate::mechanism::description::joint::Pose;
use crate::model::{Model, PlacedRobot};
use crate::scene::Inertial;
use nalgebra::{Rotation3, Translation3, Vector3};
use roxmltree::Document;
use std::collections::HashMap;
use std::fmt::Write;

/// The colour of bodies without geometry: a quiet blue.
pub const STANDIN_COLOR: [f64; 4] = [0.45, 0.56, 0.69, 1.0];

/// Edge of the box for a point mass [m].
const POINT: f64 = 0.02;
/// The thinnest box: an edge over the longest…
const THINNEST: f64 = 0.1;
/// … and its length [m].
const LEAST: f64 = 1e-3;

/// A box for a link.
pub struct Standin {
    /// The link, by its number in the robot.
    pub link: usize,
    /// The box's frame in the link frame.
    pub pose: Pose,
    /// Its edges (m).
    pub size: Vector3<f64>,
}

/// The boxes for all links with mass in bodies of which no link has looks.
pub fn standins(model: &Model, placed: &PlacedRobot) -> Vec<Standin> {
    let links = &placed.robot.links;
    let body = |link: usize| model.links[placed.links.start + link].body;
    let is_drawn =
        |wanted: usize| links.iter().enumerate().any(|(link, it)| !it.visuals.is_empty() && body(link) == Some(wanted));
    let bare = links.iter().enumerate().filter(|&(link, _)| body(link).is_some_and(|body| !is_drawn(body)));
    let heavy =
        bare.filter_map(|(link, it)| Some((link, it.inertial.as_ref().filter(|inertial| inertial.mass > 0.0)?)));
    heavy.map(|(link, inertial)| standin(link, inertial)).collect()
}

fn standin(link: usize, inertial: &Inertial) -> Standin {
    let principal = inertial.inertia.symmetric_eigen();
    let mut axes = principal.eigenvectors;
    if axes.determinant() < 0.0 {
        axes.column_mut(2).neg_mut();
    }
    let moments = principal.eigenvalues;
    let edge = |axis: usize| (6.0 * (moments.sum() - 2.0 * moments[axis]) / inertial.mass).max(0.0).sqrt();
    let edges = Vector3::new(edge(0), edge(1), edge(2));
    let longest = edges.max();
    let size = if longest > LEAST && longest.is_finite() {
        edges.map(|edge| edge.max(THINNEST * longest).max(LEAST))
    } else {
        Vector3::repeat(POINT)
    };
    let turn = Pose::from_parts(Translation3::identity(), Rotation3::from_matrix_unchecked(axes));
    Standin { link, pose: inertial.origin * turn, size }
}

/// The description of a robot, whose names begin with `prefix`, with the boxes as visuals of their links; `names` are the names of the links in the
/// robot.
pub(crate) fn with_standins(
    description: &str,
    prefix: &str,
    standins: &[Standin],
    names: &dyn Fn(usize) -> String,
) -> String {
    let document = if standins.is_empty() { None } else { Document::parse(description).ok() };
    let Some(document) = document else { return description.to_string() };
    let boxes: HashMap<String, &Standin> =
        standins.iter().map(|standin| (format!("{prefix}{}", names(standin.link)), standin)).collect();
    let mut text = String::with_capacity(description.len() + 400 * standins.len());
    let mut copied = 0;
    for link in document.root_element().children().filter(|node| node.has_tag_name("link")) {
        let Some(standin) = link.attribute("name").and_then(|name| boxes.get(name)) else { continue };
        let range = link.range();
        let element = &description[range.clone()];
        // Either `<link name="…"/>` or `<link name="…">…</link>`.
        let (start, open) = match (element.strip_suffix("/>"), element.strip_suffix("</link>")) {
            (Some(start), _) if !start.contains('>') => (start, ">"),
            (_, Some(start)) => (start, ""),
            _ => continue,
        };
        text.push_str(&description[copied..range.start]);
        text.push_str(start);
        text.push_str(open);
        text.push_str(&visual(standin));
        text.push_str("</link>");
        copied = range.end;
    }
    text.push_str(&description[copied..]);
    text
}

fn visual(standin: &Standin) -> String {
    let (roll, pitch, yaw) = standin.pose.rotation.euler_angles();
    let at = standin.pose.translation.vector;
    let (size, [r, g, b, a]) = (standin.size, STANDIN_COLOR);
    let mut text = String::new();
    // Writing into a string does not fail.
    let _ = write!(
        text,
        "<visual><origin xyz=\"{} {} {}\" rpy=\"{roll} {pitch} {yaw}\"/><geometry><box size=\"{} {} {}\"/></geometry>\
         <material name=\"standin\"><color rgba=\"{r} {g} {b} {a}\"/></material></visual>",
        at.x, at.y, at.z, size.x, size.y, size.z
    );
    text
}
