//! Possible contacts: from the collision shapes of links and the obstacles of a scene to colliders and pairs of the mechanism.
//!
//! `L` is the frame of a link in the body that carries it, and `S` the frame of a shape in the link. The shape lies at `L S` in the body, or in the
//! world if the link does not move. Shapes are not read if contacts are impossible (no obstacle, or `pairs = "none"`).

use crate::geometry::kind;
use crate::mechanism::description::contact::{Collider, ContactPair, Shape};
use crate::mechanism::description::nonsmooth::Reeving;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::kinematics::body_states;
use crate::model::coupling::contact_meshes::ShapeReader;
use crate::model::coupling::overlaps::number;
use crate::model::description::contact_pairs::{ContactRecord, LeftOutPair, Owner, contact_pairs, rules_of_nothing};
use crate::model::description::contact_reach::ContactReach;
use crate::model::description::coupling_error::{CouplingError, CouplingProblem};
use crate::model::description::model_error::ModelError;
use crate::model::description::never_touch::NeverTouch;
use crate::model::description::robot_model::Model;
use crate::model::description::wheel::turned_onto_axes;
use crate::scene::pattern::matches;
use crate::scene::{ContactSettings, Element, LinkReference, LinkShapes, PairRule, Surface, Warning, listed};
use nalgebra::Vector3;

impl Model {
    /// Takes the colliders and the pairs that may touch into the mechanism, instead of those it has.
    ///
    /// # Errors
    /// [`ModelError`] for shapes of links without size, meshes that are there and cannot be used, unknown names, obstacles with the name of a
    /// link, and ellipsoids that may touch anything but half spaces. Meshes of links that are not found are left out, with a warning.
    pub fn set_contact(&mut self, settings: &ContactSettings) -> Result<(), ModelError> {
        let of_rules = self.check_contact_names(settings)?;
        let robots = self.robots.len();
        let mut colliders = Vec::new();
        let (mut owners, mut surfaces) = (Vec::new(), Vec::new());
        let mut reader = ShapeReader::default();
        if settings.touches_others(robots) || settings.touches_itself(robots) {
            for number in 0..robots {
                self.link_colliders(number, settings, &mut reader, &mut colliders, &mut surfaces)?;
                owners.resize(colliders.len(), Owner::Robot(number));
            }
            for (index, obstacle) in settings.obstacles.iter().enumerate() {
                let (name, shape) = (obstacle.name.clone(), obstacle.shape.clone());
                let surface_velocity = obstacle.surface_velocity_in_world();
                colliders.push(Collider { name, body: None, pose: obstacle.pose, shape, surface_velocity });
                owners.push(Owner::Obstacle(index));
                let (friction, restitution) = (obstacle.friction, obstacle.restitution);
                surfaces.push(Surface { friction, restitution, moments: obstacle.moments, velocity: None });
            }
        }
        let wheels = turned_onto_axes(&self.mechanism, &mut colliders);
        let placed = body_states(&self.mechanism, &self.zero_state());
        let reach = ContactReach::new(&self.mechanism, placed);
        let (mut pairs, left_out) = contact_pairs(settings, &colliders, &owners, &surfaces, robots, &reach);
        let is_ellipsoid = |collider: &Collider| matches!(collider.shape, Shape::Ellipsoid { .. });
        let asked = Some(&pairs).filter(|_| colliders.iter().any(is_ellipsoid));
        for pair in asked.into_iter().flat_map(|pairs| pairs.iter()) {
            for [own, other] in [[pair.a, pair.b], [pair.b, pair.a]].map(|pair| pair.map(|of| &colliders[of])) {
                if is_ellipsoid(own) && other.shape != Shape::HalfSpace {
                    let (a, b) = (own.name.clone(), other.name.clone());
                    return Err(ModelError::EllipsoidTouches { a, b, other: kind(&other.shape) });
                }
            }
        }
        let ropes = std::mem::take(&mut self.contact.ropes);
        let mut reevings = Vec::new();
        for (index, rope) in ropes.iter().enumerate() {
            let (a, number) = (colliders.len(), pairs.len());
            if rope.points.len() > 2 {
                reevings.push(Reeving { collider: a, points: rope.points.clone() });
            }
            colliders.extend(rope.colliders.iter().cloned());
            owners.extend([Owner::Rope(index), Owner::RopeEnd(index)]);
            pairs.push(ContactPair::without_moments(number, [a, a + 1], 0.0, rope.restitution));
            for stop in &rope.stops {
                let (a, number) = (colliders.len(), pairs.len());
                colliders.extend(stop.iter().cloned());
                owners.extend([Owner::RopeEnd(index); 2]);
                pairs.push(ContactPair::without_moments(number, [a, a + 1], 0.0, rope.restitution));
            }
        }
        self.mechanism.nonsmooth.colliders = colliders;
        self.mechanism.nonsmooth.pairs = pairs;
        self.mechanism.nonsmooth.reevings = reevings;
        self.warnings.extend(of_rules);
        self.warnings.extend(self.nothing_to_touch(settings));
        self.warnings.extend(Warning::of_kind(reader.warnings, "collision mesh", "collision meshes"));
        self.contact =
            ContactRecord { settings: settings.clone(), owners, wheels, left_out, meshes: reader.meshes, ropes };
        Ok(())
    }

