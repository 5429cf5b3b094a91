//! One [`Model`] from a [`Scene`]: its robots side by side, then their couplings.
//!
//! The bodies of each robot follow the bodies of the robot before it, all with the world as their root. With several robots every name of a link,
//! joint or body is `robot/name`; with one they stay plain. A `[[body]]` has a link and a joint of its name.

use crate::mechanism::description::joint::Pose;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;
use crate::model::description::model_error::ModelError;
use crate::model::description::robot_model::{Model, SourceFile};
use crate::model::reduction::reduce::{Base, ModelOptions};
use crate::scene::{JointValues, Scene, TableFile, WORLD_LINK};
use nalgebra::Vector3;
use std::collections::HashSet;
use std::path::Path;

/// The start of a scene, in the coordinates of its user ([`Model::initial_state`]).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Start {
    /// Joint positions.
    pub positions: Vec<(String, Vec<f64>)>,
    /// Joint velocities, including the velocity of a floating base.
    pub velocities: Vec<(String, Vec<f64>)>,
}

impl Model {
    /// Reduces the robots of a scene, puts them side by side and couples them; and says where the scene starts.
    ///
    /// # Errors
    /// [`ModelError`] when a robot cannot be reduced, a joint that is given a start does not move, or a loop, spring or
    /// load cannot be.
    pub fn from_scene(scene: &Scene) -> Result<(Self, Start), ModelError> {
        let gravity = scene.gravity.unwrap_or(ModelOptions::default().gravity);
        let mut parts = Vec::with_capacity(scene.robots.len());
        for robot in &scene.robots {
            let base = if robot.floating { Base::Floating } else { Base::Fixed };
            let options = ModelOptions { base, base_pose: robot.pose, gravity };
            let mut part = Model::of_robot(robot.robot.clone(), &options)?;
            let placed = &mut part.robots[0];
            (placed.is_body, placed.is_copy) = (robot.body.is_some(), robot.copy);
            placed.name.clone_from(&robot.name);
            placed.prefix.clone_from(&robot.prefix);
            parts.push(if robot.body.is_some() { part.base_called(&robot.name) } else { part.prefixed(&robot.prefix) });
        }
        let mut model = Model::side_by_side(&scene.name, gravity, parts)?;
        model.scene = Some(SourceFile { path: scene.path.clone(), text: scene.source.clone() });
        let table = |table: &TableFile| SourceFile { path: table.path.clone(), text: table.text.clone() };
        model.tables = scene.tables.iter().map(table).collect();
        model.warnings.extend(scene.warnings.iter().cloned());
        let start = model.start(scene)?;
        model.build_ranges(Some(scene))?;
        let state = model.initial_state(&start.positions, &start.velocities, None)?;
        model.build_couplings(Some(scene), &state)?;
        model.set_contact(&scene.contact)?;
        model.leave_out_overlaps(&state);
        Ok((model, start))
    }

    /// Calls the joint of the base of a body `name`.
    fn base_called(mut self, name: &str) -> Self {
        for record in self.joints.iter_mut().filter(|record| record.is_base) {
            record.name = name.to_string();
            record.body.iter().for_each(|&body| self.mechanism.bodies[body].joint.name = name.to_string());
            self.links.iter_mut().for_each(|link| link.parent_joint = Some(name.to_string()));
        }
        self
    }

    /// Puts `prefix` before every name.
    fn prefixed(mut self, prefix: &str) -> Self {
        if prefix.is_empty() {
            return self;
        }
        let put = |name: &mut String| name.insert_str(0, prefix);
        let links: HashSet<String> = self.links.iter().map(|link| link.name.clone()).collect();
        for body in &mut self.mechanism.bodies {
            put(&mut body.name);
            put(&mut body.joint.name);
        }
        for link in &mut self.links {
            put(&mut link.name);
            link.parent_joint.iter_mut().for_each(put);
        }
        for joint in &mut self.joints {
            put(&mut joint.name);
            put(&mut joint.child_link);
            // The world that only joints mention belongs to no robot.
            if !joint.is_base && links.contains(&joint.parent_link) {
                put(&mut joint.parent_link);
            }
        }
        for reduction in &mut self.reductions {
            put(&mut reduction.link);
            reduction.joint.iter_mut().for_each(put);
            if reduction.into != WORLD_LINK {
                put(&mut reduction.into);
            }
        }
        self
    }

