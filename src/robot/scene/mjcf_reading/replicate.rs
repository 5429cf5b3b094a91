//! `<replicate>` of MJCF: copies of its children, each in a frame that follows from the one before.
//!
//! ```text
//!     T_i = Tⁱ,   T = (offset, euler)        names + sep + i,   i = 0 … count − 1 with as many digits as the count
//! ```
//!
//! Copies of inner replicates are made first. An element of another section that names a part of a copy is copied, too, once for each copy, after the
//! elements of its section that name none. This is what MuJoCo 4.0 writes of such files.

use crate::scene::error::SceneError;
use crate::scene::mjcf_reading::orientation::Angles;
use crate::scene::mjcf_reading::tree::Element;
use crate::scene::robot::Pose;
use nalgebra::{Rotation3, Translation3, UnitQuaternion};
use std::collections::HashSet;

/// Most elements that the copies of one replicate may have.
const MOST: f64 = 1e6;

/// Sections whose elements name parts of bodies; those that others name come first.
const SECTIONS: [&str; 4] = ["tendon", "equality", "contact", "actuator"];

/// The copied parts: the kind and name of each part, and the ends of the names of the copies.
struct Copied {
    names: HashSet<(String, String)>,
    ends: Vec<String>,
}

/// The file with all copies in their places.
pub(crate) fn with_copies(mut root: Element, angles: &Angles) -> Result<Element, SceneError> {
    let mut made = Vec::new();
    for world in root.children.iter_mut().filter(|section| section.name == "worldbody") {
        expand(world, angles, &mut made)?;
    }
    for mut copied in made {
        for section in SECTIONS {
            let sections = root.children.iter_mut().filter(|own| own.name == section);
            sections.for_each(|section| copied.copy_naming(section));
        }
    }
    Ok(root)
}

/// Puts frames in the places of the replicates in an element.
fn expand(element: &mut Element, angles: &Angles, made: &mut Vec<Copied>) -> Result<(), SceneError> {
    let mut children = Vec::with_capacity(element.children.len());
    for mut child in std::mem::take(&mut element.children) {
        expand(&mut child, angles, made)?;
        if child.name == "replicate" {
            let copied = Copied::of(&child)?;
            let step = Pose::from_parts(
                Translation3::from(child.vector("offset")?.unwrap_or_default()),
                angles.rotation(&child)?,
            );
            let mut pose = Pose::identity();
            for end in &copied.ends {
                children.push(copied.frame(&child, &pose, end));
                pose *= step;
            }
            made.push(copied);
        } else {
            children.push(child);
        }
    }
    element.children = children;
    Ok(())
}

/// The kind of names that an element of this kind has, and that an attribute like it names.
fn kind(word: &str) -> &str {
    let kinds = ["site", "joint", "body", "geom"];
    let tendon = ["spatial", "fixed", "tendon"].iter().any(|own| word.starts_with(own));
    if tendon { "tendon" } else { kinds.into_iter().find(|kind| word.contains(kind)).unwrap_or(word) }
}

impl Copied {
    fn of(replicate: &Element) -> Result<Self, SceneError> {
        let count = replicate.number("count")?.ok_or_else(|| replicate.missing("count"))?;
        if count < 1.0 || count.fract() != 0.0 || count * size(replicate) > MOST {
            let reason = format!("a whole number from 1 on is wanted, with {MOST} elements of all copies at most");
            return Err(replicate.error("count", reason));
        }
        let between = replicate.text("sep").unwrap_or_default();
        let digits = count.to_string().len();
        let ends = (0..count as usize).map(|index| format!("{between}{index:0digits$}")).collect();
        let mut names = HashSet::new();
        collect(replicate, &mut names);
        Ok(Copied { names, ends })
    }

    /// One copy.
    fn frame(&self, replicate: &Element, pose: &Pose, end: &str) -> Element {
        let written =
            |numbers: &[f64]| numbers.iter().map(|number| format!("{number:?}")).collect::<Vec<_>>().join(" ");
        let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*pose.rotation.matrix()));
        let mut attributes = vec![("pos".to_string(), written(pose.translation.vector.as_slice()))];
        attributes.push(("quat".to_string(), written(&[turn.w, turn.i, turn.j, turn.k])));
        attributes.extend(replicate.attributes.iter().filter(|(name, _)| name == "childclass").cloned());
        let mut frame = Element { name: "frame".to_string(), attributes, ..replicate.clone() };
        frame.children.iter_mut().for_each(|child| rename(child, end));
        frame
    }

    /// Whether an element or one in it names a part of a copy.
    fn is_named_by(&self, element: &Element) -> bool {
        let names = |(attribute, name): &(String, String)| {
            attribute != "name" && self.names.contains(&(kind(attribute).to_string(), name.clone()))
        };
        element.attributes.iter().any(names) || element.children.iter().any(|child| self.is_named_by(child))
    }

    /// Copies the elements of a section that name a part of a copy.
    fn copy_naming(&mut self, section: &mut Element) {
        let (naming, mut kept): (Vec<Element>, _) =
            std::mem::take(&mut section.children).into_iter().partition(|one| self.is_named_by(one));
        for one in naming {
            kept.extend(self.ends.iter().map(|end| {
                let mut copy = one.clone();
                self.point_to(&mut copy, end);
                rename(&mut copy, end);
                copy
            }));
            collect_own(&one, &mut self.names);
        }
        section.children = kept;
    }

    /// Lets an element name the parts of one copy.
    fn point_to(&self, element: &mut Element, end: &str) {
        for (attribute, name) in element.attributes.iter_mut().filter(|(attribute, _)| attribute != "name") {
            if self.names.contains(&(kind(attribute).to_string(), name.clone())) {
                name.push_str(end);
            }
        }
        element.children.iter_mut().for_each(|child| self.point_to(child, end));
    }
}

/// How many elements there are in an element, itself included.
fn size(element: &Element) -> f64 {
    1.0 + element.children.iter().map(size).sum::<f64>()
}

/// Gives an element and all in it names of their own.
fn rename(element: &mut Element, end: &str) {
    element.attributes.iter_mut().filter(|(attribute, _)| attribute == "name").for_each(|(_, name)| name.push_str(end));
    element.children.iter_mut().for_each(|child| rename(child, end));
}

fn collect(element: &Element, names: &mut HashSet<(String, String)>) {
    element.children.iter().for_each(|child| collect(child, names));
    collect_own(element, names);
}

fn collect_own(element: &Element, names: &mut HashSet<(String, String)>) {
    names.extend(element.text("name").map(|name| (kind(&element.name).to_string(), name.to_string())));
}