    /// The collision shapes of all links as colliders, whether they may touch anything or not, and warnings of meshes that were not found.
    ///
    /// # Errors
    /// [`ModelError`] for shapes without size and meshes that cannot be used.
    pub fn shapes_of_links(&self) -> Result<(Vec<Collider>, Vec<Warning>), ModelError> {
        let (mut colliders, mut reader) = (Vec::new(), ShapeReader::default());
        for number in 0..self.robots.len() {
            self.link_colliders(number, &self.contact.settings, &mut reader, &mut colliders, &mut Vec::new())?;
        }
        Ok((colliders, reader.warnings))
    }

    /// Simulates the model without the rules that have simplified it already, as far as they are among these.
    pub fn keep(&mut self, rules: &[Rule]) {
        if rules.contains(&Rule::Wheels) && !self.contact.wheels.is_empty() {
            for wheel in std::mem::take(&mut self.contact.wheels) {
                self.mechanism.nonsmooth.colliders[wheel.collider].pose = wheel.written;
            }
            // Shapes that are out of reach of each other, or keep their distance, are so where they were turned to.
            self.forget_reach();
        }
    }

    /// Puts pairs back whose shapes are out of reach of each other: the proof from the limits of joints no longer holds, and joints that were locked move.
    pub(crate) fn forget_reach(&mut self) {
        let proved = [NeverTouch::OutOfReach, NeverTouch::Locked, NeverTouch::OneDistance];
        let out_of_reach = |left: &LeftOutPair| proved.contains(&left.because);
        let back = self.contact.left_out.iter().filter(|left| out_of_reach(left)).map(|left| left.pair);
        let mut pairs: Vec<ContactPair> = self.mechanism.nonsmooth.pairs.iter().chain(back).collect();
        pairs.sort_by_key(|pair| (pair.a, pair.b));
        number(&mut pairs);
        self.mechanism.nonsmooth.pairs = pairs.into();
        self.contact.left_out.retain(|left| !out_of_reach(left));
    }

    /// A warning if there are obstacles, and no link has a collision shape that could touch them.
    fn nothing_to_touch(&self, settings: &ContactSettings) -> Option<Warning> {
        let robot = self.robots.first()?;
        let obstacle = settings.obstacles.first().filter(|_| settings.touches_others(self.robots.len()))?;
        let mut links = self.robots.iter().flat_map(|placed| &placed.robot.links);
        if links.any(|link| !link.collisions.is_empty()) {
            return None;
        }
        let whose = match self.robots.len() {
            1 => format!("robot {:?}", robot.robot.name),
            _ => "any robot".to_string(),
        };
        let message = format!(
            "no link of {whose} has a collision shape, so nothing touches {:?}: add <collision> elements to the links",
            obstacle.name
        );
        Some(Warning::odd(self.path(), None, None, message))
    }