    /// One model of several, whose bodies keep their order.
    fn side_by_side(name: &str, gravity: Vector3<f64>, parts: Vec<Model>) -> Result<Self, ModelError> {
        let mut bodies = Vec::new();
        let (mut links, mut joints) = (Vec::new(), Vec::new());
        let (mut reductions, mut warnings, mut robots) = (Vec::new(), Vec::new(), Vec::new());
        for part in parts {
            let first = bodies.len();
            let moved = |body: Option<usize>| body.map(|body| body + first);
            for mut robot in part.robots {
                robot.links = links.len()..links.len() + part.links.len();
                robot.joints = joints.len()..joints.len() + part.joints.len();
                robots.push(robot);
            }
            let robot = robots.len() - 1;
            bodies.extend(part.mechanism.bodies.into_iter().map(|mut body| {
                body.parent = moved(body.parent);
                body
            }));
            links.extend(part.links.into_iter().map(|mut link| {
                link.body = moved(link.body);
                link
            }));
            joints.extend(part.joints.into_iter().map(|mut joint| {
                (joint.body, joint.parent_body) = (moved(joint.body), moved(joint.parent_body));
                joint.robot = robot;
                joint
            }));
            reductions.extend(part.reductions);
            for warning in part.warnings {
                // Two robots of one file say the same.
                if !warnings.contains(&warning) {
                    warnings.push(warning);
                }
            }
        }
        let mechanism = Mechanism::new(name, gravity, bodies)?;
        Ok(Model {
            mechanism,
            links,
            joints,
            reductions,
            warnings,
            robots,
            scene: None,
            tables: Vec::new(),
            damping: 0..0,
            at_start: Vec::new(),
            contact: Default::default(),
        })
    }

    /// The start that a scene gives, every entry of it tried.
    pub fn start(&self, scene: &Scene) -> Result<Start, ModelError> {
        let mut start = Start::default();
        for (index, robot) in scene.robots.iter().enumerate() {
            let full = |given: &JointValues| (format!("{}{}", robot.prefix, given.joint), given.values.clone());
            let base = self.joints[self.robots[index].joints.clone()].iter().find(|joint| joint.is_base);
            for given in &robot.positions {
                let entry = full(given);
                self.try_start(std::slice::from_ref(&entry), &[], &scene.path, given.line)?;
                start.positions.push(entry);
            }
            if let (Some((velocity, line)), Some(base)) = (robot.velocity, base) {
                let entry = (base.name.clone(), velocity.to_vec());
                self.try_start(&[], std::slice::from_ref(&entry), &scene.path, line)?;
                start.velocities.push(entry);
            }
            for given in &robot.velocities {
                let entry = full(given);
                self.try_start(&[], std::slice::from_ref(&entry), &scene.path, given.line)?;
                start.velocities.push(entry);
            }
        }
        Ok(start)
    }

    /// Whether an entry of a start is good; an error with its line if not.
    fn try_start(
        &self,
        positions: &[(String, Vec<f64>)],
        velocities: &[(String, Vec<f64>)],
        file: &Path,
        line: usize,
    ) -> Result<(), ModelError> {
        let tried: Result<State, ModelError> = self.initial_state(positions, velocities, None);
        let at = |problem| ModelError::InFile { file: file.to_path_buf(), line, problem: Box::new(problem) };
        tried.map(drop).map_err(at)
    }

    /// The frame of a link in the body that carries it, by robot and link of the scene.
    pub(crate) fn link_of_robot(&self, robot: usize, link: usize) -> (usize, &Pose) {
        let index = self.robots[robot].links.start + link;
        (index, &self.links[index].in_body)
    }
}
