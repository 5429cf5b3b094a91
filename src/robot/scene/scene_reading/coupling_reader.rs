//! Loops, springs and loads, from the tables of a scene file: names resolved, axes of length one.

use crate::scene::coupling::{JointReference, LinkReference, LoopEnd, Point, SceneLoop, SceneSpring, SpringPlace};
use crate::scene::description::SceneRobot;
use crate::scene::error::{Element, Problem, SceneError};
use crate::scene::numbers::unit;
use crate::scene::robot::LoopType;
use crate::scene::scene_reading::scene_numbers::{Finite, NotNegative, Quantity};
use crate::scene::scene_reading::scene_schema::{EndTable, LoopTable, SpringTable, vector};
use crate::scene::scene_reading::toml_text::TomlText;
use crate::scene::warning::Warning;
use crate::scene::world::WORLD_LINK;
use std::ops::Range;
use toml::Spanned;

/// The common data of all tables.
pub(crate) struct CouplingReader<'r> {
    pub text: &'r TomlText<'r>,
    pub robots: &'r [SceneRobot],
    pub warnings: Vec<Warning>,
}

impl CouplingReader<'_> {
    /// All loops.
    pub fn loops(&mut self, tables: Vec<Spanned<LoopTable>>) -> Result<Vec<SceneLoop>, SceneError> {
        let mut loops: Vec<SceneLoop> = Vec::with_capacity(tables.len());
        for (index, table) in tables.into_iter().enumerate() {
            let span = table.span();
            let table = table.into_inner();
            let name = named(table.name, "loop", index);
            let owner = Element::Loop(name.clone());
            if let Some(first) = loops.iter().find(|other| other.name == name) {
                let problem = Problem::DuplicateName { first_line: first.line };
                return Err(self.text.error(&span, Some(owner), problem));
            }
            if let Some(length) = table.length.as_ref().filter(|_| table.kind != LoopType::Distance) {
                let problem = Problem::Keys("only a loop of the type \"distance\" has a length");
                return Err(self.text.error(&length.span(), Some(owner), problem));
            }
            let a = self.end(&table.a, table.kind, &owner)?;
            let b = self.end(&table.b, table.kind, &owner)?;
            if table.kind == LoopType::Fixed && a.axis.is_some() != b.axis.is_some() {
                let problem = Problem::Keys("give an axis at both ends of a fixed loop, or at none");
                return Err(self.text.error(&span, Some(owner), problem));
            }
            let length = table.length.map(|length| length.get_ref().0);
            loops.push(SceneLoop { name, kind: table.kind, length, a, b, line: self.text.line(&span) });
        }
        Ok(loops)
    }

    /// All springs.
    pub fn springs(&mut self, tables: Vec<Spanned<SpringTable>>) -> Result<Vec<SceneSpring>, SceneError> {
        let mut springs = Vec::with_capacity(tables.len());
        for (index, table) in tables.into_iter().enumerate() {
            let span = table.span();
            let table = table.into_inner();
            let name = named(table.name, "spring", index);
            let owner = Element::Spring(name.clone());
            let refuse = |span, message| Err(self.text.error(&span, Some(owner.clone()), Problem::Keys(message)));
            let number = |given: Option<NotNegative>| given.map_or(0.0, |number| number.0);
            let (stiffness, damping) = (number(table.stiffness), number(table.damping));
            let place = match (&table.a, &table.b, &table.joint) {
                (Some(a), Some(b), None) => {
                    if let Some(rest) = table.rest {
                        return refuse(rest.span(), "a spring between points has a rest_length, no rest");
                    }
                    let rest_length = match table.rest_length {
                        Some(rest_length) => rest_length.get_ref().0,
                        None if stiffness == 0.0 => 0.0,
                        None => return refuse(span, "a spring between points needs its rest_length"),
                    };
                    let a = self.point(&a.link, &a.position, &owner)?;
                    let b = self.point(&b.link, &b.position, &owner)?;
                    SpringPlace::Points { a, b, rest_length }
                }
                (None, None, Some(joint)) => {
                    if let Some(rest_length) = table.rest_length {
                        return refuse(rest_length.span(), "a spring in a joint has a rest, no rest_length");
                    }
                    let joint = self.joint(joint, &owner)?;
                    let rest = match table.rest {
                        None => 0.0,
                        Some(rest) => self.joint_number(&joint, *rest.get_ref(), false, &rest.span(), &owner)?,
                    };
                    SpringPlace::Joint { joint, rest }
                }
                _ => return refuse(span, "a spring is either between points a and b, or in a joint"),
            };
            if table.stiffness.is_none() && table.damping.is_none() {
                return refuse(span, "a spring needs its stiffness, its damping, or both");
            }
            springs.push(SceneSpring { name, stiffness, damping, place, line: self.text.line(&span) });
        }
        Ok(springs)
    }

    fn end(&mut self, table: &Spanned<EndTable>, kind: LoopType, owner: &Element) -> Result<LoopEnd, SceneError> {
        let EndTable { link, position, axis } = table.get_ref();
        let point = self.point(link, position, owner)?;
        let Some(given) = axis else {
            if kind.needs_axes() {
                let problem = Problem::Keys("both ends of this type of loop need an axis");
                return Err(self.text.error(&table.span(), Some(owner.clone()), problem));
            }
            return Ok(LoopEnd { point, axis: None, given_axis: None });
        };
        let refuse = || self.text.error(&given.span(), Some(owner.clone()), Problem::ZeroAxis);
        let given_axis = vector(given.get_ref());
        let (axis, warning) = unit(&given_axis).ok_or_else(refuse)?;
        if let Some(message) = warning {
            let line = Some(self.text.line(&given.span()));
            self.warnings.push(Warning::odd(self.text.file, line, Some(owner.clone()), message));
        }
        Ok(LoopEnd { point, axis: Some(axis), given_axis: Some(given_axis) })
    }

    /// A point of the link of a name.
    pub fn point(&self, link: &Spanned<String>, position: &[Finite; 3], owner: &Element) -> Result<Point, SceneError> {
        let name = link.get_ref().clone();
        let found = if name == WORLD_LINK {
            Some(LinkReference::World)
        } else {
            self.called(&name).find_map(|(robot, rest)| {
                Some(LinkReference::Link { robot, link: self.robots[robot].robot.link(rest)? })
            })
        };
        match found {
            Some(link) => Ok(Point { link, name, position: vector(position) }),
            None => Err(self.unknown("link", link, owner)),
        }
    }

    /// The joint of a name.
    pub fn joint(&self, joint: &Spanned<String>, owner: &Element) -> Result<JointReference, SceneError> {
        let has = |robot: usize, name: &str| self.robots[robot].robot.joints.iter().any(|joint| joint.name == name);
        let found = self.called(joint.get_ref()).find(|&(robot, rest)| has(robot, rest));
        match found {
            Some((robot, name)) => Ok(JointReference { robot, joint: name.to_string() }),
            None => Err(self.unknown("joint", joint, owner)),
        }
    }

    /// A position of a joint of one freedom, or with `rate` a velocity of it, whose unit it must have if it has one.
    pub fn joint_number(
        &self,
        of: &JointReference,
        given: Quantity,
        rate: bool,
        span: &Range<usize>,
        owner: &Element,
    ) -> Result<f64, SceneError> {
        let joint = self.robots[of.robot].robot.joints.iter().find(|joint| joint.name == of.joint);
        given.value(joint.is_none_or(|joint| joint.kind.is_angle(0)), rate).map_err(|reason| {
            let problem = Problem::JointNumber { joint: of.joint.clone(), reason };
            self.text.error(span, Some(owner.clone()), problem)
        })
    }

    /// The robots, and the names in them, that a name may stand for.
    pub fn called<'n>(&self, name: &'n str) -> impl Iterator<Item = (usize, &'n str)> {
        let plain = self.robots.iter().enumerate().filter(|(_, robot)| robot.prefix.is_empty());
        let plain = plain.map(move |(index, _)| (index, name));
        let prefixed = self.robots.iter().enumerate().filter_map(move |(index, robot)| {
            Some((index, name.strip_prefix(robot.name.as_str())?.strip_prefix('/')?))
        });
        plain.chain(prefixed)
    }

    fn unknown(&self, what: &'static str, name: &Spanned<String>, owner: &Element) -> SceneError {
        let known = self.robots.iter().flat_map(|placed| {
            let called = |own: &String| format!("{}{own}", placed.prefix);
            let (links, joints) = (&placed.robot.links, &placed.robot.joints);
            match what {
                "link" => links.iter().map(|link| called(&link.name)).collect::<Vec<_>>(),
                _ => joints.iter().map(|joint| called(&joint.name)).collect(),
            }
        });
        let robots = self.robots.iter().filter(|placed| !placed.prefix.is_empty()).count();
        let known = known.collect();
        let problem = Problem::UnknownName { what, name: name.get_ref().clone(), robots, known };
        self.text.error(&name.span(), Some(owner.clone()), problem)
    }
}

/// The name that was given, or a number.
fn named(name: Option<Spanned<String>>, what: &str, index: usize) -> String {
    name.map_or_else(|| format!("{what}{}", index + 1), Spanned::into_inner)
}