    /// Adds the colliders of a robot's links, and how each touches.
    fn link_colliders(
        &self,
        number: usize,
        settings: &ContactSettings,
        reader: &mut ShapeReader,
        colliders: &mut Vec<Collider>,
        surfaces: &mut Vec<Surface>,
    ) -> Result<(), ModelError> {
        let placed = &self.robots[number];
        for (index, link) in placed.robot.links.iter().enumerate() {
            let frame = &self.links[placed.links.start + index];
            let reference = LinkReference::Link { robot: number, link: index };
            for (shape, given) in link.collisions.iter().enumerate() {
                let choice = settings.choice(reference, shape + 1);
                if choice == LinkShapes::None {
                    continue;
                }
                let pose = frame.in_body * given.origin;
                let names = [link.name.as_str(), frame.name.as_str()];
                let shapes =
                    reader.shapes((self.file_of(number), &placed.robot), names, (shape + 1, given), choice, &pose)?;
                let surface = given.surface.or(&link.surface);
                let surface_velocity = surface.velocity.map_or(Vector3::zeros(), |own| frame.in_body.rotation * own);
                let (name, body) = (&frame.name, frame.body);
                let collider = |shape| Collider { name: name.clone(), body, pose, shape, surface_velocity };
                colliders.extend(shapes.into_iter().map(collider));
                surfaces.resize(colliders.len(), surface);
            }
        }
        Ok(())
    }

    /// Refuses unknown and ambiguous names; warns of rules that name no two things that may touch.
    fn check_contact_names(&self, settings: &ContactSettings) -> Result<Vec<Warning>, ModelError> {
        let file = self.path().to_path_buf();
        for obstacle in &settings.obstacles {
            if self.link(&obstacle.name).is_some() {
                let problem = ModelError::ObstacleNamedAsLink(obstacle.name.clone());
                return Err(match obstacle.line {
                    Some(line) => ModelError::InFile { file, line, problem: Box::new(problem) },
                    None => problem,
                });
            }
        }
        let links = self.robots.iter().enumerate().flat_map(|(number, placed)| {
            let links = placed.robot.links.iter().zip(&self.links[placed.links.clone()]);
            let touching = links.filter(|(link, _)| !link.collisions.is_empty());
            touching.map(move |(_, frame)| (frame.name.as_str(), Owner::Robot(number)))
        });
        let obstacles = settings.obstacles.iter().enumerate();
        let obstacles = obstacles.map(|(index, obstacle)| (obstacle.name.as_str(), Owner::Obstacle(index)));
        let named: Vec<(&str, Owner)> = links.chain(obstacles).collect();
        let element = |rule: &PairRule| Element::Pair(format!("{:?} and {:?}", rule.a, rule.b));
        for rule in &settings.rules {
            for pattern in [&rule.a, &rule.b] {
                if !named.iter().any(|(name, _)| matches(pattern, name)) {
                    let known: Vec<String> = named.iter().map(|(name, _)| (*name).to_string()).collect();
                    let problem = CouplingProblem::NoShape { pattern: pattern.clone(), known: listed(&known) };
                    return Err(ModelError::Coupling(CouplingError {
                        file,
                        line: rule.line,
                        element: element(rule),
                        problem,
                    }));
                }
            }
        }
        let of_nothing = rules_of_nothing(settings, self.robots.len(), &named).into_iter().map(|(number, why)| {
            let rule = &settings.rules[number];
            let message = format!("this [[contact.pair]] changes nothing: {why}");
            Warning::odd(&file, Some(rule.line), Some(element(rule)), message)
        });
        Ok(of_nothing.collect())
    }
}
