//! Bodies of MJCF: trees of links. Each child of the world with a joint in it is a robot, each without is obstacles.
//!
//! A joint turns about its own point c of its body at pose B: its frame is at B T(c), and the body at T(−c) in the frame that it moves. Several
//! joints of one body move the frames of one another; between them are links without mass.

use crate::scene::error::SceneError;
use crate::scene::mjcf_reading::mass::{MassOf, composed};
use crate::scene::mjcf_reading::parts::{Between, Form, FreeFrame, Joint, Link, Moving, Placed, Tree};
use crate::scene::mjcf_reading::reader::Reader;
use crate::scene::mjcf_reading::tree::Element;
use crate::scene::robot::Pose;
use crate::scene::world::WORLD_LINK;
use nalgebra::{Matrix3, Point3, Rotation3, Translation3, Vector3};
use std::cell::OnceCell;

/// A body in another: its pose there, and the class of its elements.
type Inner = (Element, Pose, Option<String>);

/// Elements of a body that say nothing of its motion.
const SILENT: [&str; 4] = ["camera", "light", "site", "plugin"];

impl Reader<'_> {
    /// The children of the world.
    pub fn world(&mut self, world: &Element) -> Result<(), SceneError> {
        let class = world.text("childclass").map(str::to_string);
        self.world_part(world, WORLD_LINK, &Pose::identity(), class.as_deref())
    }

    /// A part of the world, or of a body that does not move.
    fn world_part(&mut self, part: &Element, body: &str, at: &Pose, class: Option<&str>) -> Result<(), SceneError> {
        for child in &part.children {
            match child.name.as_str() {
                "geom" => self.obstacle(child, body, at, class)?,
                "frame" => {
                    let inner = at * self.angles.pose(child)?;
                    self.world_part(child, body, &inner, child.text("childclass").or(class))?;
                }
                "body" => self.tree(child, at, class)?,
                "site" => self.site(child, None, at, class)?,
                name if SILENT.contains(&name) => self.ignore(child, "worldbody"),
                _ => self.unknown(child, "worldbody"),
            }
        }
        Ok(())
    }

    /// A child of the world.
    fn tree(&mut self, body: &Element, at: &Pose, class: Option<&str>) -> Result<(), SceneError> {
        let pose = at * self.angles.pose(body)?;
        let inner = body.text("childclass").or(class).map(str::to_string);
        if !moves(body) {
            return self.fixed(body, &pose, inner.as_deref());
        }
        let free = body.children.iter().find(|child| is_free(child));
        let name = self.body_name(body);
        let index = self.trees.len();
        let hangs = free.is_none() && has_joint(body);
        let damping = free.map_or(Ok(0.0), |free| self.damping_of_base(free, inner.as_deref()))?;
        self.trees.push(Tree {
            name: name.clone(),
            floats: free.is_some(),
            // On a joint of its own the tree hangs in the world frame.
            pose: if hangs { Pose::identity() } else { pose },
            free_frame: FreeFrame::Body,
            velocity: None,
            damping,
            links: Vec::new(),
            joints: Vec::new(),
            inertias: OnceCell::new(),
        });
        if let Some(free) = free {
            self.order.push(Moving::Free(index));
            let names = free.text("name").map(str::to_string);
            self.free_names.extend(names);
        }
        self.link(body, &name, index, hangs.then(|| ("world".to_string(), pose)), &pose, inner.as_deref())
    }

    /// The damping of a free joint: of its velocity [N s/m], and of its spin [N m s].
    fn damping_of_base(&mut self, free: &Element, class: Option<&str>) -> Result<f64, SceneError> {
        // A <freejoint> has no defaults.
        let free = if free.name == "joint" { self.defaults.applied(free, class) } else { free.clone() };
        for (attribute, what) in [("armature", "armature"), ("frictionloss", "friction"), ("stiffness", "stiffness")] {
            if free.list(attribute, 1, 3)?.is_some_and(|all| all.iter().any(|number| *number != 0.0)) {
                self.not_simulated(&free, format!("{what} of free joints is not simulated"));
            }
        }
        Ok(self.linear(&free, "damping")?.unwrap_or(0.0))
    }

    /// A body that does not move, and all that it carries.
    fn fixed(&mut self, body: &Element, pose: &Pose, class: Option<&str>) -> Result<(), SceneError> {
        let name = self.body_name(body);
        self.placed.insert(name.clone(), Placed { tree: None, pose: *pose });
        for child in &body.children {
            match child.name.as_str() {
                "geom" => self.obstacle(child, &name, pose, class)?,
                "body" => {
                    let inner = pose * self.angles.pose(child)?;
                    self.fixed(child, &inner, child.text("childclass").or(class))?;
                }
                "frame" => {
                    let inner = pose * self.angles.pose(child)?;
                    self.world_part(child, &name, &inner, child.text("childclass").or(class))?;
                }
                "site" => self.site(child, None, pose, class)?,
                "inertial" => {}
                name if SILENT.contains(&name) => self.ignore(child, "body"),
                _ => self.unknown(child, "body"),
            }
        }
        Ok(())
    }

    /// A link of a tree; `on` is its parent and its frame there, `at` its pose at the start.
    fn link(
        &mut self,
        body: &Element,
        name: &str,
        tree: usize,
        on: Option<(String, Pose)>,
        at: &Pose,
        class: Option<&str>,
    ) -> Result<(), SceneError> {
        self.placed.insert(name.to_string(), Placed { tree: Some(tree), pose: *at });
        let is_base = on.is_none();
        let mut joints = Vec::new();
        self.joints(body, &Pose::identity(), class, name, &mut joints)?;
        if let Some((mut parent, mut origin)) = on {
            let shifted = |by: Vector3<f64>| Pose::from_parts(Translation3::from(by), Rotation3::identity());
            let mut before = Vector3::zeros();
            let last = joints.len().saturating_sub(1);
            let mut pending = joints.is_empty();
            for (number, joint) in joints.into_iter().enumerate() {
                let (place, is_end) = (joint.place, number == last && joint.place == Vector3::zeros());
                let child = if is_end { name.to_string() } else { format!("{name}|{}", number + 1) };
                self.order.push(Moving::Joint(tree, joint.name.clone(), joint.kind));
                self.references.insert(joint.name.clone(), (tree, joint.reference));
                let between = Between { parent, child: child.clone(), origin: origin * shifted(place - before) };
                if !is_end {
                    let line = joint.line;
                    self.trees[tree].links.push(Link {
                        name: child.clone(),
                        mass: None,
                        held: 0.0,
                        geoms: Vec::new(),
                        line,
                    });
                }
                self.trees[tree].joints.push((between, Some(joint)));
                (parent, origin, before) = (child, Pose::identity(), place);
                pending = !is_end;
            }
            if pending {
                let between = Between { parent, child: name.to_string(), origin: origin * shifted(-before) };
                self.trees[tree].joints.push((between, None));
            }
        }
        let held = body.number("gravcomp")?.unwrap_or(0.0);
        let mut link = Link { name: name.to_string(), mass: None, held, geoms: Vec::new(), line: body.line };
        let mut parts = Vec::new();
        let mut bodies: Vec<Inner> = Vec::new();
        let inertial =
            self.contents(body, &Pose::identity(), class, (name, at), (&mut link, &mut parts), &mut bodies)?;
        let is_given = inertial.is_some() && self.compiler.inertia_from_geoms != Some(true);
        let mass = match (self.compiler.inertia_from_geoms, inertial) {
            (Some(true), _) | (None, None) => composed(&parts),
            (_, given) => given,
        };
        if is_base {
            let is_one = is_given || parts.len() == 1;
            self.trees[tree].free_frame = self.free_frame(body, mass.as_ref().filter(|_| bodies.is_empty()), is_one);
        }
        link.mass = self.compiler.bounded(mass);
        self.rounded(body, &mut link);
        self.trees[tree].links.push(link);
        for (child, pose, class) in bodies {
            let inner = self.body_name(&child);
            self.link(&child, &inner, tree, Some((name.to_string(), pose)), &(at * pose), class.as_deref())?;
        }
        Ok(())
    }

    /// The joints of a body, or of a frame of it at `frame`.
    fn joints(
        &mut self,
        part: &Element,
        frame: &Pose,
        class: Option<&str>,
        body: &str,
        joints: &mut Vec<Joint>,
    ) -> Result<(), SceneError> {
        for child in &part.children {
            match child.name.as_str() {
                "joint" if !is_free(child) => {
                    let mut joint = self.joint(child, class, (body, joints.len()))?;
                    joint.place = (frame * Point3::from(joint.place)).coords;
                    joint.axis = frame.rotation * joint.axis;
                    joints.push(joint);
                }
                "frame" => {
                    let inner = frame * self.angles.pose(child)?;
                    self.joints(child, &inner, child.text("childclass").or(class), body, joints)?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Reads the contents of a body or of a frame of it at `frame`: geoms into the link, bodies into the list; returns its inertia.
    fn contents(
        &mut self,
        part: &Element,
        frame: &Pose,
        class: Option<&str>,
        body: (&str, &Pose),
        (link, parts): (&mut Link, &mut Vec<MassOf>),
        bodies: &mut Vec<Inner>,
    ) -> Result<Option<MassOf>, SceneError> {
        let mut inertial = None;
        for child in &part.children {
            match child.name.as_str() {
                "geom" => {
                    let (mut geom, mass) = self.geom(child, class)?;
                    if matches!(geom.form, Form::Field(_)) {
                        self.not_simulated(child, "a height field that moves touches nothing".to_string());
                    }
                    geom.pose = frame * geom.pose;
                    parts.extend(mass.map(|mass| MassOf { frame: frame * mass.frame, ..mass }));
                    link.geoms.push(geom);
                }
                "inertial" => inertial = Some(self.inertial(child)?),
                "body" => {
                    let pose = frame * self.angles.pose(child)?;
                    let class = child.text("childclass").or(class).map(str::to_string);
                    bodies.push((child.clone(), pose, class));
                }
                "frame" => {
                    let inner = frame * self.angles.pose(child)?;
                    let class = child.text("childclass").or(class);
                    self.contents(child, &inner, class, body, (link, parts), bodies)?;
                }
                "joint" | "freejoint" => {}
                "site" => self.site(child, Some(body.0), &(body.1 * frame), class)?,
                name if SILENT.contains(&name) => self.ignore(child, "body"),
                _ => self.unknown(child, "body"),
            }
        }
        Ok(inertial)
    }

    fn inertial(&mut self, inertial: &Element) -> Result<MassOf, SceneError> {
        let frame = self.angles.pose(inertial)?;
        let mass = inertial.number("mass")?.ok_or_else(|| inertial.missing("mass"))?;
        let inertia = match (inertial.list("fullinertia", 6, 6)?, inertial.vector("diaginertia")?) {
            (Some(full), _) => {
                let &[xx, yy, zz, xy, xz, yz] = full.as_slice() else { return Err(inertial.missing("fullinertia")) };
                Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
            }
            (None, Some(diagonal)) => Matrix3::from_diagonal(&diagonal),
            (None, None) => Matrix3::zeros(),
        };
        Ok(MassOf { mass, frame, inertia })
    }

    /// A geom of a body that does not move.
    fn obstacle(&mut self, given: &Element, body: &str, at: &Pose, class: Option<&str>) -> Result<(), SceneError> {
        let (mut geom, mass) = self.geom(given, class)?;
        geom.pose = at * geom.pose;
        self.fixed_mass += mass.map_or(0.0, |of| of.mass);
        if geom.is_ellipsoid() {
            self.ellipsoids(given, "an ellipsoid that does not move touches nothing");
        } else if geom.touches && !matches!(geom.form, Form::Other) {
            self.obstacles.push((body.to_string(), geom));
        }
        Ok(())
    }

    /// A point that other elements name.
    fn site(&mut self, given: &Element, body: Option<&str>, at: &Pose, class: Option<&str>) -> Result<(), SceneError> {
        let site = self.defaults.applied(given, class);
        if let Some(name) = site.text("name").map(str::to_string) {
            let pose = at * self.angles.pose(&site)?;
            self.sites.insert(name, (body.map(str::to_string), pose));
        }
        Ok(())
    }

    /// Ellipsoids touch planes alone, and only where all shapes of their body that touch are ellipsoids.
    fn rounded(&mut self, body: &Element, link: &mut Link) {
        let ellipsoids = link.geoms.iter().filter(|geom| geom.can_touch() && geom.is_ellipsoid()).count();
        if ellipsoids == 0 {
            return;
        }
        if ellipsoids == link.geoms.iter().filter(|geom| geom.can_touch()).count() {
            self.ellipsoids(body, "a body of ellipsoids touches planes, and no other shapes");
            return;
        }
        link.geoms.iter_mut().filter(|geom| geom.is_ellipsoid()).for_each(|geom| geom.touches = false);
        self.ellipsoids(body, "ellipsoids beside other shapes of one body touch nothing");
    }

    /// Warns of what ellipsoids do not touch, unless nothing is to touch.
    fn ellipsoids(&mut self, of: &Element, what: &str) {
        if self.touches {
            self.not_simulated(of, what.to_string());
        }
    }

    /// The name of a body, or a number.
    fn body_name(&mut self, body: &Element) -> String {
        self.bodies += 1;
        body.text("name").map_or_else(|| format!("body{}", self.bodies), str::to_string)
    }
}

/// Whether a body or anything that it carries has a joint.
fn moves(body: &Element) -> bool {
    has_joint(body) || body.children.iter().any(|child| matches!(child.name.as_str(), "body" | "frame") && moves(child))
}

/// Whether a body, or a frame of it, has a joint.
fn has_joint(body: &Element) -> bool {
    let has = |child: &Element| match child.name.as_str() {
        "joint" | "freejoint" => true,
        "frame" => has_joint(child),
        _ => false,
    };
    body.children.iter().any(has)
}

/// Whether a joint of a body is a free one.
pub(super) fn is_free(joint: &Element) -> bool {
    joint.name == "freejoint" || (joint.name == "joint" && joint.text("type") == Some("free"))
}
